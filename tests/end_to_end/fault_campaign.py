"""Makes each call of a server to its store fail in turn, and checks what is left.

For each function (open, write, fsync, ...), each error (EIO, ENOSPC, EINTR, half of the bytes) and
each N, the Nth such call fails once: while a map is uploaded and activated, while one is deleted,
and while the server starts. Then must hold:

- what was acknowledged is there, after a kill too;
- what was not is whole or absent, and the same call succeeds once it is made again;
- the server goes on, or ends without a signal, and starts again within five seconds;
- `dcloc-server store check` finds the store whole.
"""

import argparse
import errno
import itertools
import mmap
import os
import pathlib
import random
import shutil
import struct
import subprocess
import sys
import tempfile
import time

from processes import Programs

FUNCTIONS = ["open", "read", "write", "sync", "rename", "truncate", "map", "remove", "mkdir"]
ERRORS = {"EIO": errno.EIO, "ENOSPC": errno.ENOSPC, "EINTR": errno.EINTR, "short": 0}
CAN_BE_SHORT = {"read", "write"}
CAN_BE_INTERRUPTED = {"open", "read", "write", "sync"}
START_LIMIT_S = 5.0
MAX_CALLS = 400
# Reads that fail while coverage is added: SQLite's R*Trees kept an entry of what was rolled back.
ALWAYS = [("read", nth, "ENOSPC") for nth in range(12, 20)]


class Fault:
    """The memory that is shared with the shim (`fault_shim.cpp`)."""

    def __init__(self, path):
        path.write_bytes(bytes(16))
        self.path = path
        self.file = open(path, "r+b")
        self.memory = mmap.mmap(self.file.fileno(), 16)

    def arm(self, function, nth, error):
        self.memory[0:16] = struct.pack("4i", 0, nth, ERRORS[error], 0)
        self.memory[0:4] = struct.pack("i", FUNCTIONS.index(function) + 1)

    def disarm(self):
        """Whether the call came."""
        self.memory[0:4] = struct.pack("i", 0)
        return struct.unpack("4i", self.memory[0:16])[3] > 0


def with_faults(shim, fault, folder):
    """The environment of a program whose calls to files of `folder` can fail."""
    return {**os.environ, "LD_PRELOAD": shim, "DCLOC_FAULT_CONTROL": str(fault.path),
            "DCLOC_FAULT_FOLDER": str(folder)}


class Server:
    """A server with the shim; `address` is None if it did not start."""

    def __init__(self, programs, shim, fault, store, log):
        begin = time.monotonic()
        environment = with_faults(shim, fault, store)
        self.process = subprocess.Popen(
            [programs.server, "--data", str(store), "--listen", "127.0.0.1:0", "--scrub-mb-per-s",
             "0"], env=environment, text=True, stdout=subprocess.PIPE, stderr=open(log, "a"))
        line = self.process.stdout.readline()
        self.address = line.split()[-1] if line.startswith("listening on ") else None
        self.start_s = time.monotonic() - begin

    def alive(self):
        return self.process.poll() is None

    def kill(self):
        self.process.kill()
        return self.process.wait()


