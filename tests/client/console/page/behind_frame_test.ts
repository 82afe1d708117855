import assert from "node:assert/strict";
import { beforeEach, test } from "node:test";
import { BehindFrame } from "../../../../client/console/page/map/behind_frame.ts";

let frames: (() => void)[] = [];
let log: string[] = [];

Object.assign(globalThis, {
  requestAnimationFrame: (run: () => void) => frames.push(run),
  cancelAnimationFrame: (number: number) => (frames[number - 1] = () => undefined),
});

beforeEach(() => {
  frames = [];
  log = [];
});

/** What a browser does for a frame: its callbacks, its painting, and then other tasks. */
async function frame(): Promise<void> {
  const due = frames;
  frames = [];
  for (const run of due) run();
  log.push("painted");
  await new Promise((resolve) => setTimeout(resolve, 5));
}

test("the work is done behind the frame, once", async () => {
  const drawing = new BehindFrame(() => log.push("drawn"));
  drawing.ask();
  drawing.ask();
  await frame();
  await frame();
  assert.deepEqual(log, ["painted", "drawn", "painted"]);
});

test("work that asks again is done behind the frame after", async () => {
  const drawing = new BehindFrame(() => {
    if (log.push("drawn") < 4) drawing.ask();
  });
  drawing.ask();
  await frame();
  await frame();
  assert.deepEqual(log, ["painted", "drawn", "painted", "drawn"]);
});

test("what is cancelled is not done, before the frame and behind it", async () => {
  const drawing = new BehindFrame(() => log.push("drawn"));
  drawing.ask();
  drawing.cancel();
  await frame();
  drawing.ask();
  for (const run of frames.splice(0)) run();
  drawing.cancel();
  await frame();
  assert.deepEqual(log, ["painted", "painted"]);
});
