#!/usr/bin/env python3
"""What is installed can be used: the client libraries from other projects, the Debian packages.

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


class ClientLibraries(unittest.TestCase):
    """Each as a project of one's own finds it: nothing of the checkout is looked at."""

    @classmethod
    def setUpClass(cls):
        from processes import Programs, Server
        cls.folder = pathlib.Path(cls.enterClassContext(tempfile.TemporaryDirectory()))
        programs = Programs(*ARGUMENTS[:2])
        programs.succeed("simulate", "--out", cls.folder / "sim", "--length-m", "100")
        programs.succeed("map", "build", "--dataset", "nuscenes", "--root", cls.folder / "sim",
                         "--drive", "map", "--out", cls.folder / "map")
        cls.server = cls.enterClassContext(Server(programs, cls.folder / "store"))
        programs.succeed("map", "upload", "--server", cls.server.address, "--map", "town",
                         "--activate", cls.folder / "map")

    def install(self, *components):
        """Where they are, as nowhere known to compilers."""
        prefix = self.folder / components[0]
        for component in components:
            run("cmake", "--install", ARGUMENTS[2], "--component", component, "--prefix", prefix)
        return prefix

    def build(self, prefix, example):
        """The program of an example that is installed with the library."""
        source = self.folder / f"source-{example}"
        shutil.copytree(prefix / "share/dcloc" / example, source)
        run("cmake", "-S", source, "-B", source / "build", f"-DCMAKE_PREFIX_PATH={prefix}",
            "-DCMAKE_BUILD_TYPE=Debug")
        run("cmake", "--build", source / "build")
        return source / "build/example"

    def test_the_cpp_library_is_found_by_cmake(self):
        prefix = self.install("sdk")
        include = prefix / "include/dcloc"
        for header in include.glob("client/sdk/**/*.h"):
            for used in re.findall(r'#include "((?:client|dcloc)/[^"]+)"', header.read_text()):
                self.assertTrue((include / used).is_file(), f"{header.name} needs {used}")
        answer = run(self.build(prefix, "example"), self.server.address, "town")
        self.assertEqual(len(re.findall("^(?:x |no pose yet)", answer, re.MULTILINE)), 100, answer)

    def test_the_c_library_is_found_by_cmake_and_by_pkg_config(self):
        prefix = self.install("c", "c_dev")
        said = run(self.build(prefix, "example-c"), self.server.address, "town")
        self.assertEqual(said.count("\n"), 100, said)
        if shutil.which("pkg-config") is None:
            self.skipTest("needs pkg-config")
        (folder,) = prefix.glob("lib*/**/pkgconfig")
        flags = run("pkg-config", "--cflags", "--libs", "dcloc",
                    env={**os.environ, "PKG_CONFIG_PATH": str(folder)}).split()
        program = self.folder / "by-pkg-config"
        run("cc", prefix / "share/dcloc/example-c/example.c", "-o", program, *flags)
        said = run(program, self.server.address, "town",
                   env={**os.environ, "LD_LIBRARY_PATH": str(folder.parent)})
        self.assertEqual(said.count("\n"), 100, said)


@unittest.skipIf(shutil.which("dpkg-deb") is None, "needs dpkg-deb")
class Packages(unittest.TestCase):
    def test_the_packages_have_what_they_should(self):
        with tempfile.TemporaryDirectory() as name:
            folder = pathlib.Path(name)
            run("cpack", "--config", pathlib.Path(ARGUMENTS[2]) / "CPackConfig.cmake", "-B",
                folder, cwd=folder)
            (programs,) = folder.glob("dcloc_*.deb")
            (library,) = folder.glob("libdcloc1_*.deb")
            (header,) = folder.glob("libdcloc-dev_*.deb")
            (sdk,) = folder.glob("libdcloc++-dev_*.deb")
            depends = run("dpkg-deb", "--field", programs, "Depends")
            for package in ("libgrpc++1.51", "libprotobuf32", "libsqlite3-0", "libc6"):
                self.assertIn(package, depends)
            root = folder / "root"
            run("dpkg-deb", "-x", programs, root)
            for package in (library, header, sdk):
                run("dpkg-deb", "-x", package, root)
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
            self.assertTrue((root / "usr/share/zsh/vendor-completions/_dcloc").is_file())
            self.assertTrue(list(root.glob("usr/lib/**/cmake/dcloc/dclocConfig.cmake")))
            self.assertTrue((root / "usr/include/dcloc/client/sdk/session.h").is_file())
            self.assertTrue((root / "usr/include/dcloc.h").is_file())
            (link,) = root.glob("usr/lib/**/libdcloc.so")
            self.assertEqual(os.readlink(link), "libdcloc.so.1")
            self.assertTrue(link.is_file(), "the package of the library has what it points to")
            self.assertIn("libdcloc1 (=", run("dpkg-deb", "--field", header, "Depends"))
            self.assertIn("libgrpc++1.51", run("dpkg-deb", "--field", library, "Depends"))
            control = folder / "control-library"
            run("dpkg-deb", "-e", library, control)
            self.assertEqual((control / "shlibs").read_text().split()[:2], ["libdcloc", "1"])
            control = folder / "control"
            run("dpkg-deb", "-e", programs, control)
            for script in ("postinst", "postrm", "prerm"):
                run("sh", "-n", control / script)
            copied = re.search(r"cp (\S+)", (control / "postinst").read_text()).group(1)
            self.assertTrue((root / copied[1:]).is_file(), copied)


if __name__ == "__main__":
    ARGUMENTS[:] = map(os.path.abspath, sys.argv[1:4])
    unittest.main(argv=[sys.argv[0], *sys.argv[4:]])
