"""The Python package as a user has it: a wheel, installed offline."""

import importlib.util
import os
import pathlib
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent.parent
SYSTEM_PYTHON = pathlib.Path("/usr/bin/python3")


def run(*command, **options):
    """What it prints; an error if it fails."""
    done = subprocess.run([str(word) for word in command], text=True, stdout=subprocess.PIPE,
                          stderr=subprocess.STDOUT, check=False, timeout=120, **options)
    if done.returncode != 0:
        raise AssertionError(f"{' '.join(map(str, command))} failed: {done.stdout}")
    return done.stdout


def build_wheel(folder):
    """The file that client/python/build-wheel makes."""
    run(ROOT / "client/python/build-wheel", folder)
    (wheel,) = pathlib.Path(folder).glob("*.whl")
    return wheel


def install(wheel, target):
    """Into a folder for PYTHONPATH, without what the wheel depends on."""
    run(sys.executable, "-m", "pip", "install", "--quiet", "--no-deps", "--no-index", "--target",
        target, wheel)


def start_or_skip(programs):
    """Runs the tests of the caller's file, with the words after its name as `programs`. Where gRPC
    for Python or pip is not there, ends with 77. Debian's packages are for Debian's Python,
    whichever comes first in PATH."""
    import unittest

    def is_missing(module):
        try:
            return importlib.util.find_spec(module) is None
        except ModuleNotFoundError:
            return True
    missing = [module for module in ("grpc", "google.protobuf", "pip", "setuptools")
               if is_missing(module)]
    if missing and pathlib.Path(sys.executable).resolve() != SYSTEM_PYTHON.resolve():
        os.execv(SYSTEM_PYTHON, [SYSTEM_PYTHON, "-B", *sys.argv])
    if missing:
        print(f"skipped: needs Python's {', '.join(missing)}")
        sys.exit(77)
    count = len(programs)
    programs[:] = map(os.path.abspath, sys.argv[1:1 + count])
    unittest.main(module="__main__", argv=[sys.argv[0], *sys.argv[1 + count:]])
