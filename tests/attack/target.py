"""A server under attack: its process, its metrics, and vehicles that drive meanwhile."""

import http.client
import importlib
import json
import os
import pathlib
import re
import signal
import socket
import subprocess
import sys
import tempfile
import time

import grpc

import frames

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parent.parent


def make_stubs(folder):
    """Python's messages and stubs of the wire contract, made into `folder`."""
    protos = sorted(str(path) for path in (ROOT / "proto/dcloc/v1").glob("*.proto"))
    plugin = subprocess.run(["which", "grpc_python_plugin"], check=True, text=True,
                            stdout=subprocess.PIPE).stdout.strip()
    subprocess.run(["protoc", f"-I{ROOT / 'proto'}", f"--python_out={folder}",
                    f"--grpc_python_out={folder}",
                    f"--plugin=protoc-gen-grpc_python={plugin}", *protos], check=True)


class Api:
    """The modules that `make_stubs` has made."""

    def __init__(self, folder):
        sys.path.insert(0, str(folder))
        for name in ("localization_service", "map_service", "admin_service", "scan", "geometry"):
            setattr(self, name, importlib.import_module(f"dcloc.v1.{name}_pb2"))
            if name.endswith("service"):
                setattr(self, f"{name}_grpc", importlib.import_module(f"dcloc.v1.{name}_pb2_grpc"))


class Target:
    """A server on a store of its own, at free ports; killed at the end of the `with`."""

    def __init__(self, program, folder, town, *flags, identities=True, environment=None,
                 stub=True):
        self.folder = pathlib.Path(tempfile.mkdtemp(dir=folder))
        self.program = program
        self.store = self.folder / "store"
        self.town = town
        self.token = self._token("admin", "ops") if identities else None
        self.vehicle_token = self._token("operator", "fleet") if identities else None
        self.log = open(self.folder / "log", "w+", encoding="utf-8")
        self.flags = [*(["--stub-localizer"] if stub else []), *flags]
        self.environment = {**os.environ, **(environment or {})}
        self._start()

    def _start(self):
        self.process = subprocess.Popen(
            [self.program, "--data", self.store, "--listen", "127.0.0.1:0",
             "--metrics-listen", "127.0.0.1:0", "--log-format", "json", *map(str, self.flags)],
            text=True, stdout=subprocess.PIPE, stderr=self.log, env=self.environment)
        line = self.process.stdout.readline()
        if not line.startswith("listening on "):
            raise AssertionError(f"no server: {self.log_text()}")
        self.address = line.removeprefix("listening on ").strip()
        self.metrics = re.findall(r'metrics served","address":"([^"]+)"', self.log_text())[-1]
        self.router = Router(self.folder, self.address, self.metrics) if frames.ROUTER_CA else None
        if self.router:
            self.address = self.router.address

    def restart(self):
        """Kills it, and starts it again on the same store, at other ports."""
        self.process.kill()
        self.process.wait()
        self.process.stdout.close()
        self._start()

    def _token(self, role, name):
        self.store.mkdir(exist_ok=True)
        result = subprocess.run([self.program, "token", "create", "--data", self.store, "--name", name,
                                 "--role", role], check=True, text=True, stdout=subprocess.PIPE,
                                stderr=subprocess.DEVNULL)
        return re.search(r"dcloc_\S+", result.stdout).group(0)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        if self.router:
            self.router.process.kill()
            self.router.process.wait()
        self.process.kill()
        self.process.wait()
        self.process.stdout.close()
        self.log.close()

    def alive(self):
        return self.process.poll() is None and (
            self.router is None or self.router.process.poll() is None)

    def peak_mib(self):
        """The most memory that it ever had."""
        status = pathlib.Path(f"/proc/{self.process.pid}/status").read_text(encoding="utf-8")
        return int(re.search(r"^VmHWM:\s+(\d+)", status, re.MULTILINE).group(1)) / 1024

    def log_text(self):
        return (self.folder / "log").read_text(encoding="utf-8", errors="replace")

    def reload(self):
        self.process.send_signal(signal.SIGHUP)

    def call_metadata(self, token=None):
        token = token or self.token
        return [("authorization", f"Bearer {token}")] if token else []

    def get(self, path, timeout_s=10):
        """The status, the body, and how long it took [s]."""
        begin = time.monotonic()
        connection = http.client.HTTPConnection(*self.metrics.split(":"), timeout=timeout_s)
        try:
            connection.request("GET", path)
            response = connection.getresponse()
            return response.status, response.read().decode(), time.monotonic() - begin
        finally:
            connection.close()

    def metric(self, name):
        """The sum over a metric's labels."""
        _, text, _ = self.get("/metrics")
        values = re.findall(rf"^{name}(?:{{[^}}]*}})? (\S+)$", text, re.MULTILINE)
        return sum(map(float, values)) if values else None

    def channel(self, *options, credentials=None):
        options = [("grpc.use_local_subchannel_pool", 1), *options]
        if frames.ROUTER_CA:
            credentials = grpc.ssl_channel_credentials(
                pathlib.Path(frames.ROUTER_CA).read_bytes())
        if credentials:
            return grpc.secure_channel(self.address, credentials, options)
        return grpc.insecure_channel(self.address, options)


