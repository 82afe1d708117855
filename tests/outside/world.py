"""Streets, how a vehicle drives through them, and what its radars see. It shares no code with
client/simulation, and little of what that assumes: corners of 10 m radius, a row of parked cars of
which none stands where it did on the day of the map, targets in the walls behind the first ones.
"""

import dataclasses

import numpy

STEP_M = 0.1     # of the street's centreline
STEP_S = 0.005   # of a drive
CORNER_M = 10.0  # radius
TARGETS = 220    # the most that a scan has


@dataclasses.dataclass
class Radar:
    name: str
    x_m: float
    y_m: float
    yaw_deg: float
    view_deg: float  # to either side
    range_m: float


RIGS = {
    "one": [Radar("front", 3.6, 0.0, 0.0, 60.0, 100.0)],
    "five": [Radar("front", 3.6, 0.0, 0.0, 50.0, 160.0)] + [
        Radar(name, x_m, y_m, yaw_deg, 70.0, 80.0)
        for name, x_m, y_m, yaw_deg in (("fl", 3.3, 0.8, 50.0), ("fr", 3.3, -0.8, -50.0),
                                        ("rl", -0.9, 0.8, 130.0), ("rr", -0.9, -0.8, -130.0))],
}


def smooth(values, width):
    padded = numpy.pad(values, width // 2, "edge")
    return numpy.convolve(padded, numpy.ones(width) / width, "valid")


class Street:
    """A centreline, and what stands beside it. `kind` is "city", with corners, or "avenue"."""

    def __init__(self, kind, seed):
        self.seed = seed
        random = numpy.random.default_rng(seed)
        turns = [0.0] * 10
        if kind == "city":
            turns = [random.choice([0.0, 1.0, -1.0, 0.0]) for _ in turns]
            for i in range(1, len(turns)):  # three times the same way, and it would cross itself
                if turns[i] != 0.0 and turns[i] == turns[i - 1]:
                    turns[i] = 0.0
        curvature = []
        for turn in turns:
            block_m = random.uniform(80.0, 150.0) if kind == "city" else 120.0
            corner_m = CORNER_M * numpy.pi / 2.0 if turn != 0.0 else 2.0 * CORNER_M
            curvature += [0.0] * int((block_m - 2.0 * CORNER_M) / STEP_M)
            curvature += [turn / CORNER_M] * int(corner_m / STEP_M)
        self.curvature = numpy.array(curvature)
        self.yaw = numpy.cumsum(self.curvature) * STEP_M
        self.x = numpy.cumsum(numpy.cos(self.yaw)) * STEP_M
        self.y = numpy.cumsum(numpy.sin(self.yaw)) * STEP_M
        self.length_m = STEP_M * (len(self.x) - 1)
        self._build(random)

    def at(self, index, left_m):
        """The point `left_m` to the left of the centreline."""
        index = numpy.clip(numpy.asarray(index, int), 0, len(self.x) - 1)
        return numpy.stack([self.x[index] - left_m * numpy.sin(self.yaw[index]),
                            self.y[index] + left_m * numpy.cos(self.yaw[index])], -1)

    def _build(self, random):
        rows = []  # x, y, cross-section, height, by how much it wanders

        def add(index, left_m, rcs_dbsm, height_m, wander_m=0.0):
            rows.append([*self.at(index, left_m), rcs_dbsm, height_m, wander_m])

        count = len(self.x)
        for side in (-1.0, 1.0):
            begin = int(random.integers(0, 100))
            while begin < count:  # houses, with windows at equal distances
                length, depth_m = int(random.uniform(80, 350)), random.uniform(8.0, 14.0)
                for i in range(begin, min(count, begin + length), int(random.choice([25, 30, 35]))):
                    if random.random() < 0.8:
                        add(i, side * depth_m, random.normal(3, 4), random.uniform(0.5, 5.0))
                add(begin, side * depth_m, 12.0, 1.0)
                add(begin + length, side * depth_m, 12.0, 1.0)
                begin += length + int(random.exponential(60)) + 10
            for i in range(int(random.integers(0, 300)), count, int(random.integers(280, 320))):
                add(i, side * 6.5 + random.normal(0, 0.2), 10.0, 1.5)  # lamp posts
            for i in random.integers(0, count, count // 120):  # trees, bins, signs
                left_m = side * random.uniform(6.0, 9.0)
                for _ in range(int(random.integers(1, 4))):
                    add(i + random.normal(0, 8), left_m + random.normal(0, 0.8),
                        random.normal(2, 4), random.uniform(0.0, 3.0), 0.15)
            for i in random.integers(0, count, count // 300):  # what is further away
                add(i, side * random.uniform(15.0, 35.0), random.normal(6, 4),
                    random.uniform(0.0, 8.0), 0.05)
        built = numpy.array(rows)
        from_street_m = numpy.hypot(built[:, :1] - self.x[None, ::20],
                                    built[:, 1:2] - self.y[None, ::20]).min(1)
        self.built = built[from_street_m > 4.5]

    def parked(self, day):
        """The parked cars of a day, as rows like those of `built`."""
        random = numpy.random.default_rng(day + 1000 * self.seed)
        rows = []
        for side in (-1.0, 1.0):
            for begin in range(int(random.integers(0, 60)), len(self.x) - 60, 60):
                if random.random() < 0.5:
                    for _ in range(5):
                        left_m = side * (5.2 + random.choice([-0.9, 0.9]))
                        rows.append([*self.at(begin + random.uniform(0, 45), left_m),
                                     random.normal(5, 4), 0.5, 0.1])
        return numpy.array(rows)


class Drive:
    """Where a vehicle is at each time, slower in corners and with a halt or two."""

    def __init__(self, street, speed_mps, halts, seed):
        random = numpy.random.default_rng(seed)
        count = len(street.x)
        along = numpy.arange(count) * STEP_M
        speed = speed_mps * (1.0 + 0.15 * numpy.sin(along / 40.0 + random.uniform(0, 6)))
        speed = numpy.minimum(speed, numpy.sqrt(2.0 / numpy.maximum(abs(street.curvature), 1e-6)))
        halting = random.integers(count // 6, count - count // 10, halts)
        for index in halting:
            speed[index - 3:index + 3] = 0.3
        for i in range(count - 2, -1, -1):  # braking
            speed[i] = min(speed[i], numpy.sqrt(speed[i + 1] ** 2 + 2 * 1.8 * STEP_M))
        for i in range(1, count):  # pulling away
            speed[i] = min(speed[i], numpy.sqrt(speed[i - 1] ** 2 + 2 * 1.5 * STEP_M))
        duration = STEP_M / numpy.maximum(speed, 0.3)
        for index in halting:
            duration[index] += random.uniform(3.0, 10.0)
        times = numpy.concatenate([[0.0], numpy.cumsum(duration[:-1])])
        self.t = numpy.arange(0.0, times[-1], STEP_S)
        self.s = smooth(numpy.interp(self.t, times, along), 61)
        left = -1.5 + 0.2 * numpy.sin(self.s / 30.0 + random.uniform(0, 6))
        yaw = numpy.interp(self.s, along, street.yaw)
        self.x = smooth(numpy.interp(self.s, along, street.x) - left * numpy.sin(yaw), 41)
        self.y = smooth(numpy.interp(self.s, along, street.y) + left * numpy.cos(yaw), 41)
        moving = numpy.maximum(numpy.gradient(self.s, STEP_S), 0.2)
        drift = numpy.where(moving > 0.2, numpy.arctan2(numpy.gradient(left, STEP_S), moving), 0.0)
        self.yaw = smooth(yaw + drift, 61)
        x_mps, y_mps = numpy.gradient(self.x, STEP_S), numpy.gradient(self.y, STEP_S)
        self.ahead = x_mps * numpy.cos(self.yaw) + y_mps * numpy.sin(self.yaw)
        self.left = -x_mps * numpy.sin(self.yaw) + y_mps * numpy.cos(self.yaw)
        self.turn = numpy.gradient(self.yaw, STEP_S)

    def at(self, t):
        """x, y, yaw, forward and sideways speed, yaw rate."""
        return [numpy.interp(t, self.t, column)
                for column in (self.x, self.y, self.yaw, self.ahead, self.left, self.turn)]


def measure(random, radar, pose, built, movers):
    """Ranges, azimuths, range rates and cross-sections. `movers` are rows of x, y, vx, vy."""
    x, y, yaw, ahead, left, turn = pose
    cos, sin = numpy.cos(yaw), numpy.sin(yaw)
    origin = [x + cos * radar.x_m - sin * radar.y_m, y + sin * radar.x_m + cos * radar.y_m]
    points = built[:, :2] + random.normal(0, 1, (len(built), 2)) * built[:, 4:]
    points = numpy.vstack([points, movers[:, :2]])
    velocities = numpy.vstack([numpy.zeros((len(built), 2)), movers[:, 2:]])
    rcs = numpy.concatenate([built[:, 2], numpy.full(len(movers), 10.0)])
    heights = numpy.concatenate([built[:, 3], numpy.full(len(movers), 0.5)])
    offset = points - origin
    ground = numpy.hypot(offset[:, 0], offset[:, 1])
    reach = numpy.hypot(ground, heights - 0.5)
    azimuth = numpy.arctan2(offset[:, 1], offset[:, 0]) - yaw - numpy.radians(radar.yaw_deg)
    azimuth = (azimuth + numpy.pi) % (2 * numpy.pi) - numpy.pi
    aside = azimuth / numpy.radians(radar.view_deg)
    snr = rcs - 40 * numpy.log10(numpy.maximum(reach, 1.0) / 25.0) - 6 * aside ** 2
    snr += random.normal(0, 3, len(reach))
    own = [cos * (ahead - turn * radar.y_m) - sin * (left + turn * radar.x_m),
           sin * (ahead - turn * radar.y_m) + cos * (left + turn * radar.x_m)]
    rate = ((velocities - own) * offset).sum(1) / numpy.maximum(reach, 0.1)
    seen = (ground > 1.5) & (reach < radar.range_m) & (abs(aside) < 1.0)
    seen &= random.random(len(reach)) < 0.85 / (1 + numpy.exp(-snr / 2.5))
    scan = numpy.stack([reach, azimuth, rate, rcs])[:, seen]
    scan[0] += random.normal(0, 0.12, scan.shape[1])
    scan[1] += random.normal(0, 1, scan.shape[1]) * numpy.radians(0.4 + 0.8 * aside[seen] ** 2)
    scan[2] += random.normal(0, 0.07, scan.shape[1])
    ghosts = scan[:, random.random(scan.shape[1]) < 0.05].copy()  # by a second reflection
    ghosts[0] *= random.uniform(1.2, 1.9, ghosts.shape[1])
    ghosts[1] *= -1.0
    ghosts[2] *= random.uniform(0.6, 1.4, ghosts.shape[1])
    clutter = random.poisson(5)
    scan = numpy.hstack([scan, ghosts, numpy.stack([
        random.uniform(2.0, radar.range_m, clutter),
        random.uniform(-1.0, 1.0, clutter) * numpy.radians(radar.view_deg),
        random.uniform(-15.0, 10.0, clutter), random.normal(-5, 4, clutter)])])
    strongest = numpy.argsort(40 * numpy.log10(numpy.maximum(scan[0], 1.0)) - scan[3])[:TARGETS]
    return scan[:, strongest][:, scan[0, strongest] > 0.3]


def record(street, drive, rig, rate_hz, day, seed):
    """The scans of a drive: dicts of time, radar, targets, reported speed and turn, true pose."""
    random = numpy.random.default_rng(seed)
    built = numpy.vstack([street.built, street.parked(day)])
    cars = [(random.uniform(0, street.length_m), random.uniform(5, 14) * random.choice([-1, 1]))
            for _ in range(4)]

    def movers(t):
        rows = []
        for begin_m, speed_mps in cars:
            index = int((begin_m + speed_mps * t) % street.length_m / STEP_M)
            heading = numpy.array([numpy.cos(street.yaw[index]), numpy.sin(street.yaw[index])])
            for back_m, aside_m in ((0, -0.8), (0, 0.8), (4, 0.8), (4, -0.8)):
                at = street.at(index, (2.0 if speed_mps < 0 else -0.5) + aside_m) + back_m * heading
                rows.append([*at, *(speed_mps * heading)])
        return numpy.array(rows)

    times = []
    for radar in RIGS[rig]:
        begin_s = 0.2 + random.uniform(0, 1 / rate_hz)
        times += [(t + random.normal(0, 0.001), radar)
                  for t in numpy.arange(begin_s, drive.t[-1] - 0.3, 1 / rate_hz)]
    scans = []
    for t, radar in sorted(times, key=lambda entry: entry[0]):
        pose = drive.at(t)
        reach, azimuth, rate, rcs = measure(random, radar, pose, built, movers(t))
        scans.append({
            "t": t, "stamp": t, "radar": radar.name, "truth": pose[:3], "range": reach,
            "azimuth": azimuth, "rate": rate, "rcs": rcs,
            "speed": 1.006 * pose[3] + random.normal(0, 0.03),
            "turn": pose[5] + numpy.radians(0.15) + random.normal(0, 0.003)})
    return scans
