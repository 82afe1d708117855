"""What outsiders do to a server. Each attack yields figures, and a list of what did not hold."""

import concurrent.futures
import contextlib
import json
import shutil
import socket
import subprocess
import sys
import threading
import time

import grpc

import frames
from target import HERE

LOCALIZE = "/dcloc.v1.LocalizationService/Localize"


# ---- Streams that never open a session

def silent_streams(case, count, connection_count, token):
    """Localize calls that send nothing, over a few connections: half of them before the vehicles
    come, half while they drive."""
    with case.with_town("--max-session-count", 50) as target, contextlib.ExitStack() as stack:
        block = frames.call_headers(LOCALIZE, target.vehicle_token if token else None)
        connections = [stack.enter_context(contextlib.closing(frames.connect(target.address)))
                       for _ in range(connection_count)]

        def begin_half(first_stream):
            for i in range(count // connection_count // 2):
                for connection in connections:
                    with contextlib.suppress(OSError):
                        connection.sendall(frames.frame(frames.HEADERS, frames.END_HEADERS,
                                                        first_stream + 4 * i, block))

        begin_half(1)
        time.sleep(1)
        with case.meanwhile(target):
            time.sleep(1)
            begin_half(1 + 4 * count)
            time.sleep(case.seconds)
            case.figures["session_count"] = case.state(target).session_count
            case.figures["unopened"] = target.metric("dcloc_unopened_streams")


def streams_without_open(case):
    """120 calls without a token, then 120 with one, none of which opens a session."""
    silent_streams(case, 120, 1, token=False)
    silent_streams(case, 120, 1, token=True)


def many_streams(case):
    """10,000 calls of an unknown peer over 10 connections."""
    silent_streams(case, 10_000, 10, token=False)


def many_streams_known(case):
    """10,000 calls of a peer with a token over 10 connections."""
    silent_streams(case, 10_000, 10, token=True)


def many_connections(case):
    """1,000 connections that say nothing, from one address."""
    with case.with_town() as target:
        with case.meanwhile(target), contextlib.ExitStack() as stack:
            opened = 0
            for _ in range(1000):
                with contextlib.suppress(OSError):
                    stack.enter_context(contextlib.closing(
                        frames.connect_silently(target.address, 2)))
                    opened += 1
            case.figures["connections"] = opened
            time.sleep(case.seconds)


def a_stream_ends_without_open(case):
    """A call that sends nothing is ended, and is told why."""
    with case.target("--open-timeout-ms", 1000) as target, target.channel() as channel:
        stub = case.api.localization_service_grpc.LocalizationServiceStub(channel)
        begin = time.monotonic()
        forever = threading.Event()

        def nothing():
            forever.wait(20)
            yield from ()

        call = stub.Localize(nothing(), metadata=target.call_metadata(target.vehicle_token),
                             timeout=15)
        code = code_of(lambda: next(call))
        forever.set()
        case.figures["ended"] = [code, round(time.monotonic() - begin, 1)]
        case.expect(code[0] == "DEADLINE_EXCEEDED" and "open" in code[1], f"it ended with {code}")


def code_of(call):
    try:
        call()
    except grpc.RpcError as error:
        return [error.code().name, error.details()]
    return ["OK", ""]


# ---- Certificates

def make_certificate(folder, name, days=30):
    subprocess.run(["openssl", "req", "-x509", "-newkey", "ec", "-pkeyopt",
                    "ec_paramgen_curve:prime256v1", "-nodes", "-days", str(days), "-subj",
                    f"/CN={name}", "-addext", "subjectAltName=IP:127.0.0.1", "-keyout",
                    folder / f"{name}.key", "-out", folder / f"{name}.pem"], check=True,
                   stderr=subprocess.DEVNULL)


def certificates(case):
    """Files that are empty, garbage or do not match while the server runs."""
    folder = case.folder / "tls"
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir()
    make_certificate(folder, "first")
    make_certificate(folder, "second")
    served = [folder / "served.pem", folder / "served.key"]

    def put(name):
        for path, suffix in zip(served, ("pem", "key")):
            shutil.copy(folder / f"{name}.{suffix}", path)

    def serves(target, name):
        trust = grpc.ssl_channel_credentials((folder / f"{name}.pem").read_bytes())
        with target.channel(credentials=trust) as channel:
            return code_of(lambda: case.api.admin_service_grpc.AdminServiceStub(
                channel).GetServerState(case.api.admin_service.GetServerStateRequest(),
                                        metadata=target.call_metadata(), timeout=5))[0] == "OK"

    put("first")
    with case.target("--tls-cert", served[0], "--tls-key", served[1]) as target:
        case.expect(serves(target, "first"), "the first pair is not served")
        spoils = {"empty certificate": (0, b""), "empty key": (1, b""),
                  "garbage certificate": (0, case.random.randbytes(500)),
                  "garbage key": (1, b"-----BEGIN PRIVATE KEY-----\nAAAA\n"),
                  "another's key": (1, (folder / "second.key").read_bytes())}
        for name, (which, content) in spoils.items():
            put("first")
            served[which].write_bytes(content)
            time.sleep(3)
            case.expect(target.alive(), f"{name}: the server is dead")
            if not target.alive():
                return
            case.expect(serves(target, "first"), f"{name}: new connections fail")
            case.expect(target.metric("dcloc_tls_certificate_ok") == 0.0, f"{name}: no metric says so")
            case.expect("tls_" in target.log_text().split('"listening')[-1], f"{name}: not logged")
        put("second")
        time.sleep(3)
        case.expect(serves(target, "second"), "the second pair is not served")
        case.expect(target.metric("dcloc_tls_certificate_ok") == 1.0, "the metric says bad")


# ---- The metrics port

def silent_metrics_peers(case):
    """Peers of the metrics port that say nothing, say it slowly, or do not read."""
    with case.with_town() as target:
        host, port = target.metrics.split(":")
        for name, count in (("ten silent: ", 10), ("500 silent: ", 500)):
            with case.meanwhile(target, vehicles=False, name=name), contextlib.ExitStack() as stack:
                for _ in range(count):
                    with contextlib.suppress(OSError):
                        stack.enter_context(contextlib.closing(
                            socket.create_connection((host, int(port)), 2)))
                time.sleep(case.seconds)
        with case.meanwhile(target, vehicles=False, name="slow: "), contextlib.ExitStack() as stack:
            slow = [stack.enter_context(contextlib.closing(
                socket.create_connection((host, int(port)), 2))) for _ in range(50)]
            end = time.monotonic() + case.seconds
            while time.monotonic() < end:
                for connection in slow:
                    with contextlib.suppress(OSError):
                        connection.send(b"G")
                time.sleep(0.1)
        with case.meanwhile(target, vehicles=False, name="not reading: "), contextlib.ExitStack() as stack:
            for _ in range(20):
                connection = stack.enter_context(contextlib.closing(socket.socket()))
                connection.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 1024)
                connection.connect((host, int(port)))
                with contextlib.suppress(OSError):
                    connection.sendall(b"GET /metrics HTTP/1.1\r\n\r\n")
            time.sleep(case.seconds)


