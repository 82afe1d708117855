import assert from "node:assert/strict";
import { test } from "node:test";
import { create } from "@bufbuild/protobuf";
import { HealthSchema } from "proto/dcloc/v1/localization_service_pb.ts";
import "./browser_globals.ts";
import { type Evidence, explain } from "../../../../client/console/page/session/explain.ts";
import type { Sample } from "../../../../client/console/page/session/history.ts";

const GOOD: Sample = {
  timeMs: 0,
  state: 2,
  x: 0,
  y: 0,
  yaw: 0,
  xx: 0.01,
  xy: 0,
  yy: 0.01,
  sigmaM: 0.1,
  protectionM: Number.NaN,
  points: 400,
  inliers: 320,
  overlap: 0.8,
  residual: 1,
  edge: 0.5,
  edgeValid: true,
  isRegistered: true,
  totalMs: 3,
  stagesMs: [0, 0, 0, 0, 1, 0],
  version: 1,
  resets: 0,
  betaErrorS: 0,
  betaIsWrong: false,
};

/** Twenty seconds of good answers, and then seven of these, ten a second. */
function evidence(now: Partial<Sample>, more: Partial<Evidence> = {}): Evidence {
  const samples = Array.from({ length: 270 }, (_, i) => ({
    ...GOOD,
    ...(i >= 200 ? now : {}),
    timeMs: 100 * i,
  }));
  return { samples, rejections: [], health: undefined, outsideM: 0, nowMs: 26_900, ...more };
}

const texts = (given: Evidence): string => explain(given).map(({ text }) => text).join("\n");
const causes = (given: Evidence): number => explain(given).filter((f) => f.kind === "cause").length;

test("a vehicle that tracks has a state and no cause", () => {
  assert.match(texts(evidence({})), /agree with the map: 80 % .* sigma is 0\.10 m/);
  assert.equal(causes(evidence({})), 0);
});

test("without answers nothing is said", () => {
  assert.deepEqual(explain({ ...evidence({}), samples: [] }), []);
});

test("how long it is lost is counted from the first lost answer", () => {
  assert.match(texts(evidence({ state: 4 })), /Lost for 7 s/);
});

test("a place that looks different is told by the overlap, with what it was before", () => {
  const found = texts(evidence({ state: 4, overlap: 0.2 }));
  assert.match(found, /Only 20 % of the points .*before: 80 %/);
  assert.doesNotMatch(found, /innovation/);
});

test("where it has not tracked lately, nothing is said of before", () => {
  const samples = evidence({}).samples.map((s) => ({ ...s, state: 4, overlap: 0.2, betaIsWrong: true }));
  const found = texts({ ...evidence({}), samples });
  assert.match(found, /Only 20 % of the points have a landmark nearby: /);
  assert.doesNotMatch(found, /Beta/, "at a wrong place residuals say nothing of a radar");
});

test("sentences on the state have its colour", () => {
  const found = explain(evidence({ state: 4 }));
  assert.ok(found.every(({ kind, state }) => state === (kind === "state" ? 4 : undefined)));
});

test("a registration that the motion contradicts is told by the innovation test", () => {
  const found = texts(evidence({ state: 3, edge: 40, edgeValid: false }));
  assert.match(found, /edge distance 40\.0.* refused 50 of the last 50/);
});

test("radars that see nothing are told by the points", () => {
  assert.match(texts(evidence({ state: 4, points: 6 })), /6 static points/);
});

test("a wide position, a wrong model and a place outside of the map are told", () => {
  const found = texts(evidence({ state: 4, sigmaM: 3.5, residual: 4 }, { outsideM: 120 }));
  assert.match(found, /sigma 3\.5 m/);
  assert.match(found, /4\.0 times worse/);
  assert.match(found, /120 m outside/);
});

test("faulty sources are named with their fault", () => {
  const health = create(HealthSchema, {
    wheelSpeed: { used: false, fault: 4 },
    radars: [{ radarId: "<b>rear</b>", used: true, fault: 12 }],
  });
  const found = texts(evidence({}, { health }));
  assert.match(found, /Wheel speed is set aside or faulty: frozen/);
  assert.match(found, /<b>rear<\/b> is set aside or faulty: its clock is off/);
});

test("silence, rejections, late answers and a new version are told", () => {
  const rejections = [{ timeMs: 26_000, message: "range_m[3] is -1; it must be > 0" }];
  const found = texts(evidence({ totalMs: 80, version: 2 }, { rejections, nowMs: 30_900 }));
  assert.match(found, /No scan has come for 4 s/);
  assert.match(found, /last minute: 1\. The last one: range_m\[3\] is -1/);
  assert.match(found, /80 ms in the server/);
  assert.match(found, /from v1 to v2 11 s ago/);
});

test("where no figure stands out, that is said", () => {
  assert.match(texts(evidence({ state: 4 })), /None of the figures shown stands out/);
});
