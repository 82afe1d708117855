#!/usr/bin/env python3
"""Maps that make themselves, on the real programs: surveys as jobs of a server that dies, and the
passes that it keeps of vehicles that drive through it.

Usage: jobs_test.py DCLOC DCLOC_SERVER [TEST...]
"""

import json
import pathlib
import sqlite3
import sys
import tempfile
import time
import unittest

from processes import Programs, Server

PROGRAMS = Programs(*sys.argv[1:3])
DAY_NS = 86_400_000_000_000


class JobsTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        folder = tempfile.TemporaryDirectory(prefix="dcloc-jobs-")
        cls.addClassCleanup(folder.cleanup)
        cls.folder = pathlib.Path(folder.name)
        PROGRAMS.succeed("simulate", "--out", cls.folder / "drives", "--length-m", 250)
        cls.map_file = cls.folder / "town.dclm"
        PROGRAMS.succeed("map", "build", *cls.data(), "--drive", "map", "--out", cls.map_file)

    @classmethod
    def data(cls):
        return ["--dataset", "nuscenes", "--root", cls.folder / "drives"]

    def setUp(self):
        self.store = self.folder / self.id().rpartition(".")[2]

    def serve(self, *arguments):
        return Server(PROGRAMS, self.store, *arguments)

    def json(self, server, *arguments):
        return json.loads(PROGRAMS.succeed("map", *arguments, "--server", server.address, "--json"))

    def wait_for(self, what, condition, timeout_s=90):
        end = time.monotonic() + timeout_s
        while not condition():
            self.assertLess(time.monotonic(), end, what)
            time.sleep(0.1)

    def survey(self, server, *options):
        return self.json(server, "remote-survey", "--map", "town", *self.data(), "--drive",
                         "map,live-0", *options)

    def build(self, server):
        return self.json(server, "builds")[0]

    def files(self, folder):
        return [entry.name for entry in (self.store / folder).iterdir()]

    def test_a_survey_is_the_same_map_on_the_server_and_here(self):
        here = self.folder / "here.dclm"
        surveyed = json.loads(PROGRAMS.succeed("map", "survey", *self.data(), "--drive", "map,live-0",
                                               "--out", here, "--json"))
        with self.serve() as server:
            made = self.survey(server)
        self.assertTrue(all(drive["is_in_map"] for drive in made["drives"]), made["drives"])
        inspected = json.loads(PROGRAMS.succeed("map", "inspect", here, "--json"))
        self.assertEqual(made["point_count"], inspected["point_count"])
        self.assertEqual(made["keyframe_count"], inspected["keyframe_count"])
        self.assertEqual(made["radars"], surveyed["radars"])
        self.assertEqual(len(made["radars"]), 1)

    def test_a_killed_server_goes_on_when_it_starts_again(self):
        with self.serve() as server:
            self.survey(server, "--no-wait")
            self.wait_for("the build has begun", lambda: self.build(server)["attempt_count"] == 1)
            before = self.build(server)
            server.kill()
        with self.serve() as server:
            self.wait_for("the build has ended", lambda: self.build(server)["state"] != "running")
            done = self.build(server)
            self.assertEqual(done["state"], "done", done["error"])
            self.assertEqual(done["version"], 1)
            self.assertEqual(done["build"], before["build"])
            if before["state"] == "running":
                self.assertEqual(done["attempt_count"], 2)
            self.assertEqual(self.files("builds"), [])

    def test_what_is_wrong_with_drives_is_said_by_name(self):
        with self.serve() as server:
            failed = PROGRAMS.run("map", "remote-survey", "--server", server.address, "--map",
                                  "town", *self.data(), "--drive", "map", "--to-s", 0.3)
            self.assertEqual(failed.returncode, 1)
            self.assertIn("map: it moved", failed.stderr)
            self.assertEqual(PROGRAMS.succeed("map", "list", "--server", server.address,
                                              "--json").strip(), "[]")

    def consent(self, server, *whose):
        return self.json(server, "pass-consent", *whose)

    def drive(self, server, *options):
        PROGRAMS.succeed("localize", "--server", server.address, "--map", "town", *self.data(),
                         "--drive", "live-0", "--rate", "max", "--out", self.folder / "answers.csv",
                         *options)

    def serve_town(self, *arguments):
        server = self.serve(*arguments)
        PROGRAMS.succeed("map", "upload", "--server", server.address, "--map", "town", "--activate",
                         self.map_file)
        return server

    def test_nothing_is_kept_without_consent(self):
        with self.serve_town() as server:
            self.drive(server)
            self.consent(server, "--map", "town")
            self.drive(server)
            server.stop()
        self.assertEqual(self.files("passes"), [])

    def test_passes_are_kept_with_consent_and_go_with_it_and_with_the_time(self):
        with self.serve_town() as server:
            self.consent(server, "--map", "town")
            self.consent(server, "--identity", "anonymous")
            self.drive(server)
            self.drive(server)
            passes = lambda: self.json(server, "passes", "--map", "town")
            self.wait_for("two passes are kept", lambda: len(passes()) == 2)
            first, second = passes()
            self.assertGreater(first["scan_count"], 100)
            self.assertEqual(first["vehicle"], second["vehicle"])
            self.assertEqual(sorted(self.files("passes")), sorted([first["pass"], second["pass"]]))
            server.stop()
        rows = sqlite3.connect(self.store / "passes.sqlite")
        with rows:
            rows.execute("UPDATE pass SET expire_time_ns = create_time_ns - ? WHERE pass_id = ?",
                         (DAY_NS, first["pass"]))
        rows.close()
        with self.serve() as server:
            self.wait_for("one is over", lambda: self.files("passes") == [second["pass"]])
            removed = self.consent(server, "--identity", "anonymous", "--withdraw")
            self.assertEqual(removed["removed_pass_count"], 1)
            self.assertEqual(self.files("passes"), [])

    def test_nothing_is_kept_over_the_quota_or_of_a_vehicle_that_is_elsewhere(self):
        with self.serve_town("--pass-storage-mib", "0") as server:
            self.consent(server, "--map", "town")
            self.consent(server, "--identity", "anonymous")
            self.drive(server)
            server.stop()
        self.assertEqual(self.files("passes"), [])
        elsewhere = self.folder / "elsewhere"
        PROGRAMS.succeed("simulate", "--out", elsewhere, "--length-m", 250, "--seed", 77)
        with self.serve() as server:
            PROGRAMS.run("localize", "--server", server.address, "--map", "town", "--dataset",
                         "nuscenes", "--root", elsewhere, "--drive", "live-0", "--rate", "max",
                         "--out", self.folder / "lost.csv")
            server.stop()
        self.assertEqual(self.files("passes"), [])

    def let_four_vehicles_drive(self, server, data):
        """Until a pass of each is kept."""
        for number in range(4):
            PROGRAMS.succeed("localize", "--server", server.address, "--map", "town", *data,
                             "--drive", f"live-{number}", "--vehicle", f"car-{number}",
                             "--rate", "max", "--out", self.folder / "answers.csv")
        passes = lambda: self.json(server, "passes", "--map", "town")
        self.wait_for("a pass of each is kept",
                      lambda: len({row["vehicle"] for row in passes()}) == 4)

    def test_new_streets_join_by_kept_passes(self):
        longer = self.folder / "longer"
        PROGRAMS.succeed("simulate", "--out", longer, "--length-m", 500, "--vehicles", 4, "--seed", 77,
                         "--live-speed-kmh", "50,40,60,45")
        data = ["--dataset", "nuscenes", "--root", longer]
        whole, part = self.folder / "whole.dclm", self.folder / "part.dclm"
        PROGRAMS.succeed("map", "build", *data, "--drive", "map", "--out", whole)
        PROGRAMS.succeed("map", "crop", whole, "--box=-1000,-300,2000,150", "--out", part)
        street = lambda file: json.loads(PROGRAMS.succeed("map", "inspect", file, "--json"))["length_m"]
        self.assertGreater(street(whole) - street(part), 200)
        with self.serve() as server:
            PROGRAMS.succeed("map", "upload", "--server", server.address, "--map", "town",
                             "--activate", part)
            self.consent(server, "--map", "town")
            self.consent(server, "--identity", "anonymous")
            self.let_four_vehicles_drive(server, data)
            PROGRAMS.succeed("map", "remote-update", "--server", server.address, "--map", "town",
                             "--activate")
            longer_map = self.folder / "longer.dclm"
            PROGRAMS.succeed("map", "download", "--server", server.address, "--map", "town",
                             "--out", longer_map)
        self.assertGreater(street(longer_map), street(whole) - 40)

    def test_an_update_needs_witnesses_and_comes_of_kept_passes(self):
        aged = self.folder / "aged"
        PROGRAMS.succeed("simulate", "--out", aged, "--length-m", 400, "--replaced", 0.1,
                         "--vehicles", 4, "--seed", 12, "--live-speed-kmh", "50,40,60,45")
        data = ["--dataset", "nuscenes", "--root", aged]
        base = self.folder / "aged.dclm"
        PROGRAMS.succeed("map", "build", *data, "--drive", "map", "--out", base)
        with self.serve() as server:
            PROGRAMS.succeed("map", "upload", "--server", server.address, "--map", "town",
                             "--activate", base)
            update = ["map", "remote-update", "--server", server.address, "--map", "town", "--json"]
            self.consent(server, "--map", "town")
            self.consent(server, "--identity", "anonymous")
            few = PROGRAMS.run(*update)
            self.assertEqual(few.returncode, 1)
            self.assertIn("needs passes of 3 vehicles or days", few.stderr)
            self.let_four_vehicles_drive(server, data)
            ended = PROGRAMS.run(*update)
            build = self.build(server)
            self.assertEqual(build["method"], "update")
            self.assertGreaterEqual(len(build["drives"]), 3, build)
            self.assertGreater(build["update"]["came_count"], 5)
            self.assertGreater(build["update"]["went_count"], 5)
            if build["update"]["is_better"]:
                self.assertEqual(ended.returncode, 0, ended.stderr)
                self.assertEqual(json.loads(ended.stdout)["version"], 2)
            else:
                self.assertEqual(ended.returncode, 1)
                self.assertIn(build["update"]["reason"], ended.stderr)
            self.assertEqual(self.files("incoming"), [])


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[3:]])
