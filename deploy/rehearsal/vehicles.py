"""Vehicles that drive during an act, and what they saw."""

import csv
import dataclasses
import json
import signal

from rehearsal.programs import Failure, Program, wait_until
from rehearsal.site import MAP

RAMP_S = 1
WARMUP_S = 1


@dataclasses.dataclass
class Seen:
    """What the vehicles of one kind saw in an act."""

    kind: str
    vehicles: int
    scans: int = 0
    answers: int = 0
    worst_gap_s: float = 0.0
    p99_ms: float = 0.0
    counted: int = 0  # answers after the start, until the vehicle tracks for the first time
    tracking: int = 0  # of these, that say TRACKING
    lost: int = 0  # answers that say LOST
    errors: int = 0  # answers that break the contract or mislead, and refused scans
    restarts: int = 0  # sessions that began anew
    max_error_m: float = 0.0

    @property
    def unanswered(self):
        return self.scans - self.answers

    @property
    def tracking_share(self):
        return self.tracking / self.counted if self.counted else 0.0


class Client(Program):
    """A program of vehicles: it drives until it is told to end, and then prints JSON."""

    def __init__(self, site, name, command):
        self.output = site.folder / f"{name}.json"
        self.output.unlink(missing_ok=True)
        super().__init__(name, command, site.folder / f"{name}.log", end_signal=signal.SIGINT,
                         output=self.output)

    def end_with_json(self):
        self.end(60)
        try:
            return json.loads(self.output.read_text(encoding="utf-8"))
        except ValueError:
            raise Failure(f"{self.name} has no result: {self.text().strip()}") from None


class Load:
    """`dcloc load`: many vehicles in one program."""

    def __init__(self, site, count):
        self.site, self.count = site, count
        self.program = Client(site, "load", [
            site.dcloc, "load", *site.access(), "--map", MAP, *site.drive(), "--vehicles", count,
            "--ramp-s", RAMP_S, "--warmup-s", WARMUP_S, "--duration-s", 86400, "--drain-s", 10,
            "--json"])

    def end(self):
        """Ends the drive; what the vehicles saw."""
        result = self.program.end_with_json()
        totals = result["totals"]
        unanswered = totals["lost_count"] + totals["skipped_count"] + totals["dropped_count"]
        return Seen(
            kind="load", vehicles=self.count, scans=totals["answered_count"] + unanswered,
            answers=totals["answered_count"], worst_gap_s=result["answer_gap"]["max_ms"] / 1e3,
            p99_ms=result["latency"]["p99_ms"], counted=totals["answered_count"],
            tracking=totals["tracking_count"],
            lost=totals["lost_state_count"], restarts=totals["restart_count"],
            errors=totals["misleading_count"] + totals["violations"]["count"]
            + totals["refused"]["count"], max_error_m=totals["max_error_m"])


class SdkVehicle:
    """`dcloc localize`: one vehicle with a session of the client library, and a token of its own."""

    def __init__(self, site, number):
        self.name = f"car-{number}"
        token = site.folder / f"{self.name}.token"
        if not token.exists():
            site.make_token(self.name, "vehicle")
        self.answers = site.folder / f"{self.name}.csv"
        self.program = Client(site, self.name, [
            site.dcloc, "localize", *site.access(token), "--map", MAP, *site.drive(), "--vehicle",
            self.name, "--from-s", 3 * number, "--reconnect-s", 60, "--out", self.answers,
            "--json"])

    def end(self):
        # It ends by itself at the end of the drive, with 0; before that only if it has given up.
        gave_up = not self.program.alive() and self.program.process.returncode != 0
        result = self.program.end_with_json()
        with open(self.answers, encoding="utf-8") as file:
            rows = list(csv.DictReader(file))
        latencies_s = [float(row["latency_ms"]) / 1e3 for row in rows]
        # Scans are sent when their stamps say.
        times_s = [(int(row["stamp_ns"]) - int(rows[0]["stamp_ns"])) * 1e-9 + latency_s
                   for row, latency_s in zip(rows, latencies_s)]
        states = result["states"]
        start = next((i for i, row in enumerate(rows) if row["state"] == "TRACKING"), len(rows))
        return Seen(
            kind="localize", vehicles=1, scans=len(rows) + result["refused"], answers=len(rows),
            counted=len(rows) - start, tracking=states["TRACKING"], lost=states["LOST"],
            worst_gap_s=max((b - a for a, b in zip(times_s, times_s[1:])), default=0.0),
            p99_ms=1e3 * sorted(latencies_s)[int(0.99 * (len(rows) - 1))] if rows else 0.0,
            errors=result["misleading_count"] + result["refused"] + gave_up,
            restarts=result["restart_count"], max_error_m=result["rte_m"]["max"] or 0.0)


def together(kind, seen):
    """What several vehicles saw, as of one."""
    add = {name: sum(getattr(one, name) for one in seen)
           for name in ("vehicles", "scans", "answers", "counted", "tracking", "lost", "errors",
                        "restarts")}
    worst = {name: max(getattr(one, name) for one in seen)
             for name in ("worst_gap_s", "p99_ms", "max_error_m")}
    return Seen(kind=kind, **add, **worst)


class Vehicles:
    """All that drive during an act."""

    def __init__(self, site, load_count, sdk_count, timeout_s):
        self.load = Load(site, load_count)
        self.cars = [SdkVehicle(site, number) for number in range(sdk_count)]
        programs = [self.load.program, *(car.program for car in self.cars)]

        def all_drive():
            for program in programs:
                if not program.alive():
                    raise Failure(f"{program.name} ended: {program.text().strip()}")
            return site.session_count() >= load_count + sdk_count

        try:
            wait_until(all_drive, timeout_s, "a session for each vehicle")
        except BaseException:
            self.kill()
            raise

    def end(self):
        """[what the load saw, what the client library's vehicles saw]."""
        try:
            seen = [self.load.end()]
            if self.cars:
                seen.append(together("localize", [car.end() for car in self.cars]))
            return seen
        finally:
            self.kill()

    def kill(self):
        for program in (self.load.program, *(car.program for car in self.cars)):
            program.kill()
