import assert from "node:assert/strict";
import { test } from "node:test";
import { Camera } from "../../../../client/console/page/map/camera.ts";
import { ellipseOf } from "../../../../client/console/page/map/draw_vehicles.ts";
import { MARGIN_M, boundsOf, levelFor, parentOf, sideOf, tilesIn } from "../../../../client/console/page/map/tile_grid.ts";

function camera(): Camera {
  const made = new Camera();
  [made.width, made.height, made.x, made.y, made.scale] = [800, 600, 100, 50, 2];
  return made;
}

test("a point goes to the screen and back, with y up", () => {
  const view = camera();
  assert.deepEqual([view.toScreenX(100), view.toScreenY(50)], [400, 300]);
  assert.ok(view.toScreenY(60) < view.toScreenY(50));
  assert.equal(view.toMapX(view.toScreenX(37)), 37);
  assert.equal(view.toMapY(view.toScreenY(-4)), -4);
});

test("zooming keeps the point under the pointer", () => {
  const view = camera();
  const before = [view.toMapX(120), view.toMapY(500)];
  view.zoom(3, 120, 500);
  assert.ok(Math.abs(view.toMapX(120) - before[0]!) < 1e-9);
  assert.ok(Math.abs(view.toMapY(500) - before[1]!) < 1e-9);
  view.zoom(1e12);
  assert.equal(view.scale, 60);
});

test("fit shows all of a rectangle", () => {
  const view = camera();
  const map = { minX: -500, maxX: 4000, minY: 10, maxY: 20 };
  view.fit(map);
  const shown = view.bounds;
  assert.ok(shown.minX < map.minX && shown.maxX > map.maxX);
  assert.ok(shown.minY < map.minY && shown.maxY > map.maxY);
});

test("no rectangle is larger than a server reads at once", () => {
  for (const scale of [0.0005, 0.01, 0.2, 3, 60]) assert.ok(sideOf(levelFor(scale)) + 2 * MARGIN_M <= 5000);
  assert.equal(levelFor(0.0005), 0);
  assert.ok(levelFor(3) > levelFor(0.2));
});

test("the tiles of a view cover it, the middle first", () => {
  const view = { minX: 10, maxX: 2000, minY: -700, maxY: 900 };
  const tiles = tilesIn(view, { minX: -1e5, maxX: 1e5, minY: -1e5, maxY: 1e5 }, 3);
  assert.equal(tiles.length, 4 * 4);
  assert.deepEqual(boundsOf(tiles[0]!), { minX: 512, maxX: 1024, minY: 0, maxY: 512 });
  const up = parentOf(tiles[0]!)!;
  assert.ok(boundsOf(up).minX <= 512 && boundsOf(up).maxX >= 1024);
});

test("tiles without map are not read, and their number is bounded", () => {
  const everything = { minX: -1e6, maxX: 1e6, minY: -1e6, maxY: 1e6 };
  assert.equal(tilesIn(everything, { minX: 0, maxX: 100, minY: 0, maxY: 100 }, 0).length, 1);
  assert.ok(tilesIn(everything, everything, 5).length <= 400);
});

test("the ellipse of a covariance holds 95 %, and turns with it", () => {
  const round = ellipseOf({ xx: 0.04, xy: 0, yy: 0.04 });
  assert.ok(Math.abs(round.major - 0.2 * 2.4477) < 1e-9);
  const along = ellipseOf({ xx: 4, xy: 0, yy: 0.01 });
  assert.equal(along.angle, 0);
  const across = ellipseOf({ xx: 0.01, xy: 0, yy: 4 });
  assert.ok(Math.abs(Math.abs(across.angle) - Math.PI / 2) < 1e-9);
  const diagonal = ellipseOf({ xx: 1, xy: 0.9, yy: 1 });
  assert.ok(Math.abs(diagonal.angle - Math.PI / 4) < 1e-9);
  // Not quite positive, as rounding makes it.
  assert.equal(ellipseOf({ xx: 1, xy: 1.0001, yy: 1 }).minor, 0);
});
