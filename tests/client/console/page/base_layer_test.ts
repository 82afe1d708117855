import assert from "node:assert/strict";
import { test } from "node:test";
import { BaseLayer } from "../../../../client/console/page/map/base_layer.ts";
import { Camera } from "../../../../client/console/page/map/camera.ts";

class FakeCanvas {
  readonly copied: unknown[] = [];
  constructor(
    public width: number,
    public height: number,
  ) {}
  getContext() {
    return { drawImage: (image: unknown) => this.copied.push(image) };
  }
}

/** A layer on a canvas, and what it did: `paint` or `copy` for each time it was drawn. */
function layer() {
  Object.assign(globalThis, { OffscreenCanvas: FakeCanvas });
  const done: string[] = [];
  const made = new BaseLayer();
  const camera = new Camera();
  const context = {
    canvas: new FakeCanvas(800, 600),
    save: () => undefined,
    restore: () => undefined,
    resetTransform: () => undefined,
    drawImage: () => done.push("copy"),
  } as unknown as CanvasRenderingContext2D;
  const draw = (look = "dark"): void => made.draw(context, camera, look, () => done.push("paint"));
  return { made, camera, draw, done, canvas: context.canvas };
}

test("a view that stays is painted twice, and copied from then on", () => {
  const { draw, done } = layer();
  for (let i = 0; i < 5; ++i) draw();
  assert.deepEqual(done, ["paint", "paint", "copy", "copy", "copy"]);
});

test("a view that moves is painted each time", () => {
  const { draw, done, camera } = layer();
  for (let i = 0; i < 4; ++i) {
    camera.pan(3, 0);
    draw();
  }
  assert.deepEqual(done, ["paint", "paint", "paint", "paint"]);
});

test("other tiles, other colours and another size are painted anew", () => {
  const { made, draw, done, canvas } = layer();
  const changes = [() => made.invalidate(), () => (canvas.width = 400)];
  for (let i = 0; i < 3; ++i) draw();
  for (const change of changes) {
    change();
    for (let i = 0; i < 3; ++i) draw();
  }
  assert.deepEqual(done, ["paint", "paint", "copy", "paint", "paint", "copy", "paint", "paint", "copy"]);
  draw("light");
  assert.equal(done.at(-1), "paint");
});
