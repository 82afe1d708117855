"""Holds Kubernetes objects against the models of Kubernetes' own client (Debian's python3-kubernetes),
which are made from the API's definition: what they do not know, is of another type, or is missing."""

import datetime
import re

from kubernetes import client

SCALARS = {"str": str, "int": int, "float": (int, float), "bool": bool, "object": object,
           "datetime": (str, datetime.datetime)}


# What became of them has the same fields; Debian's models are from before.
MODELS = {"autoscaling/v2": "autoscaling/v2beta2"}


def faults(item):
    """A line for each fault of an object as read from YAML."""
    version, kind = str(item.get("apiVersion")), str(item.get("kind"))
    version = MODELS.get(version, version)
    group, _, version = version.rpartition("/")
    name = (group.split(".")[0] or "core").capitalize() + version.capitalize() + "Api"
    create = "_".join(["create_namespaced", *re.findall("[A-Z][a-z]+", kind)]).lower()
    if not hasattr(getattr(client, name, None), create):
        return [f"{item.get('apiVersion')} has no {kind}"]
    return list(_model_faults(version.capitalize() + kind, item, kind))


def _faults(kind, value, where):
    listed = re.fullmatch(r"list\[(.*)\]", kind)
    mapped = re.fullmatch(r"dict\(str, (.*)\)", kind)
    if listed:
        if not isinstance(value, list):
            yield f"{where} must be a list"
            return
        for index, element in enumerate(value):
            yield from _faults(listed.group(1), element, f"{where}[{index}]")
    elif mapped:
        if not isinstance(value, dict):
            yield f"{where} must be a map"
            return
        for key, element in value.items():
            yield from _faults(mapped.group(1), element, f"{where}.{key}")
    elif kind not in SCALARS:
        yield from _model_faults(kind, value, where)
    elif not isinstance(value, SCALARS[kind]) or (isinstance(value, bool) and
                                                  kind not in ("bool", "object")):
        yield f"{where} must be of type {kind}, not {value!r}"


def _model_faults(name, value, where):
    if not isinstance(value, dict):
        yield f"{where} must be a map"
        return
    model = getattr(client, name)
    fields = {key: field for field, key in model.attribute_map.items()}
    for key, element in value.items():
        if key not in fields:
            yield f"{where}.{key}: there is no such field"
        else:
            yield from _faults(model.openapi_types[fields[key]], element, f"{where}.{key}")
    try:
        # The models' own checks: what must be there, and what values are possible.
        model(**{fields[key]: element for key, element in value.items() if key in fields})
    except ValueError as error:
        yield f"{where}: {error}"
