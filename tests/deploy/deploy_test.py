#!/usr/bin/env python3
"""What lies in deploy/ fits the programs: settings, router, unit, certificates.

Usage: deploy_test.py DCLOC SERVER [unittest arguments]
"""

import os
import pathlib
import re
import tempfile
import unittest

from deployed import DEPLOY, PROGRAMS, Server, load_yaml, main, needs_program, run, yaml


class Certificates(unittest.TestCase):
    def test_the_script_makes_what_server_and_client_take(self):
        with tempfile.TemporaryDirectory() as folder:
            made = run(DEPLOY / "certificates", "--out", folder, "--server", "localhost,127.0.0.1",
                       "--client", "ops")
            self.assertEqual(made.returncode, 0, made.stdout)
            path = pathlib.Path(folder)
            for key in path.glob("*.key"):
                self.assertEqual(key.stat().st_mode & 0o077, 0, f"{key} is for its owner alone")
            identity = run(PROGRAMS[1], "token", "create", "--certificate", "--data",
                           path / "store", "--name", "ops", "--role", "admin")
            self.assertEqual(identity.returncode, 0, identity.stdout)
            tls = ["--tls-cert", path / "localhost.pem", "--tls-key", path / "localhost.key",
                   "--tls-client-ca", path / "ca.pem"]
            with Server(folder, *tls) as server:
                status = [PROGRAMS[0], "server", "status", "--server", server.address, "--tls-ca",
                          path / "ca.pem"]
                known = run(*status, "--tls-cert", path / "ops.pem", "--tls-key", path / "ops.key")
                self.assertEqual(known.returncode, 0, known.stdout)
                self.assertEqual(run(*status).returncode, 1, "without a certificate")

    def test_bad_arguments_are_refused(self):
        for words in ([], ["--out"], ["--out", "x", "--days", "0"], ["--what"],
                      ["--out", "x", "--client", "a b"]):
            self.assertNotEqual(run(DEPLOY / "certificates", *words).returncode, 0, words)
        self.assertFalse(pathlib.Path("x").exists())


class Files(unittest.TestCase):
    """What cannot be run here is at least read by its own program."""

    def test_the_example_settings_are_valid(self):
        checked = run(PROGRAMS[1], "--data", "/tmp", "--config", DEPLOY / "server.json",
                      "--check-config")
        self.assertEqual(checked.returncode, 0, checked.stdout)

    @needs_program("haproxy", "haproxy")
    def test_haproxy_accepts_its_configuration(self):
        lists = [(DEPLOY / "haproxy-replicas.cfg").read_text()]
        if yaml is not None:
            lists += [item["data"]["haproxy-replicas.cfg"]
                      for item in load_yaml(DEPLOY / "kubernetes.yml")
                      if item["metadata"]["name"] == "dcloc-replicas"]
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder)
            made = run(DEPLOY / "certificates", "--out", folder, "--server", "localhost")
            self.assertEqual(made.returncode, 0, made.stdout)
            pem = path / "dcloc.pem"
            pem.write_text((path / "localhost.pem").read_text() +
                           (path / "localhost.key").read_text())
            for text in lists:
                replicas = path / "replicas.cfg"
                replicas.write_text(text.replace("/etc/haproxy-tls/ca.crt", str(path / "ca.pem")))
                for more in ({}, {"DCLOC_ROUTER_CLIENT_CA": str(path / "ca.pem")}):
                    result = run("haproxy", "-c", "-f", DEPLOY / "haproxy.cfg", "-f", replicas,
                                 env={**os.environ, "DCLOC_ROUTER_CERTIFICATE": str(pem), **more})
                    self.assertEqual(result.returncode, 0, result.stdout)

    @needs_program("systemd-analyze", "systemd")
    def test_systemd_accepts_the_unit(self):
        with tempfile.TemporaryDirectory() as folder:
            unit = pathlib.Path(folder) / "dcloc-server.service"
            # The program need not be installed where the test runs.
            unit.write_text(re.sub(r"^ExecStart=\S+", f"ExecStart={PROGRAMS[1]}",
                                   (DEPLOY / "dcloc-server.service").read_text(),
                                   flags=re.MULTILINE))
            result = run("systemd-analyze", "verify", "--man=no", unit)
        self.assertEqual(result.returncode, 0, result.stdout)
        self.assertNotIn("dcloc-server.service:", result.stdout, "a line is not understood")


if __name__ == "__main__":
    main()
