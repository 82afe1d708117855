#!/usr/bin/env python3
"""What lies in deploy/ fits the programs: metrics, settings, ports, files, certificates.

Usage: deploy_test.py DCLOC SERVER [unittest arguments]
"""

import functools
import json
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
try:
    import kubernetes_objects
except ImportError:  # Debian package python3-kubernetes
    kubernetes_objects = None

DEPLOY = pathlib.Path(__file__).resolve().parent.parent.parent / "deploy"
METRIC = re.compile(r"\b(?:dcloc|process)_[a-z0-9_]+\b")
PROGRAMS = []
SYSTEM_PYTHON = pathlib.Path("/usr/bin/python3")
needs_yaml = unittest.skipIf(yaml is None, "needs Python's yaml (Debian package python3-yaml)")


def needs_program(name, package):
    return unittest.skipIf(shutil.which(name) is None, f"needs {name} (Debian package {package})")


def run(*command, **options):
    return subprocess.run([str(word) for word in command], text=True, stdout=subprocess.PIPE,
                          stderr=subprocess.STDOUT, check=False, timeout=60, **options)


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


def dpkg_query(*arguments):
    return run("dpkg-query", *arguments).stdout.splitlines()


def libraries_of(program):
    """{library: Debian package} of what the program itself is linked with; ours are not there."""
    packages = {}
    linked = set(re.findall(r"NEEDED.*\[(.*)\]", run("readelf", "--dynamic", program).stdout))
    for line in run("ldd", program).stdout.splitlines():
        found = re.match(r"\s*(\S+) => (/\S+)", line)
        if found and found.group(1) in linked:
            # As it is found, or, since / and /usr are one, as the package names it.
            file = os.path.realpath(found.group(2))
            for name in (file, file.removeprefix("/usr")):
                owners = [owner for owner in dpkg_query("--search", name) if ": " in owner]
                if owners and not owners[0].startswith("dpkg-query:"):
                    packages[found.group(1)] = owners[0].split(":")[0]
                    break
    return packages


def closure(packages):
    """The packages with all that they depend on, as far as it is installed here."""
    depends, providers = {}, {}
    for line in dpkg_query("--show", "--showformat",
                           "${Package}\t${Provides}\t${Pre-Depends}, ${Depends}\n"):
        name, provides, needs = line.split("\t")
        depends[name] = re.split(r"[,|]", re.sub(r"\([^)]*\)|:any|\s", "", needs))
        for provided in re.sub(r"\([^)]*\)|\s", "", provides).split(","):
            providers.setdefault(provided, set()).add(name)
    found, new = set(), set(packages)
    while new:
        found |= new
        needed = {word for name in new for word in depends.get(name, []) if word}
        needed |= {name for word in needed for name in providers.get(word, ())}
        new = needed - found
    return found


def servers_of(haproxy_list):
    """[(name, host)] of the router's list; each with the check of /ready."""
    return re.findall(r"^ *server (\S+) (\S+):50051 port 9464 check-proto h1$", haproxy_list,
                      re.MULTILINE)


