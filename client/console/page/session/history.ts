import type { WatchSessionResponse } from "proto/dcloc/v1/admin_service_pb.ts";
import type { Health, LocalizationResult } from "proto/dcloc/v1/localization_service_pb.ts";
import { Bands } from "./bands.ts";

const NS_PER_MS = 1e6;
/** Some five minutes of a vehicle with five radars. */
const MAX_LENGTH = 20_000;

/** A scan's way through the server, in this order. */
export const STAGES = [
  "queue",
  "conversion",
  "compensation",
  "submap",
  "registration",
  "posegraph",
] as const;
export type Stage = (typeof STAGES)[number];

/** What a stage took of an answer. */
export const stageMs = (sample: Sample, stage: Stage): number =>
  sample.stagesMs[STAGES.indexOf(stage)] ?? 0;

/** One answer, in the figures that the page shows. */
export interface Sample {
  /** When it came, on the page's clock. */
  timeMs: number;
  state: number;
  x: number;
  y: number;
  yaw: number;
  /** Covariance of x and y, m^2. */
  xx: number;
  xy: number;
  yy: number;
  /** Largest standard deviation of the position in the plane. */
  sigmaM: number;
  /** What the position in the plane is off by at most, but for once in 10,000 times; NaN: not promised. */
  protectionM: number;
  points: number;
  inliers: number;
  overlap: number;
  residual: number;
  edge: number;
  edgeValid: boolean;
  /** Whether a registration of this very scan came about: a search may have found no place. */
  isRegistered: boolean;
  /** What each stage of STAGES took, and all together. */
  stagesMs: readonly number[];
  totalMs: number;
  version: number;
  resets: number;
  betaErrorS: number;
  betaIsWrong: boolean;
}

export interface Rejection {
  timeMs: number;
  message: string;
}

export function sampleOf(result: LocalizationResult, timeMs: number): Sample | undefined {
  const translation = result.pose?.pose?.translationM;
  const rotation = result.pose?.pose?.rotation;
  const covariance = result.pose?.covariance ?? [];
  const { quality, timings } = result;
  if (!translation || !rotation || covariance.length !== 36) return undefined;
  const [xx, xy, yy] = [covariance[0]!, covariance[1]!, covariance[7]!];
  const { w, x, y, z } = rotation;
  return {
    timeMs,
    state: result.state,
    x: translation.x,
    y: translation.y,
    yaw: Math.atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z)),
    xx,
    xy,
    yy,
    sigmaM: Math.sqrt(Math.max(0, (xx + yy) / 2 + Math.hypot((xx - yy) / 2, xy))),
    protectionM: result.protectionLevelM ?? Number.NaN,
    points: quality?.livePointCount ?? 0,
    inliers: quality?.inlierCount ?? 0,
    overlap: quality?.overlap ?? 0,
    residual: quality?.residualScale ?? 0,
    edge: quality?.edgeDistance ?? 0,
    edgeValid: quality?.edgeValid ?? false,
    isRegistered: (timings?.registrationDurationNs ?? 0n) > 0n && (quality?.inlierCount ?? 0) > 0,
    stagesMs: STAGES.map((stage) => Number(timings?.[`${stage}DurationNs`] ?? 0n) / NS_PER_MS),
    totalMs: Number(timings?.totalDurationNs ?? 0n) / NS_PER_MS,
    version: Number(result.mapVersion),
    resets: Number(result.resets?.count ?? 0n),
    betaErrorS: quality?.betaErrorS ?? 0,
    betaIsWrong: quality?.betaIsWrong ?? false,
  };
}

/** The last answers of a session. */
export class History {
  samples: Sample[] = [];
  rejections: Rejection[] = [];
  readonly bands = new Bands();
  health: Health | undefined;
  missed = 0;

  take(message: WatchSessionResponse, timeMs: number): void {
    const answer = message.answer?.message;
    this.missed = Math.max(this.missed, Number(message.missedAnswerCount));
    if (answer?.case === "rejected") {
      this.rejections = [...this.rejections.slice(-99), { timeMs, message: answer.value.message }];
    }
    if (answer?.case !== "result" || message.answer?.fromMemory) return;
    this.health = answer.value.health ?? this.health;
    this.bands.take(timeMs, answer.value.state, answer.value.health);
    const sample = sampleOf(answer.value, timeMs);
    if (!sample) return;
    this.samples.push(sample);
    // In large steps, so that not each answer moves all.
    if (this.samples.length > MAX_LENGTH * 1.1) this.samples = this.samples.slice(-MAX_LENGTH);
  }

  samplesSince(timeMs: number): Sample[] {
    let begin = this.samples.length;
    while (begin > 0 && this.samples[begin - 1]!.timeMs >= timeMs) --begin;
    return this.samples.slice(begin);
  }

  get last(): Sample | undefined {
    return this.samples[this.samples.length - 1];
  }
}
