#!/usr/bin/env python3
"""What dcloc_node costs under a full rig: five radars at 50 scans a second each, and odometry.

Usage: node_load.py DCLOC SERVER NODE [--seconds S] [--rate-hz HZ]
Plays a simulated drive at its own pace, with the stamps of now, at a node with a real server and a
master of ROS of its own. Prints the processor time of the node's process, and what became of each
scan. Exit status 1 where a scan was lost or the node took more than half a core; 77 where ROS 1 is
not there.
"""

import argparse
import json
import pathlib
import struct
import sys
import tempfile
import threading
import time

import node_test
from node_test import Node, Player, Ros, cpu_s, shifted, wait_for
from processes import Programs, Server

SPEED_KMH = 20
SETTLES_S = 6.0  # the session opens, and tracks
MAX_CORES = 0.5


def arguments():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("programs", nargs=3, metavar="PROGRAM", help="dcloc, dcloc-server, dcloc_node")
    parser.add_argument("--seconds", type=float, default=30.0, help="that are measured")
    parser.add_argument("--rate-hz", type=float, default=50.0, help="scans of each radar a second")
    return parser.parse_args()


def prepare(programs, folder, seconds, rate_hz):
    """A bag of the drive, its mapping, and a map of another drive there."""
    length_m = str(int((seconds + SETTLES_S + 2) * SPEED_KMH / 3.6) + 50)
    town = ("--length-m", length_m, "--rig", "5", "--radar", "carla", "--clutter", "0.25")
    root = folder / "sim"
    programs.succeed("simulate", "--out", root, *town, "--live-speed-kmh", SPEED_KMH,
                     "--scan-rate-hz", rate_hz)
    sim = ("--dataset", "nuscenes", "--root", root)
    programs.succeed("dataset", "export", *sim, "--drive", "live-0", "--bag", folder / "live.bag")
    programs.succeed("dataset", "inspect", folder / "live.bag", "--write-mapping",
                     folder / "dcloc_bag.json")
    programs.succeed("map", "build", *sim, "--drive", "map", "--out", folder / "map")


def publish_begin(folder, stamp_ns):
    """Where the drive begins, to within a metre, to /initialpose; the publisher keeps it."""
    import rospy
    from geometry_msgs.msg import PoseWithCovarianceStamped
    poses = json.loads((folder / "sim/v1.0-sim/ego_pose.json").read_text())
    begin = min(poses, key=lambda pose: abs(1000 * pose["timestamp"] - stamp_ns))
    message = PoseWithCovarianceStamped()
    message.header.frame_id = "map"
    position, orientation = message.pose.pose.position, message.pose.pose.orientation
    position.x, position.y, position.z = begin["translation"]
    orientation.w, orientation.x, orientation.y, orientation.z = begin["rotation"]
    message.pose.covariance = [(0.01 if i < 21 else 1e-3) if i % 7 == 0 else 0.0 for i in range(36)]
    message.pose.covariance[0] = message.pose.covariance[7] = 0.5
    publisher = rospy.Publisher("/initialpose", PoseWithCovarianceStamped, queue_size=1, latch=True)
    publisher.publish(message)
    return publisher


def targets_of(raw):
    """Points of a PointCloud2: height times width, after the header."""
    frame_size = struct.unpack_from("<I", raw, 12)[0]
    height, width = struct.unpack_from("<II", raw, 16 + frame_size)
    return height * width


def measure(folder, address, seconds):
    """Whether all was answered and cheap enough."""
    with Player(folder / "live.bag") as player, \
            Node(server=address, map="town", mapping=folder / "dcloc_bag.json",
                 rig=folder / "dcloc_rig.json") as node:
        radars = [topic for topic in player.publishers if topic.startswith("/radar")]
        scans = [(stamp, raw[1]) for topic, raw, stamp in player.messages if topic in radars]
        player.connect([*radars, "/vehicle/velocity", "/tf_static"])
        first_ns = player.messages[0][2]
        publisher = publish_begin(folder, scans[0][0])
        wait_for(publisher.get_num_connections, "a listener to /initialpose")
        time.sleep(1.0)
        shift_ns = time.time_ns() - first_ns
        begin = time.monotonic()
        playing = threading.Thread(target=player.play, kwargs={"change": shifted(shift_ns)})
        playing.start()
        samples = []
        for at_s in (SETTLES_S, SETTLES_S + seconds):
            time.sleep(begin + at_s - time.monotonic())
            samples.append((cpu_s(node.process.pid), time.monotonic() - begin, len(node.odometry)))
        (cpu_before_s, from_s, odometry), (cpu_after_s, to_s, odometry_after) = samples
        playing.join()
        time.sleep(3.0)  # diagnostics come once a second
        window = {stamp + shift_ns for stamp, _ in scans
                  if from_s <= (stamp - first_ns) * 1e-9 < to_s}
        poses = len(window & node.poses.keys())
        used_s, took_s = cpu_after_s - cpu_before_s, to_s - from_s
        targets = sum(targets_of(raw) for _, raw in scans) / len(scans)
        print(f"{len(window)} scans of {len(radars)} radars, {targets:.0f} targets each, in "
              f"{took_s:.1f} s: {len(window) / took_s:.0f} a second\n"
              f"{poses} poses came of them, and {odometry_after - odometry} of ~odometry\n"
              f"of the whole drive's {len(scans)} scans: {node.value('scans_sent')} sent, "
              f"{node.value('scans_answered')} answered, {node.value('scans_rejected')} rejected, "
              f"{node.value('scans_dropped')} dropped\n"
              f"the node's processor time: {used_s:.2f} s, {100 * used_s / took_s:.0f} % of a core, "
              f"{1e3 * used_s / len(window):.2f} ms a scan", flush=True)
        is_whole = node.value("scans_answered") == node.value("scans_sent") == str(len(scans))
        return is_whole and poses == len(window) and used_s <= MAX_CORES * took_s


def main():
    given = arguments()
    node_test.PROGRAMS.extend(str(pathlib.Path(program).resolve()) for program in given.programs)
    try:
        import rosbag  # noqa: F401
        import rospy  # noqa: F401
    except ImportError as error:
        print(f"skipped: {error}")
        return 77
    programs = Programs(*node_test.PROGRAMS[:2])
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        prepare(programs, folder, given.seconds, given.rate_hz)
        ros = Ros(folder)
        try:
            with Server(programs, folder / "store") as server:
                programs.succeed("map", "upload", "--server", server.address, "--map", "town",
                                 "--activate", folder / "map")
                return 0 if measure(folder, server.address, given.seconds) else 1
        finally:
            ros.end()


if __name__ == "__main__":
    sys.exit(main())
