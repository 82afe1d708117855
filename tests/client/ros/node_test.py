#!/usr/bin/env python3
"""dcloc_node against the master that roscore starts: a bag of a simulated drive is played at it.

Usage: node_test.py DCLOC SERVER NODE [unittest arguments]; exit status 77 where ROS 1 is not there.
Everything listens on loopback, at ports of its own, and writes to a temporary folder.
"""

import os
import pathlib
import signal
import socket
import struct
import subprocess
import sys
import tempfile
import threading
import time
import unittest

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent.parent
sys.path.append(str(ROOT / "tests/end_to_end"))

from processes import Programs, Server, read_answers  # noqa: E402

PROGRAMS = []
POSE = ["x", "y", "z", "qx", "qy", "qz", "qw"]


def free_port():
    with socket.socket() as listener:
        listener.bind(("127.0.0.1", 0))
        return listener.getsockname()[1]


class Ros:
    """A master of the test's own, and one node of the test that publishes and listens."""

    def __init__(self, folder):
        os.environ.update(ROS_MASTER_URI=f"http://127.0.0.1:{free_port()}", ROS_IP="127.0.0.1",
                          ROS_HOME=str(folder / "ros"), ROS_LOG_DIR=str(folder / "ros/log"))
        os.environ.pop("ROS_HOSTNAME", None)
        self.start_master()
        import rospy
        rospy.init_node("node_test", disable_signals=True)

    def start_master(self):
        import rosgraph
        port = os.environ["ROS_MASTER_URI"].rpartition(":")[2]
        self.master = subprocess.Popen(["rosmaster", "--core", "-p", port], env=os.environ,
                                       stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        try:
            wait_for(rosgraph.is_master_online, "the master", timeout_s=200)
        except AssertionError:
            self.master.kill()
            raise

    def end_master(self):
        self.master.terminate()
        self.master.wait(20)

    def end(self):
        import rospy
        rospy.signal_shutdown("the test is over")
        self.end_master()


def wait_for(condition, what, timeout_s=90):
    end = time.monotonic() + timeout_s
    while not condition():
        if time.monotonic() > end:
            raise AssertionError(f"{what}: nothing within {timeout_s} s")
        time.sleep(0.02)


def wait_until_still(count, most, still_s=5, timeout_s=90):
    """Until there are `most`, or no more have come for a while."""
    newest, since = count(), time.monotonic()
    end = since + timeout_s
    while newest < most and time.monotonic() < min(end, since + still_s):
        time.sleep(0.1)
        if count() > newest:
            newest, since = count(), time.monotonic()


class Node:
    """dcloc_node with parameters, and what it publishes."""

    count = 0

    def __init__(self, **parameters):
        Node.count += 1
        self.name = f"dcloc_{Node.count}"
        self.poses, self.odometry, self.transforms, self.diagnostics = {}, [], [], {}
        self.subscribers = []
        self.listen()
        arguments = [f"_{key}:={value}" for key, value in parameters.items()]
        self.process = subprocess.Popen([PROGRAMS[2], f"__name:={self.name}", *arguments],
                                        text=True, stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
        self.lines = []
        self.reader = threading.Thread(target=lambda: self.lines.extend(self.process.stdout))
        self.reader.start()

    def listen(self):
        """To its topics; again where the master has forgotten who listens."""
        import rospy
        from diagnostic_msgs.msg import DiagnosticArray
        from geometry_msgs.msg import PoseWithCovarianceStamped
        from nav_msgs.msg import Odometry
        from tf2_msgs.msg import TFMessage
        for subscriber in self.subscribers:
            subscriber.unregister()
        self.subscribers = [
            rospy.Subscriber(f"/{self.name}/pose", PoseWithCovarianceStamped, self.take_pose),
            rospy.Subscriber(f"/{self.name}/odometry", Odometry, self.odometry.append),
            rospy.Subscriber("/tf", TFMessage, lambda tf: self.transforms.extend(tf.transforms)),
            rospy.Subscriber("/diagnostics", DiagnosticArray, self.take_diagnostics)]

    def take_pose(self, message):
        pose = message.pose.pose
        self.poses[message.header.stamp.to_nsec()] = (
            pose.position.x, pose.position.y, pose.position.z, pose.orientation.x,
            pose.orientation.y, pose.orientation.z, pose.orientation.w, *message.pose.covariance)

    def take_diagnostics(self, message):
        if message._connection_header["callerid"] != f"/{self.name}":
            return
        for entry in message.status:
            values = {value.key: value.value for value in entry.values}
            self.diagnostics[entry.name] = (entry.level, entry.message, values)

    def state(self):
        return self.diagnostics.get("dcloc: state", (2, "nothing yet", {}))

    def topics(self):
        return self.diagnostics.get("dcloc: topics", (2, "nothing yet", {}))

    def value(self, key):
        return self.state()[2].get(key)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.process.send_signal(signal.SIGINT)
        try:
            self.process.wait(20)
        except subprocess.TimeoutExpired:
            self.process.kill()
        self.reader.join()
        self.process.stdout.close()
        for subscriber in self.subscribers:
            subscriber.unregister()


class Player:
    """Plays the messages of a bag as they lie in it."""

    def __init__(self, bag):
        import rosbag
        with rosbag.Bag(str(bag)) as read:
            self.messages = [(topic, raw, stamp.to_nsec())
                             for topic, raw, stamp in read.read_messages(raw=True)]
        self.publishers, self.kinds = {}, {}

    def __enter__(self):
        import rospy
        for topic, (_, _, _, _, kind), _ in self.messages:
            if topic in self.publishers:
                continue
            self.kinds[topic] = type("Raw", (kind,), {
                "serialize": lambda message, buffer: buffer.write(message.raw)})
            self.publishers[topic] = rospy.Publisher(
                topic, self.kinds[topic], latch=topic == "/tf_static", queue_size=1000)
        return self

    def __exit__(self, *_):
        for publisher in self.publishers.values():
            publisher.unregister()

    def connect(self, topics):
        """Waits until somebody listens to each of them."""
        wait_for(lambda: all(self.publishers[topic].get_num_connections() for topic in topics),
                 f"a listener to {topics}")

    def play(self, speed=1.0, skip=(), only=None, change=lambda raw: raw, begin_s=0.0, end_s=1e9):
        first_ns = self.messages[0][2]
        begin = time.monotonic()
        for topic, raw, stamp_ns in self.messages:
            at_s = (stamp_ns - first_ns) * 1e-9
            if topic in skip or topic == "/tf" or not begin_s <= at_s <= end_s:
                continue
            if only is not None and topic not in only:
                continue
            message = self.kinds[topic]()
            message.raw = change(raw[1])
            delay_s = begin + (at_s - begin_s) / speed - time.monotonic()
            if delay_s > 0:
                time.sleep(delay_s)
            self.publishers[topic].publish(message)


def cpu_s(pid):
    """Processor time of a process so far."""
    fields = pathlib.Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def shifted(by_ns):
    """Another time in the header of a message."""
    def change(data):
        seconds, nanoseconds = struct.unpack_from("<II", data, 4)
        total = seconds * 10**9 + nanoseconds + by_ns
        return data[:4] + struct.pack("<II", total // 10**9, total % 10**9) + data[12:]
    return change


class NodeTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = pathlib.Path(cls.enterClassContext(tempfile.TemporaryDirectory()))
        cls.ros = Ros(cls.folder)
        cls.addClassCleanup(cls.ros.end)
        cls.programs = Programs(*PROGRAMS[:2])
        sim = ("--dataset", "nuscenes", "--root", cls.folder / "sim")
        bags = cls.folder / "bags"
        bags.mkdir()
        cls.programs.succeed("simulate", "--out", cls.folder / "sim", "--length-m", "250")
        cls.programs.succeed("dataset", "export", *sim, "--drive", "live-0", "--bag",
                             bags / "live.bag")
        cls.programs.succeed("dataset", "inspect", bags / "live.bag", "--write-mapping",
                             bags / "dcloc_bag.json")
        cls.programs.succeed("map", "build", *sim, "--drive", "map", "--out", cls.folder / "map")
        cls.store = cls.folder / "store"
        cls.server = cls.enterClassContext(Server(cls.programs, cls.store))
        cls.programs.succeed("map", "upload", "--server", cls.server.address, "--map", "town",
                             "--activate", cls.folder / "map")
        cls.programs.succeed("localize", "--server", cls.server.address, "--map", "town",
                             "--dataset", "rosbag", "--root", bags, "--drive", "live",
                             "--initial", "none", "--rate", "max", "--out", cls.folder / "bag.csv")
        cls.answers = read_answers(cls.folder / "bag.csv")
        cls.player = cls.enterClassContext(Player(bags / "live.bag"))
        cls.radars = sorted(topic for topic in cls.player.publishers if topic.startswith("/radar"))
        cls.heard = [*cls.radars, "/vehicle/velocity", "/tf_static"]

    def node(self, server=None, **parameters):
        bags = self.folder / "bags"
        return Node(server=server or self.server.address, map="town",
                    mapping=bags / "dcloc_bag.json", rig=bags / "dcloc_rig.json", **parameters)

    def begin(self, node):
        """Lets a node hear one scan, so that its session opens."""
        self.player.connect(self.heard)
        self.player.play(end_s=0.05)
        wait_for(lambda: node.value("connection") == "open", "a session")

    def test_poses_are_those_of_dcloc_localize_on_the_same_bag(self):
        with self.node(max_velocity_wait_s=0.2, max_queued_scan_count=1000) as node:
            self.player.connect(self.heard)
            self.player.play(speed=4.0)
            wait_for(lambda: node.value("scans_answered") == str(len(self.answers)), "all answers")
            expected = {int(answer["stamp_ns"]): answer for answer in self.answers
                        if answer["state"] in ("TRACKING", "DEAD_RECKONING")}
            self.assertGreater(len(expected), 100)
            wait_for(lambda: len(node.poses) >= len(expected), "all poses")
        self.assertEqual(sorted(node.poses), sorted(expected))
        for stamp, pose in node.poses.items():
            self.assertEqual(pose[:7], tuple(float(expected[stamp][name]) for name in POSE), stamp)
        self.assertEqual(len(node.transforms), len(expected))
        self.assertEqual(node.transforms[-1].header.frame_id, "map")
        self.assertEqual(node.transforms[-1].child_frame_id, "base_link")
        self.assertEqual(node.value("scans_dropped"), "0")

    def test_a_server_that_is_killed_and_comes_back_is_found_again(self):
        address, store = f"127.0.0.1:{free_port()}", self.folder / "other_store"
        with Server(self.programs, store, listen=address) as server, \
                self.node(server=address) as node:
            self.programs.succeed("map", "upload", "--server", address, "--map", "town",
                                  "--activate", self.folder / "map")
            self.begin(node)
            self.player.play(speed=2.0, begin_s=0.1, end_s=5.0)
            wait_for(lambda: node.poses, "poses")
            server.kill()
            wait_for(lambda: node.state()[0] == 2, "an error")
            with Server(self.programs, store, listen=address):
                wait_for(lambda: node.value("connection") == "open", "a connection")
                node.poses.clear()
                self.player.play(speed=2.0, begin_s=5.1, end_s=12.0)
                wait_for(lambda: len(node.poses) > 20, "poses again")
            self.assertGreaterEqual(int(node.value("disconnects")), 1)

    def test_a_master_that_ends_and_is_started_anew_hears_of_its_topics(self):
        with self.node() as node:
            self.begin(node)
            self.player.play(speed=2.0, begin_s=0.1, end_s=4.0)
            wait_for(lambda: node.poses, "poses")
            session = node.value("session")
            self.ros.end_master()
            time.sleep(2.0)
            self.ros.start_master()
            # The test's own node does not tell the new master of its topics either.
            self.player.__exit__()
            self.player.publishers.clear()
            self.player.__enter__()
            node.listen()
            self.player.connect(self.heard)
            node.poses.clear()
            self.player.play(speed=2.0, begin_s=4.1, end_s=10.0)
            wait_for(lambda: len(node.poses) > 20, "poses again")
            self.assertEqual(node.value("session"), session)
            self.assertTrue(any("started anew" in line for line in node.lines), node.lines)

    def test_a_topic_that_is_missing_is_named_and_poses_come_all_the_same(self):
        with self.node() as node:
            self.player.connect(self.heard)
            self.player.play(speed=2.0, skip=["/vehicle/velocity"], end_s=5.0)
            wait_for(lambda: "/vehicle/velocity: nothing comes" in node.topics()[1], "a warning")
            wait_for(lambda: len(node.poses) > 10, "poses")
        self.assertEqual(node.topics()[0], 1)

    def test_wrong_types_and_fields_are_named(self):
        mapping = (self.folder / "bags/dcloc_bag.json").read_text()
        wrong = self.folder / "wrong.json"
        wrong.write_text(mapping.replace('"range_rate": "range_rate"', '"range_rate": "v_radial"'))
        with self.node() as other, Node(server=self.server.address, map="town", mapping=wrong) as node:
            self.player.connect(self.heard)
            self.player.play(end_s=1.0)
            wait_for(lambda: 'no field "v_radial"' in node.topics()[1], "the field's name")
            self.assertIn("range_rate", node.topics()[1])
        self.assertTrue(any("v_radial" in line for line in node.lines), node.lines)
        self.assertEqual(other.topics()[2] != {}, True)
        wrong.write_text(mapping.replace("/vehicle/velocity", self.radars[0] + "/"))
        swapped = mapping.replace(f'"topic": "{self.radars[0]}"', '"topic": "/vehicle/velocity"')
        wrong.write_text(swapped.replace('"motion_topic": "/vehicle/velocity"',
                                         '"motion_topic": ""'))
        with Node(server=self.server.address, map="town", mapping=wrong) as node:
            self.player.connect(["/vehicle/velocity"])
            self.player.play(end_s=1.0)
            wait_for(lambda: "it must be sensor_msgs/PointCloud2" in node.topics()[1], "the type")

    def test_clocks_may_jump(self):
        hour_ns = 3600 * 10**9
        with self.node() as node:
            self.begin(node)
            self.player.play(speed=2.0, begin_s=0.1, end_s=4.0, skip=["/tf_static"])
            wait_for(lambda: node.poses, "poses")
            for by_ns in (hour_ns, -hour_ns):
                node.poses.clear()
                self.player.play(speed=2.0, begin_s=4.1, end_s=11.0, skip=["/tf_static"],
                                 change=shifted(by_ns))
                wait_for(lambda: len(node.poses) > 20, f"poses after {by_ns}")
            self.assertGreaterEqual(int(node.value("clock_jumps")), 1)

    def test_the_launch_file_starts_it(self):
        package = pathlib.Path(PROGRAMS[2]).parent
        environment = {**os.environ, "ROS_PACKAGE_PATH": f"{package.parent}:/usr/share"}
        launch = subprocess.Popen(
            ["roslaunch", "dcloc", "dcloc.launch", f"server:={self.server.address}", "map:=town",
             f"mapping:={self.folder}/bags/dcloc_bag.json"],
            env=environment, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
        try:
            self.player.connect(self.heard)
        except AssertionError:
            launch.terminate()
            raise AssertionError(launch.communicate()[0]) from None
        launch.send_signal(signal.SIGINT)
        launch.communicate(timeout=30)

    def test_parameters_that_cannot_be_end_it_with_their_name(self):
        for parameters, words in (
                ({"odometry_rate_hz": -1}, "~odometry_rate_hz is -1; it must lie in [0, 1000]"),
                ({"publish_tf": "perhaps"}, "~publish_tf is \"perhaps\"; it must be true or false"),
                ({"maps": "town"}, "~maps is no parameter of this node"),
                ({"token_file": "/nowhere"}, "/nowhere")):
            with self.node(**parameters) as node:
                self.assertEqual(node.process.wait(30), 1)
            self.assertIn(words, "".join(node.lines))

    def test_five_radars_at_50_hz_cost_at_most_half_a_core(self):
        """Processor time of the node alone, since the machine may be busy."""
        load, bags = self.folder / "load", self.folder / "load_bags"
        bags.mkdir()
        sim = ("--dataset", "nuscenes", "--root", load)
        self.programs.succeed("simulate", "--out", load, "--length-m", "250", "--rig", "5")
        self.programs.succeed("dataset", "export", *sim, "--drive", "live-0", "--bag",
                              bags / "live.bag")
        self.programs.succeed("dataset", "inspect", bags / "live.bag", "--write-mapping",
                              bags / "dcloc_bag.json")
        with Player(bags / "live.bag") as player, \
                Node(server=self.server.address, map="town", mapping=bags / "dcloc_bag.json",
                     rig=bags / "dcloc_rig.json", max_queued_scan_count=1000) as node:
            radars = [topic for topic in player.publishers if topic.startswith("/radar")]
            self.assertEqual(len(radars), 5)
            scans = [stamp for topic, _, stamp in player.messages if topic in radars]
            player.connect([*radars, "/vehicle/velocity", "/tf_static"])
            player.play(end_s=0.5)
            wait_for(lambda: node.value("connection") == "open", "a session")
            drive_s = (scans[-1] - scans[0]) * 1e-9
            speed = 250.0 / (len(scans) / drive_s)
            begin, begin_cpu_s = time.monotonic(), cpu_s(node.process.pid)
            sent = int(node.value("scans_sent"))
            player.play(speed=speed, begin_s=0.5)
            # ROS drops messages where the machine is busy, and what is measured is a scan's cost.
            wait_until_still(lambda: int(node.value("scans_sent")), len(scans))
            count = int(node.value("scans_sent")) - sent
            used_s, took_s = cpu_s(node.process.pid) - begin_cpu_s, time.monotonic() - begin
            load_share = used_s / count * 250
            print(f"{count} scans of 5 radars in {took_s:.1f} s, {count / took_s:.0f} a second: "
                  f"{1e3 * used_s / count:.2f} ms of processor time each, "
                  f"{100 * load_share:.0f} % of a core at 250 a second; "
                  f"{node.value('scans_dropped')} dropped", flush=True)
            self.assertGreater(count, len(scans) / 2)
            self.assertLess(load_share, 0.5)


def main():
    PROGRAMS.extend(str(pathlib.Path(argument).resolve()) for argument in sys.argv[1:4])
    try:
        import rosbag  # noqa: F401
        import rospy  # noqa: F401
    except ImportError as error:
        print(f"skipped: {error}")
        return 77
    result = unittest.main(argv=[sys.argv[0], *sys.argv[4:]], exit=False,
                           warnings="ignore").result  # rospy leaves sockets to the collector
    return 0 if result.wasSuccessful() else 1


if __name__ == "__main__":
    sys.exit(main())
