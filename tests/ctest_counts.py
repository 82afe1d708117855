#!/usr/bin/env python3
"""Prints how many tests passed, failed and were skipped in a JUnit file of ctest's."""

import sys
import xml.etree.ElementTree


def outcome(case):
    status = case.get("status")
    if status == "run":
        return "passed"
    skipped = case.find("skipped")
    # A program that is not there is "notrun" as well.
    chosen = skipped is not None and skipped.get("message", "").startswith("SKIP_")
    return "skipped" if chosen or status == "disabled" else "failed"


cases = xml.etree.ElementTree.parse(sys.argv[1]).iter("testcase")
outcomes = [outcome(case) for case in cases]
print(*map(outcomes.count, ("passed", "failed", "skipped")))
