"""What the vehicles saw, for people and for scripts."""

import dataclasses

HEADER = ("act", "vehicles", "scans", "answers", "worst gap [s]", "p99 [ms]", "TRACKING", "LOST",
          "errors", "new sessions", "limits")


def table(played):
    """Lines of a table: for each act what the load saw, and what the client library's vehicles saw."""
    rows = [HEADER]
    for act in played:
        verdict = "failed" if act.faults else "held"
        for seen in act.seen:
            rows.append((f"{act.name}, {seen.kind}", str(seen.vehicles), str(seen.scans),
                         str(seen.answers), f"{seen.worst_gap_s:.2f}", f"{seen.p99_ms:.0f}",
                         f"{100 * seen.tracking_share:.1f} %", str(seen.lost), str(seen.errors),
                         str(seen.restarts), verdict))
        if not act.seen:
            rows.append((act.name, *["-"] * (len(HEADER) - 2), verdict))
    widths = [max(map(len, column)) for column in zip(*rows)]
    return ["  ".join(cell.ljust(width) if i == 0 else cell.rjust(width)
                      for i, (cell, width) in enumerate(zip(row, widths))) for row in rows]


def faults(played):
    """A line for each limit that did not hold."""
    return [f"{act.name}: {fault}" for act in played for fault in act.faults]


def as_json(played):
    """For scripts: a list of the acts."""
    return [{**dataclasses.asdict(act),
             "seen": [{**dataclasses.asdict(seen), "unanswered": seen.unanswered,
                       "tracking_share": round(seen.tracking_share, 4)} for seen in act.seen]}
            for act in played]
