#!/usr/bin/env python3
"""Dashboard and alerts ask for what is exposed, and Prometheus takes them.

Usage: monitoring_test.py DCLOC SERVER [unittest arguments]
"""

import functools
import json
import pathlib
import re
import shutil
import tempfile
import unittest
import urllib.request

from deployed import DEPLOY, PROGRAMS, Server, exposed_metrics, load_yaml, main, needs_yaml, run

METRIC = re.compile(r"\b(?:dcloc|process)_[a-z0-9_]+\b")


@functools.cache
def promtool():
    """The installed one, or else Debian's, unpacked beside the programs: the package is a service,
    which a test has no business to install. None where neither is to be had."""
    installed = shutil.which("promtool")
    if installed:
        return installed
    program = pathlib.Path(PROGRAMS[0]).parent.parent / "tests" / "promtool"
    if not program.is_file() and shutil.which("apt-get"):
        with tempfile.TemporaryDirectory() as download:
            run("apt-get", "download", "--quiet=2", "-o", "APT::Sandbox::User=root", "prometheus",
                cwd=download)
            for package in pathlib.Path(download).glob("prometheus_*.deb"):
                run("dpkg-deb", "--extract", package, download)
                shutil.move(pathlib.Path(download) / "usr/bin/promtool", program)
    return str(program) if program.is_file() else None


def run_promtool(test, *arguments, **options):
    if promtool() is None:
        test.skipTest("needs promtool (Debian package prometheus), and apt-get cannot download it")
    result = run(promtool(), *arguments, **options)
    test.assertEqual(result.returncode, 0, result.stdout)


class Monitoring(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.exposed = exposed_metrics()
        # Only servers that share their map files have these; the one that is asked here has its own.
        source = (DEPLOY.parent / "server/app/map_file_metrics.cpp").read_text(encoding="utf-8")
        cls.shared = set(re.findall(r'"(dcloc_(?:object_store|map_cache)_\w+)"', source))

    def check(self, expression, where):
        names = set(METRIC.findall(expression))
        self.assertTrue(names, f"{where} names no metric: {expression}")
        self.assertEqual(names - self.exposed - self.shared, set(),
                         f"{where} names what is not exposed")

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

    def test_promtool_accepts_rules_and_configuration(self):
        for kind, file in (("rules", "alerts.yml"), ("config", "prometheus.yml")):
            run_promtool(self, "check", kind, DEPLOY / "monitoring" / file)

    def test_promtool_accepts_the_metrics(self):
        with tempfile.TemporaryDirectory() as folder, \
                Server(folder, "--metrics-listen", "0") as server:
            text = urllib.request.urlopen(server.metrics, timeout=10).read().decode()
        run_promtool(self, "check", "metrics", input=text)

    def test_alerts_fire_when_they_should(self):
        with tempfile.TemporaryDirectory() as folder:
            for file in (DEPLOY / "monitoring/alerts.yml",
                         pathlib.Path(__file__).parent / "alerts_test.yml"):
                shutil.copy(file, folder)
            run_promtool(self, "test", "rules", pathlib.Path(folder) / "alerts_test.yml")


if __name__ == "__main__":
    main()
