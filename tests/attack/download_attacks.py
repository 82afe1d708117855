"""Downloads that are not read."""

import contextlib
import socket
import time

import frames
from attacks import code_of

DOWNLOAD = "/dcloc.v1.MapService/DownloadMap"
MAX_OF_A_CALLER = 32  # max_download_count_per_caller
# A window of nothing: what is sent to us waits for as long as we like.
NO_WINDOW = frames.frame(frames.SETTINGS, 0, 0, b"\x00\x04\x00\x00\x00\x00")


def unread_download(case):
    """A download that nobody reads lets go of its version."""
    with case.with_town("--peer-timeout-ms", 2000) as target:
        connection = frames.connect(target.address)
        request = case.api.map_service.DownloadMapRequest(map_name="town").SerializeToString()
        block = frames.call_headers(DOWNLOAD, target.token)
        connection.sendall(
            NO_WINDOW + frames.frame(frames.HEADERS, frames.END_HEADERS, 1, block)
            + frames.frame(frames.DATA, frames.END_STREAM, 1, frames.message(request)))
        time.sleep(0.5)
        with target.channel() as channel:
            maps = case.api.map_service_grpc.MapServiceStub(channel)
            begin = time.monotonic()
            code = ["", ""]
            while time.monotonic() < begin + 2 + max(5, case.seconds):
                code = code_of(lambda: maps.DeleteMap(
                    case.api.map_service.DeleteMapRequest(map_name="town"),
                    metadata=target.call_metadata(), timeout=5))
                if code[0] == "OK":
                    break
                time.sleep(0.2)
            case.figures["let go after [s]"] = round(time.monotonic() - begin, 1)
            case.expect(code[0] == "OK", f"the version is still held: {code}")
        connection.close()


def begin_downloads(case, target, connections, connection_count, of_each):
    """Begins so many downloads that take no answer; how many were sent. `connections` keeps what they
    need."""
    payload = case.api.map_service.DownloadMapRequest(map_name="town").SerializeToString()
    block = frames.call_headers(DOWNLOAD, target.token)
    begun = 0
    for _ in range(connection_count):
        with contextlib.suppress(OSError):
            connection = connections.enter_context(
                contextlib.closing(frames.connect(target.address)))
            connection.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
            connection.sendall(NO_WINDOW)
            for stream in range(1, 2 * of_each, 2):
                connection.sendall(
                    frames.frame(frames.HEADERS, frames.END_HEADERS, stream, block)
                    + frames.frame(frames.DATA, frames.END_STREAM, stream,
                                   frames.message(payload)))
                begun += 1
    return begun


def slow_readers(case):
    """1,000 downloads over 50 connections whose caller reads nothing of them."""
    with case.with_town() as target, contextlib.ExitStack() as connections:
        with case.meanwhile(target):
            case.figures["downloads"] = begin_downloads(case, target, connections, 50, 20)
            time.sleep(case.seconds)
            case.figures["open"] = target.metric("dcloc_downloads")
            code = download(case, target)
            case.figures["one more"] = code
        case.figures["memory [MiB]"] = round(target.metric("process_resident_memory_bytes") / 2**20)
        case.expect(case.figures["open"] == MAX_OF_A_CALLER,
                    f"{case.figures['open']} are open; a caller may have {MAX_OF_A_CALLER}")
        case.expect(code[0] == "RESOURCE_EXHAUSTED", f"one more of the caller was told {code}")


def download(case, target):
    """How a download by the same caller ends."""
    with target.channel() as channel:
        stub = case.api.map_service_grpc.MapServiceStub(channel)
        return code_of(lambda: list(stub.DownloadMap(
            case.api.map_service.DownloadMapRequest(map_name="town"),
            metadata=target.call_metadata(), timeout=10)))


DOWNLOAD_ATTACKS = [unread_download, slow_readers]
