import type { Health, SourceHealth } from "proto/dcloc/v1/localization_service_pb.ts";

export const STATE_BAND = "state";
export const FIX_BAND = "fixes";
export const WHEEL_BAND = "wheel_speed";
export const YAW_RATE_BAND = "yaw_rate";
/** Before the name of a radar, so that none is taken for another band. */
const RADAR_PREFIX = "radar:";

/** Nothing said for so long is a hole in a band. */
const HOLE_MS = 2_000;
/** A band forgets its oldest segments beyond so many. */
const MAX_SEGMENT_COUNT = 5_000;
const MAX_BAND_COUNT = 40;

/** A value that was told again and again in this time. */
export interface Segment {
  beginMs: number;
  endMs: number;
  /** A LocalizationState; a FixUse; of a source what `sourceValue` gives. */
  value: number;
}

export interface Band {
  name: string;
  kind: "state" | "source" | "fix";
  segments: Segment[];
}

/** The fault of a source, and in the last bit whether it takes part. */
export const sourceValue = ({ used, fault }: Pick<SourceHealth, "used" | "fault">): number =>
  2 * fault + (used ? 1 : 0);

export const isUsed = (value: number): boolean => value % 2 === 1;
export const faultOf = (value: number): number => Math.floor(value / 2);

/** States over time: of a session and of its sources, as segments of equal value. */
export class Bands {
  private readonly bands = new Map<string, Band>();

  /** The state first, then the sources in the order in which they were told. */
  get all(): Band[] {
    return [...this.bands.values()];
  }

  get states(): readonly Segment[] {
    return this.bands.get(STATE_BAND)?.segments ?? [];
  }

  take(timeMs: number, state: number, health: Health | undefined): void {
    this.add(STATE_BAND, "state", timeMs, state);
    if (!health) return;
    const { wheelSpeed, yawRate, radars } = health;
    if (wheelSpeed) this.add(WHEEL_BAND, "source", timeMs, sourceValue(wheelSpeed));
    if (yawRate) this.add(YAW_RATE_BAND, "source", timeMs, sourceValue(yawRate));
    for (const radar of radars) {
      this.add(RADAR_PREFIX + radar.radarId, "source", timeMs, sourceValue(radar));
    }
  }

  add(name: string, kind: Band["kind"], timeMs: number, value: number): void {
    let band = this.bands.get(name);
    if (!band) {
      if (this.bands.size >= MAX_BAND_COUNT) return;
      band = { name, kind, segments: [] };
      this.bands.set(name, band);
    }
    const { segments } = band;
    const last = segments[segments.length - 1];
    const isHole = last && timeMs - last.endMs > HOLE_MS;
    if (last && !isHole) last.endMs = timeMs;
    if (last?.value === value && !isHole) return;
    segments.push({ beginMs: timeMs, endMs: timeMs, value });
    if (segments.length > MAX_SEGMENT_COUNT) segments.splice(0, MAX_SEGMENT_COUNT / 10);
  }
}

export const radarOf = (bandName: string): string => bandName.slice(RADAR_PREFIX.length);
