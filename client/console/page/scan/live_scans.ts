import type { WatchSessionResponse } from "proto/dcloc/v1/admin_service_pb.ts";
import type { Rig } from "proto/dcloc/v1/scan_pb.ts";
import type { DrawnTarget } from "./draw_scan.ts";
import { type PlacedScan, drawnTargets, placeScan } from "./placed_scan.ts";
import type { Surroundings } from "./surroundings.ts";

/** A radar's scan is shown until the next one, or for so long: radars of 2 Hz do not flicker. */
const SCAN_MS = 800;
/** A rig has at most 16 radars; a server may say anything. */
const MAX_RADAR_COUNT = 64;
/** An older server sends answers without their scans. */
const TELLING_ANSWER_COUNT = 20;

/** The newest scan of each radar of a session that is watched. */
export class LiveScans {
  private rig: Rig | undefined;
  private readonly scans = new Map<string, { timeMs: number; placed: PlacedScan }>();
  private answersWithout = 0;
  private hasScans = false;

  /** The server hands on answers alone. */
  get areMissing(): boolean {
    return !this.hasScans && this.answersWithout >= TELLING_ANSWER_COUNT;
  }

  take({ answer, scan, rig }: WatchSessionResponse, timeMs: number): void {
    this.rig = rig ?? this.rig;
    if (scan) this.hasScans = true;
    else if (answer?.message.case === "result") ++this.answersWithout;
    const placed = placeScan(scan, answer, this.rig);
    if (!placed) return;
    if (!this.scans.has(placed.radarId) && this.scans.size >= MAX_RADAR_COUNT) return;
    this.scans.set(placed.radarId, { timeMs, placed });
  }

  targetsAt(timeMs: number, surroundings: Surroundings | undefined): DrawnTarget[] {
    return [...this.scans.values()]
      .filter((scan) => timeMs - scan.timeMs <= SCAN_MS)
      .flatMap(({ placed }) => drawnTargets(placed, surroundings));
  }
}
