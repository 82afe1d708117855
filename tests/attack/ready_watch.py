"""Asks /ready until it is told to stop.

Usage: ready_watch.py HOST:PORT INTERVAL_S
"""

import http.client
import json
import select
import sys
import time

ADDRESS, INTERVAL_S = sys.argv[1:3]


def ask():
    """How long it took [ms], and whether it said that the server is ready."""
    begin = time.monotonic()
    connection = http.client.HTTPConnection(*ADDRESS.split(":"), timeout=15)
    try:
        connection.request("GET", "/ready")
        ready = connection.getresponse().status == 200
    except OSError:
        ready = False
    finally:
        connection.close()
    return 1e3 * (time.monotonic() - begin), ready


def main():
    times_ms = []
    failed = 0
    ask()
    print("watching", flush=True)
    while not select.select([sys.stdin], [], [], float(INTERVAL_S))[0]:
        took_ms, ready = ask()
        times_ms.append(took_ms)
        failed += not ready
    times_ms.sort()
    print(json.dumps({"asked": len(times_ms), "worst_ms": round(times_ms[-1], 1),
                      "p99_ms": round(times_ms[int(0.99 * (len(times_ms) - 1))], 1),
                      "failed": failed}))


if __name__ == "__main__":
    main()
