"""What the tests of deploy/ share: the programs, a server, the readers of files."""

import importlib.util
import os
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
SYSTEM_PYTHON = pathlib.Path("/usr/bin/python3")
PROGRAMS = []  # dcloc and dcloc-server
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
             "--stub-localizer", *map(str, arguments)],
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
    """Every name that a query may use, those of a server with TLS among them."""
    with tempfile.TemporaryDirectory() as folder:
        run(DEPLOY / "certificates", "--out", folder, "--server", "127.0.0.1")
        pair = pathlib.Path(folder) / "127.0.0.1"
        with Server(folder, "--metrics-listen", "0", "--tls-cert", f"{pair}.pem", "--tls-key",
                    f"{pair}.key") as server:
            text = urllib.request.urlopen(server.metrics, timeout=10).read().decode()
    names = set()
    for name, kind in re.findall(r"^# TYPE (\S+) (\S+)$", text, re.MULTILINE):
        names |= ({f"{name}_bucket", f"{name}_sum", f"{name}_count"} if kind == "histogram"
                  else {name})
    return names


def servers_of(haproxy_list):
    """[(name, host)] of the router's list; each with the check of /ready."""
    return re.findall(r"^ *server (\S+) (\S+):50051 port 9464 check-proto h1$", haproxy_list,
                      re.MULTILINE)


def load_yaml(path):
    return list(yaml.safe_load_all(path.read_text(encoding="utf-8")))


def check_server_arguments(test, arguments):
    """Every flag is one of dcloc-server's."""
    help_text = run(PROGRAMS[1], "--help").stdout
    for word in arguments:
        if word.startswith("--"):
            test.assertRegex(help_text, re.escape(word) + r"\s", f"dcloc-server has no {word}")


def main(modules=("yaml",)):
    """Runs the tests of the program that is run: PROGRAM DCLOC SERVER [unittest arguments]. In
    Debian's Python, if this one lacks a module: Debian's packages are for Debian's Python, whichever
    comes first in PATH."""
    PROGRAMS[:] = map(os.path.abspath, sys.argv[1:3])
    lacks = any(importlib.util.find_spec(module) is None for module in modules)
    if lacks and pathlib.Path(sys.executable).resolve() != SYSTEM_PYTHON.resolve():
        os.execv(SYSTEM_PYTHON, [SYSTEM_PYTHON, "-B", *sys.argv])
    unittest.main(module="__main__", argv=[sys.argv[0], *sys.argv[3:]])
