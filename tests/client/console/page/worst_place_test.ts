import assert from "node:assert/strict";
import { test } from "node:test";
import type { Loss } from "../../../../client/console/page/map/fleet.ts";
import { worstPlace } from "../../../../client/console/page/map/worst_place.ts";

function loss(vehicle: string, x: number, timeMs = 100, map = "town"): Loss {
  return { server: "a", map, vehicle, x, y: 0, timeMs };
}

test("several vehicles lost in one place are one alarm; one vehicle twice is none", () => {
  assert.equal(worstPlace([loss("1", 0), loss("1", 1)], 50, 0), undefined);
  assert.equal(worstPlace([loss("1", 0), loss("2", 900)], 50, 0), undefined);
  assert.equal(worstPlace([loss("1", 0), loss("2", 20), loss("3", 40)], 50, 0)?.count, 3);
  assert.equal(worstPlace([loss("1", 0, 1), loss("2", 20, 1)], 50, 50), undefined);
});

test("an alarm does not end at the side of a square, and one map's is not another's", () => {
  assert.equal(worstPlace([loss("1", 49), loss("2", 51)], 50, 0)?.count, 2);
  assert.equal(worstPlace([loss("1", -1), loss("2", 48)], 50, 0)?.count, 2);
  assert.equal(worstPlace([loss("1", 0), loss("2", 51)], 50, 0), undefined);
  assert.equal(worstPlace([loss("1", 0), loss("2", 1, 100, "harbour")], 50, 0), undefined);
});

test("of two places the worse one is told", () => {
  const worst = worstPlace([loss("1", 0), loss("2", 1), loss("3", 5_000), loss("4", 5_001), loss("5", 5_002)], 50, 0);
  assert.equal(worst?.count, 3);
  assert.ok(worst!.x >= 5_000);
});
