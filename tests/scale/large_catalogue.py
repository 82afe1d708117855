#!/usr/bin/env python3
"""What each call takes where the catalogue is large: 10,000 tenants, 1,000,000 versions, 100,000 holds.

Usage: large_catalogue.py DCLOC DCLOC_SERVER [--tenants N] [--maps N] [--holders N] [--calls N]
Starts a PostgreSQL and a server of its own, fills the tables by SQL (fill.sql), and calls the server
from one client, one call after the other. Prints p50, p99, and statements of each call. Needs Debian's
python3-grpcio, postgresql-15 and postgresql-15-postgis-3; 77 where they are not there.
"""

import argparse
import hashlib
import pathlib
import random
import sys
import tempfile
import time

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
sys.path[:0] = [str(ROOT / "deploy"), str(ROOT / "tests/attack")]

try:
    import grpc
    from target import Api, make_stubs
except ImportError as error:
    print(f"large_catalogue: {error}", file=sys.stderr)
    sys.exit(77)

from rehearsal.engines import Database, SharedFolder, missing_packages  # noqa: E402
from rehearsal.programs import LOOPBACK, Program, free_port, run, wait_until  # noqa: E402
from rehearsal.site import http  # noqa: E402

VERSION_COUNT = 10
TENANTS_THAT_CALL = 20


class Server:
    """One server on the large database."""

    def __init__(self, program, folder, database, files):
        port, metrics_port = free_port(), free_port()
        begin = time.monotonic()
        self.program = Program("dcloc-server", [
            program, "--catalogue", database.address, *files.flags, "--data", folder / "data",
            "--listen", f"{LOOPBACK}:{port}", "--metrics-listen", f"{LOOPBACK}:{metrics_port}",
            "--scrub-mb-per-s", 0, "--database-timeout-ms", 60000], folder / "server.log")
        wait_until(lambda: not self.program.alive() or http(metrics_port, "/ready")[0] == 200, 600,
                   "the server")
        if not self.program.alive():
            raise SystemExit(f"the server did not start: {self.program.text()}")
        self.start_s = time.monotonic() - begin
        self.address = f"{LOOPBACK}:{port}"


def make_seed(arguments, folder, database, files):
    """The map "seed" of tenant t1 with versions that differ; the files of the maps."""
    drives = folder / "drives"
    run(arguments.dcloc, "simulate", "--out", drives, "--length-m", 100, timeout_s=600)
    token = make_token(arguments, folder, database, 1)
    server = Server(arguments.server, folder, database, files)
    maps = []
    for i in range(VERSION_COUNT + 1):
        maps.append(folder / f"{i}.dclm")
        run(arguments.dcloc, "map", "build", "--dataset", "nuscenes", "--root", drives, "--drive",
            "map", "--to-s", f"{2 + 0.2 * i:.1f}", "--out", maps[-1])
        if i < VERSION_COUNT:
            run(arguments.dcloc, "map", "upload", "--server", server.address, "--token-file", token,
                "--map", "seed", "--activate", maps[-1])
    server.program.end()
    return maps[-1]


def make_token(arguments, folder, database, tenant):
    path = folder / f"{tenant}.token"
    path.touch(mode=0o600)
    path.write_text(run(arguments.server, "token", "create", "--catalogue", database.address,
                        "--name", f"operator-{tenant}", "--role", "operator", "--tenant",
                        f"t{tenant}").stdout)
    return path


