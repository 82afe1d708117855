#!/usr/bin/env python3
"""Attacks a server over real sockets and spoils its machine, while vehicles drive and /ready is asked.

Usage: attack.py DCLOC DCLOC_SERVER [--only NAME[,NAME...]] [--seed N] [--seconds S] [--list] [--router]
With --router HAProxy of deploy/haproxy.cfg stands in front, and attacks come from another address than
vehicles; only attacks that go through it are run.
"""

import argparse
import json
import os
import pathlib
import random
import subprocess
import sys
import tempfile
import time

def through_router():
    """Runs this program again, with the router's certificates in the environment."""
    with tempfile.TemporaryDirectory(prefix="dcloc-attack-tls-") as name:
        folder = pathlib.Path(name)
        certificates = pathlib.Path(__file__).resolve().parent.parent.parent / "deploy/certificates"
        subprocess.run([certificates, "--out", folder, "--server", "localhost,127.0.0.1"], check=True,
                       stdout=subprocess.DEVNULL)
        (folder / "router.pem").write_text((folder / "localhost.pem").read_text()
                                           + (folder / "localhost.key").read_text())
        return subprocess.run([sys.executable, "-B", *sys.argv], check=False, env={
            **os.environ, "DCLOC_ATTACK_CA": str(folder / "ca.pem")}).returncode


if __name__ == "__main__" and "--router" in sys.argv and "DCLOC_ATTACK_CA" not in os.environ:
    sys.exit(through_router())  # before what is imported here reads it

from attacks import ATTACKS  # noqa: E402
from case import Case  # noqa: E402
from download_attacks import DOWNLOAD_ATTACKS  # noqa: E402
from faults import FAULTS  # noqa: E402
from heavy_attacks import HEAVY_ATTACKS  # noqa: E402
from request_attacks import REQUEST_ATTACKS  # noqa: E402
from router_attacks import ROUTER_ATTACKS  # noqa: E402
from target import Api, make_stubs  # noqa: E402


def make_town(dcloc, folder):
    """A small map."""
    drives, town = folder / "drives", folder / "town.dclm"
    for arguments in (["simulate", "--out", drives, "--length-m", "100"],
                      ["map", "build", "--dataset", "nuscenes", "--root", drives, "--drive", "map",
                       "--out", town]):
        subprocess.run([dcloc, *arguments], check=True, stdout=subprocess.DEVNULL)
    return town


def run(attack, case):
    """Whether it held."""
    begin = time.monotonic()
    attack(case)
    print(f"{'ok' if not case.faults else 'FAILED':7} {attack.__name__:28} "
          f"{time.monotonic() - begin:5.1f} s  {json.dumps(case.figures)}", flush=True)
    for fault in case.faults:
        print(f"        {fault}", flush=True)
    return not case.faults


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("dcloc", type=pathlib.Path)
    parser.add_argument("server", type=pathlib.Path)
    parser.add_argument("--only", default="", help="names of attacks, with commas")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--seconds", type=float, default=3.0, help="how long each one lasts")
    parser.add_argument("--router", action="store_true", help="through HAProxy")
    parser.add_argument("--list", action="store_true", help="only print their names")
    arguments = parser.parse_args()
    direct = ATTACKS + REQUEST_ATTACKS + DOWNLOAD_ATTACKS + HEAVY_ATTACKS + FAULTS
    chosen = [attack for attack in (ROUTER_ATTACKS if arguments.router else direct)
              if not arguments.only or attack.__name__ in arguments.only.split(",")]
    if arguments.list:
        print("\n".join(f"{attack.__name__:28} {attack.__doc__.splitlines()[0]}" for attack in chosen))
        return 0
    with tempfile.TemporaryDirectory(prefix="dcloc-attack-") as name:
        folder = pathlib.Path(name)
        stubs = folder / "stubs"
        stubs.mkdir()
        make_stubs(stubs)
        api = Api(stubs)
        town = make_town(arguments.dcloc, folder)
        print(f"seed {arguments.seed}", flush=True)
        results = [run(attack, Case(arguments.dcloc, arguments.server, folder, stubs, api, town,
                                    random.Random(arguments.seed), arguments.seconds))
                   for attack in chosen]
    print(f"{sum(results)} held, {len(results) - sum(results)} failed")
    return 0 if results and all(results) else 1


if __name__ == "__main__":
    sys.exit(main())
