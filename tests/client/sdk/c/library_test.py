#!/usr/bin/env python3
"""libdcloc.so as C programs see it: its symbols, its header, and its example against a server.

Usage: library_test.py DCLOC SERVER LIBRARY [unittest arguments]
"""

import os
import pathlib
import re
import subprocess
import sys
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent.parent.parent
SOURCE = ROOT / "client/sdk/c"
sys.path.append(str(ROOT / "tests/end_to_end"))
ARGUMENTS = []
# The block of the version script, where it is not the first.
BLOCKS = {"dcloc_session_add_motion": "DCLOC_2", "dcloc_config_forget_answers": "DCLOC_3"}


def run(*command, **options):
    done = subprocess.run([str(word) for word in command], text=True, stdout=subprocess.PIPE,
                          stderr=subprocess.STDOUT, check=False, timeout=120, **options)
    if done.returncode != 0:
        raise AssertionError(f"{' '.join(map(str, command))} failed: {done.stdout}")
    return done.stdout


class Library(unittest.TestCase):
    def test_it_exports_what_its_header_declares_and_nothing_else(self):
        header = (SOURCE / "dcloc.h").read_text()
        declared = set(re.findall(r"^[a-z].*?\b(dcloc_[a-z_]+)\(", header, re.MULTILINE))
        table = run("nm", "--dynamic", "--defined-only", "--with-symbol-versions", ARGUMENTS[2])
        exported = {line.split()[-1] for line in table.splitlines()} - {"DCLOC_1", *BLOCKS.values()}
        self.assertEqual(exported, {f"{name}@@{BLOCKS.get(name, 'DCLOC_1')}" for name in declared})
        self.assertIn("libdcloc.so.1", run("readelf", "--dynamic", ARGUMENTS[2]))

    def test_the_header_is_plain_c_and_plain_cpp(self):
        with tempfile.TemporaryDirectory() as name:
            for compiler, standard, suffix in (("cc", "c99", "c"), ("c++", "c++98", "cpp")):
                program = pathlib.Path(name) / f"program.{suffix}"
                program.write_text('#include "dcloc.h"\nint main(void) { return 0; }\n')
                run(compiler, f"-std={standard}", "-Wall", "-Wextra", "-Wpedantic", "-Werror",
                    "-Wno-long-long", "-fsyntax-only", f"-I{SOURCE}", program)

    def test_the_example_runs(self):
        from processes import Programs, Server
        with tempfile.TemporaryDirectory() as name:
            folder = pathlib.Path(name)
            program = folder / "example"
            library = pathlib.Path(ARGUMENTS[2])
            run("cc", "-std=gnu11", "-Wall", "-Wextra", "-Werror", f"-I{SOURCE}",
                SOURCE / "example/example.c", "-o", program, f"-L{library.parent}", "-ldcloc",
                f"-Wl,-rpath,{library.parent}")
            programs = Programs(*ARGUMENTS[:2])
            programs.succeed("simulate", "--out", folder / "sim", "--length-m", "100")
            programs.succeed("map", "build", "--dataset", "nuscenes", "--root", folder / "sim",
                             "--drive", "map", "--out", folder / "map")
            with Server(programs, folder / "store") as server:
                programs.succeed("map", "upload", "--server", server.address, "--map", "town",
                                 "--activate", folder / "map")
                said = run(program, server.address, "town")
            # An empty scan confirms no place: the pose is refused by name, or told where it is.
            self.assertEqual(len(re.findall(r"^x .* y |^no answer", said, re.MULTILINE)), 100, said)
            refused = subprocess.run([program, "127.0.0.1:1", "town"], text=True,
                                     stdout=subprocess.PIPE, check=False, timeout=60)
            self.assertEqual(refused.returncode, 1)
            self.assertIn("127.0.0.1:1", refused.stdout)


if __name__ == "__main__":
    ARGUMENTS[:] = map(os.path.abspath, sys.argv[1:4])
    unittest.main(argv=[sys.argv[0], *sys.argv[4:]])
