"""libdcloc.so.1, the C interface of the client library, by ctypes: its structs and functions.

`dcloc.h` is the reference. A test holds sizes and offsets against it.
"""

from __future__ import annotations

import ctypes
import enum
import functools
import os
from ctypes import POINTER, c_char_p, c_double, c_float, c_int, c_int32, c_int64, c_size_t, c_void_p

#: Names another file than the one that the loader finds.
LIBRARY_VARIABLE = "DCLOC_LIBRARY"


class Status(enum.IntEnum):
    """Why a call failed: the numbers of gRPC."""

    OK = 0
    CANCELLED = 1
    UNKNOWN = 2
    INVALID_ARGUMENT = 3
    DEADLINE_EXCEEDED = 4
    NOT_FOUND = 5
    ALREADY_EXISTS = 6
    PERMISSION_DENIED = 7
    RESOURCE_EXHAUSTED = 8
    FAILED_PRECONDITION = 9
    ABORTED = 10
    OUT_OF_RANGE = 11
    UNIMPLEMENTED = 12
    INTERNAL = 13
    UNAVAILABLE = 14
    DATA_LOSS = 15
    UNAUTHENTICATED = 16


class Error(Exception):
    """A call that failed, with its `status`."""

    def __init__(self, status: int, message: str) -> None:
        super().__init__(message)
        self.status = Status(status)


class ScanStruct(ctypes.Structure):
    """dcloc_scan."""

    _fields_ = [("struct_size", c_size_t), ("sequence_number", c_int64), ("stamp_ns", c_int64),
                ("radar_id", c_char_p), ("target_count", c_size_t), ("range_m", POINTER(c_float)),
                ("range_rate_mps", POINTER(c_float)), ("azimuth_rad", POINTER(c_float)),
                ("elevation_rad", POINTER(c_float)), ("rcs_dbsm", POINTER(c_float)),
                ("ego_velocity", POINTER(c_double))]


class PoseStruct(ctypes.Structure):
    """dcloc_pose."""

    _fields_ = [("struct_size", c_size_t), ("stamp_ns", c_int64), ("answer_stamp_ns", c_int64),
                ("translation_m", c_double * 3), ("rotation_wxyz", c_double * 4),
                ("covariance", c_double * 36), ("velocity", c_double * 6), ("state", c_int32)]


class AnswerStruct(ctypes.Structure):
    """dcloc_answer."""

    _fields_ = [("struct_size", c_size_t), ("sequence_number", c_int64), ("rejection", c_int32),
                ("protection_level_m", c_double), ("pose", PoseStruct)]


_DOUBLES = POINTER(c_double)
#: The arguments of each function that returns a dcloc_status.
_CALLS = {
    "dcloc_config_set_tls": [c_void_p, c_char_p, c_char_p, c_char_p],
    "dcloc_config_set_token_file": [c_void_p, c_char_p],
    "dcloc_config_add_radar": [c_void_p, c_char_p, _DOUBLES, _DOUBLES, c_double],
    "dcloc_config_set_initial_pose": [c_void_p, _DOUBLES, _DOUBLES, _DOUBLES],
    "dcloc_config_set_reconnect_ms": [c_void_p, c_int64],
    "dcloc_config_forget_answers": [c_void_p],
    "dcloc_session_open": [c_void_p, POINTER(c_void_p)],
    "dcloc_session_send_scan": [c_void_p, POINTER(ScanStruct)],
    "dcloc_session_add_motion": [c_void_p, c_int64, c_double, c_double],
    "dcloc_session_add_ego_velocity": [c_void_p, c_int64, _DOUBLES],
    "dcloc_session_pose_at": [c_void_p, c_int64, POINTER(PoseStruct)],
    "dcloc_session_smooth_pose_at": [c_void_p, c_int64, POINTER(PoseStruct)],
    "dcloc_session_next": [c_void_p, POINTER(AnswerStruct)],
    "dcloc_session_close_sending": [c_void_p],
    "dcloc_session_cancel": [c_void_p],
    "dcloc_session_end_status": [c_void_p],
}


@functools.cache
def load() -> ctypes.CDLL:
    """The library. OSError where there is none, and says what to install."""
    name = os.environ.get(LIBRARY_VARIABLE, "libdcloc.so.1")
    try:
        library = ctypes.CDLL(name)
    except OSError as error:
        raise OSError(f"{error}: install the Debian package libdcloc1, or name the file in "
                      f"{LIBRARY_VARIABLE}") from error
    for function, arguments in _CALLS.items():
        getattr(library, function).argtypes = arguments
        getattr(library, function).restype = c_int
    library.dcloc_error_text.restype = c_char_p
    library.dcloc_version.restype = c_char_p
    library.dcloc_config_new.argtypes = [c_char_p, c_char_p, c_char_p]
    library.dcloc_config_new.restype = c_void_p
    for function in (library.dcloc_config_free, library.dcloc_session_free):
        function.argtypes = [c_void_p]
        function.restype = None
    return library


def error_text() -> str:
    """What the last call of this thread that failed had to say."""
    return load().dcloc_error_text().decode(errors="replace")


def call(function: str, *arguments: object) -> None:
    """Calls a function by its name; Error where it fails."""
    status = getattr(load(), function)(*arguments)
    if status != Status.OK:
        raise Error(status, error_text())
