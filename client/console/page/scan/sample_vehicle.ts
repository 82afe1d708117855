import type { Vehicle } from "../map/fleet.ts";
import type { Sample } from "../session/history.ts";

const MAX_TRAIL_LENGTH = 300;
export const TRAIL_MS = 20_000;

type Named = Pick<Vehicle, "server" | "id" | "vehicle">;

/** A vehicle where an answer put it, with the way that it came, as the live view draws vehicles. */
export function sampleVehicle(sample: Sample, way: readonly Sample[], named: Named): Vehicle {
  const { timeMs, x, y, yaw, xx, xy, yy, state, version } = sample;
  const step = Math.ceil(way.length / MAX_TRAIL_LENGTH);
  return {
    ...named,
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
