import assert from "node:assert/strict";
import { test } from "node:test";
import { LossLog } from "../../../../client/console/bridge/loss_log.ts";
import type { LiveSession } from "../../../../client/console/shared/live.ts";

function session(id: string, state: number, x = 0): LiveSession {
  const pose = { x, y: 0, yaw: 0, xx: 0, xy: 0, yy: 0, stampMs: 0 };
  return { id, vehicle: id, map: "town", version: 1, state, detached: false, silentS: 0, faults: [], pose };
}

test("getting lost is told once, where and when it happened", () => {
  const log = new LossLog();
  assert.deepEqual(log.take([session("1", 2)], 0), []);
  const told = { vehicle: "1", map: "town", x: 3, y: 0 };
  assert.deepEqual(log.take([session("1", 4, 3)], 1_000), [{ ...told, agoMs: 0 }]);
  assert.deepEqual(log.take([session("1", 4, 4)], 2_000), []);
  assert.deepEqual(log.all(5_000), [{ ...told, agoMs: 4_000 }]);
});

test("who was lost when first seen, or while nobody looked, got lost at no known place", () => {
  const log = new LossLog();
  log.take([session("1", 4), session("2", 2)], 0);
  assert.deepEqual(log.take([session("1", 4), session("2", 4)], 90_000), []);
});

test("a loss is forgotten after an hour, and there are never too many", () => {
  const log = new LossLog();
  const all = (state: number) => Array.from({ length: 3_000 }, (_, i) => session(String(i), state));
  log.take(all(2), 0);
  assert.equal(log.take(all(4), 1_000).length, 3_000);
  assert.equal(log.all(1_000).length, 2_000);
  assert.deepEqual(log.all(3_602_000), []);
});
