import { fromBinary } from "@bufbuild/protobuf";
import { FixUse, type Health } from "proto/dcloc/v1/localization_service_pb.ts";
import {
  type RecordedFix,
  type RecordedScan,
  type RecordingEntry,
  RecordingEntrySchema,
  type RecordingHeader,
} from "proto/dcloc/v1/recording_pb.ts";
import { Bands, FIX_BAND } from "../session/bands.ts";
import { type Rejection, type Sample, sampleOf } from "../session/history.ts";
import { shortened } from "../texts/shortened.ts";

/** Stamps further from one another say that the clock was set, not that it was silent for so long. */
const MAX_GAP_MS = 10 * 60_000;

/** A scan or a fix with its answer, at its place in the time of the recording. */
export interface Step {
  /** Since the first stamp; never less than that of the step before. */
  timeMs: number;
  /** The RecordingEntry, decoded when it is shown. */
  entry: Uint8Array;
  /** Of a scan that was answered with a pose. */
  sample?: Sample;
}

export interface RecordingEnding {
  /** Why it ended, in words. */
  reason: string;
  /** What is wrong with the recording; absent where all of it is there. */
  fault?: string;
}

/** A session as it was recorded, or as it is being recorded: the figures of all of its answers. */
export class Recording {
  header: RecordingHeader | undefined;
  readonly steps: Step[] = [];
  /** The steps that have a sample, in order. */
  readonly samples: Sample[] = [];
  readonly bands = new Bands();
  readonly rejections: Rejection[] = [];
  readonly fixUses = new Map<number, number>();
  scanCount = 0;
  fixCount = 0;
  byteCount = 0;
  ending: RecordingEnding | undefined;
  private newestMs: number | undefined;
  private elapsedMs = 0;

  get durationMs(): number {
    return this.elapsedMs;
  }

  takeScan(scan: RecordedScan, entry: Uint8Array): void {
    const timeMs = this.timeOf(scan.scan?.stampNs ?? 0n);
    const step: Step = { timeMs, entry };
    this.keep(step);
    ++this.scanCount;
    const answer = scan.answer?.message;
    if (answer?.case === "rejected") {
      this.rejections.push({ timeMs, message: shortened(answer.value.message) });
    }
    if (answer?.case !== "result") return;
    this.bands.take(timeMs, answer.value.state, answer.value.health);
    const sample = sampleOf(answer.value, timeMs);
    if (!sample) return;
    step.sample = sample;
    this.samples.push(sample);
  }

  takeFix(fix: RecordedFix, entry: Uint8Array): void {
    const timeMs = this.elapsedMs;
    this.keep({ timeMs, entry });
    ++this.fixCount;
    const use = fix.answer?.use ?? FixUse.UNSPECIFIED;
    this.fixUses.set(use, (this.fixUses.get(use) ?? 0) + 1);
    this.bands.add(FIX_BAND, "fix", timeMs, use);
  }

  /** The number of steps up to `timeMs`, with it. */
  countUntil(timeMs: number): number {
    return countUntil(this.steps, timeMs);
  }

  /** The samples of (beginMs, endMs]. */
  samplesIn(beginMs: number, endMs: number): Sample[] {
    return this.samples.slice(countUntil(this.samples, beginMs), countUntil(this.samples, endMs));
  }

  entryOf(step: Step): RecordingEntry["entry"] {
    return fromBinary(RecordingEntrySchema, step.entry).entry;
  }

  /** The health that was last told at `timeMs`. */
  healthAt(timeMs: number): Health | undefined {
    for (let i = this.countUntil(timeMs) - 1; i >= 0; --i) {
      const step = this.steps[i]!;
      if (!step.sample) continue;
      const entry = this.entryOf(step);
      const answer = entry.case === "scan" ? entry.value.answer?.message : undefined;
      return answer?.case === "result" ? answer.value.health : undefined;
    }
    return undefined;
  }

  private keep(step: Step): void {
    this.steps.push(step);
    this.byteCount += step.entry.length;
  }

  /** A late scan, one that was dropped, and one after a clock was set stand where time had come to. */
  private timeOf(stampNs: bigint): number {
    if (stampNs <= 0n) return this.elapsedMs;
    const stampMs = Number(stampNs / 1000n) / 1000;
    const gap = stampMs - (this.newestMs ?? stampMs);
    if (gap > MAX_GAP_MS || gap < -1000) {
      this.newestMs = stampMs;
    } else {
      this.newestMs = Math.max(stampMs, this.newestMs ?? stampMs);
      this.elapsedMs += Math.max(0, gap);
    }
    return this.elapsedMs;
  }
}

function countUntil(items: readonly { timeMs: number }[], timeMs: number): number {
  let [low, high] = [0, items.length];
  while (low < high) {
    const middle = (low + high) >> 1;
    if (items[middle]!.timeMs <= timeMs) low = middle + 1;
    else high = middle;
  }
  return low;
}
