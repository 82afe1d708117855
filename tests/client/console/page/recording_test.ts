import assert from "node:assert/strict";
import { test } from "node:test";
import { create, fromBinary, toBinary } from "@bufbuild/protobuf";
import {
  LocalizationResultSchema,
  LocalizationState,
  LocalizeResponseSchema,
} from "proto/dcloc/v1/localization_service_pb.ts";
import {
  type RecordedScan,
  RecordedScanSchema,
  RecordingEntrySchema,
  RecordingHeaderSchema,
} from "proto/dcloc/v1/recording_pb.ts";
import { crc32 } from "../../../../client/console/page/recording/crc32.ts";
import {
  NoRecording,
  readRecording,
  writeRecording,
} from "../../../../client/console/page/recording/file.ts";
import { Recording } from "../../../../client/console/page/recording/recording.ts";

const HEADER = create(RecordingHeaderSchema, {
  program: "test 1",
  open: { vehicleId: "car-1", resumeToken: "secret" },
  opened: { mapName: "town", mapVersion: 3n, resumeToken: "secret" },
});

function recordedScan(stampMs: number, state: LocalizationState): RecordedScan {
  const result = create(LocalizationResultSchema, {
    state,
    pose: {
      pose: { translationM: { x: stampMs, y: 0, z: 0 }, rotation: { w: 1, x: 0, y: 0, z: 0 } },
      covariance: new Array<number>(36).fill(0),
    },
  });
  return create(RecordedScanSchema, {
    scan: { stampNs: BigInt(stampMs) * 1_000_000n, radarId: "front", rangeM: [1, 2] },
    answer: create(LocalizeResponseSchema, { message: { case: "result", value: result } }),
  });
}

function recordingOf(scans: RecordedScan[]): Recording {
  const recording = new Recording();
  recording.header = HEADER;
  for (const value of scans) {
    const entry = create(RecordingEntrySchema, { entry: { case: "scan", value } });
    recording.takeScan(value, toBinary(RecordingEntrySchema, entry));
  }
  recording.ending = { reason: "the session ended" };
  return recording;
}

const { TRACKING, LOST } = LocalizationState;
const SCANS = [
  recordedScan(1000, TRACKING),
  recordedScan(1100, TRACKING),
  recordedScan(1200, LOST),
  recordedScan(1300, LOST),
];

function fileOf(recording: Recording): Uint8Array {
  return Buffer.concat(writeRecording(recording, HEADER));
}

async function read(bytes: Uint8Array): Promise<Recording> {
  const recording = new Recording();
  await readRecording(bytes, recording, () => undefined, new AbortController().signal);
  return recording;
}

test("the checksum is that of zlib", () => {
  assert.equal(crc32(0, new TextEncoder().encode("123456789")), 0xcbf43926);
  const half = crc32(0, new TextEncoder().encode("12345"));
  assert.equal(crc32(half, new TextEncoder().encode("6789")), 0xcbf43926);
});

test("what is written is read again, without secrets", async () => {
  const again = await read(fileOf(recordingOf(SCANS)));
  assert.deepEqual(again.ending, { reason: "the session ended" });
  assert.equal(again.scanCount, 4);
  assert.equal(again.header!.formatVersion, 2);
  assert.equal(again.header!.open!.vehicleId, "car-1");
  assert.equal(again.header!.open!.resumeToken + again.header!.opened!.resumeToken, "");
  assert.deepEqual(
    again.bands.states.map(({ beginMs, endMs, value }) => [beginMs, endMs, value]),
    [
      [0, 200, TRACKING],
      [200, 300, LOST],
    ],
  );
  assert.deepEqual(
    again.samplesIn(0, 200).map(({ x }) => x),
    [1100, 1200],
  );
});

