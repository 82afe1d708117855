import assert from "node:assert/strict";
import { test } from "node:test";
import "./browser_globals.ts";
import type { Loss } from "../../../../client/console/page/map/fleet.ts";
import { lossesByMinute, lossesWithin } from "../../../../client/console/page/views/losses.tsx";

const MINUTE_MS = 60_000;
const NOW_MS = 100 * MINUTE_MS;

const agoMinutes = (minutes: number): Loss => ({
  server: "a",
  map: "town",
  vehicle: String(minutes),
  x: 0,
  y: 0,
  timeMs: NOW_MS - minutes * MINUTE_MS,
});

test("a window holds the losses from its begin to its end", () => {
  const losses = [0, 4, 5, 12, 59].map(agoMinutes);
  const names = (minutes: number, endMinutes: number) =>
    lossesWithin(losses, { minutes, endMinutes }, NOW_MS).map(({ vehicle }) => vehicle);
  assert.deepEqual(names(60, 0), ["0", "4", "5", "12", "59"]);
  assert.deepEqual(names(5, 0), ["0", "4"]);
  assert.deepEqual(names(15, 5), ["5", "12"]);
});

test("bars count each minute of an hour, the oldest first", () => {
  const counts = lossesByMinute([0.5, 0.5, 59.5, 61].map(agoMinutes), NOW_MS);
  assert.equal(counts.length, 60);
  assert.deepEqual([counts[0], counts[58], counts[59]], [1, 0, 2]);
});
