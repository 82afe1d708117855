"""Programs that run beside each other, and end with this one, however it ends."""

import ctypes
import os
import pathlib
import signal
import socket
import subprocess
import time

LOOPBACK = "127.0.0.1"
TICKS_PER_S = os.sysconf("SC_CLK_TCK")
_PR_SET_PDEATHSIG = 1
_LIBC = ctypes.CDLL(None)


class Failure(Exception):
    """What went wrong, for people."""


def free_port():
    """A port of loopback that nobody listens on now."""
    with socket.create_server((LOOPBACK, 0)) as listener:
        return listener.getsockname()[1]


def wait_until(condition, timeout_s, what):
    """The first true value of `condition()`."""
    end = time.monotonic() + timeout_s
    while True:
        value = condition()
        if value:
            return value
        if time.monotonic() > end:
            raise Failure(f"{what} has not come within {timeout_s:g} s")
        time.sleep(0.05)


def run(*command, check=True, timeout_s=300, **options):
    """A program that is waited for; its output is text."""
    try:
        done = subprocess.run([str(word) for word in command], text=True, stdout=subprocess.PIPE,
                              stderr=subprocess.PIPE, timeout=timeout_s, stdin=subprocess.DEVNULL,
                              check=False, **options)
    except subprocess.TimeoutExpired:
        raise Failure(f"{pathlib.Path(command[0]).name} {command[1]} has not ended within "
                      f"{timeout_s} s") from None
    if check and done.returncode != 0:
        raise Failure(f"{pathlib.Path(command[0]).name} {command[1]} failed with "
                      f"{done.returncode}: {(done.stderr or done.stdout).strip()}")
    return done


def processor_s(pid):
    """Processor time of a process, of its children that have ended, and of those that live [s]."""
    def ticks(stat):
        # After the name, which may hold anything: field 3 and on of proc(5).
        return sum(map(int, stat.rpartition(")")[2].split()[11:15]))

    total = 0
    for path in pathlib.Path("/proc").glob("[0-9]*/stat"):
        try:
            stat = path.read_text(encoding="utf-8", errors="replace")
        except OSError:
            continue  # it has just ended
        parent = int(stat.rpartition(")")[2].split()[1])
        if pid in (int(path.parent.name), parent):
            total += ticks(stat)
    return total / TICKS_PER_S


class Program:
    """A program in the background, with what it says in a file, and its output there too or in one
    of its own."""

    def __init__(self, name, command, log, user=None, end_signal=signal.SIGTERM, environment=None,
                 output=None):
        self.name = name
        self.log = pathlib.Path(log)
        self.end_signal = end_signal

        def end_with_parent():
            _LIBC.prctl(_PR_SET_PDEATHSIG, signal.SIGKILL)

        with open(self.log, "ab") as errors, open(output or self.log, "ab") as output:
            # A session of its own: Ctrl-C is ours, and this one is ended in its turn.
            self.process = subprocess.Popen(
                [str(word) for word in command], stdin=subprocess.DEVNULL, stdout=output,
                stderr=errors, start_new_session=True, preexec_fn=end_with_parent, user=user,
                group=user, extra_groups=[] if user else None,
                env={**os.environ, **(environment or {})})

    def alive(self):
        return self.process.poll() is None

    def text(self):
        return self.log.read_text(encoding="utf-8", errors="replace")

    def processor_s(self):
        return processor_s(self.process.pid) if self.alive() else 0.0

    def memory_mib(self):
        """Resident memory."""
        try:
            text = pathlib.Path(f"/proc/{self.process.pid}/status").read_text(encoding="utf-8")
        except OSError:
            return 0.0
        lines = [line for line in text.splitlines() if line.startswith("VmRSS:")]
        return int(lines[0].split()[1]) / 1024 if lines else 0.0

    def signal(self, number):
        if self.alive():
            self.process.send_signal(number)

    def kill(self):
        self.signal(signal.SIGKILL)
        self.process.wait()

    def end(self, timeout_s=20):
        """Asks it to end, and ends it if it does not. Its exit status."""
        self.signal(self.end_signal)
        try:
            return self.process.wait(timeout_s)
        except subprocess.TimeoutExpired:
            self.kill()
            raise Failure(f"{self.name} did not end within {timeout_s} s") from None
