#!/usr/bin/env python3
"""The objects for Kubernetes fit each other, and have no field that Kubernetes does not know.

Usage: kubernetes_test.py DCLOC SERVER [unittest arguments]
"""

import json
import os
import pathlib
import tempfile
import unittest

from deployed import (DEPLOY, PROGRAMS, check_server_arguments, exposed_metrics, load_yaml, main,
                      needs_yaml, run, servers_of, yaml)

try:
    import kubernetes_objects
except ImportError:  # Debian package python3-kubernetes
    kubernetes_objects = None


class Kubernetes(unittest.TestCase):
    @needs_yaml
    def test_kubernetes_objects_fit_each_other(self):
        items = load_yaml(DEPLOY / "kubernetes.yml")
        for item in items:
            self.assertTrue(item["apiVersion"] and item["metadata"]["name"])
        objects = {item["kind"]: item for item in items if item["metadata"]["name"] == "dcloc"}
        stateful = objects["StatefulSet"]["spec"]
        pod = stateful["template"]
        self.assertEqual(stateful["selector"]["matchLabels"], pod["metadata"]["labels"])
        self.assertEqual(objects["Service"]["spec"]["selector"], pod["metadata"]["labels"])
        self.assertEqual(stateful["serviceName"], objects["Service"]["metadata"]["name"])
        (container,) = pod["spec"]["containers"]
        volumes = {volume["name"] for volume in pod["spec"]["volumes"]}
        volumes |= {claim["metadata"]["name"] for claim in stateful["volumeClaimTemplates"]}
        self.assertEqual({mount["name"] for one in (container, *pod["spec"]["initContainers"])
                          for mount in one["volumeMounts"]}, volumes)
        ports = {port["name"]: port["containerPort"] for port in container["ports"]}
        for port in objects["Service"]["spec"]["ports"]:
            self.assertEqual(ports[port["name"]], port["port"])
        self.assertIn(container["readinessProbe"]["httpGet"]["port"], ports)
        check_server_arguments(self, container["args"])
        args = container["args"]
        known_as = args[args.index("--replica-address") + 1]
        self.assertEqual(known_as.replace("$(POD_NAME)", "dcloc-0"),
                         f"dcloc-0.{stateful['serviceName']}.default.svc.cluster.local")
        self.assertIn("POD_NAME", [variable["name"] for variable in container["env"]])
        self.assertTrue(any(args[args.index("--replica-ca") + 1].startswith(mount["mountPath"] + "/")
                            for mount in container["volumeMounts"]))
        settings = json.loads(objects["ConfigMap"]["data"]["server.json"])
        self.assertIn(os.path.dirname(settings["ticket_keys"]),
                      [mount["mountPath"] for mount in container["volumeMounts"]])
        self.assertTrue(settings["listen"].endswith(f":{ports['grpc']}"))
        self.assertTrue(settings["metrics_listen"].endswith(f":{ports['metrics']}"))
        self.assertGreater(pod["spec"]["terminationGracePeriodSeconds"] * 1000,
                           settings["shutdown_deadline_ms"])
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder) / "server.json"
            # Its certificates and keys are not here.
            path.write_text(json.dumps({key: value for key, value in settings.items()
                                        if not key.startswith(("tls_", "ticket_keys", "object_cred"))}
                                       | {"listen": "127.0.0.1:0"}))
            checked = run(PROGRAMS[1], "--config", path, "--check-config", env={
                **os.environ, "AWS_ACCESS_KEY_ID": "key", "AWS_SECRET_ACCESS_KEY": "secret"})
        self.assertEqual(checked.returncode, 0, checked.stdout)

    @needs_yaml
    def test_the_router_of_kubernetes_knows_each_replica_that_there_may_be(self):
        items = load_yaml(DEPLOY / "kubernetes.yml")
        objects = {(item["kind"], item["metadata"]["name"]): item for item in items}
        scaler = objects["HorizontalPodAutoscaler", "dcloc"]["spec"]
        self.assertIn((scaler["scaleTargetRef"]["kind"], scaler["scaleTargetRef"]["name"]), objects)
        listed = servers_of(objects["ConfigMap", "dcloc-replicas"]["data"]["haproxy-replicas.cfg"])
        self.assertEqual(listed, [(f"dcloc-{i}", f"dcloc-{i}.dcloc.default.svc.cluster.local")
                                  for i in range(scaler["maxReplicas"])])
        exposed = exposed_metrics()
        for metric in scaler["metrics"]:
            if metric["type"] == "Pods":
                self.assertIn(metric["pods"]["metric"]["name"], exposed)
        router = objects["Deployment", "dcloc-router"]["spec"]["template"]
        for kind in ("Service", "PodDisruptionBudget"):
            selector = objects[kind, "dcloc-router"]["spec"]["selector"]
            self.assertEqual(selector.get("matchLabels", selector), router["metadata"]["labels"])
        (container,) = router["spec"]["containers"]
        files = [word for word in container["args"] if word.endswith(".cfg")]
        mounted = {mount["mountPath"] for mount in container["volumeMounts"]}
        for file in files:
            self.assertIn(os.path.dirname(file), mounted)
        self.assertEqual({mount["name"] for mount in container["volumeMounts"]},
                         {volume["name"] for volume in router["spec"]["volumes"]})

    @needs_yaml
    @unittest.skipIf(kubernetes_objects is None, "needs Debian's python3-kubernetes")
    def test_kubernetes_knows_every_field(self):
        for item in load_yaml(DEPLOY / "kubernetes.yml"):
            self.assertEqual(kubernetes_objects.faults(item), [])

    @needs_yaml
    @unittest.skipIf(kubernetes_objects is None, "needs Debian's python3-kubernetes")
    def test_what_kubernetes_does_not_know_is_found(self):
        text = (DEPLOY / "kubernetes.yml").read_text()
        for right, wrong, fault in (
                ("periodSeconds: 5\n", "periodSecond: 5\n", "periodSecond: there is no such field"),
                ("  maxUnavailable: 1\n  selector:\n    matchLabels: {app: dcloc}\n---",
                 "  maxUnavailables: 1\n  selector:\n    matchLabels: {app: dcloc}\n---", "maxUnavailables: there is no such field"),
                ("replicas: 2\n", "replicas: two\n", "replicas must be of type int, not 'two'"),
                ("runAsUser: 99\n", "runAsUser: root\n", "runAsUser must be of type int"),
                ("policies: [{type: Pods, value: 1, periodSeconds: 300}]", "policies: Pods",
                 "policies must be a list"),
                ("- {name: grpc, containerPort: 50051}", "- {name: grpc}", "container_port"),
                ("serviceName: dcloc", "", "service_name"),
                ("policy/v1", "apps/v1", "apps/v1 has no PodDisruptionBudget")):
            broken = text.replace(right, wrong, 1)
            self.assertNotEqual(broken, text, right)
            found = [line for item in yaml.safe_load_all(broken)
                     for line in kubernetes_objects.faults(item)]
            self.assertEqual(len(found), 1, f"{wrong}: {found}")
            self.assertIn(fault, found[0])


if __name__ == "__main__":
    main(modules=("yaml", "kubernetes"))
