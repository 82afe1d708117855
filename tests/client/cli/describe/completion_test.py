#!/usr/bin/env python3
"""What bash and zsh offer for words behind `dcloc`, by the scripts that it prints; its manual.

Usage: completion_test.py DCLOC [unittest arguments]
"""

import os
import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest

PROGRAMS = []

BASH = r"""
. <("$DCLOC" completion)
COMP_WORDS=(dcloc "$@") COMP_CWORD=$#
compopt() { echo "files"; }
_dcloc
printf '%s\n' "${COMPREPLY[@]}"
"""

# Beside an editor its functions only print what they are given.
ZSH = r"""
compdef() { :; }
. <("$DCLOC" completion zsh)
_describe() { print -l -- "${(P@)2}"; }
_files() { print files; }
words=(dcloc "$@") CURRENT=$(($# + 1))
_dcloc
"""

ZSH_INSTALLED = r"""
fpath=($1 $fpath)
autoload -Uz compinit && compinit -u -D
print -- ${_comps[dcloc]}
_describe() { print -l -- "${(P@)2}"; }
words=(dcloc map '') CURRENT=3
_dcloc
"""


def run(*command):
    done = subprocess.run(command, text=True, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                          env={**os.environ, "DCLOC": PROGRAMS[0]}, timeout=60, check=False)
    if done.returncode != 0 or done.stderr:
        raise AssertionError(f"{command[0]} failed: {done.stdout}{done.stderr}")
    return done.stdout


class Completion:
    """The same for each shell: `offered(words)`, the last one of which is being typed."""

    def test_commands_and_options_of_the_place(self):
        top = self.offered("")
        self.assertIn("session", top)
        self.assertIn("doctor", top)
        session = self.offered("session", "")
        self.assertIn("replay", session)
        self.assertNotIn("upload", session)
        self.assertIn("--token-file", self.offered("session", "list", "--"))
        self.assertIn("--all-versions", self.offered("map", "delete", "--map", "x", "--"),
                      "options of groups are there as well")

    def test_values_where_there_are_but_some(self):
        self.assertEqual(self.offered("localize", "--dataset", ""),
                         ["nuscenes", "radarscenes", "rosbag", "snail-radar", "ntu4dradlm",
                          "msc-rad4r", "hercules", "zod"])

    def test_files_elsewhere(self):
        self.assertIn("files", self.offered("map", "inspect", "/no-such"))


class Bash(Completion, unittest.TestCase):
    def offered(self, *words):
        return run("bash", "-c", BASH, "bash", *words).split()


@unittest.skipIf(shutil.which("zsh") is None, "needs zsh")
class Zsh(Completion, unittest.TestCase):
    def offered(self, *words):
        lines = run("zsh", "-f", "-c", ZSH, "zsh", *words).splitlines()
        return [line.partition(":")[0] for line in lines]

    def test_words_are_described(self):
        said = run("zsh", "-f", "-c", ZSH, "zsh", "map", "")
        self.assertIn("build:Make a map of a recorded drive\n", said)

    def test_an_installed_file_is_found_and_loaded(self):
        with tempfile.TemporaryDirectory() as folder:
            (pathlib.Path(folder) / "_dcloc").write_text(run(PROGRAMS[0], "completion", "zsh"))
            said = run("zsh", "-f", "-c", ZSH_INSTALLED, "zsh", folder)
        self.assertTrue(said.startswith("_dcloc\n"), said)
        self.assertIn("survey:", said)


class Manual(unittest.TestCase):
    def test_another_shell_is_refused_by_name(self):
        refused = subprocess.run([PROGRAMS[0], "completion", "tcsh"], text=True, check=False,
                                 stdout=subprocess.PIPE, stderr=subprocess.PIPE)
        self.assertEqual(refused.returncode, 2)
        self.assertIn("tcsh", refused.stderr)

    @unittest.skipIf(shutil.which("groff") is None, "needs groff")
    def test_troff_has_nothing_to_say_of_the_manual(self):
        manual = run(PROGRAMS[0], "manual")
        done = subprocess.run(["groff", "-man", "-Tutf8", "-ww", "-rLL=200n", "-z"], input=manual,
                              text=True, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                              check=False)
        self.assertEqual(done.stdout, "")


if __name__ == "__main__":
    PROGRAMS[:] = [os.path.abspath(sys.argv[1])]
    unittest.main(argv=[sys.argv[0], *sys.argv[2:]])
