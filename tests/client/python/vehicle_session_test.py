#!/usr/bin/env python3
"""dcloc.VehicleSession on libdcloc.so.1: the wheel, its structs, and a drive through a real server.

Usage: vehicle_session_test.py DCLOC SERVER LIBRARY [unittest arguments]; exit status 77 where gRPC
for Python or pip is not there.
"""

import ctypes
import math
import os
import pathlib
import re
import sys
import tempfile
import threading
import time
import unittest
import zipfile

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent.parent
sys.path.append(str(ROOT / "tests/end_to_end"))

from package import build_wheel, install, run, start_or_skip  # noqa: E402
from processes import Programs, Server, true_positions  # noqa: E402

PROGRAMS = [None, None, None]


def read_recording(path):
    """Its header and its scans with their answers, as RecordedScan messages."""
    from dcloc.v1 import recording_pb2
    data = pathlib.Path(path).read_bytes()
    if not data.startswith(b"DCLOCREC"):
        raise AssertionError(f"{path} is no recording")
    messages, at = [], 8
    while at < len(data):
        size, shift = 0, 0
        while True:
            byte, at = data[at], at + 1
            size, shift = size | (byte & 0x7f) << shift, shift + 7
            if byte < 0x80:
                break
        messages.append(data[at:at + size])
        at += size
    entries = map(recording_pb2.RecordingEntry.FromString, messages[1:])
    return (recording_pb2.RecordingHeader.FromString(messages[0]),
            [entry.scan for entry in entries if entry.HasField("scan")])


def as_tuple(message):
    """x, y, z of a vector; w, x, y, z of a quaternion."""
    names = "wxyz" if message.DESCRIPTOR.name == "Quaternion" else "xyz"
    return tuple(getattr(message, name) for name in names)


class VehicleSessionTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = pathlib.Path(cls.enterClassContext(tempfile.TemporaryDirectory()))
        cls.wheel = build_wheel(cls.folder)
        cls.site = cls.folder / "site"
        install(cls.wheel, cls.site)
        sys.path.insert(0, str(cls.site))
        os.environ["DCLOC_LIBRARY"] = PROGRAMS[2]
        programs = Programs(*PROGRAMS[:2])
        drives = ("--dataset", "nuscenes", "--root", cls.folder / "sim")
        programs.succeed("simulate", "--out", cls.folder / "sim", "--length-m", "200")
        programs.succeed("map", "build", *drives, "--drive", "map", "--out", cls.folder / "map")
        cls.server = cls.enterClassContext(Server(programs, cls.folder / "store"))
        programs.succeed("map", "upload", "--server", cls.server.address, "--map", "town",
                         "--activate", cls.folder / "map")
        programs.succeed("localize", "--server", cls.server.address, "--map", "town", *drives,
                         "--drive", "live-0", "--initial", "truth", "--rate", "max", "--out",
                         cls.folder / "live.csv", "--record", cls.folder / "live.dclr")
        cls.header, cls.scans = read_recording(cls.folder / "live.dclr")
        cls.truth = true_positions(cls.folder / "sim")

    def open(self, server=None, **options):
        """A session as the recorded one was."""
        import dcloc
        first = self.header.open
        prior = dcloc.Prior(as_tuple(first.initial_pose.pose.translation_m),
                            list(first.initial_pose.covariance),
                            as_tuple(first.initial_pose.pose.rotation))
        radars = [dcloc.Radar(radar.radar_id, as_tuple(radar.t_vehicle_radar.translation_m),
                              as_tuple(radar.t_vehicle_radar.rotation), radar.beta_s)
                  for radar in first.rig.radars]
        return dcloc.VehicleSession(server or self.server.address, "town", "car", radars,
                                    **{"prior": prior, **options})

    @staticmethod
    def velocity(scan):
        return (*as_tuple(scan.ego_velocity.linear_mps), *as_tuple(scan.ego_velocity.angular_radps))

    def send(self, session, recorded, with_velocity=True):
        scan = recorded.scan
        session.send_scan(scan.radar_id, scan.sequence_number, scan.stamp_ns,
                          range_m=scan.range_m, range_rate_mps=scan.range_rate_mps,
                          azimuth_rad=scan.azimuth_rad, elevation_rad=scan.elevation_rad or None,
                          rcs_dbsm=scan.rcs_dbsm or None, ego_velocity=self.velocity(scan) if with_velocity else None)

    def assert_near(self, pose, message):
        """Not to the bit: a rig in C tells no deviations of a radar's targets."""
        self.assertLess(math.dist(pose.translation_m, as_tuple(message.translation_m)), 0.02)

    def test_the_wheel_installs_offline_with_all_that_it_names(self):
        run(sys.executable, "-m", "venv", "--system-site-packages", "--without-pip",
            self.folder / "venv")
        python = self.folder / "venv/bin/python"
        environment = {**os.environ, "PYTHONPATH": ""}
        run(sys.executable, "-m", "pip", "--python", python, "install", "--no-index", self.wheel,
            env=environment)
        said = run(python, "-c", "import dcloc, dcloc.v1.scan_pb2 as scan; print(dcloc.__file__)",
                   env=environment)
        self.assertTrue(said.startswith(str(self.folder / "venv")), said)

    def test_the_wheel_is_the_same_each_time_and_of_this_version(self):
        again = build_wheel(self.folder / "again")
        self.assertEqual(again.read_bytes(), self.wheel.read_bytes())
        version = re.search(r"project\(dcloc VERSION (\S+)", (ROOT / "CMakeLists.txt").read_text())
        self.assertEqual(self.wheel.name, f"dcloc-{version[1]}-py3-none-any.whl")
        names = zipfile.ZipFile(self.wheel).namelist()
        self.assertIn("dcloc/v1/map_service_pb2_grpc.py", names)
        self.assertFalse([name for name in names if "build" in name or name.endswith(".pyc")])

    def test_structs_are_those_of_the_header(self):
        from dcloc import library
        structs = {"dcloc_scan": library.ScanStruct, "dcloc_pose": library.PoseStruct,
                   "dcloc_answer": library.AnswerStruct}
        lines = []
        for name, struct in structs.items():
            lines.append(f'printf("%zu ", sizeof({name}));')
            lines += [f'printf("%zu ", offsetof({name}, {field}));'
                      for field, *_ in struct._fields_]
        program = self.folder / "layout"
        program.with_suffix(".c").write_text(
            '#include <dcloc.h>\n#include <stdio.h>\nint main(void) {\n' + "\n".join(lines) +
            "\nreturn 0; }\n")
        run("cc", f"-I{ROOT}/client/sdk/c", program.with_suffix(".c"), "-o", program)
        here = []
        for struct in structs.values():
            here.append(ctypes.sizeof(struct))
            here += [getattr(struct, field).offset for field, *_ in struct._fields_]
        self.assertEqual([int(word) for word in run(program).split()], here)
        header = (ROOT / "client/sdk/c/dcloc.h").read_text()
        for name, number in re.findall(r"DCLOC_([A-Z_]+) = (\d+)", header):
            import dcloc
            state = name.removeprefix("STATE_")
            known = dcloc.State[state] if state != name else dcloc.Status[name]
            self.assertEqual(known, int(number))

    def test_ticks_stand_in_for_the_velocities_of_scans(self):
        import dcloc
        with self.open() as session:
            for recorded in self.scans[:40]:
                velocity = self.velocity(recorded.scan)
                stamp_ns = recorded.scan.stamp_ns
                session.add_motion(stamp_ns, speed_mps=velocity[0])
                session.add_motion(stamp_ns, yaw_rate_radps=velocity[5])
                self.send(session, recorded, with_velocity=False)
                self.assert_near(session.next_answer().pose, recorded.answer.result.pose.pose)
            pose = session.pose_at(stamp_ns)
            self.assertAlmostEqual(pose.velocity[0], velocity[0], delta=0.05 * velocity[0] + 0.1)
            with self.assertRaises(dcloc.Error) as raised:
                session.add_motion(stamp_ns)
            self.assertIn("neither", str(raised.exception))

    def test_a_drive_is_localized_with_a_pose_at_any_time(self):
        import dcloc
        errors_m = []
        with self.open() as session:
            for recorded in self.scans:
                self.send(session, recorded)
                answer = session.next_answer()
                self.assertIsNone(answer.rejection)
                self.assertEqual(answer.sequence_number, recorded.scan.sequence_number)
                self.assert_near(answer.pose, recorded.answer.result.pose.pose)
                stamp_ns = recorded.scan.stamp_ns
                session.add_ego_velocity(stamp_ns + 1, self.velocity(recorded.scan))
                if answer.pose.state != dcloc.State.TRACKING:
                    continue
                now = session.pose_at(stamp_ns)
                x, y = self.truth[stamp_ns // 1000]
                errors_m.append(math.hypot(now.translation_m[0] - x, now.translation_m[1] - y))
                ahead = session.smooth_pose_at(stamp_ns + 50_000_000)
                moved_m = math.dist(ahead.translation_m[:2], now.translation_m[:2])
                self.assertLess(moved_m, 0.05 * math.hypot(*now.velocity[:2]) + 0.5)
                later = session.pose_at(stamp_ns + 50_000_000)
                self.assertGreater(later.covariance[0] + later.covariance[7],
                                   now.covariance[0] + now.covariance[7])
            with self.assertRaises(dcloc.Error) as raised:
                session.pose_at(stamp_ns + 10**9)
            self.assertEqual(raised.exception.status, dcloc.Status.OUT_OF_RANGE)
            session.close_sending()
            self.assertEqual(list(session), [])
        self.assertGreater(len(errors_m), len(self.scans) // 2)
        self.assertLess(sorted(errors_m)[len(errors_m) // 2], 0.1)

    def test_a_broken_connection_is_mended(self):
        from relay import Relay
        with Relay(self.server.address) as relay, self.open(relay.address) as session:
            numbers = []
            for i, recorded in enumerate(self.scans[:60]):
                self.send(session, recorded)
                if i in (20, 40):
                    relay.cut()
                numbers.append(session.next_answer().sequence_number)
            self.assertEqual(numbers, [recorded.scan.sequence_number
                                       for recorded in self.scans[:60]])

    def test_who_waits_for_an_answer_is_let_go_by_close(self):
        import dcloc
        session = self.open()
        ended = []

        def wait():
            try:
                session.next_answer()
            except dcloc.Error as error:
                ended.append(error.status)
        waiting = threading.Thread(target=wait)
        waiting.start()
        time.sleep(0.2)
        session.close()
        session.close()
        waiting.join(10)
        self.assertEqual(ended, [dcloc.Status.OUT_OF_RANGE])
        with self.assertRaisesRegex(dcloc.Error, "closed"):
            session.pose_at(0)

    def test_bad_input_is_named_and_loses_nothing(self):
        import dcloc
        with self.assertRaisesRegex(dcloc.Error, "127.0.0.1:1"):
            self.open("127.0.0.1:1")
        with self.assertRaisesRegex(dcloc.Error, "radars"):
            dcloc.VehicleSession(self.server.address, "town", "car", [])
        with self.assertRaisesRegex(ValueError, "translation_m has 2 numbers; it must have 3"):
            dcloc.VehicleSession(self.server.address, "town", "car", [dcloc.Radar("front", (1, 2))])
        with self.assertRaisesRegex(ValueError, "tls_ca"):
            self.open(tls_cert="car.pem")
        with self.open() as session:
            with self.assertRaisesRegex(ValueError, "azimuth_rad has 0 targets; range_m has 1"):
                session.send_scan("front", 0, 10**18, range_m=[1.0], range_rate_mps=[0.0])
            with self.assertRaises(dcloc.Error) as raised:
                session.smooth_pose_at(10**18)
            self.assertEqual(raised.exception.status, dcloc.Status.FAILED_PRECONDITION)
            session.send_scan("none", 7, 10**18)
            answer = session.next_answer()
            self.assertIsNone(answer.pose)
            self.assertRegex(str(answer.rejection), "radar_id")
            self.send(session, self.scans[0])
            self.assertIsNotNone(session.next_answer().pose)

    def test_without_the_library_it_says_what_to_install(self):
        said = run(sys.executable, "-c", "import dcloc\ntry: dcloc.VehicleSession('a:1', 'b', 'c', "
                   "[])\nexcept OSError as error: print(error)",
                   env={"PYTHONPATH": str(self.site), "DCLOC_LIBRARY": "/nowhere/libdcloc.so.1"})
        self.assertIn("install the Debian package libdcloc1", said)

    def test_both_kinds_of_sessions_live_in_one_process(self):
        import dcloc
        from dcloc.v1 import scan_pb2
        message = type(self.header.open)()
        message.CopyFrom(self.header.open)
        message.vehicle_id = "other"
        with self.open() as session, \
                dcloc.Session(dcloc.connect(self.server.address), message) as thin:
            for recorded in self.scans[:5]:
                self.send(session, recorded)
                answer = thin.localize(scan_pb2.Scan.FromString(recorded.scan.SerializeToString()))
                self.assert_near(session.next_answer().pose, answer.result.pose.pose)

    def test_the_example_runs(self):
        said = run(sys.executable, ROOT / "client/python/pose_example.py", self.server.address,
                   "town", env={**os.environ, "PYTHONPATH": str(self.site)})
        self.assertEqual(len(said.splitlines()), 100, said)
        self.assertRegex(said, r"^no pose yet: ")


if __name__ == "__main__":
    start_or_skip(PROGRAMS)
