"""A session that mends its connection and knows the vehicle's pose at any time."""

from __future__ import annotations

import ctypes
import dataclasses
import enum
import math
import os
import pathlib
from types import TracebackType
from typing import Iterable, Iterator, Sequence

from dcloc import library
from dcloc.library import Error, Status

_IDENTITY = (1.0, 0.0, 0.0, 0.0)


class State(enum.IntEnum):
    """What a pose rests on."""

    INITIALIZING = 1
    TRACKING = 2
    DEAD_RECKONING = 3
    LOST = 4


@dataclasses.dataclass(frozen=True)
class Radar:
    """A radar by its frame in the vehicle frame (x ahead, y left, z up)."""

    radar_id: str
    translation_m: Sequence[float]
    rotation_wxyz: Sequence[float] = _IDENTITY
    beta_s: float = 0.0  #: range-Doppler coupling


@dataclasses.dataclass(frozen=True)
class Prior:
    """The vehicle in the map frame. The covariance is row-major 6 by 6 of (x, y, z, rotation about
    x, y, z), about the map's axes."""

    translation_m: Sequence[float]
    covariance: Sequence[float]
    rotation_wxyz: Sequence[float] = _IDENTITY


@dataclasses.dataclass(frozen=True)
class Pose:
    """The vehicle in the map frame at a stamp; the covariance as in `Prior`."""

    stamp_ns: int
    answer_stamp_ns: int  #: of the answer that it goes out from
    translation_m: tuple[float, ...]
    rotation_wxyz: tuple[float, ...]
    covariance: tuple[float, ...]
    velocity: tuple[float, ...]  #: as in `VehicleSession.add_ego_velocity`
    state: State


@dataclasses.dataclass(frozen=True)
class Answer:
    """What became of a scan. Without a `pose` it was refused, for the reason in `rejection`."""

    sequence_number: int
    pose: Pose | None
    protection_level_m: float | None  #: None: none is promised
    rejection: Error | None


def _doubles(name: str, values: Sequence[float], count: int) -> ctypes.Array:
    if len(values) != count:
        raise ValueError(f"{name} has {len(values)} numbers; it must have {count}")
    return (ctypes.c_double * count)(*values)


def _column(name: str, values: Sequence[float] | None, count: int) -> ctypes.Array | None:
    if values is None:
        return None
    if len(values) != count:
        raise ValueError(f"{name} has {len(values)} targets; range_m has {count}")
    return (ctypes.c_float * count)(*values)


def _pose(struct: library.PoseStruct) -> Pose:
    return Pose(struct.stamp_ns, struct.answer_stamp_ns, tuple(struct.translation_m),
                tuple(struct.rotation_wxyz), tuple(struct.covariance), tuple(struct.velocity),
                State(struct.state))


class _Handle:
    """A pointer of the library. Each call holds the handle, so that it is freed after the last."""

    def __init__(self, pointer: int | None, free: str) -> None:
        self.pointer = ctypes.c_void_p(pointer)
        self._free = getattr(library.load(), free)

    def __del__(self) -> None:
        self._free(self.pointer)


