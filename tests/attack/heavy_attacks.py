"""Vehicles that are let in, and ask for as much as they may."""

import json
import math
import struct
import subprocess
import threading
import time

import grpc

from case import MAX_MS

TARGETS = 20_000  # max_target_count
HEAVY_VEHICLES = 20
MAX_MIB = 300  # of the server
POINT = struct.Struct("<fffbhfffff")  # x, y, z, dyn_prop, id, rcs, vx, vy, vx_comp, vy_comp
POINT_BYTES = 43


class Drive:
    """A simulated drive in the nuScenes layout: what a vehicle sends of it, with each target many
    times over, so that it is found in the map all the same."""

    def __init__(self, folder, name, random):
        def table(kind):
            return json.loads((folder / "v1.0-sim" / f"{kind}.json").read_text())

        scene = next(row["token"] for row in table("scene") if row["name"] == name)
        samples = {row["token"] for row in table("sample") if row["scene_token"] == scene}
        self.folder, self.random = folder, random
        self.poses = {row["token"]: row for row in table("ego_pose")}
        self.mount = table("calibrated_sensor")[0]
        self.rows = sorted((row for row in table("sample_data") if row["sample_token"] in samples),
                           key=lambda row: row["timestamp"])

    def pose(self, i):
        return self.poses[self.rows[i]["ego_pose_token"]]

    def speed_mps(self, i):
        begin, end = self.pose(i), self.pose(i + 1)
        seconds = 1e-6 * (self.rows[i + 1]["timestamp"] - self.rows[i]["timestamp"])
        return math.dist(begin["translation"], end["translation"]) / seconds

    def targets(self, i):
        """(range [m], range rate [m/s], azimuth [rad]) of TARGETS targets."""
        bytes_ = (self.folder / self.rows[i]["filename"]).read_bytes()
        start = bytes_.index(b"DATA binary\n") + len(b"DATA binary\n")
        count = (len(bytes_) - start) // POINT_BYTES
        for k in range(count):
            x, y, *_, vx, vy, _, _ = POINT.unpack_from(bytes_, start + k * POINT_BYTES)
            range_m = math.hypot(x, y)
            for _ in range(TARGETS // count):
                yield (range_m + self.random.gauss(0, 0.1),
                       (vx * x + vy * y) / range_m + self.random.gauss(0, 0.05),
                       math.atan2(y, x) + self.random.gauss(0, 0.004))

    def opening(self, messages, vehicle_id):
        request = messages.LocalizeRequest()
        request.open.vehicle_id = vehicle_id
        request.open.map_name = "town"
        radar = request.open.rig.radars.add(radar_id="RADAR_FRONT")
        set_pose(radar.t_vehicle_radar, self.mount)
        set_pose(request.open.initial_pose.pose, self.pose(0))
        request.open.initial_pose.covariance.extend(
            0.0 if i % 7 else 1.0 if i < 18 else 0.01 for i in range(36))
        return request

    def scan(self, messages, i):
        request = messages.LocalizeRequest()
        scan = request.scan
        scan.sequence_number = i
        scan.radar_id = "RADAR_FRONT"
        scan.stamp_ns = 1000 * self.rows[i]["timestamp"]
        for range_m, range_rate_mps, azimuth_rad in self.targets(i):
            scan.range_m.append(range_m)
            scan.range_rate_mps.append(range_rate_mps)
            scan.azimuth_rad.append(azimuth_rad)
            scan.rcs_dbsm.append(3.0)
        scan.ego_velocity.linear_mps.x = self.speed_mps(i)
        scan.ego_velocity.angular_radps.SetInParent()
        return request


def set_pose(pose, row):
    pose.translation_m.x, pose.translation_m.y, pose.translation_m.z = row["translation"]
    rotation = pose.rotation
    rotation.w, rotation.x, rotation.y, rotation.z = row["rotation"]


class HeavyVehicle(threading.Thread):
    """Drives a drive again and again, as fast as it is answered."""

    def __init__(self, target, opening, scans, stop):
        super().__init__(daemon=True)
        self.target, self.opening, self.scans, self.stop = target, opening, scans, stop
        self.answers = 0

    def requests(self):
        yield self.opening
        for scan in self.scans:
            if self.stop.is_set():
                return
            yield scan

    def run(self):
        with self.target.channel() as channel:
            localize = channel.stream_stream(
                "/dcloc.v1.LocalizationService/Localize", request_serializer=lambda bytes_: bytes_)
            while not self.stop.is_set():
                try:
                    for _ in localize(self.requests(),
                                      metadata=self.target.call_metadata(self.target.vehicle_token)):
                        self.answers += 1
                except grpc.RpcError:
                    self.stop.wait(0.2)


class UsualVehicles:
    """Ten of the usual kind, in a process of its own. Measured are `seconds` after `warm_up_s`."""

    def __init__(self, case, target, drives, seed, warm_up_s, seconds):
        token = case.folder / "vehicle.token"
        token.write_text(target.vehicle_token)
        token.chmod(0o600)
        self.process = subprocess.Popen(
            [case.dcloc, "load", "--server", target.address, "--map", "town", "--dataset", "nuscenes",
             "--root", drives, "--drive", "live-0", "--vehicles", "10", "--ramp-s", "1",
             "--warmup-s", str(warm_up_s), "--begin-within", "0.2", "--duration-s", str(seconds),
             "--seed", str(seed), "--token-file", token, "--json"],
            text=True, stdout=subprocess.PIPE)

    def result(self, case, name):
        """Checks what they saw."""
        seen = json.loads(self.process.communicate()[0])
        totals, latency = seen["totals"], seen["latency"]
        tracked = totals["tracking_count"] / max(1, totals["answered_count"])
        case.figures[name] = {
            "p50_ms": round(latency["p50_ms"], 1), "p99_ms": round(latency["p99_ms"], 1),
            "server p99_ms": round(seen["server_latency"]["p99_ms"], 1),
            "tracking": round(tracked, 3), "lost": totals["lost_count"]}
        case.expect(latency["p99_ms"] <= MAX_MS, f"{name}: p99 was {latency['p99_ms']:.1f} ms")
        case.expect(tracked >= 0.97, f"{name}: tracked {100 * tracked:.0f} % of their scans")
        case.expect(totals["lost_count"] + totals["dropped_count"] == 0,
                    f"{name}: scans were lost or dropped")


def heavy_scans(case):
    """20 vehicles send the largest scans that are allowed, as fast as they are answered."""
    drives, town = case.folder / "heavy", case.folder / "heavy.dclm"
    for arguments in (["simulate", "--out", drives, "--length-m", "400"],
                      ["map", "build", "--dataset", "nuscenes", "--root", drives, "--drive", "map",
                       "--out", town]):
        subprocess.run([case.dcloc, *arguments], check=True, stdout=subprocess.DEVNULL)
    case.town = town
    drive = Drive(drives, "live-0", case.random)
    scans = [drive.scan(case.api.localization_service, i).SerializeToString() for i in range(100)]
    stop = threading.Event()
    with case.with_town(stub=False) as target:
        heavy = [HeavyVehicle(
            target, drive.opening(case.api.localization_service, f"heavy-{i}").SerializeToString(),
            scans, stop) for i in range(HEAVY_VEHICLES)]
        with case.meanwhile(target, vehicles=False):
            there = UsualVehicles(case, target, drives, 1, warm_up_s=4, seconds=5 + case.seconds)
            time.sleep(5.5)
            for vehicle in heavy:
                vehicle.start()
            time.sleep(0.5)
            # They have a second to find their place.
            come = UsualVehicles(case, target, drives, 2, warm_up_s=1, seconds=2 + case.seconds)
            there.result(case, "vehicles that are there")
            come.result(case, "vehicles that come")
            stop.set()
            for vehicle in heavy:
                vehicle.join()
        case.figures["heavy answers"] = sum(vehicle.answers for vehicle in heavy)
        case.figures["MiB"] = round(target.peak_mib())
        case.expect(case.figures["MiB"] <= MAX_MIB, f"it took {case.figures['MiB']} MiB")


HEAVY_ATTACKS = [heavy_scans]
