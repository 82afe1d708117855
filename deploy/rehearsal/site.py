"""A whole site on one machine: engines, replicas, router, map, and who may call."""

import json
import pathlib
import re
import secrets
import signal
import time
import urllib.error
import urllib.request

from rehearsal.engines import PATH, ROOT, Database, ObjectStore, SharedFolder
from rehearsal.programs import LOOPBACK, Failure, Program, free_port, run, wait_until

MAP = "town"
# The router asks each replica twice a second, and believes the second answer.
DRAIN_NOTICE_MS = 1000


def http(port, path, timeout_s=2):
    """The status and the text of a page; (0, "") if nobody answers."""
    try:
        with urllib.request.urlopen(f"http://{LOOPBACK}:{port}{path}", timeout=timeout_s) as page:
            return page.status, page.read().decode()
    except urllib.error.HTTPError as error:
        return error.code, ""
    except OSError:
        return 0, ""


def metric(text, name):
    """The sum of a metric over its labels."""
    return sum(map(float, re.findall(rf"^{name}(?:{{[^}}]*}})? (\S+)$", text, re.MULTILINE)))


class Replica:
    """One dcloc-server. Its ports stay when it is started again."""

    def __init__(self, name, site):
        self.name = name
        self.site = site
        self.data = site.folder / name
        self.port, self.metrics_port = free_port(), free_port()

    def start(self):
        site = self.site
        self.program = Program(
            self.name, [site.server, "--catalogue", site.database.address, *site.files.flags,
                        "--database-timeout-ms", site.database_timeout_ms, "--data", self.data,
                        "--listen", f"{LOOPBACK}:{self.port}",
                        "--metrics-listen", f"{LOOPBACK}:{self.metrics_port}",
                        "--tls-cert", site.folder / "certificates/localhost.pem",
                        "--tls-key", site.folder / "certificates/localhost.key",
                        "--replica-address", LOOPBACK,
                        "--replica-ca", site.folder / "certificates/ca.pem",
                        "--ticket-keys", site.folder / "ticket-keys",
                        "--drain-notice-ms", DRAIN_NOTICE_MS,
                        "--require-identity"], site.folder / f"{self.name}.log")

        def is_ready():
            if not self.program.alive():
                raise Failure(f"{self.name} did not start: {self.program.text()[-2000:]}")
            return http(self.metrics_port, "/ready")[0] == 200

        wait_until(is_ready, 60, self.name)

    def metrics(self):
        return http(self.metrics_port, "/metrics")[1]

    def session_count(self):
        return int(metric(self.metrics(), "dcloc_sessions"))

    def is_building(self):
        """Whether it takes in the scans of a map to build."""
        return any((self.data / "incoming").glob("*"))


