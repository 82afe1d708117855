"""Calls that anybody may begin and that send no request, or ask and never go."""

import contextlib
import re
import time

import grpc

import frames
from attacks import code_of
from download_attacks import NO_WINDOW

OPEN_TIMEOUT_S = 2
# (what, its method, whether a token comes with it, the message that is sent)
KINDS = [("maps", "/dcloc.v1.MapService/ListMaps", True, None),
         ("health", "/grpc.health.v1.Health/Check", False, None),
         ("health watched", "/grpc.health.v1.Health/Watch", False, frames.message(b"")),
         ("reflection", "/grpc.reflection.v1alpha.ServerReflection/ServerReflectionInfo", False, None)]


def process_state(target):
    """Its memory [MiB] and its threads."""
    with open(f"/proc/{target.process.pid}/status", encoding="utf-8") as status:
        text = status.read()
    memory, threads = (int(re.search(rf"^{name}:\s+(\d+)", text, re.MULTILINE).group(1))
                       for name in ("VmRSS", "Threads"))
    return round(memory / 1024), threads


def begin_calls(connections, block, message, count):
    """`count` calls on each connection, some at a time as a server reads them."""
    for i in range(count):
        for connection in connections:
            stream = 1 + 2 * i
            sent = frames.frame(frames.HEADERS, frames.END_HEADERS, stream, block)
            if message is not None:
                sent += frames.frame(frames.DATA, 0, stream, message)
            with contextlib.suppress(OSError):
                connection.sendall(sent)
        if i % 100 == 99:
            time.sleep(0.1)


def calls_without_request(case):
    """Per kind 2,000 calls over two connections that send headers and no request, or a question
    that has no end: few are held, for a limited time, and without threads of their own."""
    for name, method, token, message in KINDS:
        flags = ["--open-timeout-ms", OPEN_TIMEOUT_S * 1000]
        with case.with_town(*flags) as target, contextlib.ExitStack() as stack:
            before = process_state(target)
            connections = [stack.enter_context(contextlib.closing(frames.connect(target.address)))
                           for _ in range(2)]
            block = frames.call_headers(method, target.vehicle_token if token else None)
            with case.meanwhile(target, name=f"{name}: "):
                begin_calls(connections, block, message, 1000)
                during = process_state(target)
                time.sleep(OPEN_TIMEOUT_S + 2)
                after = process_state(target)
            held = {metric: target.metric(f"dcloc_{metric}")
                    for metric in ("awaited_requests", "health_watchers")}
            case.figures[f"{name}: MiB, threads"] = [before, during, after]
            case.figures[f"{name}: held"] = held
            case.expect(during[1] <= before[1] + 20, f"{name}: {during[1]} threads")
            case.expect(during[0] <= before[0] + 40, f"{name}: {during[0]} MiB")
            case.expect(held["awaited_requests"] == 0, f"{name}: {held} after their time")
            case.expect(held["health_watchers"] is not None and held["health_watchers"] <= 200,
                        f"{name}: {held}")


def unread_answers(case):
    """2,000 questions over two connections whose answers are not read: each is let go in time."""
    with case.with_town("--peer-timeout-ms", 5000) as target, contextlib.ExitStack() as stack:
        connections = [stack.enter_context(contextlib.closing(frames.connect(target.address)))
                       for _ in range(2)]
        for connection in connections:
            connection.sendall(NO_WINDOW)
        block = frames.call_headers("/dcloc.v1.AdminService/GetServerState", target.token)
        with case.meanwhile(target):
            begin_calls(connections, block, frames.message(b""), 1000)
            time.sleep(8)
        case.figures["not read"] = target.metric("dcloc_calls_ended_total")
        case.expect(case.figures["not read"] >= 2000, f"{case.figures['not read']} were let go")


def made_up_tokens(case):
    """Calls with tokens that nobody has, which the gate lets through, as fast as they are taken."""
    with case.with_town() as target, target.channel() as channel:
        maps = case.api.map_service_grpc.MapServiceStub(channel)
        request = case.api.map_service.ListMapsRequest()
        calls, codes = 0, set()
        with case.meanwhile(target):
            end = time.monotonic() + case.seconds
            while time.monotonic() < end:
                token = "dcloc_" + case.random.randbytes(32).hex()
                codes.add(code_of(lambda: maps.ListMaps(  # pylint: disable=cell-var-from-loop
                    request, metadata=[("authorization", f"Bearer {token}")], timeout=5))[0])
                calls += 1
        case.figures["calls"] = calls
        case.expect(codes == {"UNAUTHENTICATED"}, f"they ended with {codes}")


def packed_messages(case):
    """Messages of 400 kB that unpack to 400 MiB, of peers without a token and with one."""
    large = bytes(400 << 20)
    with case.with_town() as target, target.channel(("grpc.max_send_message_length", -1)) as channel:
        before, codes = target.peak_mib(), set()
        with case.meanwhile(target):
            for kind in (grpc.Compression.Gzip, grpc.Compression.Deflate):
                for method, metadata in (("/grpc.health.v1.Health/Check", []),
                                         ("/dcloc.v1.LocalizationService/Localize",
                                          target.call_metadata(target.vehicle_token))):
                    call = channel.stream_stream(method)
                    codes.add(code_of(lambda: list(call(  # pylint: disable=cell-var-from-loop
                        iter([large]), metadata=metadata, compression=kind, timeout=20)))[0])
        case.figures["MiB more"] = round(target.peak_mib() - before)
        case.expect(case.figures["MiB more"] <= 40, f"it took {case.figures['MiB more']} MiB")
        case.expect(codes == {"UNIMPLEMENTED"}, f"they ended with {codes}")


REQUEST_ATTACKS = [calls_without_request, unread_answers, made_up_tokens, packed_messages]