def load_yaml(path):
    return list(yaml.safe_load_all(path.read_text(encoding="utf-8")))


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
    """What cannot be run here is at least read by its own program, or as what it is."""

    def check_server_arguments(self, arguments):
        """Every flag is one of dcloc-server's."""
        help_text = run(PROGRAMS[1], "--help").stdout
        for word in arguments:
            if word.startswith("--"):
                self.assertRegex(help_text, re.escape(word) + r"\s", f"dcloc-server has no {word}")

    @needs_yaml
    def test_compose_refers_to_what_is_there(self):
        (compose,) = load_yaml(DEPLOY / "compose.yml")
        made_by_user = {"./certs/dcloc.pem", "./certs/pgpass", "./certs/database-password"}
        services = compose["services"]
        for name, service in services.items():
            for volume in service.get("volumes", []):
                source = volume.split(":")[0]
                if source.startswith("./"):
                    self.assertTrue(source in made_by_user or (DEPLOY / source).exists(),
                                    f"{name}: {source}")
                else:
                    self.assertIn(source, compose["volumes"], name)
            for network in service["networks"]:
                self.assertIn(network, compose["networks"], name)
        self.check_server_arguments(services["dcloc-1"]["command"])
        for secret in compose["secrets"].values():
            self.assertIn(secret["file"], made_by_user)
        jobs = {job["job_name"]: job["static_configs"][0]["targets"] for job in load_yaml(
            DEPLOY / "monitoring/prometheus.yml")[0]["scrape_configs"]}
        servers = [name for name in services if name.startswith("dcloc-")]
        self.assertEqual(jobs["dcloc"], [f"{name}:9464" for name in servers])
        self.assertEqual(jobs["router"], ["router:8404"])
        self.assertEqual(servers_of((DEPLOY / "haproxy-replicas.cfg").read_text()),
                         [(name, name) for name in servers])

    @needs_program("docker-compose", "docker-compose")
    def test_compose_reads_its_file(self):
        result = run("docker-compose", "--file", DEPLOY / "compose.yml", "config", "--quiet")
        self.assertEqual(result.returncode, 0, result.stdout)

    def dockerfile(self):
        """Its instructions: (name, words)."""
        text = re.sub(r"^#.*\n", "", (DEPLOY / "Dockerfile").read_text(), flags=re.MULTILINE)
        lines = [line.split() for line in text.replace("\\\n", " ").splitlines() if line.strip()]
        return [(words[0], words[1:]) for words in lines]

    def test_the_image_has_every_library_that_the_programs_need(self):
        words = [word for name, words in self.dockerfile() if name == "RUN" for word in words]
        listed = words[words.index("--no-install-recommends") + 1:]
        installed = closure(listed[:listed.index("&&")])
        for program in PROGRAMS:
            for library, package in libraries_of(program).items():
                self.assertTrue(package in installed, f"{program} needs {library} of {package}")

    def test_the_image_is_made_of_what_is_there(self):
        instructions = self.dockerfile()
        known = {"FROM", "WORKDIR", "COPY", "RUN", "USER", "VOLUME", "EXPOSE", "STOPSIGNAL",
                 "ENTRYPOINT"}
        self.assertEqual({name for name, _ in instructions} - known, set())
        for name, words in instructions:
            if name == "COPY" and not words[0].startswith("--from"):
                for source in words[:-1]:
                    self.assertTrue((DEPLOY.parent / source).exists(), source)
        entrypoint = json.loads(" ".join(dict(instructions)["ENTRYPOINT"]))
        self.assertEqual(entrypoint[0], "dcloc-server")
        self.check_server_arguments(entrypoint)

    @needs_program("buildah", "buildah")
    @unittest.skipIf(os.geteuid() != 0, "needs root")
    def test_buildah_reads_the_dockerfile(self):
        """Each instruction is carried out, with programs that do nothing in the place of those that
        take long; tests/deploy/image builds the image as it is."""
        with tempfile.TemporaryDirectory() as name:
            folder = pathlib.Path(name)

            def build(file, tag, context):
                return run("buildah", "--storage-driver", "vfs", "--root", folder / "storage",
                           "--runroot", folder / "run", "build", "--isolation", "chroot",
                           "--pull-never", "--file", file, "--tag", tag, context)

            def script(path, text="exit 0"):
                path.parent.mkdir(parents=True, exist_ok=True)
                path.write_text(f"#!/bin/sh\n{text}\n")
                path.chmod(0o755)

            base = folder / "base"
            for library in re.findall(r"(/\S+) \(0x", run("ldd", "/bin/sh").stdout):
                copy = base / library.lstrip("/")
                copy.parent.mkdir(parents=True, exist_ok=True)
                shutil.copy(library, copy)
            (base / "bin").mkdir()
            shutil.copy("/bin/sh", base / "bin")
            for program in ("apt-get", "install", "rm", "strip", "useradd"):
                script(base / "bin" / program)
            (folder / "Basefile").write_text("FROM scratch\nCOPY base /\n")
            made = build(folder / "Basefile", "docker.io/library/debian:bookworm-slim", folder)
            if made.returncode != 0:
                self.skipTest(f"buildah cannot work here: {made.stdout}")

            tree = folder / "tree"
            script(tree / "deploy/install-packages")
            (tree / "deploy/packages.txt").touch()
            script(tree / "deploy/build", "\n".join(
                f"echo >build/release/bin/{program}" for program in ("dcloc", "dcloc-server")))
            (tree / "build/release/bin").mkdir(parents=True)
            made = build(DEPLOY / "Dockerfile", "dcloc", tree)
            self.assertEqual(made.returncode, 0, made.stdout)
            text = (DEPLOY / "Dockerfile").read_text()
            for right, wrong in (("\nSTOPSIGNAL", "\nSTOPSIGNALS"), ("--from=build", "--form=build"),
                                 ("rm -rf", "(rm -rf"), (" AS build", " AS AS build")):
                self.assertIn(right, text)
                (folder / "Dockerfile").write_text(text.replace(right, wrong))
                broken = build(folder / "Dockerfile", "broken", tree)
                self.assertNotEqual(broken.returncode, 0, wrong)

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
        self.check_server_arguments(container["args"])
        settings = json.loads(objects["ConfigMap"]["data"]["server.json"])
        self.assertTrue(settings["listen"].endswith(f":{ports['grpc']}"))
        self.assertTrue(settings["metrics_listen"].endswith(f":{ports['metrics']}"))
        self.assertGreater(pod["spec"]["terminationGracePeriodSeconds"] * 1000,
                           settings["shutdown_deadline_ms"])
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder) / "server.json"
            # Its certificates and keys are not here.
            path.write_text(json.dumps({key: value for key, value in settings.items()
                                        if not key.startswith(("tls_", "object_cred"))}
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
    PROGRAMS[:] = map(os.path.abspath, sys.argv[1:3])
    incomplete = yaml is None or kubernetes_objects is None
    if incomplete and pathlib.Path(sys.executable).resolve() != SYSTEM_PYTHON.resolve():
        # Debian's packages are for Debian's Python, whichever comes first in PATH.
        os.execv(SYSTEM_PYTHON, [SYSTEM_PYTHON, "-B", *sys.argv])
    unittest.main(argv=[sys.argv[0], *sys.argv[3:]])
