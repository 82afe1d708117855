import type { Bounds, Camera } from "./camera.ts";
import { LENGTH_M, MIN_LENGTH_PX } from "./draw_arrow.ts";
import type { Vehicle } from "./fleet.ts";

/** A smaller movement is not seen. */
const SEEN_PX = 0.5;

/** How fast any part of a vehicle's body moves on the screen, in pixels/ms; 0 where it does not glide. */
function speedOf(vehicle: Vehicle, scale: number, nowMs: number): number {
  const { pose, before, arrivalMs, intervalMs } = vehicle;
  if (!pose || !before || nowMs - arrivalMs >= intervalMs) return 0;
  const turn = Math.atan2(Math.sin(pose.yaw - before.yaw), Math.cos(pose.yaw - before.yaw));
  const reachPx = Math.max(MIN_LENGTH_PX, LENGTH_M * scale) / 2;
  const wayPx = Math.hypot(pose.x - before.x, pose.y - before.y) * scale;
  return (wayPx + Math.abs(turn) * reachPx) / intervalMs;
}

/** Whether a vehicle's way between its last two poses may be in view. */
function isInView({ pose, before = pose }: Vehicle, { minX, minY, maxX, maxY }: Bounds): boolean {
  if (!pose || !before) return false;
  const isBeside = Math.max(pose.x, before.x) < minX || Math.min(pose.x, before.x) > maxX;
  return !isBeside && Math.max(pose.y, before.y) >= minY && Math.min(pose.y, before.y) <= maxY;
}

/**
 * How long after `nowMs` something in view will have moved so far that it is seen [ms]; Infinity while
 * everything stands. Drawn oftener, a picture is the same and costs as much: on a map of a whole city
 * vehicles take seconds for a pixel.
 */
export function nextMovementMs(vehicles: Iterable<Vehicle>, camera: Camera, nowMs: number): number {
  const view = camera.bounds;
  let fastest = 0;
  for (const vehicle of vehicles) {
    if (isInView(vehicle, view)) fastest = Math.max(fastest, speedOf(vehicle, camera.scale, nowMs));
  }
  return SEEN_PX / fastest;
}
