import assert from "node:assert/strict";
import { test } from "node:test";
import { type TileShapes, rasterize, withPlacesBetween } from "../../../../client/console/page/map/tile_raster.ts";

const SIDE = 16;
const COLOURS = { street: [[10, 20, 30], [40, 50, 60]], landmark: [200, 100, 50] } as const;
const NOTHING: TileShapes = {
  keyframeX: [],
  keyframeY: [],
  keyframeGrade: [0, 0],
  streetRadiusPx: 3,
  pointX: [],
  pointY: [],
  strength: () => 1,
  pointPx: 2,
};

function pixels(more: Partial<TileShapes>): (x: number, y: number) => number[] {
  const rgba = rasterize(SIDE, { ...NOTHING, ...more }, COLOURS);
  return (x, y) => [...rgba.slice(4 * (y * SIDE + x), 4 * (y * SIDE + x) + 4)];
}

test("where there is nothing the picture is transparent", () => {
  assert.deepEqual(pixels({})(5, 5), [0, 0, 0, 0]);
});

test("a keyframe is a disc of street, with a soft edge, also across the picture's edge", () => {
  const at = pixels({ keyframeX: [8], keyframeY: [8] });
  assert.deepEqual(at(8, 8), [10, 20, 30, 255]);
  assert.deepEqual(at(8, 12), [0, 0, 0, 0]);
  assert.deepEqual(at(12, 8), [0, 0, 0, 0]);
  const edge = at(5, 8)[3]!;
  assert.ok(edge > 200 && edge < 255, String(edge));
  const corner = pixels({ keyframeX: [-1], keyframeY: [17] });
  assert.deepEqual(corner(0, 15), [10, 20, 30, 255]);
});

test("street has the colour of its keyframe's grade", () => {
  const at = pixels({ keyframeX: [3, 12], keyframeY: [8, 8], keyframeGrade: [0, 1] });
  assert.deepEqual(at(3, 8), [10, 20, 30, 255]);
  assert.deepEqual(at(12, 8), [40, 50, 60, 255]);
});

test("between keyframes that follow one another closely there is street, and none over a gap", () => {
  const places = withPlacesBetween([0, 8, 40], [0, 4, 4], 10);
  assert.deepEqual(places.x, [0, 2, 4, 6, 8, 40]);
  assert.deepEqual(places.y, [0, 1, 2, 3, 4, 4]);
  assert.deepEqual(places.keyframe, [0, 0, 1, 1, 1, 2]);
  assert.deepEqual(withPlacesBetween([], [], 10), { x: [], y: [], keyframe: [] });
});

test("a landmark is a square over the street, and shares the pixels that it lies between", () => {
  const at = pixels({ keyframeX: [8], keyframeY: [8], pointX: [7.5], pointY: [8] });
  const [r] = at(8, 8);
  assert.ok(r! > 190, String(r));
  const [half, , , alpha] = at(7, 8);
  assert.ok(half! > 95 && half! < 115, String(half));
  assert.equal(alpha, 255);
  assert.deepEqual(at(9, 7), [10, 20, 30, 255]);
});

test("a weak echo is fainter, and no strength is out of range", () => {
  const alphaOf = (strength: number) =>
    pixels({ pointX: [4], pointY: [4], strength: () => strength })(4, 4)[3]!;
  assert.deepEqual([alphaOf(-9), alphaOf(0)], [128, 128]);
  assert.deepEqual([alphaOf(1), alphaOf(9)], [250, 250]);
});

test("what is no number draws nothing", () => {
  const at = pixels({ keyframeX: [NaN], keyframeY: [3], pointX: [NaN, 3], pointY: [3, NaN] });
  assert.deepEqual(at(3, 3), [0, 0, 0, 0]);
});