# ---- Messages that do not parse

def methods(api):
    """The paths of all RPCs."""
    for messages in (api.localization_service, api.map_service, api.admin_service):
        for service in messages.DESCRIPTOR.services_by_name.values():
            yield from (f"/{service.full_name}/{method.name}" for method in service.methods)


def unparsed_messages(case):
    """A message that is none, to each RPC: INVALID_ARGUMENT, and what is wrong."""
    with case.with_town() as target, target.channel() as channel:
        paths = list(methods(case.api))
        for path in paths:
            answers = channel.stream_stream(path)(
                iter([b"\xff\xff\xff"]), metadata=target.call_metadata(), timeout=5)
            code = code_of(lambda: list(answers))  # pylint: disable=cell-var-from-loop
            case.expect(code[0] == "INVALID_ARGUMENT" and "parse" in code[1], f"{path}: {code}")
        case.figures["RPCs"] = len(paths)
        case.figures["a second message"] = code = second_message(case, channel, target)
        case.expect(code[0] == "INVALID_ARGUMENT" and "parse" in code[1], f"Localize, later: {code}")


def second_message(case, channel, target):
    """How a session ends that is opened well and then sends what is no message."""
    opening = case.api.localization_service.LocalizeRequest()
    opening.open.vehicle_id = "car-9"
    opening.open.map_name = "town"
    radar = opening.open.rig.radars.add(radar_id="front")
    radar.t_vehicle_radar.translation_m.SetInParent()
    radar.t_vehicle_radar.rotation.w = 1.0
    call = channel.stream_stream(LOCALIZE)
    answers = call(iter([opening.SerializeToString(), b"\xff\xff\xff"]),
                   metadata=target.call_metadata(target.vehicle_token), timeout=5)
    return code_of(lambda: list(answers))


