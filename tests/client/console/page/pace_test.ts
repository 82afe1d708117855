import assert from "node:assert/strict";
import { test } from "node:test";
import { Camera } from "../../../../client/console/page/map/camera.ts";
import { Fleet, type Vehicle } from "../../../../client/console/page/map/fleet.ts";
import { nextMovementMs } from "../../../../client/console/page/map/pace.ts";
import type { LiveSession } from "../../../../client/console/shared/live.ts";

function session(x: number, yaw = 0): LiveSession {
  const pose = { x, y: 0, yaw, xx: 0.01, xy: 0, yy: 0.01, stampMs: 0 };
  return { id: "1", vehicle: "car", map: "town", version: 1, state: 2, detached: false, silentS: 0, faults: [], pose };
}

/** One that came from `first` to `second` within a second. */
function driven(first: LiveSession, second: LiveSession): Iterable<Vehicle> {
  const fleet = new Fleet();
  fleet.take({ server: "a", full: true, set: [first] }, 0);
  fleet.take({ server: "a", set: [second] }, 1_000);
  return fleet.vehicles.values();
}

function camera(scale: number, x = 0): Camera {
  const made = new Camera();
  [made.width, made.height, made.scale, made.x] = [800, 600, scale, x];
  return made;
}

const WAY = (): Iterable<Vehicle> => driven(session(0), session(10));

test("the wait is as long as the fastest vehicle takes for half a pixel", () => {
  assert.equal(nextMovementMs(WAY(), camera(1), 1_000), 50);
  assert.equal(nextMovementMs(WAY(), camera(0.1), 1_000), 500);
});

test("nothing is waited for where nothing glides", () => {
  assert.equal(nextMovementMs([], camera(1), 1_000), Infinity);
  assert.equal(nextMovementMs(WAY(), camera(1), 2_000), Infinity);
  assert.equal(nextMovementMs(driven(session(3), session(3)), camera(1), 1_000), Infinity);
});

test("a vehicle counts while any of its way is in view", () => {
  // 800 pixels at 100 to the metre: 8 m.
  assert.equal(nextMovementMs(WAY(), camera(100, -3.9), 1_000), 0.5);
  assert.equal(nextMovementMs(WAY(), camera(100, 5), 1_000), 0.5);
  assert.equal(nextMovementMs(WAY(), camera(100, 20), 1_000), Infinity);
});

test("a vehicle that turns on its place moves, too", () => {
  const wait = nextMovementMs(driven(session(0), session(0, 1)), camera(1), 1_000);
  assert.ok(wait > 40 && wait < 80, `${wait} ms for an arrow of 17 pixels`);
});
