#!/usr/bin/env python3
"""Checks that the tree is built as it was designed; floors.py says how.

Usage: architecture.py [ROOT]
Prints one line for each violation; the exit status is 1 if there is one.
"""

import pathlib
import sys

sys.dont_write_bytecode = True  # the tree stays as it is

from include_check import IncludeCheck  # noqa: E402
from link_check import LinkCheck  # noqa: E402
from mirror_check import MirrorCheck  # noqa: E402
from shape_check import ShapeCheck  # noqa: E402


def violations(root):
    """One line for each violation in the tree at `root`."""
    found = []
    for check in (ShapeCheck, MirrorCheck, IncludeCheck, LinkCheck):
        check(root, lambda path, text: found.append(f"{path}: {text}")).run()
    return found


def main():
    root = pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else
                        pathlib.Path(__file__).parent.parent.parent).resolve()
    found = violations(root)
    for violation in found:
        print(violation)
    print(f"{len(found)} violations")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