class Campaign:
    def __init__(self, arguments, folder):
        self.programs = Programs(arguments.dcloc, arguments.server)
        self.shim = arguments.shim
        self.folder = folder
        self.log = folder / "log"
        self.fault = Fault(folder / "fault")
        self.old = self.make_map("old")
        self.new = self.make_map("new")
        self.seed = folder / "seed"
        self.store = folder / "store"
        self.case_count = 0
        self.came_count = 0
        self.refused_count = 0
        self.problems = []
        self.situations = arguments.only.split(",")
        server = self.start(self.seed)
        self.upload(server, "town", self.old)
        self.upload(server, "city", self.new)
        self.call(server, "delete", "--map", "city", "--all-versions")
        self.upload(server, "doomed", self.make_map("doomed"))
        server.process.terminate()
        server.process.wait()
        self.backup = folder / "backup"
        self.tool(None, "backup", "--data", self.seed, "--to", self.backup)

    def tool(self, folder, *arguments):
        """Whether a command of the store says that all went well; calls to `folder` may fail."""
        environment = with_faults(self.shim, self.fault, folder) if folder else None
        with open(self.log, "a") as log:
            return subprocess.run([self.programs.server, "store", *arguments], env=environment,
                                  stdout=log, stderr=log).returncode == 0

    def make_map(self, name):
        root = self.folder / "drives"
        if not root.exists():
            self.programs.succeed("simulate", "--out", root, "--radar", "carla", "--seed", "3")
        path = self.folder / f"{name}.dclm"
        self.programs.succeed("map", "build", "--dataset", "nuscenes", "--root", root, "--drive",
                              "map", "--name", name, "--out", path)
        return path

    def start(self, store=None):
        return Server(self.programs, self.shim, self.fault, store or self.store, self.log)

    def call(self, server, command, *arguments):
        return self.programs.run("map", command, "--server", server.address, *arguments)

    def upload(self, server, name, path):
        return self.call(server, "upload", "--map", name, "--activate", path)

    def delete(self, server):
        return self.call(server, "delete", "--map", "doomed", "--all-versions")

    def has(self, server, name, path):
        """Whether a map is there, and is this file; None if it is not there."""
        copy = self.folder / "copy"
        result = self.call(server, "download", "--map", name, "--out", copy)
        if result.returncode != 0:
            return None if "no such map" in result.stderr or "no active" in result.stderr else False
        return copy.read_bytes() == path.read_bytes()

    def expect(self, truth, what):
        if not truth:
            self.problems.append(f"{self.case}: {what}")

    # One fault in one situation; each says whether the call came.

    def while_uploading(self, function, nth, error):
        server = self.start()
        self.fault.arm(function, nth, error)
        acknowledged = self.upload(server, "fresh", self.new).returncode == 0
        came = self.fault.disarm()
        self.refused_count += not acknowledged
        self.expect(server.alive(), "the server ended")
        if server.alive():
            self.expect(self.has(server, "town", self.old), "the old map is lost at once")
            self.expect(not acknowledged or self.has(server, "fresh", self.new), "not what was acknowledged")
        if acknowledged or nth % 2 == 0:
            server.kill()
            self.after_restart("fresh", acknowledged)
        else:
            self.expect(self.upload(server, "fresh", self.new).returncode == 0, "not taken again")
            server.kill()
            self.after_restart("fresh", True)
        return came

    def while_deleting(self, function, nth, error):
        server = self.start()
        self.fault.arm(function, nth, error)
        acknowledged = self.delete(server).returncode == 0
        came = self.fault.disarm()
        self.refused_count += not acknowledged
        self.expect(server.alive(), "the server ended")
        server.kill()
        server = self.restart()
        if server is None:
            return came
        there = self.has(server, "doomed", self.folder / "doomed.dclm")
        self.expect(there is None if acknowledged else there is not False, "deleted by half")
        self.check_and_kill(server)
        return came

    def while_starting(self, function, nth, error):
        self.fault.arm(function, nth, error)
        server = self.start()
        came = self.fault.disarm()
        self.refused_count += server.address is None
        if server.address is None:
            self.expect(server.process.wait() == 1, f"it ended with {server.process.returncode}")
        else:
            server.kill()
        self.check_after_restart()
        return came

    def while_backing_up(self, function, nth, error):
        backup = self.folder / "another"
        shutil.rmtree(backup, ignore_errors=True)
        arguments = ["backup", "--data", self.store, "--to", backup]
        self.fault.arm(function, nth, error)
        done = self.tool(backup, *arguments)
        came = self.fault.disarm()
        self.refused_count += not done
        self.expect(done or self.tool(None, *arguments), "not backed up when it is tried again")
        shutil.rmtree(self.store)
        self.expect(self.tool(None, "restore", "--data", self.store, "--from", backup),
                    "what was called a backup is none")
        self.check_after_restart()
        return came

    def while_restoring(self, function, nth, error):
        (self.store / "catalogue.sqlite").write_bytes(b"")
        arguments = ["restore", "--data", self.store, "--from", self.backup]
        self.fault.arm(function, nth, error)
        done = self.tool(self.store, *arguments)
        came = self.fault.disarm()
        self.refused_count += not done
        self.expect(done or self.tool(None, *arguments), "not restored when it is tried again")
        logged = self.log.stat().st_size
        server = self.start()
        # A catalogue that could not be read may have been one with identities: then nobody is let in
        # before there are some.
        if server.address is None and "has seen identities" in self.log.read_text()[logged:]:
            self.expect(function in ("read", "open", "map"), "identities were asked for")
            return came
        server.kill()
        self.check_after_restart()
        return came

    def check_after_restart(self):
        server = self.restart()
        if server is not None:
            self.check_and_kill(server)

    def restart(self):
        server = self.start()
        self.expect(server.address is not None, "it does not start again")
        self.expect(server.start_s < START_LIMIT_S, f"it took {server.start_s:.1f} s to start")
        return server if server.address else None

    def after_restart(self, name, acknowledged):
        server = self.restart()
        if server is None:
            return
        there = self.has(server, name, self.new)
        self.expect(there if acknowledged else there is not False, f"{name} is {there}")
        if not acknowledged:
            self.expect(self.upload(server, name, self.new).returncode == 0, "not taken any more")
        self.check_and_kill(server)

    def check_and_kill(self, server):
        self.expect(self.has(server, "town", self.old), "the old map is lost")
        server.kill()
        check = subprocess.run([self.programs.server, "store", "check", "--data", str(self.store)],
                               text=True, capture_output=True)
        self.expect(check.returncode == 0, f"not whole: {check.stdout}{check.stderr}")

    def run_case(self, situation, function, nth, error):
        self.case = f"{situation.__name__}: {error} of {function} {nth}"
        self.case_count += 1
        shutil.rmtree(self.store, ignore_errors=True)
        shutil.copytree(self.seed, self.store)
        came = situation(function, nth, error)
        self.came_count += came
        return came

    def run(self, chance, random_numbers):
        if "uploading" in self.situations:
            for function, nth, error in ALWAYS:
                self.run_case(self.while_uploading, function, nth, error)
        situations = [getattr(self, f"while_{name}") for name in self.situations]
        for situation, function, error in itertools.product(situations, FUNCTIONS, ERRORS):
            if error == "short" and function not in CAN_BE_SHORT:
                continue
            if error == "EINTR" and function not in CAN_BE_INTERRUPTED:
                continue
            for nth in range(1, MAX_CALLS):
                if random_numbers.random() > chance:
                    if nth > 60:
                        break
                    continue
                if not self.run_case(situation, function, nth, error):
                    break


def main():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("dcloc")
    parser.add_argument("server")
    parser.add_argument("shim")
    parser.add_argument("--chance", type=float, default=0.02,
                        help="of each fault to be tried; 1 for all, which takes an hour")
    parser.add_argument("--only", default="uploading,deleting,starting,backing_up,restoring",
                        help="situations, with commas")
    parser.add_argument("--seed", type=int, default=1)
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory(prefix="dcloc-fault-") as folder:
        campaign = Campaign(arguments, pathlib.Path(folder).resolve())
        campaign.run(arguments.chance, random.Random(arguments.seed))
        print(f"{campaign.came_count} faults came, {campaign.refused_count} of them made the call or "
              f"the start fail; {len(campaign.problems)} problems")
        for problem in campaign.problems:
            print(problem)
        return 1 if campaign.problems else 0


if __name__ == "__main__":
    sys.exit(main())
