import { create, fromBinary, toBinary } from "@bufbuild/protobuf";
import {
  RecordingEntrySchema,
  type RecordingHeader,
  RecordingHeaderSchema,
} from "proto/dcloc/v1/recording_pb.ts";
import { crc32 } from "./crc32.ts";
import type { Recording, RecordingEnding } from "./recording.ts";

/** The format that is written, and the newest that is read. */
export const FORMAT_VERSION = 2;
const MAGIC = new TextEncoder().encode("DCLOCREC");
/** Of one message; far above the largest scan. */
const MAX_MESSAGE_BYTES = 64 << 20;
const MAX_VARINT_BYTES = 5;
/** The page answers in between. */
const BUSY_MS = 25;

/** Bounds of what a page holds; beyond them a recording ends, and a file is refused. */
export const MAX_RECORDING_BYTES = 256 << 20;
export const MAX_STEP_COUNT = 400_000;

/** Why a file cannot be read at all. */
export class NoRecording extends Error {
  constructor(
    readonly reason: "not_one" | "too_large" | "newer" | "damaged",
    /** Of the format, or in bytes. */
    readonly value: number,
  ) {
    super(`${reason} ${value}`);
  }
}

function sizePrefix(size: number): Uint8Array<ArrayBuffer> {
  const bytes: number[] = [];
  for (let rest = size; ; rest >>>= 7) {
    if (rest < 128) return Uint8Array.from([...bytes, rest]);
    bytes.push((rest & 127) | 128);
  }
}

/** The file that `dcloc session replay` reads, in parts. */
export function writeRecording(
  recording: Recording,
  header: RecordingHeader,
): Uint8Array<ArrayBuffer>[] {
  const parts: Uint8Array<ArrayBuffer>[] = [];
  let crc = 0;
  const write = (bytes: Uint8Array): void => {
    crc = crc32(crc, bytes);
    parts.push(bytes as Uint8Array<ArrayBuffer>);
  };
  const writeMessage = (bytes: Uint8Array): void => {
    write(sizePrefix(bytes.length));
    write(bytes);
  };
  write(MAGIC);
  writeMessage(toBinary(RecordingHeaderSchema, withoutSecrets(header)));
  for (const { entry } of recording.steps) writeMessage(entry);
  const reason = recording.ending?.reason ?? "";
  const end = {
    scanCount: BigInt(recording.scanCount),
    fixCount: BigInt(recording.fixCount),
    reason,
    crc32: BigInt(crc32(crc, new TextEncoder().encode(reason))),
  };
  const last = create(RecordingEntrySchema, { entry: { case: "end", value: end } });
  writeMessage(toBinary(RecordingEntrySchema, last));
  return parts;
}

function withoutSecrets(header: RecordingHeader): RecordingHeader {
  const copy = fromBinary(RecordingHeaderSchema, toBinary(RecordingHeaderSchema, header));
  copy.formatVersion = FORMAT_VERSION;
  if (copy.open) copy.open.resumeToken = "";
  if (copy.opened) copy.opened.resumeToken = "";
  return copy;
}

type Damage = "cut_off" | "damaged" | "end_differs" | "goes_on";

/** Reads messages behind their sizes. */
class Messages {
  at = MAGIC.length;

  constructor(readonly bytes: Uint8Array) {}

  /** The next one, or what is wrong with it; `at` then stays. */
  next(): Uint8Array | Damage {
    let size = 0;
    let begin = this.at;
    for (let i = 0; ; ++i) {
      const byte = this.bytes[begin++];
      if (byte === undefined) return "cut_off";
      if (i === MAX_VARINT_BYTES) return "damaged";
      size += (byte & 127) * 2 ** (7 * i);
      if (byte < 128) break;
    }
    if (size > MAX_MESSAGE_BYTES) return "damaged";
    if (begin + size > this.bytes.length) return "cut_off";
    this.at = begin + size;
    return this.bytes.subarray(begin, this.at);
  }
}

/**
 * Fills `recording` with a file's contents, bit by bit so that the page goes on meanwhile. What is
 * there before a damage stays: `ending.fault` then says so. Throws NoRecording where nothing can be
 * shown.
 */
export async function readRecording(
  bytes: Uint8Array,
  recording: Recording,
  onShare: (share: number) => void,
  stop: AbortSignal,
): Promise<void> {
  if (bytes.length > MAX_RECORDING_BYTES) throw new NoRecording("too_large", bytes.length);
  if (!MAGIC.every((byte, i) => bytes[i] === byte)) throw new NoRecording("not_one", 0);
  const messages = new Messages(bytes);
  recording.header = readHeader(messages);
  let crc = crc32(0, bytes.subarray(0, messages.at));
  let begin = performance.now();
  while (!recording.ending) {
    const from = messages.at;
    recording.ending = readEntry(messages, recording, crc);
    crc = crc32(crc, bytes.subarray(from, messages.at));
    if (performance.now() - begin < BUSY_MS) continue;
    onShare(messages.at / bytes.length);
    await new Promise((resolve) => setTimeout(resolve, 0));
    stop.throwIfAborted();
    begin = performance.now();
  }
}

function readHeader(messages: Messages): RecordingHeader {
  const bytes = messages.next();
  if (typeof bytes === "string") throw new NoRecording("damaged", messages.at);
  let header: RecordingHeader;
  try {
    header = fromBinary(RecordingHeaderSchema, bytes);
  } catch {
    throw new NoRecording("damaged", messages.at);
  }
  const { formatVersion } = header;
  if (formatVersion < 1 || formatVersion > FORMAT_VERSION) {
    throw new NoRecording("newer", formatVersion);
  }
  return header;
}

/** Takes one entry; gives the ending with the last one, or with one that cannot be read. */
function readEntry(
  messages: Messages,
  recording: Recording,
  crcBefore: number,
): RecordingEnding | undefined {
  const { at } = messages;
  const damaged = (damage: Damage): RecordingEnding => ({ reason: "", fault: `${damage} ${at}` });
  if (recording.steps.length >= MAX_STEP_COUNT) return { reason: "", fault: `too_long ${at}` };
  const bytes = messages.next();
  if (typeof bytes === "string") return damaged(bytes);
  try {
    const { entry } = fromBinary(RecordingEntrySchema, bytes);
    switch (entry.case) {
      case "scan":
        recording.takeScan(entry.value, bytes);
        return undefined;
      case "fix":
        recording.takeFix(entry.value, bytes);
        return undefined;
      case "end": {
        const { scanCount, fixCount, reason, crc32: told } = entry.value;
        const isWhole =
          Number(scanCount) === recording.scanCount &&
          Number(fixCount) === recording.fixCount &&
          Number(told) === crc32(crcBefore, new TextEncoder().encode(reason));
        if (!isWhole) return { ...damaged("end_differs"), reason };
        if (messages.at < messages.bytes.length) return { ...damaged("goes_on"), reason };
        return { reason };
      }
      default:
        return damaged("damaged");
    }
  } catch {
    return damaged("damaged");
  }
}
