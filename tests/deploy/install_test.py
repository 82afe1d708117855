#!/usr/bin/env python3
"""What is installed can be used: the client library from another project, the Debian packages.

Usage: install_test.py DCLOC SERVER BUILD [unittest arguments]
"""

import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
sys.path.append(str(ROOT / "tests/end_to_end"))
ARGUMENTS = []


def run(*command, **options):
    done = subprocess.run([str(word) for word in command], text=True, stdout=subprocess.PIPE,
                          stderr=subprocess.STDOUT, check=False, timeout=280, **options)
    if done.returncode != 0:
        raise AssertionError(f"{' '.join(map(str, command))} failed: {done.stdout}")
    return done.stdout


class ClientLibrary(unittest.TestCase):
    def test_a_project_of_ones_own_finds_builds_and_runs_the_example(self):
        from processes import Programs, Server
        with tempfile.TemporaryDirectory() as name:
            folder = pathlib.Path(name)
            prefix = folder / "prefix"
            run("cmake", "--install", ARGUMENTS[2], "--component", "sdk", "--prefix", prefix)
            include = prefix / "include/dcloc"
            for header in include.glob("client/sdk/**/*.h"):
                for used in re.findall(r'#include "((?:client|dcloc)/[^"]+)"', header.read_text()):
                    self.assertTrue((include / used).is_file(), f"{header.name} needs {used}")
            source = folder / "example"
            shutil.copytree(prefix / "share/dcloc/example", source)
            # Nothing of the checkout is looked at.
            run("cmake", "-S", source, "-B", folder / "build", f"-DCMAKE_PREFIX_PATH={prefix}",
                "-DCMAKE_BUILD_TYPE=Debug")
            run("cmake", "--build", folder / "build")
            programs = Programs(*ARGUMENTS[:2])
            programs.succeed("simulate", "--out", folder / "sim", "--length-m", "100")
            programs.succeed("map", "build", "--dataset", "nuscenes", "--root", folder / "sim",
                             "--drive", "map", "--out", folder / "map")
            with Server(programs, folder / "store") as server:
                programs.succeed("map", "upload", "--server", server.address, "--map", "town",
                                 "--activate", folder / "map")
                answer = run(folder / "build/example", server.address, "town")
            self.assertIn("result {", answer)
            self.assertIn("LOCALIZATION_STATE_", answer)


@unittest.skipIf(shutil.which("dpkg-deb") is None, "needs dpkg-deb")
class Packages(unittest.TestCase):
    def test_the_packages_have_what_they_should(self):
        with tempfile.TemporaryDirectory() as name:
            folder = pathlib.Path(name)
            run("cpack", "--config", pathlib.Path(ARGUMENTS[2]) / "CPackConfig.cmake", "-B",
                folder, cwd=folder)
            (programs,) = folder.glob("dcloc_*.deb")
            (sdk,) = folder.glob("libdcloc-dev_*.deb")
            depends = run("dpkg-deb", "--field", programs, "Depends")
            for package in ("libgrpc++1.51", "libprotobuf32", "libsqlite3-0", "libc6"):
                self.assertIn(package, depends)
            root = folder / "root"
            run("dpkg-deb", "-x", programs, root)
            run("dpkg-deb", "-x", sdk, root)
            unit = (root / "lib/systemd/system/dcloc-server.service"
                    if (root / "lib/systemd/system").exists()
                    else root / "usr/lib/systemd/system/dcloc-server.service").read_text()
            program = re.search(r"^ExecStart=(\S+)", unit, re.MULTILINE).group(1)
            self.assertTrue(os.access(root / program[1:], os.X_OK), program)
            self.assertIn("dcloc ", run(root / "usr/bin/dcloc", "--version"))
            manual = (root / "usr/share/man/man1/dcloc.1").read_text()
            self.assertIn(".SS dcloc session replay", manual)
            manual = (root / "usr/share/man/man8/dcloc-server.8").read_text()
            for said in (r"\-\-max\-session\-count", r"token create", "SIGHUP"):
                self.assertIn(said, manual)
            self.assertNotIn(ARGUMENTS[1], manual, "no path of the build")
            self.assertTrue((root / "usr/share/bash-completion/completions/dcloc").is_file())
            self.assertTrue(list(root.glob("usr/lib/**/cmake/dcloc/dclocConfig.cmake")))
            self.assertTrue((root / "usr/include/dcloc/client/sdk/session.h").is_file())
            control = folder / "control"
            run("dpkg-deb", "-e", programs, control)
            for script in ("postinst", "postrm", "prerm"):
                run("sh", "-n", control / script)
            copied = re.search(r"cp (\S+)", (control / "postinst").read_text()).group(1)
            self.assertTrue((root / copied[1:]).is_file(), copied)


if __name__ == "__main__":
    ARGUMENTS[:] = map(os.path.abspath, sys.argv[1:4])
    unittest.main(argv=[sys.argv[0], *sys.argv[4:]])
