import assert from "node:assert/strict";
import { test } from "node:test";
import { Fleet } from "../../../../client/console/page/map/fleet.ts";
import type { LivePose, LiveSession } from "../../../../client/console/shared/live.ts";

function pose(x: number, yaw = 0): LivePose {
  return { x, y: 0, yaw, xx: 0.01, xy: 0, yy: 0.01, stampMs: 0 };
}

function session(id: string, more: Partial<LiveSession> = {}): LiveSession {
  const base = { id, vehicle: id, map: "town", version: 1, state: 2, detached: false };
  return { ...base, silentS: 0, faults: [], ...more };
}

test("a full frame replaces what was known of that server alone", () => {
  const fleet = new Fleet();
  fleet.take({ server: "a", full: true, set: [session("1"), session("2")] }, 0);
  fleet.take({ server: "b", full: true, set: [session("1")] }, 0);
  fleet.take({ server: "a", full: true, set: [session("2")] }, 1);
  assert.deepEqual([...fleet.vehicles.keys()].sort(), ["a/2", "b/1"]);
  fleet.take({ server: "b", set: [], gone: ["1"] }, 2);
  assert.deepEqual([...fleet.vehicles.keys()], ["a/2"]);
});

test("a server that does not answer keeps its vehicles, with the fault", () => {
  const fleet = new Fleet();
  fleet.take({ server: "a", full: true, set: [session("1")] }, 0);
  fleet.take({ server: "a", failure: { code: 14, message: "gone" } }, 1);
  assert.equal(fleet.vehicles.size, 1);
  assert.equal(fleet.faults.get("a")?.message, "gone");
  fleet.take({ server: "a", full: true, set: [] }, 2);
  assert.equal(fleet.faults.size, 0);
});

test("a vehicle glides between its poses and does not run ahead", () => {
  const fleet = new Fleet();
  fleet.take({ server: "a", full: true, set: [session("1", { pose: pose(0, 3.1) })] }, 0);
  fleet.take({ server: "a", set: [session("1", { pose: pose(10, -3.1) })] }, 1000);
  const vehicle = fleet.vehicles.get("a/1")!;
  assert.equal(Fleet.poseOf(vehicle, 1000)?.x, 0);
  assert.equal(Fleet.poseOf(vehicle, 1500)?.x, 5);
  assert.equal(Fleet.poseOf(vehicle, 9000)?.x, 10);
  // By the short way around, from 3.1 to -3.1.
  assert.ok(Math.abs(Fleet.poseOf(vehicle, 1500)!.yaw) > 3.1);
});

test("a vehicle that is found elsewhere is there at once, without a trail", () => {
  const fleet = new Fleet();
  fleet.take({ server: "a", full: true, set: [session("1", { pose: pose(0) })] }, 0);
  fleet.take({ server: "a", set: [session("1", { pose: pose(500) })] }, 1000);
  const vehicle = fleet.vehicles.get("a/1")!;
  assert.equal(Fleet.poseOf(vehicle, 1000)?.x, 500);
  assert.deepEqual(vehicle.trail, [500, 0]);
});

test("trails are bounded", () => {
  const fleet = new Fleet();
  for (let i = 0; i < 500; ++i) fleet.take({ server: "a", set: [session("1", { pose: pose(i) })] }, 1000 * i);
  assert.equal(fleet.vehicles.get("a/1")!.trail.length, 180);
});

test("losses are told by the bridge; a full frame has all of its server's", () => {
  const fleet = new Fleet();
  const loss = (vehicle: string, agoMs: number) => ({ vehicle, map: "town", x: 3, y: 0, agoMs });
  fleet.take({ server: "a", full: true, losses: [loss("1", 500)] }, 1_000);
  fleet.take({ server: "b", full: true, losses: [loss("2", 0)] }, 1_000);
  fleet.take({ server: "a", losses: [loss("3", 0)] }, 2_000);
  assert.deepEqual(fleet.losses.map((l) => [l.vehicle, l.timeMs]), [["1", 500], ["2", 1_000], ["3", 2_000]]);
  fleet.take({ server: "a", full: true, losses: [loss("1", 2_500)] }, 3_000);
  assert.deepEqual(fleet.losses.map((l) => [l.server, l.vehicle]), [["b", "2"], ["a", "1"]]);
});

test("a server of the fleet that is silent is known until it answers", () => {
  const fleet = new Fleet();
  const silent = [{ address: "b:1", fault: "timed out" }];
  fleet.take({ server: "a", full: true, silent }, 0);
  assert.deepEqual(fleet.silent.get("a"), silent);
  fleet.take({ server: "a", set: [] }, 1_000);
  assert.deepEqual(fleet.silent.get("a"), []);
});