test("a file cut off anywhere is told as such, and what was whole is there", async () => {
  const bytes = fileOf(recordingOf(SCANS));
  const sizes = new Set<number>();
  for (let size = 0; size < bytes.length; ++size) {
    try {
      const { ending, scanCount } = await read(bytes.slice(0, size));
      assert.match(ending!.fault!, /^cut_off \d+$/, `${size} bytes`);
      sizes.add(scanCount);
    } catch (error) {
      assert.ok(error instanceof NoRecording, `${size} bytes: ${String(error)}`);
      assert.equal(sizes.size, 0, "once the header is there, the rest is shown");
    }
  }
  assert.deepEqual([...sizes], [0, 1, 2, 3, 4]);
});

test("a byte changed anywhere is never taken for a whole recording", async () => {
  const bytes = fileOf(recordingOf(SCANS));
  for (let at = 0; at < bytes.length; ++at) {
    const changed = bytes.slice();
    changed[at] = changed[at]! ^ 0x41;
    try {
      const { ending } = await read(changed);
      assert.ok(ending!.fault, `byte ${at}`);
    } catch (error) {
      assert.ok(error instanceof NoRecording, `byte ${at}: ${String(error)}`);
    }
  }
});

test("other files, newer ones, and ones that go on are refused or told by name", async () => {
  const reasonOf = (bytes: Uint8Array) =>
    read(bytes).then(
      ({ ending }) => ending!.fault?.split(" ")[0],
      (error: NoRecording) => error.reason,
    );
  assert.equal(await reasonOf(new Uint8Array(0)), "not_one");
  assert.equal(await reasonOf(Buffer.from("PK\u0003\u0004 something else")), "not_one");
  const whole = fileOf(recordingOf(SCANS));
  assert.equal(await reasonOf(Buffer.concat([whole, Buffer.from([1])])), "goes_on");
  const newer = toBinary(RecordingHeaderSchema, create(RecordingHeaderSchema, { formatVersion: 3 }));
  const magic = Buffer.from("DCLOCREC");
  assert.equal(await reasonOf(Buffer.concat([magic, Buffer.from([newer.length]), newer])), "newer");
  const huge = Buffer.from([0xff, 0xff, 0xff, 0xff, 0x7f]);
  assert.equal(await reasonOf(Buffer.concat([magic, huge])), "damaged");
});

test("time goes on with the stamps, and a clock that was set makes no gap", async () => {
  const stamps = [5000, 5100, 5050, 9_000_000, 9_000_100, 1000, 1100];
  const recording = recordingOf(stamps.map((stamp) => recordedScan(stamp, TRACKING)));
  assert.deepEqual(
    recording.steps.map(({ timeMs }) => timeMs),
    [0, 100, 100, 100, 200, 200, 300],
  );
  const dropped = create(RecordedScanSchema, { scan: { sequenceNumber: 9n } });
  recording.takeScan(dropped, new Uint8Array(0));
  assert.equal(recording.durationMs, 300);
});

test("an entry is kept as it came, with fields that this page does not know", () => {
  const recording = recordingOf(SCANS);
  const unknown = Uint8Array.of(...toBinary(RecordedScanSchema, SCANS[0]!), 0xfa, 0x3f, 1, 7);
  const entry = { case: "scan" as const, value: fromBinary(RecordedScanSchema, unknown) };
  const bytes = toBinary(RecordingEntrySchema, create(RecordingEntrySchema, { entry }));
  recording.takeScan(entry.value, bytes);
  const file = Buffer.from(fileOf(recording));
  assert.ok(file.includes(Buffer.from([0xfa, 0x3f, 1, 7])));
});

test("what a hostile file says without end is cut short", () => {
  const message = "x".repeat(1 << 20);
  const rejected = { case: "rejected" as const, value: { message, code: 3, sequenceNumber: 1n } };
  const answer = create(LocalizeResponseSchema, { message: rejected });
  const recording = recordingOf([create(RecordedScanSchema, { scan: { stampNs: 1n }, answer })]);
  assert.ok(recording.rejections[0]!.message.length < 300);
});
