"""What an attack is given, and what it finds."""

import contextlib
import subprocess

from target import ReadyWatch, Target, Vehicles

MAX_MS = 100.0  # of /ready and of vehicles, while an attack runs


class Case:
    """What an attack needs: where things are, how long it may take, and what it found."""

    def __init__(self, dcloc, program, folder, stubs, api, town, random, seconds):
        self.dcloc, self.program, self.folder = dcloc, program, folder
        self.stubs, self.api = stubs, api
        self.town, self.random, self.seconds = town, random, seconds
        self.figures = {}
        self.faults = []

    def target(self, *flags, **options):
        return Target(self.program, self.folder, self.town, *flags, **options)

    def with_town(self, *flags, **options):
        """A target that has the map."""
        target = self.target(*flags, **options)
        self.upload(target)
        return target

    def upload(self, target, map_name="town"):
        messages = self.api.map_service
        bytes_ = self.town.read_bytes()

        def requests():
            request = messages.UploadMapRequest()
            request.header.map_name = map_name
            request.header.size_bytes = len(bytes_)
            request.header.sha256 = subprocess.run(
                ["sha256sum", self.town], check=True, text=True,
                stdout=subprocess.PIPE).stdout.split()[0]
            request.header.activate = True
            yield request
            for offset in range(0, len(bytes_), 1 << 20):
                yield messages.UploadMapRequest(chunk=messages.MapChunk(
                    offset_bytes=offset, data=bytes_[offset:offset + (1 << 20)]))

        with target.channel() as channel:
            return self.api.map_service_grpc.MapServiceStub(channel).UploadMap(
                requests(), metadata=target.call_metadata()).version.version

    def state(self, target, timeout_s=10):
        with target.channel() as channel:
            return self.api.admin_service_grpc.AdminServiceStub(channel).GetServerState(
                self.api.admin_service.GetServerStateRequest(), metadata=target.call_metadata(),
                timeout=timeout_s)

    def expect(self, holds, fault):
        if not holds:
            self.faults.append(fault)

    @contextlib.contextmanager
    def meanwhile(self, target, vehicles=True, name=""):
        """Vehicles drive and /ready is asked while the body runs; both must stay well."""
        watch = ReadyWatch(target)
        driving = Vehicles(target, self.stubs) if vehicles else None
        try:
            yield
        finally:
            ready = watch.result()
            self.figures[f"{name}ready"] = ready
            if driving:
                self.figures[f"{name}vehicles"] = seen = driving.result()
        self.expect(target.alive(), "the server is dead")
        self.expect(ready["worst_ms"] <= MAX_MS, f"/ready took {ready['worst_ms']} ms")
        self.expect(ready["failed"] == 0, f"/ready failed {ready['failed']} times")
        if driving:
            self.expect(seen["p99_ms"] <= MAX_MS, f"vehicles' p99 was {seen['p99_ms']} ms")
            self.expect(not seen["refused"], f"vehicles were refused: {seen['refused'][:3]}")
