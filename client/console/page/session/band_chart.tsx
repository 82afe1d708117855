import type { ComponentChildren } from "preact";
import { useEffect, useRef } from "preact/hooks";
import { FixUse, SourceFault } from "proto/dcloc/v1/localization_service_pb.ts";
import { type Palette, readPalette } from "../map/palette.ts";
import { State } from "../map/fleet.ts";
import { stateName } from "../parts/state_mark.tsx";
import { shownName } from "../texts/shortened.ts";
import { clock, decimals, numbered, t } from "../texts/texts.ts";
import {
  type Band,
  FIX_BAND,
  STATE_BAND,
  type Segment,
  WHEEL_BAND,
  YAW_RATE_BAND,
  faultOf,
  isUsed,
  radarOf,
} from "./bands.ts";

const ROW_PX = 22;
const BAR_PX = 14;

export function bandName({ name }: Band): string {
  switch (name) {
    case STATE_BAND:
      return t("state");
    case FIX_BAND:
      return t("position_fixes");
    case WHEEL_BAND:
      return t("wheel_speed");
    case YAW_RATE_BAND:
      return t("yaw_rate");
    default:
      return shownName(radarOf(name));
  }
}

/** What a segment says, in words. */
export function segmentText(kind: Band["kind"], value: number): string {
  if (kind === "state") return stateName(value);
  if (kind === "fix") return numbered("fix_use_", value, t("unknown_value", { value }));
  const fault = faultOf(value);
  const words = t(isUsed(value) ? "used" : "set_aside");
  if (fault <= SourceFault.NONE) return words;
  return `${words}, ${numbered("fault_", fault, t("unknown_value", { value: fault }))}`;
}

const FIX_STATES: Partial<Record<number, State>> = {
  [FixUse.FUSED]: State.Tracking,
  [FixUse.GUIDES_SEARCH]: State.Initializing,
  [FixUse.CONTRADICTED]: State.DeadReckoning,
};

/** The state whose colour stands for a segment. */
function colourState(kind: Band["kind"], value: number): number {
  if (kind === "state") return value;
  if (kind === "fix") return FIX_STATES[value] ?? State.Lost;
  if (!isUsed(value)) return State.Lost;
  return faultOf(value) <= SourceFault.NONE ? State.Tracking : State.DeadReckoning;
}

function drawBand(
  context: CanvasRenderingContext2D,
  palette: Palette,
  { kind, segments }: Band,
  top: number,
  toPx: (timeMs: number) => number,
  width: number,
): void {
  for (const { beginMs, endMs, value } of segments) {
    const left = Math.max(0, toPx(beginMs));
    const right = Math.min(width, toPx(endMs));
    if (right < 0 || left > width) continue;
    context.fillStyle = palette.states[colourState(kind, value)] ?? palette.states[0]!;
    context.fillRect(left, top, Math.max(1.5, right - left), BAR_PX);
  }
}

interface Props {
  bands: readonly Band[];
  beginMs: number;
  endMs: number;
  /** Where it is played. */
  positionMs?: number;
  onSeek?: (timeMs: number) => void;
  tick: number;
  children?: ComponentChildren;
}

