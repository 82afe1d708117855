#!/usr/bin/env python3
"""A bag that is made of a drive gives the poses of the drive in its own layout, to the bit.

Usage: bag_poses_test.py DCLOC [unittest arguments]
"""

import pathlib
import subprocess
import sys
import tempfile
import unittest

DCLOC = []


def dcloc(*arguments):
    done = subprocess.run([DCLOC[0], *map(str, arguments)], text=True, stdout=subprocess.PIPE,
                          stderr=subprocess.STDOUT, check=False, timeout=240)
    if done.returncode != 0:
        raise AssertionError(f"dcloc {' '.join(map(str, arguments))} failed: {done.stdout}")


class BagPosesTest(unittest.TestCase):
    def test_poses_of_a_bag_are_those_of_its_drive(self):
        folder = pathlib.Path(self.enterContext(tempfile.TemporaryDirectory()))
        sim, bags = folder / "sim", folder / "bags"
        bags.mkdir()
        dcloc("simulate", "--length-m", 150, "--rig", 5, "--out", sim)
        for drive in ("map", "live-0"):
            dcloc("dataset", "export", "--dataset", "nuscenes", "--root", sim, "--drive", drive,
                  "--bag", bags / f"{drive}.bag")
        poses = {}
        for dataset, root in (("nuscenes", sim), ("rosbag", bags)):
            out = folder / f"{dataset}.csv"
            dcloc("evaluate", "--dataset", dataset, "--root", root, "--map-drive", "map", "--drive",
                  "live-0", "--initial-error-m", 0.5, "--trajectory-out", out)
            poses[dataset] = out.read_bytes()
        self.assertGreater(poses["nuscenes"].count(b"\n"), 500)
        self.assertTrue(poses["nuscenes"] == poses["rosbag"], "the poses differ")


if __name__ == "__main__":
    DCLOC.append(str(pathlib.Path(sys.argv[1]).resolve()))
    unittest.main(argv=[sys.argv[0], *sys.argv[2:]])
