"""Tests stand where their subject stands: a source has a test at the mirrored place.

A source `core/map/a.cpp` is tested where tests/core/map has `a_test.cpp` or `a_test.py`, or another
test or fixture that includes `a.h`. It is also where it is a part: a source that only sources of
its own folder use, each of them tested, does nothing that their tests do not ask of it. A source
without a header of its own is a part of what the first header of the folder that it includes
declares. TESTED_BY has the others.
"""

import os
import re

from tree import SOURCES, files

INCLUDE = re.compile(r'#include "([^"]+)"')
TESTS = ("_test.cpp", "_test.py")

# Sources that a test of another name or place covers, by that test, and why it is not beside them.
TESTED_BY = {
    # Content has no meaning but in the files and edits that are made of it.
    "tests/core/map/map_file_test.cpp": ("core/map/map_content",),
    "tests/core/map/map_edit_test.cpp": ("core/map/editable_map",),
    # A program is tested by running it.
    "tests/client/cli/command_line_test.cpp": ("client/cli/main",),
    "tests/server/app/process_test.cpp": ("server/app/memory_hooks",),
    "tests/client/cli/describe/completion_test.py": ("client/cli/describe/describe_command",),
    # One test asks every implementation of an interface the same.
    "tests/server/identity/identity_store_test.cpp": ("server/identity/postgres_identity_store",),
    "tests/server/maps/catalogue/build_queue_test.cpp": (
        "server/maps/catalogue/postgres_build_queue", "server/maps/catalogue/sqlite_build_queue"),
    "tests/server/passes/pass_rows_test.cpp": ("server/passes/postgres_pass_rows",),
    # What needs a whole server, a database or other servers is tested through them.
    "tests/server/postgres/postgres_pool_test.cpp": ("server/postgres/postgres_connection",),
    "tests/server/admin/fleet_view_test.cpp": ("server/replicas/replicas",),
    "tests/server/app/shutdown_test.cpp": ("server/net/health",),
    "tests/server/localization/localize_stream_test.cpp": (
        "server/localization/localization_service", "server/sessions/open_session"),
    "tests/server/maps/jobs/upload_test.cpp": ("server/maps/store/incoming_files",),
    "tests/client/sdk/session_test.cpp": ("client/sdk/connection", "client/sdk/status"),
    "tests/client/cli/server/server_command_test.cpp": (
        "client/cli/remote/admin_run", "client/sdk/admin_client"),
    "tests/client/cli/map/server/map_passes_command_test.cpp": ("client/sdk/pass_client",),
    "tests/client/cli/session/session_command_test.cpp": (
        "client/cli/session/session_propose_command",),
    "tests/client/cli/session/session_record_command_test.cpp": ("client/cli/common/stop_signals",),
    "tests/client/ros/node_test.py": ("client/ros/ros1/master_watch",),
    # What commands share is tested by a command that uses all of it.
    "tests/client/cli/dataset/dataset_command_test.cpp": ("client/cli/common/written_file",),
    "tests/client/cli/evaluate/evaluate_command_test.cpp": (
        "client/cli/common/anchor_option", "client/cli/common/trajectory_options"),
    "tests/client/cli/map/map_command_test.cpp": (
        "client/cli/common/live_line", "client/cli/common/progress"),
    "tests/client/cli/calibrate/calibrate_command_test.cpp": (
        "client/cli/common/calibration_option", "client/cli/common/calibration_report",
        "client/datasets/drive_calibration"),
    "tests/client/cli/map/map_edit_command_test.cpp": ("client/evaluation/map_diff_picture",),
    "tests/client/cli/map/map_survey_command_test.cpp": ("client/cli/common/stage_line",),
    "tests/client/datasets/drive_request_test.cpp": ("client/datasets/files/check_range",),
    "tests/client/datasets/rig_file_test.cpp": ("client/datasets/files/json_file",),
    "tests/client/datasets/radarscenes_test.cpp": ("client/datasets/files/hdf5_table",),
    "tests/client/datasets/rosbag_test.cpp": (
        "client/datasets/bag_contents", "client/datasets/bag_motion",
        "client/datasets/check/range_rate_check"),
    # A picture, a campaign and a method are what comes of their parts together.
    "tests/client/evaluation/report_test.cpp": ("client/evaluation/plot_data",),
    "tests/client/evaluation/robustness/campaign_test.cpp": (
        "client/evaluation/robustness/cells", "client/evaluation/robustness/course"),
    "tests/client/evaluation/baselines/baselines_test.cpp": ("client/evaluation/baselines/method",),
    "tests/client/simulation/radar/radar_test.cpp": (
        "client/simulation/radar/echoes", "client/simulation/radar/scene"),
}

UNTESTED = {"client/sdk/example/example"}  # built as it stands, from an installed package


class MirrorCheck:
    def __init__(self, root, report):
        self.root = root
        self.report = report  # (path, text) of a violation
        self.implements = {}  # of a source without a header of its own: what declares what it defines
        self.users = {}  # of a header's source: the sources that include it
        self.included_by_tests = {}  # of a folder of tests: the headers that its files include
        self.elsewhere = {source: test for test, sources in TESTED_BY.items() for source in sources}

    def run(self):
        sources = []
        for path, file in files(self.root, *SOURCES, tops=("core", "server", "client")):
            source, ending = os.path.splitext(path)
            headers = INCLUDE.findall(file.read_text())
            if ending == ".cpp":
                sources.append(source)
                if not (self.root / (source + ".h")).is_file():
                    self.implements[source] = next(
                        (os.path.splitext(header)[0] for header in headers
                         if os.path.dirname(header) == os.path.dirname(path)), None)
            for header in headers:
                used = os.path.splitext(header)[0]
                if used not in (source, self.implements.get(source)):
                    self.users.setdefault(used, set()).add(source)
        for source in sources:
            if source not in UNTESTED:
                self.check(source)

    def check(self, source):
        path = source + ".cpp"
        test = self.elsewhere.get(source)
        if test is None:
            if not self.is_tested(source, set()):
                self.report(path, f"no test in tests/{os.path.dirname(source)} has its name or includes "
                                  "its header, and TESTED_BY of mirror_check.py names none")
        elif self.has_test(source) or self.is_part(source, set()):
            self.report(path, "is tested where it stands: TESTED_BY of mirror_check.py need not say it")
        elif not (self.root / test).is_file():
            self.report(path, f"TESTED_BY of mirror_check.py names {test}, which is not there")

    def is_tested(self, source, above):
        return (source in self.elsewhere or self.has_test(source) or self.is_part(source, above))

    def has_test(self, source):
        folder = self.root / "tests" / os.path.dirname(source)
        name = os.path.basename(source)
        return (any((folder / (name + ending)).is_file() for ending in TESTS)
                or source + ".h" in self.included(folder))

    def is_part(self, source, above):
        """Only sources of its folder use it, and each is tested; `above` are those being asked."""
        if source in self.implements:
            users = {self.implements[source]} - {None} - above
        else:
            users = self.users.get(source, set()) - above
        return bool(users) and all(
            os.path.dirname(user) == os.path.dirname(source)
            and self.is_tested(user, above | {source}) for user in users)

    def included(self, folder):
        """What the tests of a folder include, and what they share with one another."""
        if folder not in self.included_by_tests:
            self.included_by_tests[folder] = {
                header for file in (folder.iterdir() if folder.is_dir() else ())
                if file.suffix in (".cpp", ".h") for header in INCLUDE.findall(file.read_text())}
        return self.included_by_tests[folder]