class Router:
    """HAProxy of deploy/haproxy.cfg in front of one server; its certificate lies beside ROUTER_CA."""

    def __init__(self, folder, server, metrics):
        with socket.create_server(("127.0.0.1", 0)) as one, \
                socket.create_server(("127.0.0.1", 0)) as other:
            port, status = one.getsockname()[1], other.getsockname()[1]
        self.address = f"127.0.0.1:{port}"
        replicas = folder / "haproxy-replicas.cfg"
        replicas.write_text("backend dcloc from replicas\n  server dcloc-1 "
                            f"{server} port {metrics.rpartition(':')[2]} check-proto h1\n")
        environment = {
            "DCLOC_ROUTER_LISTEN": self.address, "DCLOC_ROUTER_STATUS": f"127.0.0.1:{status}",
            "DCLOC_ROUTER_CERTIFICATE": str(pathlib.Path(frames.ROUTER_CA).parent / "router.pem"),
            "DCLOC_ROUTER_CONNECTIONS": "5000", "PATH": os.environ["PATH"] + ":/usr/sbin"}
        with open(folder / "haproxy.log", "w", encoding="utf-8") as log:
            self.process = subprocess.Popen(
                ["haproxy", "-db", "-f", ROOT / "deploy/haproxy.cfg", "-f", replicas],
                env={**os.environ, **environment}, stdout=log, stderr=log)
        end = time.monotonic() + 20
        while True:
            try:
                socket.create_connection(("127.0.0.1", port)).close()
                return
            except OSError:
                if time.monotonic() > end or self.process.poll() is not None:
                    raise AssertionError((folder / "haproxy.log").read_text()) from None
                time.sleep(0.1)


class Vehicles:
    """Vehicles in a process of their own: what they see from the beginning to `result`. Each begins
    a new session, on a new connection, every `session_s`."""

    def __init__(self, target, stubs, count=5, rate_hz=10.0, session_s=2.0):
        self.process = subprocess.Popen(
            [sys.executable, HERE / "vehicles.py", stubs, target.address,
             target.vehicle_token or "-", str(count), str(rate_hz), str(session_s)],
            text=True, stdin=subprocess.PIPE, stdout=subprocess.PIPE)
        self.process.stdout.readline()  # they drive

    def result(self):
        """{"answers", "p50_ms", "p99_ms", "worst_ms", "refused": [text, ...]}."""
        out, _ = self.process.communicate("stop\n", timeout=60)
        return json.loads(out)


class ReadyWatch:
    """Asks /ready all the time, in a process of its own."""

    def __init__(self, target, interval_s=0.05):
        self.process = subprocess.Popen(
            [sys.executable, HERE / "ready_watch.py", target.metrics, str(interval_s)], text=True,
            stdin=subprocess.PIPE, stdout=subprocess.PIPE)
        self.process.stdout.readline()

    def result(self):
        """{"asked", "worst_ms", "p99_ms", "failed"}."""
        out, _ = self.process.communicate("stop\n", timeout=60)
        return json.loads(out)
