"""dcloc and dcloc-server as processes of their own."""

import csv
import json
import pathlib
import signal
import subprocess
import time

COVARIANCE = [f"c{row}{column}" for row in range(6) for column in range(6)]
COLUMNS = ["stamp_ns", "radar", "state", "x", "y", "z", "qx", "qy", "qz", "qw", *COVARIANCE,
           "latency_ms", "map_version"]


class Programs:
    """Where the programs are."""

    def __init__(self, dcloc, server):
        self.dcloc = dcloc
        self.server = server

    def start(self, *arguments):
        return subprocess.Popen([self.dcloc, *map(str, arguments)], text=True,
                                stdout=subprocess.PIPE, stderr=subprocess.PIPE)

    def run(self, *arguments, timeout_s=60):
        return subprocess.run([self.dcloc, *map(str, arguments)], text=True, timeout=timeout_s,
                              stdout=subprocess.PIPE, stderr=subprocess.PIPE)

    def succeed(self, *arguments):
        """What it prints; an error if it fails."""
        result = self.run(*arguments)
        if result.returncode != 0:
            raise AssertionError(f"dcloc {' '.join(map(str, arguments))} failed: {result.stderr}")
        return result.stdout


class Server:
    """A server on a store, at a free port of this machine unless `listen` names one; killed at the
    end of the `with`."""

    def __init__(self, programs, store, *arguments, environment=None, listen="127.0.0.1:0"):
        self.process = subprocess.Popen(
            [programs.server, "--data", store, "--listen", listen, *arguments], text=True,
            stdout=subprocess.PIPE, stderr=subprocess.PIPE, env=environment)
        line = self.process.stdout.readline()
        if not line.startswith("listening on "):
            raise AssertionError(f"no server: {line}{self.process.communicate()[1]}")
        self.address = line.removeprefix("listening on ").strip()

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.kill()
        self.process.stdout.close()
        self.process.stderr.close()

    def stop(self, timeout_s=20):
        """Its exit status and how long it took to stop."""
        begin = time.monotonic()
        self.process.send_signal(signal.SIGTERM)
        return self.process.wait(timeout_s), time.monotonic() - begin

    def kill(self):
        self.process.kill()
        self.process.wait()


def read_answers(path):
    """The lines of a CSV file of `dcloc localize`; an error where one is not complete."""
    text = pathlib.Path(path).read_text()
    if not text.endswith("\n"):
        raise AssertionError(f"{path} ends in the middle of a line: {text[-80:]!r}")
    header, *lines = csv.reader(text.splitlines())
    if header != COLUMNS:
        raise AssertionError(f"{path} has the header {header}")
    for line in lines:
        if len(line) != len(COLUMNS):
            raise AssertionError(f"{path} has an incomplete line: {line}")
    return [dict(zip(COLUMNS, line)) for line in lines]


def poses_only(answers):
    """Answers without what differs from run to run: the time they took."""
    return [{key: value for key, value in answer.items() if key != "latency_ms"}
            for answer in answers]


def true_positions(drives):
    """{stamp in microseconds: (x, y)} of all drives of a simulation."""
    poses = json.loads((pathlib.Path(drives) / "v1.0-sim" / "ego_pose.json").read_text())
    return {pose["timestamp"]: pose["translation"][:2] for pose in poses}
