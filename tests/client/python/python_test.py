#!/usr/bin/env python3
"""The Python package as a user installs it from the tree, against the real server.

Usage: python_test.py DCLOC SERVER [unittest arguments]; exit status 77 where gRPC for Python or pip
is not there.
"""

import os
import pathlib
import subprocess
import sys
import tempfile
import threading
import time
import unittest

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent.parent
sys.path.append(str(ROOT / "tests/end_to_end"))

from package import build_wheel, install, start_or_skip  # noqa: E402

PROGRAMS = [None, None]


class Package(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        from processes import Programs, Server
        folder = cls.enterClassContext(tempfile.TemporaryDirectory())
        cls.folder = pathlib.Path(folder)
        cls.site = cls.folder / "site"
        install(build_wheel(cls.folder), cls.site)
        sys.path.insert(0, str(cls.site))
        programs = Programs(*PROGRAMS)
        programs.succeed("simulate", "--out", cls.folder / "sim", "--length-m", "100")
        programs.succeed("map", "build", "--dataset", "nuscenes", "--root", cls.folder / "sim",
                         "--drive", "map", "--out", cls.folder / "map")
        cls.server = cls.enterClassContext(Server(programs, cls.folder / "store"))
        programs.succeed("map", "upload", "--server", cls.server.address, "--map", "town",
                         "--activate", cls.folder / "map")

    def test_the_package_has_messages_stubs_and_type_hints(self):
        for name in ("py.typed", "v1/scan_pb2.py", "v1/scan_pb2.pyi", "v1/recording_pb2.py",
                     "v1/localization_service_pb2_grpc.py"):
            self.assertTrue((self.site / "dcloc" / name).is_file(), name)

    def test_the_example_prints_an_answer(self):
        result = subprocess.run(
            [sys.executable, ROOT / "client/python/example.py", self.server.address, "town"],
            env={"PYTHONPATH": str(self.site)}, text=True, stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT, check=False, timeout=60)
        self.assertEqual(result.returncode, 0, result.stdout)
        self.assertIn("result {", result.stdout)

    def open_message(self, **fields):
        from dcloc.v1 import localization_service_pb2
        message = localization_service_pb2.OpenSession(vehicle_id="car", map_name="town", **fields)
        message.rig.radars.add(radar_id="front").t_vehicle_radar.rotation.w = 1.0
        message.rig.radars[0].t_vehicle_radar.translation_m.x = 3.5
        return message

    def test_a_session_answers_each_scan_in_order_and_can_be_resumed(self):
        import dcloc
        from dcloc.v1 import scan_pb2

        def scan(number):
            return scan_pb2.Scan(sequence_number=number, radar_id="front",
                                 stamp_ns=10**18 + number * 10**8)
        session = dcloc.Session(dcloc.connect(self.server.address),
                                self.open_message(resumable=True))
        self.assertEqual(session.opened.map_name, "town")
        for number in range(5):
            session.send(scan(number))
        answers = iter(session)
        self.assertEqual([next(answers).result.sequence_number for _ in range(5)], list(range(5)))
        bad = session.localize(scan_pb2.Scan(sequence_number=5, radar_id="none", stamp_ns=10**18))
        self.assertIn("radar_id", bad.rejected.message)
        session.cancel()
        again = self.open_message(resume_token=session.opened.resume_token)
        with dcloc.Session(dcloc.connect(self.server.address), again) as resumed:
            self.assertTrue(resumed.opened.resumed)
            self.assertTrue(resumed.localize(scan(4)).from_memory)

    def test_fixes_are_answered_in_their_place(self):
        import dcloc
        from dcloc.v1 import localization_service_pb2 as messages, scan_pb2
        fix = messages.PositionFix(stamp_ns=10**18)
        fix.map_pose.pose.rotation.w = 1.0
        fix.map_pose.pose.translation_m.x = 1.0
        fix.map_pose.covariance.extend(float(i % 7 == 0) for i in range(36))
        with dcloc.Session(dcloc.connect(self.server.address), self.open_message()) as session:
            session.send_fix(fix)
            session.send(scan_pb2.Scan(sequence_number=0, radar_id="front", stamp_ns=10**18))
            session.send_fix(messages.PositionFix())
            answers = iter(session)
            first = next(answers).position_fix_answer
            self.assertEqual(first.stamp_ns, 10**18)
            self.assertNotEqual(first.use, messages.FIX_USE_INVALID, first.message)
            result = next(answers).result
            self.assertEqual([radar.radar_id for radar in result.health.radars], ["front"])
            bad = next(answers).position_fix_answer
            self.assertEqual(bad.use, messages.FIX_USE_INVALID)
            self.assertIn("stamp_ns", bad.message)
            session.opened.takes_position_fixes = False
            with self.assertRaisesRegex(NotImplementedError, "older"):
                session.send_fix(fix)

    def test_what_the_server_refuses_is_an_error(self):
        import dcloc
        import grpc
        message = self.open_message()
        message.map_name = "nowhere"
        with self.assertRaises(grpc.RpcError) as raised:
            dcloc.Session(dcloc.connect(self.server.address), message)
        self.assertEqual(raised.exception.code(), grpc.StatusCode.NOT_FOUND)

    def test_who_returns_at_once_is_heard(self):
        """A stream that begins on a connection which has just broken fails, or works."""
        import dcloc
        import grpc
        from dcloc.v1 import scan_pb2
        from relay import Relay
        heard = 0
        message = self.open_message(resumable=True)
        with Relay(self.server.address) as relay:
            channel = dcloc.connect(relay.address)
            for _ in range(60):
                try:
                    session = dcloc.Session(channel, message)
                except grpc.RpcError as error:
                    self.assertEqual(error.code(), grpc.StatusCode.UNAVAILABLE, error)
                    continue
                message.resume_token = session.opened.resume_token
                deaf = threading.Timer(10, session.cancel)
                deaf.start()
                for _ in range(3):
                    answer = session.localize(scan_pb2.Scan(
                        sequence_number=heard, radar_id="front", stamp_ns=10**18 + heard * 10**8))
                    self.assertEqual(answer.result.sequence_number, heard)
                    heard += 1
                deaf.cancel()
                relay.cut()
        self.assertGreater(heard, 60)

    def test_sessions_that_failed_leave_no_thread_behind(self):
        import dcloc
        import grpc
        message = self.open_message()
        message.map_name = "nowhere"
        channel = dcloc.connect(self.server.address)
        before = threading.active_count()
        for _ in range(20):
            with self.assertRaises(grpc.RpcError):
                dcloc.Session(channel, message)
        deadline = time.monotonic() + 10
        while threading.active_count() > before + 2 and time.monotonic() < deadline:
            time.sleep(0.05)
        self.assertLessEqual(threading.active_count(), before + 2)

    def test_a_token_goes_to_this_machine_or_over_tls(self):
        import dcloc
        from dcloc.v1 import map_service_pb2, map_service_pb2_grpc
        token = self.folder / "token"
        token.write_text("two words\n")
        with self.assertRaisesRegex(ValueError, "one word"):
            dcloc.connect(self.server.address, token_file=token)
        token.write_text("dcloc_wrong\n")
        for server in ("192.0.2.1:1", "maps.example:1", "[2001:db8::1]:1"):
            with self.assertRaisesRegex(ValueError, "plaintext"):
                dcloc.connect(server, token_file=token)
        with self.assertRaisesRegex(ValueError, "tls_key"):
            dcloc.connect("maps.example:1", tls_cert=token)
        # The server has no identities yet, and so lets in everyone; the call goes through.
        maps = map_service_pb2_grpc.MapServiceStub(
            dcloc.connect(self.server.address, token_file=token))
        self.assertEqual(len(maps.ListMaps(map_service_pb2.ListMapsRequest()).maps), 1)


class Token(unittest.TestCase):
    def test_the_token_says_who_calls(self):
        import dcloc
        import grpc
        from dcloc.v1 import map_service_pb2, map_service_pb2_grpc
        from processes import Programs, Server
        with tempfile.TemporaryDirectory() as name:
            folder = pathlib.Path(name)
            with Server(Programs(*PROGRAMS), folder / "store") as server:
                made = subprocess.run(
                    [PROGRAMS[1], "token", "create", "--data", folder / "store", "--name", "ops",
                     "--role", "admin"], stdout=subprocess.PIPE, stderr=subprocess.DEVNULL,
                    check=True)
                (folder / "token").write_bytes(made.stdout)

                def list_maps(**options):
                    stub = map_service_pb2_grpc.MapServiceStub(
                        dcloc.connect(server.address, **options))
                    return stub.ListMaps(map_service_pb2.ListMapsRequest())
                self.assertEqual(len(list_maps(token_file=folder / "token").maps), 0)
                with self.assertRaises(grpc.RpcError) as raised:
                    list_maps()
                self.assertEqual(raised.exception.code(), grpc.StatusCode.UNAUTHENTICATED)


if __name__ == "__main__":
    start_or_skip(PROGRAMS)
