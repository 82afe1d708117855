#!/usr/bin/env python3
"""Runs client/TUTORIAL.md line by line, and compares what it shows with what is printed.

Usage: tutorial_test.py DCLOC SERVER [unittest arguments]
"""

import os
import pathlib
import re
import subprocess
import sys
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
PROGRAMS = []


def blocks(text):
    """(language, content) of each fenced block."""
    return re.findall(r"^```(\w+)\n(.*?)^```$", text, re.MULTILINE | re.DOTALL)


class Tutorial(unittest.TestCase):
    def test_each_line_succeeds_and_prints_what_is_shown(self):
        script, shown = ["set -euo pipefail", "trap 'kill $(jobs -p) 2>/dev/null' EXIT"], []
        for language, content in blocks((ROOT / "client/TUTORIAL.md").read_text()):
            if language == "sh":
                # A line that fails is named.
                for line in content.splitlines():
                    script += [f"echo '$' {line.split('|')[0].split('>')[0].split('&')[0]!r}", line]
            else:
                shown += content.splitlines()
        self.assertGreater(len(shown), 3)
        with tempfile.TemporaryDirectory() as folder:
            path = f"{os.path.dirname(PROGRAMS[0])}:{os.path.dirname(PROGRAMS[1])}"
            done = subprocess.run(["bash", "-c", "\n".join(script)], cwd=folder, text=True,
                                  env={**os.environ, "PATH": f"{path}:{os.environ['PATH']}"},
                                  stdout=subprocess.PIPE, stderr=subprocess.STDOUT, timeout=240,
                                  check=False)
            self.assertEqual(done.returncode, 0, done.stdout)
            for line in shown:
                self.assertIn(line, done.stdout)
            for made in ("town.dclm", "live-0.csv", "live-0.tum", "live-0.png", "monday.csv"):
                self.assertTrue((pathlib.Path(folder) / made).stat().st_size > 0, made)


if __name__ == "__main__":
    PROGRAMS[:] = map(os.path.abspath, sys.argv[1:3])
    unittest.main(argv=[sys.argv[0], *sys.argv[3:]])
