"""Tests stand where their subject stands: a source of core has a test at the mirrored place."""

import os
import re

from tree import SOURCES, files

INCLUDE = re.compile(r'#include "([^"]+)"')

# Sources that a test of another name covers, in the folder that mirrors theirs: parts of one thing
# that is tested as a whole, and what needs its owner to do anything.
TESTED_BY = {
    "core/calibration/return_pairs": "calibrator_test",
    "core/localizer/pipeline": "localizer_test",
    "core/localizer/pipeline_claim": "localizer_trust_test",
    "core/localizer/pipeline_fix": "localizer_fix_test",
    "core/localizer/pipeline_snapshot": "localizer_snapshot_test",
    "core/localizer/registration_learner": "localizer_test",
    "core/localizer/tracking_snapshot": "localizer_snapshot_test",
    "core/map/map_content": "map_file_test",
    "core/map/map_parts": "map_edit_test",
    "core/map/mapped_file": "map_file_test",
    "core/mapping/loop_finder": "survey_test",
    "core/mapping/place_finder": "survey_test",
    "core/mapping/submap_matcher": "survey_test",
    "core/relocalization/global_localizer_options": "global_localizer_test",
}


class MirrorCheck:
    def __init__(self, root, report):
        self.root = root
        self.report = report  # (path, text) of a violation

    def run(self):
        for path, _ in files(self.root, *SOURCES, tops=("core",)):
            source, ending = os.path.splitext(path)
            folder = self.root / "tests" / os.path.dirname(path)
            if ending == ".cpp" and folder.is_dir():
                self.check(path, source, folder)

    def check(self, path, source, folder):
        name = os.path.basename(source)
        has_test = (folder / f"{name}_test.cpp").is_file() or source + ".h" in self.included(folder)
        other = TESTED_BY.get(source)
        if other is None:
            if not has_test:
                self.report(path, f"no test in {folder.relative_to(self.root)} includes its header, "
                                  "and TESTED_BY of mirror_check.py names none")
        elif has_test:
            self.report(path, "has a test of its own: TESTED_BY of mirror_check.py need not name one")
        elif not (folder / f"{other}.cpp").is_file():
            self.report(path, f"TESTED_BY of mirror_check.py names {other}, which is not there")

    @staticmethod
    def included(folder):
        """What the tests of a folder include, and what they share with one another."""
        return {header for file in folder.iterdir() if file.suffix in (".cpp", ".h")
                for header in INCLUDE.findall(file.read_text())}
