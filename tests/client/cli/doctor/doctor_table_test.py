#!/usr/bin/env python3
"""`dcloc doctor` on set-ups with one mistake each, which it must find, and on sound ones.

Usage: doctor_table_test.py DCLOC SERVER [unittest arguments]
"""

import collections
import json
import os
import pathlib
import shutil
import sys
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent.parent.parent
sys.path.append(str(ROOT / "tests/end_to_end"))

from processes import Programs, Server  # noqa: E402
from setups import (Bag, Listener, Sites, answer_http, answer_tls, bus_later_by,  # noqa: E402
                    bus_times, certificates, clock_off_by, front_mount, set_of_all_radars,
                    set_of_first_radar, swap_mounts, with_bus)

PROGRAMS = []
COUNTS = collections.Counter()
FRONT, LEFT = "RADAR_FRONT", "RADAR_FRONT_LEFT"
FINDINGS = {"failed": 1, "warning": 3}


class DoctorTable(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = pathlib.Path(cls.enterClassContext(tempfile.TemporaryDirectory()))
        cls.programs = Programs(*PROGRAMS)
        cls.simulate("town", "--rig", "5")
        cls.programs.succeed("map", "build", *cls.drive("town", "map"), "--out", cls.folder / "map")
        cls.sites = Sites(cls.programs, cls.folder, cls.folder / "map")
        cls.certs = certificates(cls.folder / "certs", "--server", "127.0.0.1,localhost",
                                 "--server", "maps.example", "--client", "car")
        cls.ca = ["--tls-ca", cls.certs / "ca.pem"]

    @classmethod
    def simulate(cls, name, *arguments):
        cls.programs.succeed("simulate", "--out", cls.folder / name, "--length-m", "200",
                             "--map-speed-kmh", "40", *arguments)

    @classmethod
    def drive(cls, simulation, name="live-0"):
        return ["--dataset", "nuscenes", "--root", cls.folder / simulation, "--drive", name]

    def serve(self, server):
        return self.enterContext(server)

    def doctor(self, words):
        """The checks by their names; the exit status is that of the worst."""
        result = self.programs.run("doctor", "--json", *words, timeout_s=120)
        try:
            report = json.loads(result.stdout)
        except json.JSONDecodeError:
            self.fail(f"no report: {result.stdout}{result.stderr}")
        self.assertEqual(result.returncode, FINDINGS.get(report["result"], 0), report)
        return {check["check"]: check for check in report["checks"]}

    def expect(self, mistake, words, check, told):
        """The check finds the mistake, and says the word."""
        COUNTS["planted"] += 1
        with self.subTest(mistake):
            checks = self.doctor(words)
            self.assertIn(check, checks)
            found = checks[check]
            self.assertIn(found["result"], FINDINGS, found)
            self.assertIn(told, found["what"] + " -> " + found["advice"])
            self.assertTrue(found["advice"] or check == "TLS", found)
            COUNTS["found"] += 1

    def expect_sound(self, setup, words):
        COUNTS["sound"] += 1
        with self.subTest(setup):
            found = [check for check in self.doctor(words).values() if check["result"] in FINDINGS]
            self.assertEqual(found, [])
            COUNTS["without findings"] += 1

    def tls(self, name="127.0.0.1"):
        return ["--tls-cert", self.certs / f"{name}.pem", "--tls-key", self.certs / f"{name}.key"]

    def test_mistakes_of_the_connection(self):
        plain = ["--server", self.serve(self.sites.open("plain")).address]
        tls = ["--server", self.serve(self.sites.guarded("tls", *self.tls(), words=self.ca)).address]
        other = certificates(self.folder / "other", "--server", "127.0.0.1")
        named = self.serve(Server(self.programs, self.folder / "named", *self.tls("maps.example")))
        days = 86_400
        expired = certificates(self.folder / "expired", "--server", "127.0.0.1", "--days", "1",
                               environment=clock_off_by(-5 * days))
        early = certificates(self.folder / "early", "--server", "127.0.0.1",
                             environment=clock_off_by(5 * days))
        mutual = self.serve(self.sites.guarded(
            "mutual", *self.tls(), "--tls-client-ca", self.certs / "ca.pem",
            words=[*self.ca, "--tls-cert", self.certs / "car.pem", "--tls-key",
                   self.certs / "car.key"]))
        shown = [["--server", self.serve(Listener(answer_tls(folder, "127.0.0.1"))).address,
                  "--tls-ca", folder / "ca.pem"] for folder in (expired, early)]
        http = self.serve(Listener(answer_http))
        silent = self.serve(Listener(lambda connection: connection.recv(1 << 20)))
        for row in (
                ("no server", ["--server", "127.0.0.1:1"], "connection", "is dcloc-server running"),
                ("no such host", ["--server", "nowhere.invalid:1"], "connection", "name"),
                ("plaintext to TLS", tls, "TLS", "--tls-ca"),
                ("TLS to plaintext", [*plain, *self.ca], "TLS", "leave --tls-ca out"),
                ("another authority", [*tls, "--tls-ca", other / "ca.pem"], "certificate", "signed"),
                ("another name", ["--server", named.address, *self.ca], "certificate",
                 "--tls-server-name"),
                ("expired", shown[0], "certificate dates", "has expired"),
                ("not valid yet", shown[1], "certificate dates", "does not hold yet"),
                ("no authority's file", [*tls, "--tls-ca", "/nowhere"], "TLS", "/nowhere"),
                ("no certificate of one's own", ["--server", mutual.address, *self.ca],
                 "own certificate", "--tls-cert"),
                ("a web server", ["--server", http.address], "gRPC", "dcloc-server"),
                ("a silent port", ["--server", silent.address], "gRPC", "dcloc-server")):
            self.expect(*row)

    def test_mistakes_of_rights_maps_and_clocks(self):
        store = self.folder / "guarded"
        server = self.serve(self.sites.guarded(
            "guarded", tokens=(("car", "vehicle"), ("eye", "viewer"), ("other", "vehicle"))))
        here = ["--server", server.address]
        (self.folder / "false").write_text("dcloc_" + "A" * 40)

        def by(who):
            return [*here, "--token-file", f"{store}.{who}"]
        plain = ["--server", self.serve(self.sites.open("everyone")).address]
        stub = self.serve(Server(self.programs, self.folder / "stub", "--stub-localizer"))
        late = self.serve(self.sites.guarded("late", environment=clock_off_by(3)))
        drained = self.serve(self.sites.open("drained"))
        self.programs.succeed("server", "drain", "--server", drained.address)
        self.simulate("elsewhere", "--seed", "9", "--anchor", "48,11")
        session = ["--map", "town", "--open-session"]
        for row in (
                ("everyone may do everything", plain, "rights", "token create"),
                ("no token", here, "rights", "--token-file"),
                ("a false token", [*here, "--token-file", self.folder / "false"], "rights",
                 "not known"),
                ("a viewer is to drive", [*by("eye"), "--map", "town"], "rights", "role vehicle"),
                ("another vehicle's name", [*by("car"), *session, "--vehicle", "other"], "session",
                 "--vehicle"),
                ("no such map", [*by("ops"), "--map", "twon"], "map", "map upload"),
                ("no active version", [*by("ops"), "--map", "asleep"], "map", "map activate"),
                ("a place elsewhere", [*by("car"), "--map", "town", "--at", "3000,90"], "place",
                 "frame"),
                ("the server's clock", ["--server", late.address, "--token-file",
                                        self.folder / "late.ops", *session], "clock", "NTP"),
                ("a server that leaves", ["--server", drained.address], "server", "another"),
                ("poses that mean nothing", ["--server", stub.address], "server",
                 "--stub-localizer")):
            self.expect(*row)

    def test_mistakes_of_a_rig(self):
        bag = Bag(self.programs, self.folder / "bag", self.folder / "town", FRONT, LEFT)
        rates, first = f"radar {FRONT}: range rates", f"radar {FRONT}: "
        for row in (
                ("mounts swapped", bag.planted(swap_mounts), rates, "swap the mounts"),
                ("azimuths turned", bag.planted(set_of_all_radars(azimuth_is_clockwise=True)),
                 f"radar {LEFT}: range rates", "sign of azimuths"),
                ("range rates turned", bag.planted(set_of_all_radars(range_rate_is_towards=True)),
                 rates, "sign of range rates"),
                ("range rates over ground", bag.planted(
                    set_of_all_radars(range_rate_is_compensated=True)), rates, ""),
                ("radians taken for degrees", bag.planted(set_of_all_radars(angles_in_degrees=True)),
                 first + "scans", "radians"),
                ("a mount turned by 180 degrees",
                 bag.planted(set_of_first_radar(**front_mount(180))), rates, ""),
                ("a mount turned by 4 degrees", bag.planted(set_of_first_radar(**front_mount(4))),
                 first + "mount's yaw", "calibrate"),
                ("no beta", bag.planted(rig=set_of_first_radar(beta_s=0.0)), first + "beta",
                 "calibrate"),
                ("stamps 80 ms late", bag.planted(rig=set_of_first_radar(time_offset_s=0.08)),
                 first + "stamps", "calibrate")):
            self.expect(*row)

    def test_mistakes_of_a_bus(self):
        self.programs.succeed("simulate", "--out", self.folder / "bends", "--length-m", "400",
                              "--map-speed-kmh", "40", "--stops", "--seed", "4")
        for index, (mistake, change, check, told) in enumerate((
                ("km/h", bus_times(speed=3.6), "velocity: speed", "km/h"),
                ("wheels that say nothing", bus_times(speed=0.0), "velocity: speed", "signal"),
                ("speeds turned", bus_times(speed=-1.0), "velocity: speed", "sign"),
                ("wheels 6 % too fast", bus_times(speed=1.06), "velocity: speed", "circumference"),
                ("yaw rates turned", bus_times(yaw_rate=-1.0), "velocity: yaw rate",
                 "counter-clockwise"),
                ("velocities 0.3 s late", bus_later_by(0.3), "velocity: stamps", "clock"),
                ("a bus by GPS time", bus_later_by(18.0), "velocity: scans", "clock"))):
            with_bus(self.folder / f"bus-{index}", self.folder / "bends", change)
            self.expect(mistake, self.drive(f"bus-{index}"), check, told)

    def test_sound_servers(self):
        mutual_words = [*self.ca, "--tls-cert", self.certs / "car.pem", "--tls-key",
                        self.certs / "car.key"]
        tokens = (("car", "vehicle"), ("eye", "viewer"), ("chief", "admin"))
        store = self.folder / "sound"
        plain = self.serve(self.sites.guarded("sound", tokens=tokens))
        tls = self.serve(self.sites.guarded("sound-tls", *self.tls(), words=self.ca,
                                            tokens=tokens))
        named = self.serve(Server(self.programs, self.folder / "sound-named",
                                  *self.tls("maps.example"), "--require-identity"))
        self.sites.token(self.folder / "sound-named", "ops", "operator")
        mutual = self.serve(self.sites.guarded("sound-mutual", *self.tls(), "--tls-client-ca",
                                               self.certs / "ca.pem", words=mutual_words))
        self.sites.token(self.folder / "sound-mutual", "car", "vehicle", "--certificate")

        def by(who):
            return ["--server", plain.address, "--token-file", f"{store}.{who}"]
        by_tls = ["--server", tls.address, *self.ca, "--token-file", f"{store}-tls.car"]
        session = ["--map", "town", "--open-session", "--vehicle", "car"]
        port = tls.address.rpartition(":")[2]
        for setup in (
                ("a vehicle", [*by("car"), *session]),
                ("a vehicle without a session", [*by("car"), "--map", "town"]),
                ("a viewer", by("eye")),
                ("an operator", [*by("ops"), "--map", "town"]),
                ("an operator's session", [*by("ops"), *session]),
                ("an admin", [*by("chief"), "--map", "town"]),
                ("a place", [*by("car"), "--map", "town", "--at", "60,0"]),
                ("a vehicle over TLS", [*by_tls, *session]),
                ("TLS by the name", ["--server", f"localhost:{port}", *by_tls[2:], "--map", "town"]),
                ("TLS by another name", ["--server", named.address, *self.ca, "--tls-server-name",
                                         "maps.example", "--token-file",
                                         self.folder / "sound-named.ops"]),
                ("a certificate of one's own", ["--server", mutual.address, *mutual_words,
                                                *session])):
            self.expect_sound(*setup)

    def test_sound_drives(self):
        town = self.folder / "town"
        bag = Bag(self.programs, self.folder / "sound-bag", town, FRONT, LEFT)
        self.simulate("highway", "--world", "highway", "--live-speed-kmh", "90")
        self.simulate("carla", "--radar", "carla", "--noise", "student")
        self.simulate("stops", "--stops", "--seed", "4")
        self.simulate("ideal", "--beta-s", "0", "--range-rate-step-mps", "0.25")
        self.simulate("heights", "--elevation", "--seed", "7")
        store = self.folder / "drives"
        server = self.serve(self.sites.guarded("drives", tokens=(("car", "vehicle"),)))
        for setup in (
                ("a bag", bag.words()),
                ("a bag without a mapping", ["--dataset", "rosbag", "--root", self.unmapped(bag),
                                             "--drive", "drive"]),
                ("a side radar", [*self.drive("town"), "--radars", LEFT]),
                ("rear radars", [*self.drive("town"), "--radars",
                                 "RADAR_BACK_LEFT,RADAR_BACK_RIGHT"]),
                ("a highway", self.drive("highway")),
                ("a radar as CARLA's", self.drive("carla")),
                ("with stops", self.drive("stops")),
                ("a radar that compensates", self.drive("ideal")),
                ("with elevations", self.drive("heights")),
                ("a drive in its map", ["--server", server.address, "--token-file", f"{store}.car",
                                        "--map", "town", *self.drive("town"), "--radars", FRONT])):
            self.expect_sound(*setup)

    def unmapped(self, bag):
        folder = self.folder / "unmapped"
        folder.mkdir()
        source = bag.words()[3]
        for name in ("drive.bag", "dcloc_rig.json"):
            shutil.copy(source / name, folder / name)
        return folder


if __name__ == "__main__":
    PROGRAMS[:] = map(os.path.abspath, sys.argv[1:3])
    result = unittest.main(argv=[sys.argv[0], *sys.argv[3:]], exit=False).result
    print(f"{COUNTS['found']} of {COUNTS['planted']} planted mistakes were found; "
          f"{COUNTS['without findings']} of {COUNTS['sound']} sound set-ups had no findings")
    sys.exit(not result.wasSuccessful())
