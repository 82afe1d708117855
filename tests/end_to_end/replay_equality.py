#!/usr/bin/env python3
"""Does a newer program answer recorded sessions as an older one did, to the bit?

The older programs make a map of each site and serve it; drives are localized in it and recorded.
The newer `dcloc` makes the same map, which must have the same bytes, and replays each recording.
Sites are simulated towns, in the plane and in space, and recordings where there are any. Sessions
start with a prior, without one, with position fixes and by Doppler alone; one begins in the map of
another town, and one leaves its map and is lost.

A change that is meant to leave the method as it is (CONTRIBUTING, "How a change is checked") shows
no difference. Exit status: 0 all equal, 1 something differs or failed, 2 wrong usage.
"""

import argparse
import collections
import dataclasses
import os
import pathlib
import re
import sys
import tempfile

from processes import Programs, Server, read_answers

PRIOR = ("--initial-error-m", 1, "--initial-error-deg", 2)
NO_PRIOR = ("--initial", "none")
LONG_S = 600  # for one command on a busy machine


@dataclasses.dataclass(frozen=True)
class Site:
    """Where a map is made; the tuples are options of dcloc."""
    name: str
    dataset: tuple
    map_options: tuple
    simulate: tuple = ()  # of a simulated one


@dataclasses.dataclass(frozen=True)
class Session:
    name: str
    site: str
    options: tuple
    drives_of: str = ""  # another site whose drives are localized
    must_be: str = ""  # a state that some answers must have, so that the session is what it says


def town(name, seed, *simulate):
    return Site(name, ("--dataset", "nuscenes", "--root", f"{{work}}/{name}"), ("--drive", "map"),
                ("--length-m", 400, "--seed", seed, "--fixes", 1, *simulate))


SITES = [
    town("plane", 7),
    town("space", 7, "--elevation"),
    town("elsewhere", 8),
    Site("half", ("--dataset", "nuscenes", "--root", "{work}/plane"),
         ("--drive", "map", "--to-s", 10)),
    Site("nuscenes", ("--dataset", "nuscenes", "--root", "{data}/nuscenes_dev"),
         ("--drive", "scene-0655",
          "--radars", "RADAR_FRONT,RADAR_FRONT_LEFT,RADAR_FRONT_RIGHT")),
    Site("radarscenes", ("--dataset", "radarscenes", "--root", "{data}/radarscenes_dev"),
         ("--drive", "sequence_108", "--radars", "radar_2,radar_3", "--to-s", 40)),
]

LIVE = ("--drive", "live-0")
BACK = ("--drive", "scene-0655", "--radars", "RADAR_BACK_LEFT,RADAR_BACK_RIGHT")
SIDES = ("--drive", "sequence_108", "--radars", "radar_1,radar_4", "--to-s", 40)
SESSIONS = [
    Session("plane-prior", "plane", LIVE + PRIOR, must_be="tracking"),
    Session("plane-none", "plane", LIVE + NO_PRIOR, must_be="tracking"),
    Session("plane-fixes", "plane",
            LIVE + NO_PRIOR + ("--fixes", "{work}/plane/fixes/live-0.csv"), must_be="tracking"),
    Session("plane-doppler", "plane", LIVE + PRIOR + ("--ego-velocity", "doppler")),
    Session("plane-elsewhere", "plane", LIVE + PRIOR, drives_of="elsewhere",
            must_be="initializing"),
    Session("plane-lost", "half", LIVE + PRIOR, drives_of="plane", must_be="lost"),
    Session("space-prior", "space", LIVE + PRIOR, must_be="tracking"),
    Session("space-none", "space", LIVE + NO_PRIOR, must_be="tracking"),
    Session("nuscenes-prior", "nuscenes", BACK + PRIOR),
    Session("nuscenes-none", "nuscenes", BACK + NO_PRIOR),
    Session("radarscenes-prior", "radarscenes", SIDES + PRIOR),
    Session("radarscenes-none", "radarscenes", SIDES + NO_PRIOR),
]


