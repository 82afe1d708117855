import assert from "node:assert/strict";
import { test } from "node:test";
import { LineSplitter } from "../../../../client/console/page/wire/live_stream.ts";
import { FrameReader } from "../../../../client/console/page/wire/frames.ts";

test("an empty line is a sign of life, and no frame", () => {
  assert.deepEqual(new LineSplitter().take(new TextEncoder().encode('\n{"a":1}\n\n')), ['{"a":1}']);
});

test("lines are whole wherever they are cut, within a character too", () => {
  const bytes = new TextEncoder().encode('{"a":"ä"}\n{"b":1}\n');
  for (let cut = 0; cut <= bytes.length; ++cut) {
    const splitter = new LineSplitter();
    const lines = [...splitter.take(bytes.subarray(0, cut)), ...splitter.take(bytes.subarray(cut))];
    assert.deepEqual(lines, ['{"a":"ä"}', '{"b":1}'], `cut at ${cut}`);
  }
});

test("frames are whole wherever they are cut", () => {
  const bytes = Uint8Array.of(0, 0, 0, 0, 2, 7, 8, 1, 0, 0, 0, 0, 2, 0, 0, 0, 1, 9);
  for (let cut = 0; cut <= bytes.length; ++cut) {
    const reader = new FrameReader();
    const frames = [...reader.take(bytes.slice(0, cut)), ...reader.take(bytes.slice(cut))];
    assert.deepEqual(
      frames.map(([kind, payload]) => [kind, ...payload]),
      [[0, 7, 8], [1], [2, 9]],
      `cut at ${cut}`,
    );
  }
});
