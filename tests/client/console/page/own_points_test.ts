import assert from "node:assert/strict";
import { test } from "node:test";
import { ownPoints } from "../../../../client/console/page/map/own_points.ts";

const ID = { level: 5, column: 0, row: 0 };
const NONE = new Float32Array();
const data = (x: number[], y: number[], pointCount = x.length) => ({
  originXM: 100,
  originYM: 0,
  pointCount,
  xM: Float32Array.from(x),
  yM: Float32Array.from(y),
  rcsDbsm: NONE,
  keyframeXM: NONE,
  keyframeYM: NONE,
  keyframeGrade: new Uint8Array(),
  isGraded: false,
});

test("landmarks of the margin are the neighbours', and one on the edge is one tile's alone", () => {
  // The tile reaches from 0 to 128 m; 28 m from the origin on it is the next one's.
  const points = data([-101, -100, 0, 27.9, 28], [1, 1, 1, 1, 1]);
  assert.deepEqual(ownPoints(ID, points), { shown: 3, count: 3 });
  assert.deepEqual(ownPoints({ ...ID, column: 1 }, points), { shown: 1, count: 1 });
});

test("where only some were read, all are reckoned from the share within", () => {
  assert.deepEqual(ownPoints(ID, data([0, 1, 2, -110], [1, 1, 1, 1], 400)), { shown: 3, count: 300 });
  assert.deepEqual(ownPoints(ID, data([], [], 7)), { shown: 0, count: 0 });
});