def log_flood(case):
    """Messages with text that is no UTF-8: the log stays small, and JSON."""
    with case.with_town() as target:
        # vehicle_id is field 1 of field 1.
        bad = b"\x0a\x04\x0a\x02\xff\xfe"
        end = time.monotonic() + case.seconds

        def flood():
            sent = 0
            with target.channel() as channel:
                call = channel.stream_stream(LOCALIZE)
                while time.monotonic() < end:
                    code_of(lambda: list(call(iter([bad]), timeout=5)))
                    sent += 1
            return sent

        with concurrent.futures.ThreadPoolExecutor(4) as pool:
            sent = sum(pool.map(lambda _: flood(), range(4)))
        time.sleep(1.5)
        lines = target.log_text().splitlines()
        case.figures["calls"], case.figures["lines"] = sent, len(lines)
        bad_lines = [line for line in lines if not is_json(line)]
        case.expect(not bad_lines, f"{len(bad_lines)} lines are no JSON: {bad_lines[:1]}")
        case.expect(len(lines) <= 300 * (case.seconds + 3), f"{len(lines)} lines")


def is_json(line):
    try:
        return isinstance(json.loads(line), dict)
    except ValueError:
        return False


# ---- Settings

def settings(case):
    """A configuration that is a folder, at the start and while the server runs."""
    folder = case.folder / "settings"
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir()
    started = subprocess.run([case.program, "--config", folder], text=True, timeout=20,
                             stdout=subprocess.PIPE, stderr=subprocess.PIPE, check=False)
    case.figures["start"] = [started.returncode, started.stderr.splitlines()[:1]]
    case.expect(started.returncode == 2, f"exit status {started.returncode}")
    path = folder / "server.json"
    path.write_text('{"max_session_count": 40}')
    with case.target("--config", path) as target:
        path.write_text('{"max_session_count": 70}')
        target.reload()
        time.sleep(1)
        case.expect(case.state(target).max_session_count == 70, "the state tells the old limit")
        path.unlink()
        path.mkdir()
        target.reload()
        time.sleep(1)
        case.expect(target.alive(), "the server is dead")
        case.expect("settings not taken" in target.log_text(), "nothing is logged")


# ---- Rapid reset

def rapid_reset(case):
    """Calls that are reset as soon as they begin, as fast as the server reads, on one connection at
    a time."""
    with case.with_town() as target:
        flood = subprocess.Popen([sys.executable, HERE / "reset_flood.py", target.address, LOCALIZE],
                                 text=True, stdin=subprocess.PIPE, stdout=subprocess.PIPE)
        with case.meanwhile(target):
            time.sleep(1)
            flood.stdin.write("go\n")
            flood.stdin.flush()
            time.sleep(case.seconds)
            out, _ = flood.communicate("stop\n", timeout=60)
            time.sleep(1)
        case.figures["resets"], case.figures["connections"] = map(int, out.split())


ATTACKS = [streams_without_open, a_stream_ends_without_open, many_streams, many_streams_known,
           many_connections, certificates, silent_metrics_peers, unparsed_messages,
           log_flood, settings, rapid_reset]
