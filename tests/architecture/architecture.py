#!/usr/bin/env python3
"""Checks that the tree is built as it was designed; floors.py says how.

Usage: architecture.py [--figures] [ROOT]
Prints one line for each violation; the exit status is 1 if there is one. --figures prints first how
large files and targets are, with their bounds.
"""

import argparse
import pathlib
import sys

sys.dont_write_bytecode = True  # the tree stays as it is

from include_check import IncludeCheck  # noqa: E402
from link_check import LinkCheck  # noqa: E402
from mirror_check import MirrorCheck  # noqa: E402
from shape_check import ShapeCheck  # noqa: E402


CHECKS = (ShapeCheck, MirrorCheck, IncludeCheck, LinkCheck)


def run_checks(root):
    """The checks, done on the tree at `root`, and a line for each violation."""
    found = []
    checks = [check(root, lambda path, text: found.append(f"{path}: {text}")) for check in CHECKS]
    for check in checks:
        check.run()
    return checks, found


def violations(root):
    return run_checks(root)[1]


def main():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--figures", action="store_true")
    parser.add_argument("root", nargs="?", type=pathlib.Path,
                        default=pathlib.Path(__file__).parent.parent.parent)
    arguments = parser.parse_args()
    checks, found = run_checks(arguments.root.resolve())
    if arguments.figures:
        for check in checks:
            for line in getattr(check, "figures", list)():
                print(line)
    for violation in found:
        print(violation)
    print(f"{len(found)} violations")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
