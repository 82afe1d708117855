#!/usr/bin/env python3
"""Prints how many tests passed, failed and were skipped in a JUnit file of ctest's.

With --failures, the names of those that failed instead, each with what it printed: where a program of
many tests says which failed, and its last lines.
"""

import re
import sys
import xml.etree.ElementTree

LINES_OF_A_FAILURE = 12
FAILURES_OF_A_PROGRAM = 4
# As node's test runner, googletest and Python's unittest say that a test failed.
FAILED_TEST = re.compile(r"^\s*not ok |: Failure$|^(FAIL|ERROR): ")


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
    shown = set(range(len(lines) - LINES_OF_A_FAILURE, len(lines)))
    told = [number for number, line in enumerate(lines) if FAILED_TEST.search(line)]
    for number in told[:FAILURES_OF_A_PROGRAM]:
        shown.update(range(number, number + LINES_OF_A_FAILURE))
    print(case.get("name"))
    for number, line in enumerate(lines):
        if number in shown:
            print("  " + line[:300])


cases = list(xml.etree.ElementTree.parse(sys.argv[-1]).iter("testcase"))
if "--failures" in sys.argv[1:-1]:
    for failed in [case for case in cases if outcome(case) == "failed"]:
        print_failure(failed)
else:
    outcomes = [outcome(case) for case in cases]
    print(*map(outcomes.count, ("passed", "failed", "skipped")))
