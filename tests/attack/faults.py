"""What befalls a machine, made on purpose: its clock, its descriptors, its processor, its memory.

What the server had acknowledged is looked for afterwards, and vehicles must be well again within 5 s.
"""

import concurrent.futures
import contextlib
import hashlib
import pathlib
import resource
import signal
import time

import grpc

from target import ReadyWatch, Vehicles

MAX_RECOVERY_S = 5.0
FAKETIME = pathlib.Path("/usr/lib/x86_64-linux-gnu/faketime/libfaketimeMT.so.1")


class Ledger:
    """The maps that a server has acknowledged, and what became of other attempts."""

    def __init__(self, case):
        self.case = case
        self.versions = {}  # by name: the newest that was acknowledged
        self.refused = {}   # status code: how often
        self.sha256 = hashlib.sha256(case.town.read_bytes()).hexdigest()

    def upload(self, target, name):
        try:
            self.versions[name] = self.case.upload(target, name)
        except grpc.RpcError as error:
            code = error.code().name
            self.refused[code] = self.refused.get(code, 0) + 1

    def check(self, target):
        """Each acknowledged map is active, and its bytes are those that were sent."""
        messages = self.case.api.map_service
        with target.channel() as channel:
            maps = self.case.api.map_service_grpc.MapServiceStub(channel)
            for name, version in self.versions.items():
                metadata = target.call_metadata()
                try:
                    active = maps.GetMap(messages.GetMapRequest(map_name=name), metadata=metadata,
                                         timeout=10).map.active_version
                    digest = hashlib.sha256()
                    for part in maps.DownloadMap(messages.DownloadMapRequest(map_name=name),
                                                 metadata=metadata, timeout=10):
                        digest.update(part.chunk.data)
                except grpc.RpcError as error:
                    self.case.expect(False, f"map {name}: {error.code().name} {error.details()}")
                    continue
                # One that was not acknowledged may have been stored all the same.
                self.case.expect(active >= version, f"map {name}: version {active}, not {version}")
                self.case.expect(digest.hexdigest() == self.sha256, f"map {name}: other bytes")
        self.case.figures["acknowledged"] = len(self.versions)
        self.case.figures["refused"] = self.refused


def recovery_s(case, target):
    """How long until a vehicle drives, a map is uploaded and /ready says yes."""
    begin = time.monotonic()
    while time.monotonic() < begin + 4 * MAX_RECOVERY_S:
        with contextlib.suppress(OSError, grpc.RpcError):
            if target.get("/ready", timeout_s=2)[0] == 200:
                case.upload(target)
                break
        time.sleep(0.1)
    seconds = time.monotonic() - begin
    case.figures["recovered after [s]"] = round(seconds, 1)
    case.expect(seconds <= MAX_RECOVERY_S, f"it took {seconds:.1f} s to be well again")
    drive_well(case, target, "afterwards: ")


def drive_well(case, target, name):
    """Vehicles on new connections are answered, and none is refused."""
    vehicles = Vehicles(target, case.stubs)
    time.sleep(1.5)
    case.figures[f"{name}vehicles"] = seen = vehicles.result()
    case.expect(seen["answers"] >= 10, f"{name}{seen['answers']} answers")
    case.expect(not seen["refused"], f"{name}refused: {seen['refused'][:2]}")


@contextlib.contextmanager
def sessions_that_last(case, target):
    """Vehicles whose sessions and connections last throughout: none may be ended."""
    vehicles = Vehicles(target, case.stubs, session_s=600)
    time.sleep(1.0)  # until they are connected
    try:
        yield
    finally:
        case.figures["vehicles"] = seen = vehicles.result()
    case.expect(target.alive(), "the server is dead")
    case.expect(not seen["refused"], f"sessions were ended: {seen['refused'][:2]}")
    case.expect(seen["answers"] > 10 * case.seconds, f"only {seen['answers']} answers")


def create_time(case, target, name):
    """When a map was made, by the server's clock [s]."""
    with target.channel() as channel:
        maps = case.api.map_service_grpc.MapServiceStub(channel)
        versions = maps.ListMapVersions(
            case.api.map_service.ListMapVersionsRequest(map_name=name),
            metadata=target.call_metadata(), timeout=10).versions
    return max(version.create_time.seconds for version in versions)


