#!/usr/bin/env python3
"""Prints how many tests passed, failed and were skipped in a JUnit file of ctest's."""

import sys
import xml.etree.ElementTree

statuses = [case.get("status") for case in xml.etree.ElementTree.parse(sys.argv[1]).iter("testcase")]
passed = statuses.count("run")
skipped = statuses.count("notrun") + statuses.count("disabled")
print(passed, len(statuses) - passed - skipped, skipped)
