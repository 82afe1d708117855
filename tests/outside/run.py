#!/usr/bin/env python3
"""Drives of a world that shares no code with ours, with faults, against a server.

Usage: run.py SERVER [--worlds city-one-1,city-five-1,avenue-one-3,avenue-five-6]
              [--only none,turn] [--address 127.0.0.1:50199] [--json FILE]

SERVER is the program dcloc-server. It is started on loopback with a store of its own, and ended. A
world is kind-rig-seed: city or avenue, one or five radars. --only takes faults whose names contain
one of these. Needs python3-numpy, python3-grpcio and python3-protobuf; some minutes a world.
"""

import argparse
import copy
import json
import pathlib
import subprocess
import sys
import tempfile
import zipfile

import numpy

ROOT = pathlib.Path(__file__).resolve().parents[2]
MAP_MPS, HZ = 11.0, 12.0


def import_client(folder):
    """The Python package as `build-wheel` makes it."""
    subprocess.run([ROOT / "client/python/build-wheel", folder / "wheel"], check=True,
                   stdout=subprocess.DEVNULL)
    for wheel in (folder / "wheel").glob("*.whl"):
        zipfile.ZipFile(wheel).extractall(folder / "package")
    sys.path.insert(0, str(folder / "package"))


def drives_of(spec):
    """Street, rig, and the scans of the map and of the live drive, a day later and slower."""
    import world
    kind, rig, seed = spec.split("-")
    seed = int(seed)
    street = world.Street(kind, seed)
    mapped = world.Drive(street, MAP_MPS, 1, seed + 10)
    live = world.Drive(street, MAP_MPS * (0.7 if seed % 2 else 1.2), 2, seed + 20)
    return rig, (world.record(street, mapped, rig, HZ, 1, seed + 30),
                 world.record(street, live, rig, HZ, 2, seed + 40))


def run(arguments, folder):
    import_client(folder)
    import client
    import dcloc
    from faults import FAULTS
    wanted = arguments.only.split(",") if arguments.only else [""]
    rows = []
    channel = dcloc.connect(arguments.address)
    for spec in arguments.worlds.split(","):
        rig, (mapped, live) = drives_of(spec)
        client.build_map(channel, spec, rig, mapped)
        for name, fault in FAULTS.items():
            if not any(part in name for part in wanted):
                continue
            seed = int(spec.split("-")[2])
            scans = fault(copy.deepcopy(live), numpy.random.default_rng(seed))
            row = {"world": spec, "fault": name,
                   **client.judge(scans, client.drive(channel, spec, rig, scans))}
            rows.append(row)
            share = 100.0 * row["tracking"] / row["scans"]
            print(f"{spec:14s} {name:28s} TRACKING {share:5.1f} %  wrong {row['wrong']:4d}"
                  f"  level exceeded {row['exceeded']:4d}  refused {row['refused']:3d}"
                  f"  median {row['median_m']} p95 {row['p95_m']} m", flush=True)
    return rows


def main():
    parser = argparse.ArgumentParser(usage=__doc__)
    parser.add_argument("server")
    parser.add_argument("--worlds", default="city-one-1,city-five-1,avenue-one-3,avenue-five-6")
    parser.add_argument("--only", default="")
    parser.add_argument("--address", default="127.0.0.1:50199")
    parser.add_argument("--json")
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        with open(folder / "server.log", "w", encoding="utf-8") as log, subprocess.Popen(
                [arguments.server, "--data", folder / "store", "--listen", arguments.address],
                stdout=log, stderr=log) as server:
            try:
                rows = run(arguments, folder)
            finally:
                server.terminate()
    if arguments.json:
        pathlib.Path(arguments.json).write_text(json.dumps(rows, indent=1), encoding="utf-8")


if __name__ == "__main__":
    main()
