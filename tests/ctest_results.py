#!/usr/bin/env python3
"""Prints how many tests passed, failed and were skipped in a JUnit file of ctest's.

With --failures, the names of those that failed instead, each with the last lines that it printed.
"""

import sys
import xml.etree.ElementTree

LINES_OF_A_FAILURE = 12


def outcome(case):
    status = case.get("status")
    if status == "run":
        return "passed"
    skipped = case.find("skipped")
    # A program that is not there is "notrun" as well.
    chosen = skipped is not None and skipped.get("message", "").startswith("SKIP_")
    return "skipped" if chosen or status == "disabled" else "failed"


def print_failure(case):
    lines = (case.findtext("system-out") or "").strip().splitlines()
    print(case.get("name"))
    for line in lines[-LINES_OF_A_FAILURE:]:
        print("  " + line[:300])


cases = list(xml.etree.ElementTree.parse(sys.argv[-1]).iter("testcase"))
if "--failures" in sys.argv[1:-1]:
    for failed in [case for case in cases if outcome(case) == "failed"]:
        print_failure(failed)
else:
    outcomes = [outcome(case) for case in cases]
    print(*map(outcomes.count, ("passed", "failed", "skipped")))
