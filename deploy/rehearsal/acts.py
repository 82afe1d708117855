"""What happens to the fleet, one act after the other. Each act breaks something while vehicles drive
and says so; the limits say what the vehicles may see of it."""

import dataclasses
import time

from rehearsal.programs import Failure, Program, wait_until
from rehearsal.site import MAP


@dataclasses.dataclass(frozen=True)
class Limits:
    """What the vehicles of an act may see at worst."""

    gap_s: float  # between two answers to one vehicle
    tracking_share: float
    unanswered: int = 0
    lost: int = 0


# Where nothing may be seen of it; and where sessions end with their replica, and begin anew.
UNSEEN = Limits(gap_s=1.0, tracking_share=0.97)
ANEW = Limits(gap_s=3.0, tracking_share=0.75)


class Stage:
    """What an act needs: the site, the time, and where to say what happens."""

    def __init__(self, site, vehicle_count, seconds, patience, say):
        self.site, self.vehicle_count, self.seconds = site, vehicle_count, seconds
        self.patience, self.say = patience, say
        self.faults = []

    def pause(self, share=1.0):
        time.sleep(share * self.seconds)

    def expect_soon(self, condition, limit_s, what):
        """Waits for it, and says how long it took. What begins in time and ends too late is late."""
        begin = time.monotonic()
        limit_s *= self.patience
        try:
            wait_until(condition, limit_s, what)
            took_s = time.monotonic() - begin
            self.say(f"{what} after {took_s:.1f} s")
            if took_s > limit_s:
                self.faults.append(f"{what} after {took_s:.1f} s; the limit is {limit_s:g} s")
        except Failure as failure:
            self.faults.append(str(failure))
            self.say(str(failure))

    def expect_refused(self, *words):
        """A command that must fail now, in bounded time, with a word why."""
        begin = time.monotonic()
        done = self.site.call(*words, check=False)
        text = (done.stderr or done.stdout).strip().splitlines()[-1:]
        self.say(f"`dcloc {' '.join(map(str, words[:2]))}` is refused after "
                 f"{time.monotonic() - begin:.1f} s: {' '.join(text)}")
        if done.returncode == 0:
            self.faults.append(f"{words} was not refused")

    def works(self, *words):
        return lambda: self.site.call(*words, check=False).returncode == 0


def calm(stage):
    """nothing happens"""
    stage.pause()


def kill(stage):
    """kill -9 of the replica that has the most vehicles"""
    replica = stage.site.replica_by(lambda replica: replica.session_count())
    stage.say(f"kill -9 of {replica.name}, which has {replica.session_count()} vehicles")
    replica.program.kill()
    stage.expect_soon(lambda: stage.site.session_count() >= stage.vehicle_count, 3,
                      "each vehicle has a session again")
    stage.pause()
    replica.start()
    stage.say(f"{replica.name} is back")
    stage.pause()


def rolling(stage):
    """a restart of all replicas, one after the other"""
    for replica in stage.site.replicas:
        stage.say(f"SIGTERM to {replica.name}, which has {replica.session_count()} vehicles")
        begin = time.monotonic()
        status = replica.program.end()
        stage.say(f"it has drained and ended with {status} after {time.monotonic() - begin:.1f} s")
        if status != 0:
            stage.faults.append(f"{replica.name} ended with {status}")
        replica.start()
        stage.say(f"{replica.name} is ready again")
        stage.pause(0.3)


def database(stage):
    """the database is stopped"""
    site, away_s = stage.site, 3 * stage.seconds
    site.database.stop()
    stage.say(f"PostgreSQL is stopped for {away_s:g} s")
    begin = time.monotonic()
    stage.expect_refused("map", "activate", "--map", MAP, "--version", 1)
    time.sleep(max(0.0, begin + away_s - time.monotonic()))
    site.database.start()
    stage.say("PostgreSQL runs again")
    stage.expect_soon(stage.works("map", "list", "--map", MAP), 5, "maps are listed again")
    stage.pause(0.5)


def files(stage):
    """the store of the map files is stopped"""
    site, away_s = stage.site, 2 * stage.seconds
    site.files.stop()
    stage.say(f"{site.files.name} is away for {away_s:g} s; sessions open from memory and cache")
    begin = time.monotonic()
    stage.expect_refused("map", "upload", "--map", "other", site.folder / "town.dclm")
    time.sleep(max(0.0, begin + away_s - time.monotonic()))
    site.files.start()
    stage.say(f"{site.files.name} is back")
    stage.expect_soon(stage.works("map", "upload", "--map", "other", site.folder / "town.dclm"), 15,
                      "maps are uploaded again")
    stage.pause(0.5)


def activation(stage):
    """another version of the map is activated, and then back"""
    site = stage.site
    version = build_version(site)
    stage.say(f"version {version} of the map is made of the second drive, and activated")
    site.call("map", "activate", "--map", MAP, "--version", version, "--move-sessions")
    stage.pause()
    site.call("map", "rollback", "--map", MAP, "--move-sessions")
    stage.say("and rolled back")
    stage.pause()


def build_version(site):
    """A new version of the map, made by a server; its number."""
    before = versions(site)
    site.call("map", "remote-build", *site.drive("map"), "--map", MAP)
    return max(versions(site) - before)


def versions(site):
    return {version["version"] for version in site.json("map", "list", "--map", MAP)}


def build(stage):
    """kill -9 of a replica that builds a map"""
    site = stage.site
    # A map of its own: a version that is there already is not made again.
    words = ("map", "remote-build", *site.drive("map"), "--map", "built")
    builder = Program("remote-build", [site.dcloc, *words, *site.access()],
                      site.folder / "build.log")
    try:
        replica = wait_until(lambda: next(filter(lambda r: r.is_building(), site.replicas), None),
                             30, "a build")
        stage.say(f"kill -9 of {replica.name}, which takes in a drive to build a map of it")
        replica.program.kill()
        made = builder.process.wait(60) == 0
    finally:
        builder.kill()
    stage.say(f"the build {'was made by another replica' if made else 'is lost'}: "
              f"{builder.text().strip().splitlines()[-1]}")
    if not made:
        stage.say("it is begun again, through the router")
        stage.expect_soon(lambda: site.call(*words, check=False).returncode == 0, 20,
                          "the map is built by another replica")
    stage.pause()
    replica.start()
    stage.say(f"{replica.name} is back")
    stage.pause(0.5)


ACTS = {"calm": (calm, UNSEEN), "kill": (kill, ANEW), "rolling": (rolling, ANEW),
        "database": (database, UNSEEN), "files": (files, UNSEEN),
        "activation": (activation, UNSEEN), "build": (build, ANEW)}