class Campaign:
    def __init__(self, old, new, work, data):
        self.old, self.new = old, new
        self.places = {"work": str(work), "data": data}
        self.work = pathlib.Path(work)
        self.sites = {site.name: site for site in SITES}
        self.differences = 0

    def run(self, sessions):
        by_site = collections.defaultdict(list)
        for session in sessions:
            by_site[session.site].append(session)
        simulated = {name for session in sessions for name in (session.site, session.drives_of)
                     if name and self.sites[name].simulate}
        for name in sorted(simulated):
            self.succeed(self.old, "simulate", *self.sites[name].simulate,
                         "--out", self.work / name)
        for name, of_site in by_site.items():
            self.make_map(self.sites[name])
            with Server(self.old, self.work / f"{name}.store") as server:
                self.succeed(self.old, "map", "upload", "--server", server.address, "--map", name,
                             "--activate", self.map_of(name))
                for session in of_site:
                    self.record(session, server)
            for session in of_site:
                self.replay(session)
        return self.differences

    def make_map(self, site):
        newer = self.work / f"{site.name}.newer.dclm"
        for programs, out in ((self.old, self.map_of(site.name)), (self.new, newer)):
            self.succeed(programs, "map", "build", *self.filled(site.dataset),
                         *self.filled(site.map_options), "--out", out)
        same = self.map_of(site.name).read_bytes() == newer.read_bytes()
        self.tell(f"map of {site.name}", same, f"{newer.stat().st_size} bytes")

    def record(self, session, server):
        dataset = self.sites[session.drives_of or session.site].dataset
        answers = self.work / f"{session.name}.csv"
        self.succeed(self.old, "localize", "--server", server.address, "--map", session.site,
                     *self.filled(dataset), *self.filled(session.options), "--rate", "max",
                     "--record", self.recording_of(session), "--out", answers)
        states = collections.Counter(answer["state"].lower() for answer in read_answers(answers))
        if session.must_be and not states[session.must_be]:
            raise AssertionError(f"{session.name}: no answer is {session.must_be}: {dict(states)}")

    def replay(self, session):
        result = self.new.run("session", "replay", self.recording_of(session), "--map",
                              self.map_of(session.site), timeout_s=LONG_S)
        counts = re.search(r"(\d+) answers are the same to the bit, (\d+) differ", result.stdout)
        if counts is None:
            raise AssertionError(f"{session.name}: no replay: {result.stderr}")
        same, different = map(int, counts.groups())
        if same + different == 0:
            raise AssertionError(f"{session.name}: nothing was compared")
        self.tell(session.name, different == 0 and result.returncode == 0,
                  f"{same} answers are the same, {different} differ\n{result.stderr}".rstrip())

    def tell(self, name, same, text):
        self.differences += not same
        print(f"{'same  ' if same else 'DIFFER'}  {name:18}  {text}", flush=True)

    def map_of(self, site):
        return self.work / f"{site}.dclm"

    def recording_of(self, session):
        return self.work / f"{session.name}.rec"

    def filled(self, options):
        return [str(option).format(**self.places) for option in options]

    @staticmethod
    def succeed(programs, *arguments):
        result = programs.run(*arguments, timeout_s=LONG_S)
        if result.returncode != 0:
            raise AssertionError(f"dcloc {' '.join(map(str, arguments))}: {result.stderr}")


def parsed():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("old", type=pathlib.Path, help="folder with the older programs")
    parser.add_argument("new", type=pathlib.Path, help="folder with the newer ones")
    parser.add_argument("--only", metavar="A,B", help="sessions, of " +
                        ", ".join(session.name for session in SESSIONS))
    parser.add_argument("--data", default=os.environ.get("DCLOC_DATA", ""), metavar="DIR",
                        help="folder with nuscenes_dev and radarscenes_dev, $DCLOC_DATA by default; "
                             "without it their sessions are left out")
    parser.add_argument("--work", metavar="DIR", help="keep maps and recordings here")
    arguments = parser.parse_args()
    for folder in (arguments.old, arguments.new):
        if not (folder / "dcloc").is_file():
            parser.error(f"{folder} has no program dcloc")
    wanted = arguments.only.split(",") if arguments.only else [s.name for s in SESSIONS]
    for name in wanted:
        if name not in {session.name for session in SESSIONS}:
            parser.error(f"there is no session {name}")
    arguments.sessions = [session for session in SESSIONS if session.name in wanted]
    return arguments


def main():
    arguments = parsed()
    programs = [Programs(folder / "dcloc", folder / "dcloc-server")
                for folder in (arguments.old.resolve(), arguments.new.resolve())]
    sessions = arguments.sessions
    if not arguments.data:
        left = [s.name for s in sessions if not next(
            site for site in SITES if site.name == s.site).simulate]
        sessions = [s for s in sessions if s.name not in left]
        if left:
            print(f"left out without --data: {', '.join(left)}")
    with tempfile.TemporaryDirectory(prefix="dcloc-replay-") as folder:
        work = pathlib.Path(arguments.work or folder)
        work.mkdir(parents=True, exist_ok=True)
        try:
            differences = Campaign(*programs, work, arguments.data).run(sessions)
        except AssertionError as error:
            print(error, file=sys.stderr)
            return 1
    print(f"{len(sessions)} sessions, {differences} differences")
    return 1 if differences else 0


if __name__ == "__main__":
    sys.exit(main())
