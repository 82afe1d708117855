"""A client of the server in Python alone, over gRPC: makes a map, drives a session, counts."""

import math
import time

import dcloc
import numpy
from dcloc.v1 import geometry_pb2, localization_service_pb2, map_service_pb2
from dcloc.v1 import map_service_pb2_grpc, scan_pb2

from world import RIGS

EPOCH_NS = 1_760_000_000_000_000_000
AHEAD = 16  # scans that are sent before their answers are taken
WRONG_M, WRONG_DEG = 2.0, 5.0


def pose_message(x, y, yaw):
    pose = geometry_pb2.Pose()
    pose.translation_m.x, pose.translation_m.y = x, y
    pose.rotation.w, pose.rotation.z = math.cos(yaw / 2), math.sin(yaw / 2)
    return pose


def rig_message(rig):
    message = scan_pb2.Rig()
    for radar in RIGS[rig]:
        model = message.radars.add(radar_id=radar.name, range_sigma_m=0.12,
                                   azimuth_sigma_rad=math.radians(0.6), range_rate_sigma_mps=0.08)
        model.t_vehicle_radar.CopyFrom(
            pose_message(radar.x_m, radar.y_m, math.radians(radar.yaw_deg)))
        model.t_vehicle_radar.translation_m.z = 0.5
    return message


def scan_message(scan, number):
    message = scan_pb2.Scan(sequence_number=number, radar_id=scan["radar"],
                            stamp_ns=EPOCH_NS + int(1e9 * scan["stamp"]))
    message.range_m.extend(scan["range"].tolist())
    message.range_rate_mps.extend(scan["rate"].tolist())
    message.azimuth_rad.extend(scan["azimuth"].tolist())
    message.rcs_dbsm.extend(scan["rcs"].tolist())
    if scan["speed"] is not None:
        message.ego_velocity.linear_mps.x = scan["speed"]
        message.ego_velocity.angular_radps.z = scan["turn"]
    return message


def build_map(channel, name, rig, scans):
    stub = map_service_pb2_grpc.MapServiceStub(channel)

    def requests():
        first = map_service_pb2.StartMapBuildRequest()
        first.header.map_name, first.header.drive_name = name, "map"
        first.header.rig.CopyFrom(rig_message(rig))
        first.header.activate = True
        first.header.method = map_service_pb2.MAP_BUILD_METHOD_KNOWN_POSES
        yield first
        for number, scan in enumerate(scans):
            request = map_service_pb2.StartMapBuildRequest()
            request.scan.scan.CopyFrom(scan_message(scan, number))
            request.scan.t_map_vehicle.CopyFrom(pose_message(*scan["truth"]))
            yield request

    build = stub.StartMapBuild(requests()).build
    while build.state == map_service_pb2.MAP_BUILD_STATE_RUNNING:
        time.sleep(0.1)
        build = stub.GetMapBuild(map_service_pb2.GetMapBuildRequest(build_id=build.build_id)).build
    if not build.version.version:
        raise RuntimeError(f"map {name}: {build.error_message}")


def drive(channel, name, rig, scans):
    """The answers to all scans, from a prior 0.5 m and half a degree off."""
    opening = localization_service_pb2.OpenSession(vehicle_id="outside", map_name=name)
    opening.rig.CopyFrom(rig_message(rig))
    x, y, yaw = scans[0]["truth"]
    opening.initial_pose.pose.CopyFrom(pose_message(x + 0.4, y + 0.3, yaw + 0.01))
    variances = [0.25, 0.25, 0.01, 1e-4, 1e-4, math.radians(1.0) ** 2]
    opening.initial_pose.covariance.extend(numpy.diag(variances).ravel().tolist())
    answers = []
    with dcloc.Session(channel, opening) as session:
        incoming = iter(session)
        for number, scan in enumerate(scans):
            session.send(scan_message(scan, number))
            if number >= AHEAD:
                answers.append(next(incoming))
        answers += [next(incoming) for _ in range(len(scans) - len(answers))]
    return answers


def judge(scans, answers):
    """Counts, and errors of the TRACKING answers against the truth at the scan."""
    tracking, wrong, exceeded, refused, errors = 0, 0, 0, 0, []
    for scan, answer in zip(scans, answers):
        if not answer.HasField("result"):
            refused += 1
            continue
        result = answer.result
        if result.state != localization_service_pb2.LOCALIZATION_STATE_TRACKING:
            continue
        x, y, yaw = scan["truth"]
        pose = result.pose.pose
        error_m = math.hypot(pose.translation_m.x - x, pose.translation_m.y - y)
        turned = 2 * math.atan2(pose.rotation.z, pose.rotation.w) - yaw
        error_deg = abs(math.degrees(math.remainder(turned, 2 * math.pi)))
        tracking += 1
        errors.append(error_m)
        wrong += error_m > WRONG_M or error_deg > WRONG_DEG
        exceeded += error_m > result.protection_level_m
    quantiles = numpy.quantile(errors, [0.5, 0.95]).round(3).tolist() if errors else [None, None]
    return {"scans": len(scans), "refused": refused, "tracking": tracking, "wrong": wrong,
            "exceeded": exceeded, "median_m": quantiles[0], "p95_m": quantiles[1]}
