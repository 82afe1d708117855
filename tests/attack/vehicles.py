"""Vehicles that localize until they are told to stop.

Usage: vehicles.py STUBS ADDRESS TOKEN|- COUNT RATE_HZ SESSION_S
"""

import json
import pathlib
import queue
import sys
import threading
import time

import grpc

from frames import ROUTER_CA
from target import Api

STUBS, ADDRESS, TOKEN, COUNT, RATE_HZ, SESSION_S = sys.argv[1:7]
API = Api(STUBS)
MESSAGES = API.localization_service


def opening(vehicle_id):
    request = MESSAGES.LocalizeRequest()
    request.open.vehicle_id = vehicle_id
    request.open.map_name = "town"
    request.open.resumable = False
    radar = request.open.rig.radars.add(radar_id="front")
    radar.t_vehicle_radar.translation_m.SetInParent()
    radar.t_vehicle_radar.rotation.w = 1.0
    pose = request.open.initial_pose
    pose.pose.translation_m.SetInParent()
    pose.pose.rotation.w = 1.0
    pose.covariance.extend(1.0 if i % 7 == 0 and i < 18 else 0.01 if i % 7 == 0 else 0.0
                           for i in range(36))
    return request


def scan(number):
    request = MESSAGES.LocalizeRequest()
    request.scan.sequence_number = number
    request.scan.radar_id = "front"
    request.scan.stamp_ns = time.time_ns()
    for i in range(100):
        request.scan.range_m.append(5.0 + i % 60)
        request.scan.range_rate_mps.append(-10.0)
        request.scan.azimuth_rad.append(-0.6 + 0.012 * i)
        request.scan.rcs_dbsm.append(3.0)
    request.scan.ego_velocity.linear_mps.x = 10.0
    request.scan.ego_velocity.angular_radps.SetInParent()
    return request


def channel_to(address, options):
    if not ROUTER_CA:
        return grpc.insecure_channel(address, options)
    return grpc.secure_channel(
        address, grpc.ssl_channel_credentials(pathlib.Path(ROUTER_CA).read_bytes()), options)


class Vehicle(threading.Thread):
    """One session at a time; a new one, on a new connection, every SESSION_S."""

    def __init__(self, number, stop):
        super().__init__(daemon=True)
        self.vehicle_id = f"car-{number}"
        self.stop = stop
        self.latencies_ms = []
        self.openings_ms = []
        self.refused = []

    def run(self):
        while not self.stop.is_set():
            options = [("grpc.use_local_subchannel_pool", 1)]
            with channel_to(ADDRESS, options) as channel:
                try:
                    self.drive(channel)
                except grpc.RpcError as error:
                    self.refused.append(f"{error.code().name}: {error.details()}")
                    time.sleep(0.2)

    def drive(self, channel):
        outgoing = queue.Queue()
        metadata = [] if TOKEN == "-" else [("authorization", f"Bearer {TOKEN}")]
        answers = API.localization_service_grpc.LocalizationServiceStub(channel).Localize(
            iter(outgoing.get, None), metadata=metadata, timeout=60 + float(SESSION_S))
        begin = time.monotonic()
        outgoing.put(opening(self.vehicle_id))
        next(answers)
        self.openings_ms.append(1e3 * (time.monotonic() - begin))
        number = 0
        while not self.stop.is_set() and number < float(SESSION_S) * float(RATE_HZ):
            due = time.monotonic()
            outgoing.put(scan(number))
            next(answers)
            self.latencies_ms.append(1e3 * (time.monotonic() - due))
            number += 1
            time.sleep(max(0.0, due + 1.0 / float(RATE_HZ) - time.monotonic()))
        outgoing.put(None)
        for _ in answers:
            pass


def main():
    stop = threading.Event()
    vehicles = [Vehicle(i, stop) for i in range(int(COUNT))]
    for vehicle in vehicles:
        vehicle.start()
    print("driving", flush=True)
    sys.stdin.readline()
    stop.set()
    for vehicle in vehicles:
        vehicle.join(20)
    latencies = sorted(ms for vehicle in vehicles for ms in vehicle.latencies_ms) or [float("inf")]
    openings = sorted(ms for vehicle in vehicles for ms in vehicle.openings_ms) or [float("inf")]
    print(json.dumps({
        "answers": len(latencies),
        "p50_ms": round(latencies[len(latencies) // 2], 1),
        "p99_ms": round(latencies[int(0.99 * (len(latencies) - 1))], 1),
        "worst_ms": round(latencies[-1], 1),
        "open_worst_ms": round(openings[-1], 1),
        "refused": [text for vehicle in vehicles for text in vehicle.refused]}))


if __name__ == "__main__":
    main()
