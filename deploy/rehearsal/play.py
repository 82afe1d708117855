"""Plays an act: vehicles drive, something breaks, and it is looked at what they saw and what it cost."""

import dataclasses
import time

from rehearsal.acts import ACTS, Stage
from rehearsal.programs import Failure
from rehearsal.site import http, metric
from rehearsal.vehicles import RAMP_S, WARMUP_S, Vehicles


@dataclasses.dataclass
class Played:
    """An act that has been played."""

    name: str
    title: str
    seconds: float
    seen: list
    used: dict
    faults: list


class Meter:
    """What the site uses from `__init__` to `used`. What was killed meanwhile is not in it."""

    def __init__(self, site):
        self.site = site
        self.begin = self._read()

    def _read(self):
        site = self.site
        values = {"time_s": time.monotonic(), "statements": site.database.statement_count()}
        groups = {"replicas": [replica.program for replica in site.replicas],
                  "router": [site.router], "database": [site.database.program],
                  "files": [site.files.program] if site.files.program else []}
        for name, programs in groups.items():
            values[f"{name}_processor_s"] = sum(program.processor_s() for program in programs)
        pages = [replica.metrics() for replica in site.replicas]
        values["opened_sessions"] = sum(metric(page, "dcloc_session_opens_total") for page in pages)
        router = http(site.status_port, "/metrics")[1]
        vehicles = "\n".join(line for line in router.splitlines() if 'proxy="vehicles"' in line)
        for way in ("in", "out"):
            values[f"bytes_{way}"] = metric(vehicles, f"haproxy_frontend_bytes_{way}_total")
        return values

    def used(self):
        end = self._read()
        used = {name: round(end[name] - self.begin[name], 2) for name in end}
        used["replica_memory_mib"] = [round(replica.program.memory_mib())
                                      for replica in self.site.replicas]
        used["router_memory_mib"] = round(self.site.router.memory_mib())
        return used


def play(name, site, options, say):
    """Plays one act."""
    act, limits = ACTS[name]
    title = act.__doc__
    say(f"{title}")
    begin = time.monotonic()
    stage = Stage(site, options.vehicles + options.cars, options.seconds, options.patience, say)
    vehicles = None
    try:
        vehicles = Vehicles(site, options.vehicles, options.cars, 60 * options.patience)
        say(f"{stage.vehicle_count} vehicles drive")
        time.sleep(RAMP_S + WARMUP_S)  # from here on the load counts
        meter = Meter(site)
        stage.pause(0.5)
        act(stage)
        used = meter.used()
        seen = vehicles.end()
    except Failure as failure:
        stage.faults.append(str(failure))
        say(str(failure))
        used, seen = {}, []
        mend(site)
    finally:
        if vehicles is not None:
            vehicles.kill()
    for one in seen:
        stage.faults += faults_of(one, limits, options.patience)
    return Played(name, title, time.monotonic() - begin, seen, used, stage.faults)


def mend(site):
    """Starts what an act that broke off has left broken."""
    for engine in (site.database, site.files):
        if engine.program is not None and not engine.program.alive():
            engine.start()
    for replica in site.replicas:
        if not replica.program.alive():
            replica.start()


def faults_of(seen, limits, patience):
    """What is beyond the limits."""
    found = []

    def check(holds, text):
        if not holds:
            found.append(f"{seen.kind}: {text}")

    check(seen.answers > 0, "no answer")
    check(seen.unanswered <= limits.unanswered,
          f"{seen.unanswered} scans without an answer; the limit is {limits.unanswered}")
    check(seen.errors == 0, f"{seen.errors} wrong or refused answers; the limit is 0")
    check(seen.lost <= limits.lost, f"{seen.lost} answers LOST; the limit is {limits.lost}")
    check(seen.worst_gap_s <= limits.gap_s * patience,
          f"{seen.worst_gap_s:.2f} s without an answer; the limit is {limits.gap_s * patience:g} s")
    check(seen.tracking_share >= limits.tracking_share,
          f"{100 * seen.tracking_share:.1f} % TRACKING; the limit is {100 * limits.tracking_share:g} %")
    return found
