"""What vehicles and radars get wrong: each changes the scans of a drive, given a random generator."""

import numpy

BEGIN_S = 30.0  # of the faults that do not last from the start


def each(change, begin_s=0.0, end_s=numpy.inf, radar=None):
    def apply(scans, random):
        for scan in scans:
            if begin_s <= scan["t"] < end_s and radar in (None, scan["radar"]):
                change(scan, random)
        return scans
    return apply


def scaled(speed, turn, turn_off_deg=0.0):
    def change(scan, _):
        scan["speed"] *= speed
        scan["turn"] = turn * scan["turn"] + numpy.radians(turn_off_deg)
    return change


def coarse(scan, _):
    step = 1.0 / 3.6
    scan["speed"] = 0.0 if abs(scan["speed"]) < 2.5 * step else step * round(scan["speed"] / step)
    scan["turn"] = 0.01 * round(scan["turn"] / 0.01)


def silent(scan, _):
    scan["speed"] = None


def stamped(ahead_s):
    def change(scan, _):
        scan["stamp"] += ahead_s
    return change


def late(most_s):
    def apply(scans, random):
        return sorted(scans, key=lambda scan: scan["t"] + most_s * random.random())
    return apply


def late_but(radar, by_s):
    return lambda scans, _: sorted(
        scans, key=lambda scan: scan["t"] + (0.0 if scan["radar"] == radar else by_s))


def thinned(share):
    return lambda scans, random: [scan for scan in scans if random.random() < share]


def multiplied(column, factor, offset=0.0):
    def change(scan, _):
        scan[column] = factor * scan[column] + offset
    return change


def own_body(scan, random):
    count = 80
    added = {"range": random.uniform(1, 15, count), "azimuth": random.uniform(-1, 1, count),
             "rate": numpy.zeros(count), "rcs": numpy.full(count, -5.0)}
    for column, values in added.items():
        scan[column] = numpy.concatenate([scan[column], values])


def skipped(metres):
    """The vehicle is carried: what it would have seen on the way never happened."""
    def apply(scans, _):
        begin = next(scan for scan in scans if scan["t"] >= BEGIN_S)["truth"][:2]
        apart = [numpy.hypot(*numpy.subtract(scan["truth"][:2], begin)) for scan in scans]
        back = next(i for i, scan in enumerate(scans)
                    if scan["t"] >= BEGIN_S and apart[i] >= metres)
        gap_s = scans[back]["t"] - BEGIN_S
        for scan in scans[back:]:
            scan["stamp"] -= gap_s
        return [scan for scan in scans if scan["t"] < BEGIN_S] + scans[back:]
    return apply


FAULTS = {
    "none": lambda scans, random: scans,
    "no velocity": each(silent),
    "speed 0 for 3 s": each(scaled(0.0, 1.0), BEGIN_S, BEGIN_S + 3.0),
    "speed 0": each(scaled(0.0, 1.0), BEGIN_S),
    "speed and turn 0": each(scaled(0.0, 0.0), BEGIN_S),
    "speed x 1.3": each(scaled(1.3, 1.0), BEGIN_S),
    "speed x 1.1, turn + 2 deg/s": each(scaled(1.1, 1.0, 2.0), BEGIN_S),
    "turn + 3 deg/s": each(scaled(1.0, 1.0, 3.0), BEGIN_S),
    "turn 0, always": each(scaled(1.0, 0.0)),
    "coarse steps": each(coarse),
    "half of the scans lost": thinned(0.5),
    "scans up to 250 ms late": late(0.25),
    "all but front 0.2 s late": late_but("front", 0.2),
    "front 0.1 s ahead, always": each(stamped(0.1), radar="front"),
    "front 0.25 s behind, always": each(stamped(-0.25), radar="front"),
    "clock 5 s back": each(stamped(-5.0), BEGIN_S),
    "front azimuths + 4 deg": each(multiplied("azimuth", 1.0, numpy.radians(4.0)), radar="front"),
    "front azimuths mirrored": each(multiplied("azimuth", -1.0), radar="front"),
    "ranges + 0.5 m": each(multiplied("range", 1.0, 0.5)),
    "range rates 0, always": each(multiplied("rate", 0.0)),
    "range rates + 1 m/s": each(multiplied("rate", 1.0, 1.0), BEGIN_S),
    "range rates + 1 m/s, always": each(multiplied("rate", 1.0, 1.0)),
    "range rates x 1.07": each(multiplied("rate", 1.07), BEGIN_S),
    "range rates x 1.07, always": each(multiplied("rate", 1.07)),
    "own body": each(own_body),
    "carried 40 m": skipped(40.0),
    "carried 120 m": skipped(120.0),
}
