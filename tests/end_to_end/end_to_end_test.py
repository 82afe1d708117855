#!/usr/bin/env python3
"""The walk of a user, on the real programs: simulate, map, serve, upload, localize; and what goes
wrong on the way.

Usage: end_to_end_test.py DCLOC DCLOC_SERVER [TEST...]
"""

import json
import math
import pathlib
import statistics
import sys
import tempfile
import threading
import time
import unittest

from processes import Programs, Server, poses_only, read_answers, true_positions

PROGRAMS = Programs(*sys.argv[1:3])
VEHICLE_COUNT = 8


class EndToEndTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        folder = tempfile.TemporaryDirectory(prefix="dcloc-end-to-end-")
        cls.addClassCleanup(folder.cleanup)
        cls.folder = pathlib.Path(folder.name)
        cls.drives = cls.folder / "drives"
        PROGRAMS.succeed("simulate", "--out", cls.drives, "--length-m", 250)
        cls.map_file = cls.folder / "town.dclm"
        PROGRAMS.succeed("map", "build", *cls.data(), "--drive", "map", "--out", cls.map_file)

    @classmethod
    def data(cls):
        return ["--dataset", "nuscenes", "--root", cls.drives]

    def setUp(self):
        self.own = self.folder / self.id().rpartition(".")[2]
        self.own.mkdir()

    def serve(self):
        return Server(PROGRAMS, self.own / "store")

    def serve_town(self):
        server = self.serve()
        PROGRAMS.succeed("map", "upload", "--server", server.address, "--map", "town", "--activate",
                         self.map_file)
        return server

    def localize(self, server, out, *options):
        """Arguments for dcloc."""
        return ["localize", "--server", server.address, "--map", "town", *self.data(), "--drive",
                "live-0", "--out", self.own / out, *(options or ["--rate", "max"])]

    def wait_for_session(self, server):
        for line in server.process.stderr:
            if "session opened" in line:
                return
        self.fail("the server has ended without a session")

    def test_a_drive_is_localized_where_it_was(self):
        with self.serve_town() as server:
            printed = PROGRAMS.succeed(*self.localize(server, "answers.csv"))
        self.assertIn("scans were answered", printed)
        truth = true_positions(self.drives)
        answers = read_answers(self.own / "answers.csv")
        tracking = [answer for answer in answers if answer["state"] == "TRACKING"]
        self.assertGreater(len(answers), 200)
        self.assertGreater(len(tracking), 0.9 * len(answers))
        errors_m = [math.dist((float(answer["x"]), float(answer["y"])),
                              truth[int(answer["stamp_ns"]) // 1000]) for answer in tracking]
        self.assertLess(statistics.median(errors_m), 0.2)
        self.assertLess(max(errors_m), 1.0)
        for answer in answers:
            self.assertEqual(answer["map_version"], "1")
            self.assertGreater(float(answer["c00"]), 0.0)
            self.assertAlmostEqual(float(answer["c01"]), float(answer["c10"]), delta=1e-12)
            self.assertGreater(float(answer["latency_ms"]), 0.0)

    def test_a_bag_is_localized_and_compared_with_the_reference(self):
        bag = self.own / "live-0.bag"
        PROGRAMS.succeed("dataset", "export", *self.data(), "--drive", "live-0", "--bag", bag)
        told = json.loads(PROGRAMS.succeed("dataset", "inspect", bag, "--json"))
        self.assertTrue(told["mapping_is_sound"])
        truth, way = self.own / "truth.tum", self.own / "way.csv"
        PROGRAMS.succeed("dataset", "trajectory", *self.data(), "--drive", "live-0",
                         "--trajectory-out", truth)
        with self.serve_town() as server:
            PROGRAMS.succeed("localize", "--server", server.address, "--map", "town", "--dataset",
                             "rosbag", "--root", self.own, "--drive", "live-0", "--rate", "max",
                             "--out", self.own / "answers.csv", "--trajectory-out", way)
        errors = json.loads(PROGRAMS.succeed("plot", way, "--reference", truth, "--json"))[0]
        self.assertGreater(errors["compared_count"], 200)
        self.assertLess(errors["position_error_m"]["p95"], 0.3)

    def test_vehicles_at_once_get_what_each_alone_gets(self):
        with self.serve_town() as server:
            def arguments(vehicle, run):
                return self.localize(server, f"{run}-{vehicle}.csv", "--rate", "max",
                                     "--seed", vehicle, "--initial-error-m", 1)

            for vehicle in range(VEHICLE_COUNT):
                PROGRAMS.succeed(*arguments(vehicle, "alone"))
            together = [PROGRAMS.start(*arguments(vehicle, "together"))
                        for vehicle in range(VEHICLE_COUNT)]
            for process in together:
                _, errors = process.communicate(timeout=60)
                self.assertEqual(process.returncode, 0, errors)
        answers = {run: [poses_only(read_answers(self.own / f"{run}-{vehicle}.csv"))
                         for vehicle in range(VEHICLE_COUNT)] for run in ("alone", "together")}
        for vehicle in range(VEHICLE_COUNT):
            self.assertEqual(answers["alone"][vehicle], answers["together"][vehicle])
        self.assertNotEqual(answers["alone"][0], answers["alone"][1], "the vehicles do not differ")

    def test_a_signal_stops_the_server_in_the_middle_of_a_drive(self):
        with self.serve_town() as server:
            vehicle = PROGRAMS.start(*self.localize(server, "answers.csv", "--rate", "realtime",
                                                   "--reconnect-s", "1"))
            self.wait_for_session(server)
            time.sleep(1)
            # What the server says after this must not fill the pipe.
            drain = threading.Thread(target=server.process.stderr.read)
            drain.start()
            status, took_s = server.stop()
            drain.join()
            _, errors = vehicle.communicate(timeout=20)
        self.assertEqual(status, 0)
        self.assertLess(took_s, 8)
        self.assertEqual(vehicle.returncode, 1)
        self.assertRegex(errors, "dcloc: .+")
        self.assertGreater(len(read_answers(self.own / "answers.csv")), 0)

    def test_a_dead_server_leaves_whole_answers_and_its_maps(self):
        with self.serve_town() as server:
            vehicle = PROGRAMS.start(*self.localize(server, "answers.csv", "--rate", "realtime",
                                                   "--reconnect-s", "1"))
            self.wait_for_session(server)
            time.sleep(2)
            server.kill()
            _, errors = vehicle.communicate(timeout=20)
        self.assertEqual(vehicle.returncode, 1)
        self.assertRegex(errors, "dcloc: .+")
        answers = read_answers(self.own / "answers.csv")
        self.assertGreater(len(answers), 0)
        self.assertLess(len(answers), 250)
        with self.serve() as server:
            PROGRAMS.succeed(*self.localize(server, "again.csv"))
        # What was answered before the end is what a whole drive is answered.
        again = poses_only(read_answers(self.own / "again.csv"))
        self.assertEqual(poses_only(answers), again[:len(answers)])

    def test_a_file_that_is_no_map_is_refused(self):
        whole = self.map_file.read_bytes()
        middle = len(whole) // 2
        bad = {"noise.dclm": bytes(range(256)) * 64,
               "cut.dclm": whole[:middle],
               "flipped.dclm": whole[:middle] + bytes([whole[middle] ^ 1]) + whole[middle + 1:],
               "empty.dclm": b""}
        with self.serve() as server:
            for name, content in bad.items():
                (self.own / name).write_bytes(content)
                result = PROGRAMS.run("map", "upload", "--server", server.address, "--map", "town",
                                      "--activate", self.own / name)
                self.assertEqual(result.returncode, 1, name)
                self.assertRegex(result.stderr, "dcloc: .+", name)
            listing = PROGRAMS.succeed("map", "list", "--server", server.address, "--json")
            self.assertNotIn('"active_version": 1', listing)
            result = PROGRAMS.run(*self.localize(server, "answers.csv"))
        self.assertEqual(result.returncode, 1)

    def test_a_map_that_is_not_there_is_named(self):
        with self.serve() as server:
            result = PROGRAMS.run(*self.localize(server, "answers.csv"))
        self.assertEqual(result.returncode, 1)
        self.assertIn("town", result.stderr)

    def test_a_server_that_is_not_there_is_an_error_and_no_wait(self):
        with self.serve() as server:
            pass
        begin = time.monotonic()
        result = PROGRAMS.run(*self.localize(server, "answers.csv"))
        self.assertLess(time.monotonic() - begin, 15)
        self.assertEqual(result.returncode, 1)
        self.assertIn("connect", result.stderr)


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[3:]])
