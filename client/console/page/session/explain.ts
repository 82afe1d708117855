import { type Health, SourceFault } from "proto/dcloc/v1/localization_service_pb.ts";
import { State } from "../map/fleet.ts";
import { shortened, shownName } from "../texts/shortened.ts";
import { type TextKey, decimals, numbered, t } from "../texts/texts.ts";
import type { Rejection, Sample } from "./history.ts";

/** What the explanation looks at. */
export interface Evidence {
  samples: readonly Sample[];
  rejections: readonly Rejection[];
  health: Health | undefined;
  /** How far the last pose is outside of the map's street; 0 inside. */
  outsideM: number;
  nowMs: number;
}

/** A sentence; the cause of a trouble weighs more than its description. */
export interface Finding {
  kind: "state" | "cause" | "remark";
  text: string;
  /** Of a sentence on the state: which one. */
  state?: number;
}

/** The evidence is what came within so long before now. */
const WINDOW_MS = 5_000;
/** The state before: what is compared with. */
const BEFORE_MS = 60_000;
const FEW_POINTS = 25;
const LOW_OVERLAP = 0.4;
const BAD_RESIDUAL = 2;
const LOST_SIGMA_M = 2;
const REFUSED_SHARE = 0.3;
const SLOW_MS = 50;
const SILENT_MS = 2_000;
const OUTSIDE_M = 30;
const NEWS_MS = 60_000;

function mean(samples: readonly Sample[], value: (sample: Sample) => number): number {
  return samples.reduce((sum, sample) => sum + value(sample), 0) / Math.max(1, samples.length);
}

function quantile(samples: readonly Sample[], share: number, value: (sample: Sample) => number): number {
  const sorted = samples.map(value).sort((a, b) => a - b);
  return sorted[Math.min(sorted.length - 1, Math.floor(share * sorted.length))] ?? 0;
}

function stateFinding(samples: readonly Sample[], nowMs: number): Finding[] {
  const last = samples[samples.length - 1]!;
  const texts: Partial<Record<number, TextKey>> = {
    [State.Initializing]: "why_initializing",
    [State.Tracking]: "why_tracking",
    [State.DeadReckoning]: "why_reckoning",
    [State.Lost]: "why_lost",
  };
  const key = texts[last.state];
  const values = { overlap: decimals(100 * last.overlap, 0), sigma: decimals(last.sigmaM, 2) };
  const text = key ? t(key, values) : t("why_unknown", { state: last.state });
  const found: Finding[] = [{ kind: "state", text, state: last.state }];
  if (last.state === State.Lost) {
    let first = samples.length - 1;
    while (first > 0 && samples[first - 1]!.state === State.Lost) --first;
    const seconds = Math.round((nowMs - samples[first]!.timeMs) / 1000);
    found.push({ kind: "state", text: t("why_lost_for", { seconds }), state: last.state });
  }
  return found;
}

/** What is wrong with registrations, where the state is not TRACKING. */
function registrationCauses(recent: readonly Sample[], before: readonly Sample[]): string[] {
  const causes: string[] = [];
  const points = mean(recent, (s) => s.points);
  if (points < FEW_POINTS) causes.push(t("why_few_points", { points: Math.round(points) }));
  const overlap = mean(recent, (s) => s.overlap);
  const good = before.filter((s) => s.state === State.Tracking);
  const was = mean(good, (s) => s.overlap);
  if (overlap < LOW_OVERLAP || (good.length > 0 && overlap < 0.6 * was)) {
    const values = { overlap: decimals(100 * overlap, 0), before: decimals(100 * was, 0) };
    causes.push(t(good.length > 0 ? "why_overlap_fell" : "why_low_overlap", values));
  }
  const registered = recent.filter((s) => s.isRegistered);
  const refused = registered.filter((s) => !s.edgeValid);
  if (registered.length > 0 && refused.length >= REFUSED_SHARE * registered.length) {
    const distance = decimals(mean(refused, (s) => s.edge), 1);
    causes.push(t("why_edge", { distance, count: refused.length, total: registered.length }));
  }
  const sigma = recent[recent.length - 1]!.sigmaM;
  if (sigma > LOST_SIGMA_M) causes.push(t("why_sigma", { sigma: decimals(sigma, 1) }));
  return causes;
}

function sourceCauses(health: Health | undefined): string[] {
  if (!health) return [];
  const sources = [
    { name: t("wheel_speed"), source: health.wheelSpeed },
    { name: t("yaw_rate"), source: health.yawRate },
    ...health.radars.map((source) => ({ name: source.radarId, source })),
  ];
  return sources
    .filter(({ source }) => source && source.fault > SourceFault.NONE)
    .map(({ name, source }) => {
      const fault = numbered("fault_", source!.fault, t("unknown_value", { value: source!.fault }));
      return t("why_source", { source: shownName(name), fault });
    });
}

function changes(samples: readonly Sample[], nowMs: number): string[] {
  for (let i = samples.length - 1; i > 0 && nowMs - samples[i]!.timeMs < NEWS_MS; --i) {
    const [before, after] = [samples[i - 1]!, samples[i]!];
    if (before.version === after.version) continue;
    const seconds = Math.round((nowMs - after.timeMs) / 1000);
    return [t("why_version", { from: before.version, to: after.version, seconds })];
  }
  return [];
}

/**
 * What the data of the last seconds says of a session, in words: its state, what explains it, and what
 * is worth knowing besides. Nothing is said that no figure shows.
 */
export function explain({ samples, rejections, health, outsideM, nowMs }: Evidence): Finding[] {
  const last = samples[samples.length - 1];
  if (!last) return [];
  const recent = samples.filter((s) => last.timeMs - s.timeMs < WINDOW_MS);
  const before = samples.filter(
    (s) => last.timeMs - s.timeMs >= WINDOW_MS && last.timeMs - s.timeMs < BEFORE_MS,
  );
  const isWell = last.state === State.Tracking;
  const causes = isWell ? [] : registrationCauses(recent, before);
  causes.push(...sourceCauses(health));
  if (outsideM > OUTSIDE_M) causes.push(t("why_left_map", { distance: Math.round(outsideM) }));
  const residual = mean(recent, (s) => s.residual);
  if (residual > BAD_RESIDUAL) causes.push(t("why_residual", { scale: decimals(residual, 1) }));
  // At a wrong place, residuals say nothing of it.
  if (isWell && last.betaIsWrong) causes.push(t("why_beta", { beta: decimals(1000 * last.betaErrorS, 1) }));
  const silentMs = nowMs - last.timeMs;
  if (silentMs > SILENT_MS) {
    causes.push(t("why_silent", { seconds: Math.round(silentMs / 1000) }));
  }
  causes.push(...changes(samples, nowMs));

  const remarks: string[] = [];
  const latency = quantile(recent, 0.99, (s) => s.totalMs);
  if (latency > SLOW_MS) remarks.push(t("why_slow", { latency: Math.round(latency) }));
  const refused = rejections.filter((r) => nowMs - r.timeMs < NEWS_MS);
  if (refused.length > 0) {
    const message = shortened(refused[refused.length - 1]!.message, 400);
    remarks.push(t("why_rejected", { count: refused.length, message }));
  }
  if (last.resets > 0) remarks.push(t("why_reset", { count: last.resets }));
  if (!isWell && causes.length === 0 && last.state !== State.Initializing) {
    remarks.push(t("why_no_cause"));
  }
  return [
    ...stateFinding(samples, nowMs),
    ...causes.map((text): Finding => ({ kind: "cause", text })),
    ...remarks.map((text): Finding => ({ kind: "remark", text })),
  ];
}
