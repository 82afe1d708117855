import type { MapInfo } from "proto/dcloc/v1/map_service_pb.ts";
import type { Bounds } from "./camera.ts";
import type { Vehicle } from "./fleet.ts";

/** How far from its street a map has landmarks. */
const MARGIN_M = 80;

/** No place on Earth is further from another one along the ground. */
const MAX_COORDINATE_M = 2.1e7;

/** The rectangle of a map's landmarks; none where what is told cannot be one. */
export function extentOf(info: MapInfo | undefined): Bounds | undefined {
  if (!info?.minMapM || !info.maxMapM) return undefined;
  const bounds = {
    minX: info.minMapM.x - MARGIN_M,
    minY: info.minMapM.y - MARGIN_M,
    maxX: info.maxMapM.x + MARGIN_M,
    maxY: info.maxMapM.y + MARGIN_M,
  };
  const isOnEarth = Object.values(bounds).every((m) => Math.abs(m) <= MAX_COORDINATE_M);
  return isOnEarth && bounds.minX < bounds.maxX && bounds.minY < bounds.maxY ? bounds : undefined;
}

/** The rectangle of the vehicles that have a pose. */
export function extentOfVehicles(vehicles: Iterable<Vehicle>): Bounds | undefined {
  let bounds: Bounds | undefined;
  for (const { pose } of vehicles) {
    if (!pose) continue;
    const { x, y } = pose;
    bounds ??= { minX: x, minY: y, maxX: x, maxY: y };
    bounds.minX = Math.min(bounds.minX, x);
    bounds.minY = Math.min(bounds.minY, y);
    bounds.maxX = Math.max(bounds.maxX, x);
    bounds.maxY = Math.max(bounds.maxY, y);
  }
  return bounds;
}

/** How far a position is outside of a map's street; 0 inside of its rectangle. */
export function distanceOutside(info: MapInfo, x: number, y: number): number {
  const { minMapM: min, maxMapM: max } = info;
  if (!min || !max) return 0;
  return Math.hypot(Math.max(min.x - x, 0, x - max.x), Math.max(min.y - y, 0, y - max.y));
}

/** A square about a place. */
export const around = (x: number, y: number, halfM: number): Bounds => ({
  minX: x - halfM,
  maxX: x + halfM,
  minY: y - halfM,
  maxY: y + halfM,
});
