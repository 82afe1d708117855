import type { DrawnTarget } from "../scan/draw_scan.ts";
import { type PlacedScan, drawnTargets, placeScan } from "../scan/placed_scan.ts";
import { TRAIL_MS, sampleVehicle } from "../scan/sample_vehicle.ts";
import type { Surroundings } from "../scan/surroundings.ts";
import type { Vehicle } from "../map/fleet.ts";
import type { Sample } from "../session/history.ts";
import type { Recording, Step } from "./recording.ts";

/** A radar's scan is shown until the next one, or for so long. */
const SCAN_MS = 300;
const MAX_STEPS_BACK = 64;
const CACHE_SIZE = 128;

/** What of a recording is drawn on the map at a time. */
export class ReplayScene {
  /** Scans that were decoded last; undefined: not one that has a pose. */
  private readonly cache = new Map<Step, PlacedScan | undefined>();

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
      drawn.push(...drawnTargets(placed, surroundings));
    }
    return drawn;
  }

  vehicleAt(sample: Sample, server: string): Vehicle {
    const way = this.recording.samplesIn(sample.timeMs - TRAIL_MS, sample.timeMs);
    const vehicle = this.recording.header?.open?.vehicleId ?? "";
    return sampleVehicle(sample, way, { server, id: "replay", vehicle });
  }

  private place(step: Step): PlacedScan | undefined {
    if (this.cache.has(step)) return this.cache.get(step);
    const placed = this.decode(step);
    this.cache.set(step, placed);
    if (this.cache.size > CACHE_SIZE) this.cache.delete(this.cache.keys().next().value!);
    return placed;
  }

  private decode(step: Step): PlacedScan | undefined {
    if (!step.sample) return undefined;
    const entry = this.recording.entryOf(step);
    if (entry.case !== "scan") return undefined;
    return placeScan(entry.value.scan, entry.value.answer, this.recording.header?.open?.rig);
  }
}
