import assert from "node:assert/strict";
import { test } from "node:test";
import { create } from "@bufbuild/protobuf";
import { ReadMapTileResponseSchema } from "proto/dcloc/v1/map_service_pb.ts";
import { countsOf, differenceOf } from "../../../../client/console/page/compare/match.ts";

const SQUARE = { minX: 0, minY: 0, maxX: 100, maxY: 100 };

const tile = (origin: number, points: [number, number][], pointCount = points.length) =>
  create(ReadMapTileResponseSchema, {
    originM: { x: origin, y: 0, z: 0 },
    xM: points.map(([x]) => x - origin),
    yM: points.map(([, y]) => y),
    pointCount: BigInt(pointCount),
  });

test("landmarks are in both within half a metre, whatever the tiles' origins", () => {
  const from = tile(50, [
    [10, 10],
    [20, 20],
    [30, 30],
  ]);
  const to = tile(0, [
    [10.25, 10.25],
    [20.5, 20.5],
    [80, 80],
  ]);
  const difference = differenceOf(from, to, SQUARE);
  assert.deepEqual(countsOf(difference), { both: 1, onlyFrom: 2, onlyTo: 2 });
  assert.deepEqual([...difference.onlyTo], [20.5, 20.5, 80, 80]);
  assert.ok(!difference.isPart);
});

test("a landmark at the edge is compared across it, and counted in one square alone", () => {
  const from = tile(0, [[99.9, 50]]);
  const to = tile(0, [[100.1, 50]]);
  const right = { ...SQUARE, minX: 100, maxX: 200 };
  const here = countsOf(differenceOf(from, to, SQUARE));
  const there = countsOf(differenceOf(from, to, right));
  assert.deepEqual(here, { both: 1, onlyFrom: 0, onlyTo: 0 });
  assert.deepEqual(there, { both: 0, onlyFrom: 0, onlyTo: 0 });
});

test("where landmarks were left out it is said", () => {
  assert.ok(differenceOf(tile(0, [[1, 1]], 7), tile(0, []), SQUARE).isPart);
});