class VehicleSession:
    """Scans in, exactly one answer to each out, in the same order; the pose at any time beside.

    As `dcloc_session` of the C interface (Debian package libdcloc1), which does the work. A broken
    connection is mended for `give_up_after_s`. Any thread may call; `pose_at` waits for none.
    """

    def __init__(self, server: str, map_name: str, vehicle_id: str, radars: Iterable[Radar], *,
                 prior: Prior | None = None, give_up_after_s: float = 120.0,
                 forget_answers: bool = False,
                 tls_ca: str | os.PathLike[str] | None = None,
                 tls_cert: str | os.PathLike[str] | None = None,
                 tls_key: str | os.PathLike[str] | None = None,
                 token_file: str | os.PathLike[str] | None = None) -> None:
        """Waits until the server HOST:PORT has opened the session, at most 10 s; `Error` says why
        it has not. Without a prior the whole map is searched. `forget_answers` is for programs that
        only ask for poses: answers that are not taken are forgotten, the oldest first."""
        if tls_ca is None and (tls_cert is not None or tls_key is not None):
            raise ValueError("TLS needs tls_ca, the authority of the server's certificate")
        config = _Handle(library.load().dcloc_config_new(server.encode(), map_name.encode(),
                                                         vehicle_id.encode()), "dcloc_config_free")

        def configure(what: str, *arguments: object) -> None:
            library.call(f"dcloc_config_{what}", config.pointer, *arguments)

        def encoded(path: str | os.PathLike[str] | None) -> bytes | None:
            return None if path is None else os.fsencode(pathlib.Path(path))

        if tls_ca is not None:
            configure("set_tls", encoded(tls_ca), encoded(tls_cert), encoded(tls_key))
        if token_file is not None:
            configure("set_token_file", encoded(token_file))
        configure("set_reconnect_ms", round(give_up_after_s * 1e3))
        if forget_answers:
            configure("forget_answers")
        for radar in radars:
            configure("add_radar", radar.radar_id.encode(),
                      _doubles("translation_m", radar.translation_m, 3),
                      _doubles("rotation_wxyz", radar.rotation_wxyz, 4), radar.beta_s)
        if prior is not None:
            configure("set_initial_pose", _doubles("translation_m", prior.translation_m, 3),
                      _doubles("rotation_wxyz", prior.rotation_wxyz, 4),
                      _doubles("covariance", prior.covariance, 36))
        pointer = ctypes.c_void_p()
        library.call("dcloc_session_open", config.pointer, ctypes.byref(pointer))
        self._handle: _Handle | None = _Handle(pointer.value, "dcloc_session_free")

    def _call(self, what: str, *arguments: object) -> None:
        handle = self._handle
        if handle is None:
            raise Error(Status.FAILED_PRECONDITION, "the session is closed")
        library.call(f"dcloc_session_{what}", handle.pointer, *arguments)

    def send_scan(self, radar_id: str, sequence_number: int, stamp_ns: int, *,
                  range_m: Sequence[float] = (), range_rate_mps: Sequence[float] = (),
                  azimuth_rad: Sequence[float] = (),
                  elevation_rad: Sequence[float] | None = None,
                  rcs_dbsm: Sequence[float] | None = None,
                  ego_velocity: Sequence[float] | None = None) -> None:
        """Queues a scan and does not wait; RESOURCE_EXHAUSTED when too many wait already. Range
        rates are positive away from the radar, azimuths counter-clockwise from its x axis."""
        count = len(range_m)
        scan = library.ScanStruct(
            struct_size=ctypes.sizeof(library.ScanStruct), sequence_number=sequence_number,
            stamp_ns=stamp_ns, radar_id=radar_id.encode(), target_count=count,
            range_m=_column("range_m", range_m, count),
            range_rate_mps=_column("range_rate_mps", range_rate_mps, count),
            azimuth_rad=_column("azimuth_rad", azimuth_rad, count),
            elevation_rad=_column("elevation_rad", elevation_rad, count),
            rcs_dbsm=_column("rcs_dbsm", rcs_dbsm, count),
            ego_velocity=None if ego_velocity is None else _doubles("ego_velocity", ego_velocity, 6))
        self._call("send_scan", ctypes.byref(scan))

    def add_motion(self, stamp_ns: int, speed_mps: float | None = None,
                   yaw_rate_radps: float | None = None) -> None:
        """What wheels and gyroscope say, each at its own rate, for `pose_at`: forward speed, and
        turn rate about z. Scans that are sent without an ego-velocity get theirs from here."""
        self._call("add_motion", stamp_ns, math.nan if speed_mps is None else speed_mps,
                   math.nan if yaw_rate_radps is None else yaw_rate_radps)

    def add_ego_velocity(self, stamp_ns: int, velocity: Sequence[float]) -> None:
        """The vehicle's velocity as a whole, at any rate, for `pose_at`: x, y, z [m/s], turn
        rates about x, y, z [rad/s], in the vehicle frame. Nothing is sent."""
        self._call("add_ego_velocity", stamp_ns, _doubles("velocity", velocity, 6))

    def pose_at(self, stamp_ns: int) -> Pose:
        """Where the vehicle was, between answers or at most 0.5 s after the newest.
        FAILED_PRECONDITION while there is no pose, OUT_OF_RANGE too far ahead or back."""
        return self._pose("pose_at", stamp_ns)

    def smooth_pose_at(self, stamp_ns: int) -> Pose:
        """The same without jumps, for controllers."""
        return self._pose("smooth_pose_at", stamp_ns)

    def _pose(self, what: str, stamp_ns: int) -> Pose:
        struct = library.PoseStruct(struct_size=ctypes.sizeof(library.PoseStruct))
        self._call(what, stamp_ns, ctypes.byref(struct))
        return _pose(struct)

    def next_answer(self) -> Answer:
        """Waits for the next answer. OUT_OF_RANGE once the session has ended and all are taken."""
        struct = library.AnswerStruct(struct_size=ctypes.sizeof(library.AnswerStruct))
        self._call("next", ctypes.byref(struct))
        level = struct.protection_level_m if struct.protection_level_m >= 0.0 else None
        if struct.rejection != Status.OK:
            why = Error(struct.rejection, library.error_text())
            return Answer(struct.sequence_number, None, None, why)
        return Answer(struct.sequence_number, _pose(struct.pose), level, None)

    def __iter__(self) -> Iterator[Answer]:
        """The answers until the session ends; `Error` when it does not end well."""
        while True:
            try:
                yield self.next_answer()
            except Error as error:
                if error.status != Status.OUT_OF_RANGE:
                    raise
                self._call("end_status")
                return

    def close_sending(self) -> None:
        """No more scans will come; those that were sent are answered, then the session ends."""
        self._call("close_sending")

    def close(self) -> None:
        """Ends the session without waiting. May be called again."""
        handle, self._handle = self._handle, None
        if handle is not None:
            library.call("dcloc_session_cancel", handle.pointer)

    def __enter__(self) -> VehicleSession:
        return self

    def __exit__(self, error: type[BaseException] | None, value: BaseException | None,
                 trace: TracebackType | None) -> None:
        self.close()
