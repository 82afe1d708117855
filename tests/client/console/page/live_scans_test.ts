import assert from "node:assert/strict";
import { test } from "node:test";
import { create } from "@bufbuild/protobuf";
import { type WatchSessionResponse, WatchSessionResponseSchema } from "proto/dcloc/v1/admin_service_pb.ts";
import { LiveScans } from "../../../../client/console/page/scan/live_scans.ts";

const POSE = { translationM: { x: 10, y: 20, z: 0 }, rotation: { w: 1, x: 0, y: 0, z: 0 } };
const RIG = {
  radars: [{ radarId: "front", tVehicleRadar: { ...POSE, translationM: { x: 2, y: 0, z: 0 } } }],
};

function answer(radarId: string, rangeM: number, rig = false): WatchSessionResponse {
  return create(WatchSessionResponseSchema, {
    answer: { message: { case: "result", value: { pose: { pose: POSE } } } },
    scan: { radarId, rangeM: [rangeM], rangeRateMps: [0], azimuthRad: [0] },
    ...(rig ? { rig: RIG } : {}),
  });
}

test("each radar's newest scan lies where its answer and its mount put it, for a while", () => {
  const scans = new LiveScans();
  scans.take(answer("front", 5, true), 0);
  scans.take(answer("front", 7), 100);
  // Not one of the rig's: as if it were mounted at the vehicle's origin.
  scans.take(answer("other", 9), 200);
  const xs = (timeMs: number): number[] => scans.targetsAt(timeMs, undefined).map(({ x }) => x);
  assert.deepEqual(xs(300), [19, 19]);
  assert.deepEqual(xs(950), [19]);
  assert.deepEqual(xs(2000), []);
  scans.take(answer("front", 5), 2100);
  assert.deepEqual(xs(2100), [17]);
});

test("an answer without a pose places nothing, and one server too old is told apart", () => {
  const scans = new LiveScans();
  const noPose = { answer: { message: { case: "result" as const, value: {} } } };
  const bare = create(WatchSessionResponseSchema, noPose);
  for (let i = 0; i < 19; ++i) scans.take(bare, i);
  assert.ok(!scans.areMissing);
  scans.take(bare, 20);
  assert.ok(scans.areMissing);
  scans.take(create(WatchSessionResponseSchema, { ...noPose, scan: { radarId: "front" } }), 21);
  assert.ok(!scans.areMissing);
  assert.deepEqual(scans.targetsAt(21, undefined), []);
});

test("however many radars a server names, what is kept is bounded", () => {
  const scans = new LiveScans();
  for (let i = 0; i < 1000; ++i) scans.take(answer(`radar-${i}`, 5), 0);
  assert.equal(scans.targetsAt(0, undefined).length, 64);
});