/** States over time: bands of a session and its sources, under which a recording is wound. */
export function BandChart({ bands, beginMs, endMs, positionMs, onSeek, tick, children }: Props) {
  const canvas = useRef<HTMLCanvasElement>(null);
  const height = ROW_PX * Math.max(1, bands.length);
  const spanMs = Math.max(1, endMs - beginMs);
  const draw = (): void => {
    const element = canvas.current!;
    const ratio = window.devicePixelRatio || 1;
    const width = element.clientWidth;
    element.width = Math.round(width * ratio);
    element.height = Math.round(height * ratio);
    const context = element.getContext("2d")!;
    context.scale(ratio, ratio);
    const palette = readPalette();
    const toPx = (timeMs: number): number => ((timeMs - beginMs) / spanMs) * width;
    bands.forEach((band, i) => {
      drawBand(context, palette, band, i * ROW_PX + (ROW_PX - BAR_PX) / 2, toPx, width);
    });
    if (positionMs === undefined) return;
    context.fillStyle = palette.ink;
    context.fillRect(Math.min(width - 2, Math.max(0, toPx(positionMs) - 1)), 0, 2, height);
  };
  useEffect(draw, [tick, positionMs, beginMs, endMs, height]);
  const latest = useRef(draw);
  latest.current = draw;
  useEffect(() => {
    const resizing = new ResizeObserver(() => latest.current());
    resizing.observe(canvas.current!);
    return () => resizing.disconnect();
  }, []);
  const seekTo = (event: PointerEvent): void => {
    const { left, width } = canvas.current!.getBoundingClientRect();
    onSeek?.(beginMs + ((event.clientX - left) / Math.max(1, width)) * spanMs);
  };
  const summary = summaryOf(bands, beginMs, endMs);
  const role = onSeek
    ? {
        role: "slider" as const,
        tabIndex: 0,
        "aria-label": t("time_line"),
        "aria-valuemin": 0,
        "aria-valuemax": Math.round(spanMs / 1000),
        "aria-valuenow": Math.round(((positionMs ?? 0) - beginMs) / 1000),
        "aria-valuetext": clock((positionMs ?? 0) - beginMs),
        onPointerDown: (event: PointerEvent) => {
          (event.currentTarget as Element).setPointerCapture(event.pointerId);
          seekTo(event);
        },
        onPointerMove: (event: PointerEvent) => event.buttons === 1 && seekTo(event),
      }
    : { role: "img" as const, "aria-label": `${t("states_over_time")}: ${summary}` };
  return (
    <section class="bands" aria-label={t("states_over_time")}>
      <div class="bands-head">
        <h2>{t("states_over_time")}</h2>
        <span class="soft">{summary}</span>
      </div>
      <div class="band-grid">
        <ul class="band-names">
          {bands.map((band) => (
            <li key={band.name} title={bandName(band)}>
              {bandName(band)}
            </li>
          ))}
        </ul>
        <div class={onSeek ? "band-bars seekable" : "band-bars"} {...role}>
          <canvas ref={canvas} style={{ height: `${height}px` }} />
        </div>
      </div>
      {children}
    </section>
  );
}

/** The share of the time in each state. */
function summaryOf(bands: readonly Band[], beginMs: number, endMs: number): string {
  const states = bands.find(({ kind }) => kind === "state")?.segments ?? [];
  const sums = new Map<number, number>();
  let total = 0;
  for (const segment of states) {
    const length = Math.min(endMs, segment.endMs) - Math.max(beginMs, segment.beginMs);
    if (length <= 0) continue;
    total += length;
    sums.set(segment.value, (sums.get(segment.value) ?? 0) + length);
  }
  return [...sums]
    .sort((a, b) => b[1] - a[1])
    .map(([state, length]) => `${stateName(state)} ${decimals((100 * length) / total, 1)} %`)
    .join(" · ");
}

const MAX_CHANGE_COUNT = 100;

interface ChangesProps {
  segments: readonly Segment[];
  /** What times are counted from. */
  originMs: number;
  onSeek?: (timeMs: number) => void;
}

/** The last changes of state in words, for who does not see bands. */
export function StateChanges({ segments, originMs, onSeek }: ChangesProps) {
  const shown = segments.slice(-MAX_CHANGE_COUNT);
  return (
    <details class="changes">
      <summary>{t("state_changes")}</summary>
      <ol>
        {shown.map(({ beginMs, endMs, value }) => {
          const text = t("state_change", {
            time: clock(beginMs - originMs),
            state: stateName(value),
            seconds: decimals((endMs - beginMs) / 1000, 1),
          });
          return (
            <li key={beginMs}>
              {onSeek ? (
                <button class="quiet" onClick={() => onSeek(beginMs)}>
                  {text}
                </button>
              ) : (
                text
              )}
            </li>
          );
        })}
      </ol>
    </details>
  );
}