class Caller:
    """Calls of the operators of some tenants, each on a map that nobody has asked for before."""

    def __init__(self, api, address, tokens, map_count, new_map):
        self.api, self.new_map = api, new_map.read_bytes()
        self.channel = grpc.insecure_channel(address)
        self.maps = api.map_service_grpc.MapServiceStub(self.channel)
        self.sessions = api.localization_service_grpc.LocalizationServiceStub(self.channel)
        self.places = [([("authorization", f"Bearer {token}")], f"map-{m + 1}")
                       for token in tokens for m in range(map_count)]
        random.Random(1).shuffle(self.places)

    def calls(self):
        """{name of a call: function of (metadata, map name)}"""
        message = self.api.map_service
        position = message.FindCoverageRequest(radius_m=100.0)
        position.position.latitude_deg, position.position.longitude_deg = 50.0, 8.0
        return {
            "ListMaps": lambda who, name: self.maps.ListMaps(
                message.ListMapsRequest(), metadata=who),
            "GetMap": lambda who, name: self.maps.GetMap(
                message.GetMapRequest(map_name=name), metadata=who),
            "ListMapVersions": lambda who, name: self.maps.ListMapVersions(
                message.ListMapVersionsRequest(map_name=name), metadata=who),
            "FindCoverage": lambda who, name: self.maps.FindCoverage(position, metadata=who),
            "Localize, opened": self.open_session,
            "ActivateMapVersion": lambda who, name: self.maps.ActivateMapVersion(
                message.ActivateMapVersionRequest(map_name=name, version=3), metadata=who),
            "UploadMap": self.upload,
            "DeleteMapVersion": lambda who, name: self.maps.DeleteMapVersion(
                message.DeleteMapVersionRequest(map_name=name, version=1), metadata=who)}

    def open_session(self, who, name):
        request = self.api.localization_service.LocalizeRequest()
        request.open.vehicle_id, request.open.map_name = "car", name
        radar = request.open.rig.radars.add(radar_id="front")
        radar.t_vehicle_radar.translation_m.SetInParent()
        radar.t_vehicle_radar.rotation.w = 1.0
        for _ in self.sessions.Localize(iter([request]), metadata=who):
            pass

    def upload(self, who, name):
        header = self.api.map_service.UploadMapRequest()
        header.header.map_name, header.header.size_bytes = name, len(self.new_map)
        header.header.sha256 = hashlib.sha256(self.new_map).hexdigest()
        chunk = self.api.map_service.UploadMapRequest()
        chunk.chunk.data = self.new_map
        self.maps.UploadMap(iter([header, chunk]), metadata=who)


def measure(caller, database, count):
    """Prints a line for each call."""
    print(f"{'call':20} {'p50 [ms]':>9} {'p99 [ms]':>9} {'worst [ms]':>10} {'statements':>10}")
    for name, call in caller.calls().items():
        before = database.statement_count()
        times_ms = []
        for who, map_name in caller.places[:count]:
            begin = time.monotonic()
            call(who, map_name)
            times_ms.append(1e3 * (time.monotonic() - begin))
        times_ms.sort()
        statements = (database.statement_count() - before) / len(times_ms)
        print(f"{name:20} {times_ms[len(times_ms) // 2]:9.1f} "
              f"{times_ms[int(0.99 * (len(times_ms) - 1))]:9.1f} {times_ms[-1]:10.1f} "
              f"{statements:10.1f}", flush=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("dcloc", type=pathlib.Path)
    parser.add_argument("server", type=pathlib.Path)
    parser.add_argument("--tenants", type=int, default=10_000)
    parser.add_argument("--maps", type=int, default=10, help="of a tenant, ten versions each")
    parser.add_argument("--holders", type=int, default=100, help="with 1,000 holds each")
    parser.add_argument("--calls", type=int, default=200, help="of each kind, at most")
    arguments = parser.parse_args()
    if "postgresql-15" in missing_packages("folder"):
        print("large_catalogue: postgresql-15 is not installed", file=sys.stderr)
        return 77
    programs = []
    with tempfile.TemporaryDirectory(prefix="dcloc-scale-") as name:
        folder = pathlib.Path(name)
        folder.chmod(0o711)
        database, files = Database(folder / "database"), SharedFolder(folder / "files")
        programs.append(database.program)
        try:
            new_map = make_seed(arguments, folder, database, files)
            begin = time.monotonic()
            print(database.run_file(ROOT / "tests/scale/fill.sql", tenants=arguments.tenants,
                                    maps=arguments.maps, holders=arguments.holders))
            print(f"filled in {time.monotonic() - begin:.0f} s")
            callers = range(1, min(TENANTS_THAT_CALL, arguments.tenants) + 1)
            tokens = [make_token(arguments, folder, database, tenant).read_text().split()[0]
                      for tenant in callers]
            server = Server(arguments.server, folder, database, files)
            programs.insert(0, server.program)
            print(f"the server is ready after {server.start_s:.1f} s, "
                  f"{server.program.memory_mib():.0f} MiB")
            make_stubs(folder)
            caller = Caller(Api(folder), server.address, tokens, arguments.maps, new_map)
            measure(caller, database, arguments.calls)
            print(f"the server has {server.program.memory_mib():.0f} MiB")
        finally:
            for program in programs:
                program.end()
    return 0


if __name__ == "__main__":
    sys.exit(main())