def clock_jumps(case):
    """The host's clock goes an hour ahead, two hours back, and right again."""
    if not FAKETIME.exists():
        raise FileNotFoundError(f"{FAKETIME} is missing: install libfaketime")
    clock = case.folder / "clock"
    clock.write_text("+0s")
    environment = {"LD_PRELOAD": str(FAKETIME), "FAKETIME_TIMESTAMP_FILE": str(clock),
                   "FAKETIME_DONT_FAKE_MONOTONIC": "1", "FAKETIME_NO_CACHE": "1"}
    ledger = Ledger(case)
    with case.with_town(environment=environment) as target:
        watch = ReadyWatch(target)
        with sessions_that_last(case, target):
            for jump in ("+0s", "+3600s", "-3600s", "+0s"):
                clock.write_text(jump)
                time.sleep(case.seconds)
                name = f"town{jump}".replace("+", "-plus-")
                ledger.upload(target, name)
                lead_s = create_time(case, target, name) - time.time()
                case.expect(abs(lead_s - float(jump[:-1])) < 60, f"{jump} was not its clock")
        case.figures["ready"] = ready = watch.result()
        case.expect(ready["failed"] == 0, f"/ready failed {ready['failed']} times")
        case.expect(not ledger.refused, f"uploads were refused: {ledger.refused}")
        ledger.check(target)
        recovery_s(case, target)


def descriptors_gone(case):
    """No descriptor is left: who is connected goes on, what is new is refused, then all is well."""
    ledger = Ledger(case)
    with case.with_town() as target:
        ledger.upload(target, "before")
        with sessions_that_last(case, target):
            pid = target.process.pid
            limits = resource.prlimit(pid, resource.RLIMIT_NOFILE)
            taken = len(list(pathlib.Path(f"/proc/{pid}/fd").iterdir()))
            for spare in (0, 2, 5):
                resource.prlimit(pid, resource.RLIMIT_NOFILE, (taken + spare, limits[1]))
                ledger.upload(target, f"without-{spare}")
                time.sleep(case.seconds / 3)
            resource.prlimit(pid, resource.RLIMIT_NOFILE, limits)
            recovery_s(case, target)
        ledger.check(target)


def processor_taken(case):
    """The process stands still for seconds, three times; its sessions go on."""
    ledger = Ledger(case)
    with case.with_town() as target:
        ledger.upload(target, "before")
        with sessions_that_last(case, target):
            for _ in range(3):
                target.process.send_signal(signal.SIGSTOP)
                time.sleep(case.seconds)
                target.process.send_signal(signal.SIGCONT)
                time.sleep(case.seconds / 2)
        ledger.check(target)
        recovery_s(case, target)


def send_large_messages(case, target, seconds):
    """Messages of almost the size that is let in, from many callers at once, of maps that are none."""
    messages = case.api.map_service
    part = messages.UploadMapRequest(chunk=messages.MapChunk(data=case.random.randbytes(1_900_000)))
    end = time.monotonic() + seconds

    def send(number):
        header = messages.UploadMapRequest()
        header.header.map_name = f"junk-{number}"
        header.header.size_bytes = len(part.chunk.data)
        header.header.sha256 = hashlib.sha256(part.chunk.data).hexdigest()
        while time.monotonic() < end and target.alive():
            with contextlib.suppress(grpc.RpcError), target.channel() as channel:
                case.api.map_service_grpc.MapServiceStub(channel).UploadMap(
                    iter([header, part]), metadata=target.call_metadata(), timeout=5)

    with concurrent.futures.ThreadPoolExecutor(16) as pool:
        list(pool.map(send, range(16)))


def answers(case, target):
    """Whether it does, within 5 s."""
    end = time.monotonic() + MAX_RECOVERY_S
    while target.alive() and time.monotonic() < end:
        with contextlib.suppress(grpc.RpcError):
            case.state(target, timeout_s=2)
            return True
    return False


def memory_gone(case):
    """The address space is full while maps and large messages come. The server lives, as gRPC has a
    reserve; if not, a supervisor can see it, and what was acknowledged is there after a restart."""
    ledger = Ledger(case)
    with case.with_town() as target:
        ledger.upload(target, "before")
        outcomes = []
        for spare_mib in (16, 4, 0):
            pid = target.process.pid
            pages = int(pathlib.Path(f"/proc/{pid}/statm").read_text(encoding="ascii").split()[0])
            limits = resource.prlimit(pid, resource.RLIMIT_AS)
            resource.prlimit(pid, resource.RLIMIT_AS,
                             (pages * resource.getpagesize() + (spare_mib << 20), limits[1]))
            with concurrent.futures.ThreadPoolExecutor(1) as pool:
                flood = pool.submit(send_large_messages, case, target, case.seconds)
                for i in range(4):
                    ledger.upload(target, f"with-{spare_mib}-{i}")
                flood.result()
            if target.alive():
                resource.prlimit(pid, resource.RLIMIT_AS, limits)
            outcome = "lived" if answers(case, target) else "hung" if target.alive() else "died"
            outcomes.append(outcome)
            case.expect(outcome == "lived", f"with {spare_mib} MiB left it {outcome}")
            if outcome == "hung":  # gRPC does not notice that it could not start a thread
                case.expect(target.get("/ready")[0] != 200, "it does not answer, and says ready")
            if outcome != "lived":
                target.restart()
            ledger.check(target)
        case.figures["outcomes"] = outcomes
        recovery_s(case, target)


FAULTS = [clock_jumps, descriptors_gone, processor_taken, memory_gone]
