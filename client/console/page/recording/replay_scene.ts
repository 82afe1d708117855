import type { Vehicle } from "../map/fleet.ts";
import type { DrawnTarget } from "../map/draw_scan.ts";
import type { Sample } from "../session/history.ts";
import type { Recording, Step } from "./recording.ts";
import type { Surroundings } from "./surroundings.ts";
import { type Targets, targetsOf } from "./targets.ts";

/** A radar's scan is shown until the next one, or for so long. */
const SCAN_MS = 300;
const TRAIL_MS = 20_000;
const MAX_STEPS_BACK = 64;
const CACHE_SIZE = 128;

interface PlacedScan {
  radarId: string;
  targets: Targets;
}

/** What of a recording is drawn on the map at a time. */
export class ReplayScene {
  /** Scans that were decoded last; null: not one that has a pose. */
  private readonly cache = new Map<Step, PlacedScan | null>();

  constructor(private readonly recording: Recording) {}

  /** The targets of each radar's newest scan, each where its own answer put the vehicle. */
  targetsAt(timeMs: number, surroundings: Surroundings | undefined): DrawnTarget[] {
    const drawn: DrawnTarget[] = [];
    const radars = new Set<string>();
    const { steps } = this.recording;
    const end = this.recording.countUntil(timeMs);
    for (let i = end - 1; i >= Math.max(0, end - MAX_STEPS_BACK); --i) {
      const step = steps[i]!;
      if (timeMs - step.timeMs > SCAN_MS) break;
      const placed = this.place(step);
      if (!placed || radars.has(placed.radarId)) continue;
      radars.add(placed.radarId);
      const { x_map, y_map, rangeRateMps } = placed.targets;
      for (let k = 0; k < x_map.length; ++k) {
        const [x, y] = [x_map[k]!, y_map[k]!];
        drawn.push({ x, y, rangeRateMps: rangeRateMps[k]!, isNear: surroundings?.hasNear(x, y) });
      }
    }
    return drawn;
  }

  /** The vehicle as the live view draws it, with the way that it came. */
  vehicleAt(sample: Sample, server: string): Vehicle {
    const { timeMs, x, y, yaw, xx, xy, yy, state, version } = sample;
    const way = this.recording.samplesIn(timeMs - TRAIL_MS, timeMs);
    const step = Math.ceil(way.length / 300);
    return {
      server,
      id: "replay",
      vehicle: this.recording.header?.open?.vehicleId ?? "",
      map: "",
      version,
      state,
      detached: false,
      silentS: 0,
      faults: [],
      pose: { x, y, yaw, xx, xy, yy, stampMs: timeMs },
      arrivalMs: 0,
      intervalMs: 1,
      trail: way.filter((_, i) => i % step === 0).flatMap((s) => [s.x, s.y]),
    };
  }

  private place(step: Step): PlacedScan | null {
    const known = this.cache.get(step);
    if (known !== undefined) return known;
    const placed = this.decode(step);
    this.cache.set(step, placed);
    if (this.cache.size > CACHE_SIZE) this.cache.delete(this.cache.keys().next().value!);
    return placed;
  }

  private decode(step: Step): PlacedScan | null {
    if (!step.sample) return null;
    const entry = this.recording.entryOf(step);
    if (entry.case !== "scan") return null;
    const { scan, answer } = entry.value;
    const pose = answer?.message.case === "result" ? answer.message.value.pose?.pose : undefined;
    if (!scan || !pose) return null;
    const { radarId } = scan;
    const radar = this.recording.header?.open?.rig?.radars.find((r) => r.radarId === radarId);
    return { radarId, targets: targetsOf(scan, radar, pose) };
  }
}
