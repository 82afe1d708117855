import assert from "node:assert/strict";
import { test } from "node:test";
import { type Raster, press, stampOf } from "../../../../client/console/page/map/stamp.ts";

function raster(width: number, height: number): Raster {
  return { width, height, data: new Uint8ClampedArray(4 * width * height) };
}

const pixelAt = ({ width, data }: Raster, x: number, y: number): number[] =>
  [...data.subarray(4 * (y * width + x), 4 * (y * width + x) + 4)];

/** A sheet of two squares of 3 pixels: a red one with a weak edge to its right, and an empty one. */
function sheet(): Raster {
  const made = raster(6, 3);
  made.data.set([200, 0, 0, 255], 4 * (6 + 1));
  made.data.set([200, 0, 0, 51], 4 * (6 + 2));
  return made;
}

test("a stamp has the pixels of its square that are seen, from its middle", () => {
  const stamp = stampOf(sheet(), 0, 0, 3);
  assert.deepEqual([[...stamp.x], [...stamp.y]], [[0, 1], [0, 0]]);
  assert.equal(stampOf(sheet(), 3, 0, 3).x.length, 0);
});

test("pressed on nothing it is as it was drawn, and twice in a place the same where it is opaque", () => {
  const layer = raster(5, 5);
  const stamp = stampOf(sheet(), 0, 0, 3);
  press(layer, stamp, 2, 2);
  press(layer, stamp, 2, 2);
  assert.deepEqual(pixelAt(layer, 2, 2), [200, 0, 0, 255]);
  assert.deepEqual(pixelAt(layer, 1, 2), [0, 0, 0, 0]);
});

test("a weak edge lets through what lies below", () => {
  const layer = raster(5, 5);
  layer.data.fill(100);
  for (let at = 3; at < layer.data.length; at += 4) layer.data[at] = 255;
  press(layer, stampOf(sheet(), 0, 0, 3), 2, 2);
  assert.deepEqual(pixelAt(layer, 3, 2), [120, 80, 80, 255]);
});

test("what lies outside of the layer is left out, and does not come in on the other side", () => {
  const layer = raster(4, 2);
  const stamp = stampOf(sheet(), 0, 0, 3);
  press(layer, stamp, 3, 0);
  press(layer, stamp, 0, -1);
  press(layer, stamp, 1, 2);
  press(layer, stamp, -1, 1);
  assert.deepEqual(pixelAt(layer, 3, 0), [200, 0, 0, 255]);
  // Of the last one only the weak edge is in the layer.
  assert.deepEqual(pixelAt(layer, 0, 1), [200, 0, 0, 51]);
  assert.equal(layer.data.filter((value) => value > 0).length, 4);
});
