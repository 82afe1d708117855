#!/usr/bin/env python3
"""What deploys the console, compared with its program and read by the programs that it is for."""

import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import unittest

SYSTEM_PYTHON = pathlib.Path("/usr/bin/python3")

try:
    import yaml
except ImportError:  # Debian package python3-yaml
    yaml = None
try:
    import kubernetes_objects
except ImportError:  # Debian package python3-kubernetes
    kubernetes_objects = None

ROOT = pathlib.Path(__file__).resolve().parents[2]
DEPLOY = ROOT / "deploy"
OPTIONS = (ROOT / "client/console/bridge/options.ts").read_text()

PROJECT = """
cmake_minimum_required(VERSION 3.25)
project(dcloc VERSION 1.2.3 LANGUAGES NONE)
set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_CONTACT "nobody <nobody@localhost>")
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "Localizes vehicles")
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_COMPONENTS_ALL)
set(CPACK_COMPONENTS_GROUPING IGNORE)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
include(%s/console.cmake)
include(CPack)
"""


def run(*command, **options):
    return subprocess.run([str(word) for word in command], stdout=subprocess.PIPE,
                          stderr=subprocess.STDOUT, text=True, check=False, timeout=120, **options)


class ConsoleFiles(unittest.TestCase):
    def check_arguments(self, arguments):
        """Each flag is one of the bridge's, as its help lists them."""
        for word in arguments:
            if word.startswith("--"):
                self.assertRegex(OPTIONS, rf"(?m)^  {re.escape(word)}( |$)", word)

    @unittest.skipIf(yaml is None, "needs Debian's python3-yaml")
    def test_compose_starts_it_with_what_it_knows(self):
        compose = yaml.safe_load((DEPLOY / "compose.yml").read_text())
        arguments = compose["services"]["console"]["command"]
        self.check_arguments(arguments)
        shown = [word.partition("=")[2] for flag, word in zip(arguments, arguments[1:])
                 if flag == "--server"]
        servers = [name for name in compose["services"] if name.startswith("dcloc-")]
        self.assertEqual(shown, [f"{name}:50051" for name in servers])

    @unittest.skipIf(yaml is None, "needs Debian's python3-yaml")
    def test_kubernetes_objects_fit_each_other(self):
        text = (DEPLOY / "kubernetes-console.yml").read_text()
        objects = {item["kind"]: item for item in yaml.safe_load_all(text)}
        deployment = objects["Deployment"]["spec"]
        pod = deployment["template"]
        self.assertEqual(deployment["selector"]["matchLabels"], pod["metadata"]["labels"])
        self.assertEqual(objects["Service"]["spec"]["selector"], pod["metadata"]["labels"])
        (container,) = pod["spec"]["containers"]
        self.check_arguments(container["args"])
        ports = {port["name"]: port["containerPort"] for port in container["ports"]}
        for port in objects["Service"]["spec"]["ports"]:
            self.assertIn(port["targetPort"], ports)
        self.assertIn(f"0.0.0.0:{ports['https']}", container["args"])
        mounts = {mount["name"]: mount["mountPath"] for mount in container["volumeMounts"]}
        self.assertEqual(set(mounts), {volume["name"] for volume in pod["spec"]["volumes"]})
        for word in container["args"]:
            if word.startswith("/"):
                self.assertTrue(any(word.startswith(path) for path in mounts.values()), word)

    @unittest.skipIf(yaml is None or kubernetes_objects is None, "needs python3-kubernetes")
    def test_kubernetes_knows_every_field(self):
        for item in yaml.safe_load_all((DEPLOY / "kubernetes-console.yml").read_text()):
            self.assertEqual(kubernetes_objects.faults(item), [])

    def test_the_image_is_made_of_what_is_there(self):
        text = (DEPLOY / "Dockerfile.console").read_text()
        copied = re.findall(r"(?m)^COPY (?!--from)(\S+) ", text)
        self.assertEqual(copied, ["proto", "client/console"])
        for source in copied:
            self.assertTrue((ROOT / source).is_dir(), source)

    def test_unit_image_and_package_have_it_in_one_place(self):
        program = "/usr/lib/dcloc-console/dcloc-console.cjs"
        for name in ("dcloc-console.service", "Dockerfile.console", "debian/console/default"):
            self.assertIn(program, (DEPLOY / name).read_text(), name)
        defaults = (DEPLOY / "debian/console/default").read_text()
        self.check_arguments(re.search(r"(?m)^DCLOC_CONSOLE_OPTIONS=(.*)$", defaults)[1].split())

    @unittest.skipUnless(shutil.which("systemd-analyze"), "needs systemd")
    def test_systemd_accepts_the_unit(self):
        with tempfile.TemporaryDirectory() as folder:
            unit = pathlib.Path(folder) / "dcloc-console.service"
            # Node need not be installed where the test runs.
            unit.write_text((DEPLOY / "dcloc-console.service").read_text().replace(
                "/usr/bin/node", "/bin/true"))
            result = run("systemd-analyze", "verify", "--man=no", unit)
        self.assertEqual(result.returncode, 0, result.stdout)
        self.assertNotIn("dcloc-console.service:", result.stdout, "a line is not understood")

    @unittest.skipUnless(shutil.which("cpack") and shutil.which("dpkg-deb"), "needs dpkg")
    def test_the_package_has_program_unit_and_settings(self):
        with tempfile.TemporaryDirectory() as name:
            folder = pathlib.Path(name)
            dist = folder / "dist"
            (dist / "page").mkdir(parents=True)
            (dist / "dcloc-console.cjs").write_text("#!/usr/bin/env node\n")
            (dist / "page/index.html").write_text("<title>dcloc console</title>\n")
            (folder / "CMakeLists.txt").write_text(PROJECT % DEPLOY)
            build = folder / "build"
            configured = run("cmake", "-S", folder, "-B", build, f"-DDCLOC_CONSOLE_DIST={dist}")
            self.assertEqual(configured.returncode, 0, configured.stdout)
            packed = run("cpack", cwd=build)
            self.assertEqual(packed.returncode, 0, packed.stdout)
            (package,) = build.glob("*.deb")
            self.assertEqual(package.name, "dcloc-console_1.2.3_all.deb")
            listed = run("dpkg-deb", "--contents", package).stdout
            for path in ("/usr/lib/dcloc-console/dcloc-console.cjs",
                         "/usr/lib/dcloc-console/page/index.html",
                         "/usr/lib/systemd/system/dcloc-console.service",
                         "/etc/default/dcloc-console"):
                self.assertIn(f".{path}\n", listed, path)
            told = run("dpkg-deb", "--info", package).stdout
            self.assertIn("Depends: nodejs (>= 18)", told)
            self.assertIn("conffiles", told)
            missing = run("cmake", "-S", folder, "-B", build, "-DDCLOC_CONSOLE_DIST=/nowhere")
            self.assertNotEqual(missing.returncode, 0)
            self.assertIn("has no dcloc-console.cjs", missing.stdout)


if __name__ == "__main__":
    incomplete = yaml is None or kubernetes_objects is None
    if incomplete and pathlib.Path(sys.executable).resolve() != SYSTEM_PYTHON.resolve():
        # Debian's packages are for Debian's Python, whichever comes first in PATH.
        os.execv(SYSTEM_PYTHON, [SYSTEM_PYTHON, "-B", *sys.argv])
    unittest.main()
