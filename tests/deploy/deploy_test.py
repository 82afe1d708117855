#!/usr/bin/env python3
"""What lies in deploy/ fits the programs: metrics, settings, ports, files, certificates.

Usage: deploy_test.py DCLOC SERVER [unittest arguments]
"""

import json
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import unittest
import urllib.request

try:
    import yaml
except ImportError:  # Debian package python3-yaml
    yaml = None

DEPLOY = pathlib.Path(__file__).resolve().parent.parent.parent / "deploy"
METRIC = re.compile(r"\b(?:dcloc|process)_[a-z0-9_]+\b")
PROGRAMS = []
needs_yaml = unittest.skipIf(yaml is None, "needs Python's yaml (Debian package python3-yaml)")


def needs_program(name, package):
    return unittest.skipIf(shutil.which(name) is None, f"needs {name} (Debian package {package})")


def run(*command, **options):
    return subprocess.run([str(word) for word in command], text=True, stdout=subprocess.PIPE,
                          stderr=subprocess.STDOUT, check=False, timeout=60, **options)


class Server:
    """dcloc-server with metrics, for as long as the `with`."""

    def __init__(self, folder, *arguments):
        self.log = open(pathlib.Path(folder) / "server.log", "w+", encoding="utf-8")
        self.process = subprocess.Popen(
            [PROGRAMS[1], "--data", str(pathlib.Path(folder) / "store"), "--listen", "127.0.0.1:0",
             "--stub-matcher", *map(str, arguments)],
            text=True, stdout=subprocess.PIPE, stderr=self.log)
        line = self.process.stdout.readline()
        self.log.seek(0)
        log = self.log.read()
        if not line.startswith("listening on "):
            raise AssertionError(f"no server: {line} {log}")
        self.address = line.removeprefix("listening on ").strip()
        served = re.search(r"metrics served address=(\S+)", log)
        self.metrics = served and f"http://{served.group(1)}/metrics"

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.process.kill()
        self.process.wait()
        self.process.stdout.close()
        self.log.close()


def exposed_metrics():
    """Every name that a query may use."""
    with tempfile.TemporaryDirectory() as folder, Server(folder, "--metrics-listen", "0") as server:
        text = urllib.request.urlopen(server.metrics, timeout=10).read().decode()
    names = set()
    for name, kind in re.findall(r"^# TYPE (\S+) (\S+)$", text, re.MULTILINE):
        names |= ({f"{name}_bucket", f"{name}_sum", f"{name}_count"} if kind == "histogram"
                  else {name})
    return names


def load_yaml(path):
    return list(yaml.safe_load_all(path.read_text(encoding="utf-8")))


class Monitoring(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.exposed = exposed_metrics()

    def check(self, expression, where):
        names = set(METRIC.findall(expression))
        self.assertTrue(names, f"{where} names no metric: {expression}")
        self.assertEqual(names - self.exposed, set(), f"{where} names what is not exposed")

    def test_the_dashboard_shows_what_is_exposed(self):
        dashboard = json.loads((DEPLOY / "monitoring/grafana/dcloc.json").read_text())
        ids = [panel["id"] for panel in dashboard["panels"]]
        self.assertEqual(len(ids), len(set(ids)))
        shown = set()
        for panel in dashboard["panels"]:
            self.assertTrue(panel["targets"], panel["title"])
            for target in panel["targets"]:
                self.check(target["expr"], panel["title"])
                shown |= set(METRIC.findall(target["expr"]))
        for variable in dashboard["templating"]["list"]:
            if variable["type"] == "query":
                self.check(variable["query"], variable["name"])
        # A histogram is shown by any of its series.
        families = {re.sub(r"_(bucket|sum|count)$", "", name) for name in shown}
        exposed = {re.sub(r"_(bucket|sum|count)$", "", name) for name in self.exposed}
        self.assertEqual(exposed - families - {"process_start_time_seconds"}, set(),
                         "exposed, and on no panel")

    @needs_yaml
    def test_alerts_use_what_is_exposed(self):
        (rules,) = load_yaml(DEPLOY / "monitoring/alerts.yml")
        names = []
        for group in rules["groups"]:
            for rule in group["rules"]:
                names.append(rule["alert"])
                self.assertIn(rule["labels"]["severity"], ("page", "ticket"), rule["alert"])
                self.assertTrue(rule["annotations"]["summary"])
                self.assertTrue(rule["annotations"]["description"])
                if rule["alert"] != "DclocServerDown":  # `up` is Prometheus' own
                    self.check(rule["expr"], rule["alert"])
        self.assertEqual(len(names), len(set(names)))
        self.assertGreaterEqual(len(names), 8)

    @needs_program("promtool", "prometheus")
    def test_promtool_accepts_rules_and_configuration(self):
        for kind, file in (("rules", "alerts.yml"), ("config", "prometheus.yml")):
            result = run("promtool", "check", kind, DEPLOY / "monitoring" / file)
            self.assertEqual(result.returncode, 0, result.stdout)


if __name__ == "__main__":
    PROGRAMS[:] = sys.argv[1:3]
    unittest.main(argv=[sys.argv[0], *sys.argv[3:]])