class Site:
    """Starts everything; `close` ends it."""

    def __init__(self, folder, bin_folder, files, replica_count, patience, say):
        self.folder = pathlib.Path(folder)
        self.dcloc = pathlib.Path(bin_folder) / "dcloc"
        self.server = pathlib.Path(bin_folder) / "dcloc-server"
        self.patience = patience
        self.database_timeout_ms = int(2000 * patience)
        self.say = say
        self.replicas = []
        self.database = self.files = self.router = None
        self.replica_count = replica_count
        self.files_kind = files

    def start(self):
        self._make_certificates()
        self._make_ticket_keys()
        self.say("PostgreSQL with PostGIS, in a folder of its own")
        self.database = Database(self.folder / "database")
        self.files = (ObjectStore if self.files_kind == "s3" else SharedFolder)(
            self.folder / "files")
        self.say(f"{self.files.name}, for the map files")
        self.token_file = self.make_token("operator", "operator")
        for i in range(1, self.replica_count + 1):
            self.replicas.append(Replica(f"dcloc-{i}", self))
            self.replicas[-1].start()
        self.say(f"{self.replica_count} replicas with TLS")
        self._start_router()
        self.expect_call("map", "list")
        wait_until(lambda: len(self.replicas_seen()) == self.replica_count, 20 * self.patience,
                   "a view of all replicas")
        self.say(f"HAProxy on {self.address}")

    def _make_certificates(self):
        folder = self.folder / "certificates"
        run(ROOT / "deploy/certificates", "--out", folder, "--server", f"localhost,{LOOPBACK}")
        (folder / "router.pem").write_text(
            (folder / "localhost.pem").read_text() + (folder / "localhost.key").read_text())

    def _make_ticket_keys(self):
        """With one key for all, a replica goes on with the sessions of one that is gone."""
        path = self.folder / "ticket-keys"
        path.touch(mode=0o600)
        path.write_text(f"rehearsal {secrets.token_hex(32)}\n")

    def make_token(self, name, role):
        """The file of a new token."""
        path = self.folder / f"{name}.token"
        path.touch(mode=0o600)
        command = [self.server, "token", "create", "--catalogue", self.database.address, "--name",
                   name, "--role", role]
        for is_last in (False, False, True):  # the database of a busy machine may be late
            made = run(*command, check=is_last)
            if made.returncode == 0:
                break
        path.write_text(made.stdout)
        return path

    def _start_router(self):
        """The router of deploy/haproxy.cfg, with this site's list of servers."""
        self.address = f"localhost:{free_port()}"
        self.status_port = free_port()
        replicas = self.folder / "haproxy-replicas.cfg"
        replicas.write_text("\n".join(
            ["backend dcloc from replicas",
             f"  default-server ssl alpn h2 verify required verifyhost localhost ca-file "
             f"{self.folder}/certificates/ca.pem",
             *(f"  server {replica.name} {LOOPBACK}:{replica.port} port {replica.metrics_port} "
               "check-proto h1"
               for replica in self.replicas), ""]))
        haproxy = run("which", "haproxy", env={"PATH": PATH}).stdout.strip()
        files = ["-f", ROOT / "deploy/haproxy.cfg", "-f", replicas]
        environment = {
            "DCLOC_ROUTER_CONNECTIONS": "2000",
            "DCLOC_ROUTER_LISTEN": f"{LOOPBACK}:{self.address.rpartition(':')[2]}",
            "DCLOC_ROUTER_STATUS": f"{LOOPBACK}:{self.status_port}",
            "DCLOC_ROUTER_CERTIFICATE": str(self.folder / "certificates/router.pem")}
        self.router = Program("HAProxy", [haproxy, "-W", "-db", *files], self.folder / "haproxy.log",
                              environment=environment)

        def is_ready():
            if not self.router.alive():
                raise Failure(f"HAProxy did not start: {self.router.text()[-2000:]}")
            return http(self.status_port, "/ready")[0] == 200

        wait_until(is_ready, 20, "HAProxy")

    def access(self, token_file=None):
        """Flags of a client of the router."""
        return ["--server", self.address, "--tls-ca", self.folder / "certificates/ca.pem",
                "--token-file", token_file or self.token_file]

    def call(self, *words, check=True):
        """A command of the operator, through the router."""
        return run(self.dcloc, *words, *self.access(), check=check)

    def expect_call(self, *words, timeout_s=20):
        """A call that succeeds within a time; else why the last one did not."""
        end = time.monotonic() + timeout_s
        while self.call(*words, check=time.monotonic() > end).returncode != 0:
            time.sleep(0.1)

    def json(self, *words):
        """What a command of the operator prints with --json."""
        return json.loads(self.call(*words, "--json").stdout)

    def make_drives(self, length_m):
        """A simulated town, its map as version 1, and a drive through it."""
        self.drives, town = self.folder / "drives", self.folder / "town.dclm"
        run(self.dcloc, "simulate", "--out", self.drives, "--length-m", length_m, "--map-speed-kmh",
            72, "--live-speed-kmh", 40, timeout_s=600)
        self.say(f"two drives of {length_m} m through a simulated town")
        run(self.dcloc, "map", "build", "--dataset", "nuscenes", "--root", self.drives, "--drive",
            "map", "--out", town, timeout_s=600)
        self.call("map", "upload", "--map", MAP, "--activate", town)
        self.say("a map of the first one, uploaded through one replica")

    def drive(self, name="live-0"):
        """Flags of a drive."""
        return ["--dataset", "nuscenes", "--root", self.drives, "--drive", name]

    def replicas_seen(self):
        """The replicas that answer, as whichever of them the router asks says."""
        done = self.call("server", "status", "--all", "--json", check=False)
        return [seen for seen in json.loads(done.stdout or "[]") if seen["state"]]

    def session_count(self):
        return sum(replica.session_count() for replica in self.replicas)

    def replica_by(self, key):
        return max((replica for replica in self.replicas if replica.program.alive()), key=key)

    def close(self):
        """Ends what runs, the users of a thing before it. What did not end as it should."""
        faults = []
        programs = [self.router, *(getattr(r, "program", None) for r in self.replicas),
                    getattr(self.files, "program", None), getattr(self.database, "program", None)]
        for program in filter(None, programs):
            try:
                if program.alive() and program.end() not in (0, -signal.SIGTERM, 143):
                    faults.append(f"{program.name} ended with {program.process.returncode}")
            except Failure as failure:
                faults.append(str(failure))
        return faults
