import { useEffect, useRef } from "preact/hooks";
import uPlot from "uplot";
import { readPalette } from "../map/palette.ts";
import { currentTheme } from "../theme.ts";
import type { Sample } from "./history.ts";

const SHOWN_MS = 60_000;
const HEIGHT_PX = 108;
/** More than there are pixels shows nothing more. */
const MAX_POINTS = 1_200;

export interface Line {
  label: string;
  /** Of the style sheet, --chart-N. */
  colour: 1 | 2 | 3;
  /** NaN where there is none: a gap. */
  value: (sample: Sample) => number;
}

const orGap = (value: number): number | null => (Number.isFinite(value) ? value : null);

interface Props {
  title: string;
  lines: readonly Line[];
  samples: readonly Sample[];
  nowMs: number;
  /** A value that is told by a dashed line: a gate, a bound. */
  mark?: number;
  /** Then the mark is always in view, and named. */
  markLabel?: string;
  tick: number;
}

/** The samples of the shown time, thinned. */
function shownOf(samples: readonly Sample[], nowMs: number): Sample[] {
  let first = samples.length;
  while (first > 0 && nowMs - samples[first - 1]!.timeMs < SHOWN_MS) --first;
  const shown = samples.slice(first);
  const step = Math.ceil(shown.length / MAX_POINTS);
  return step > 1 ? shown.filter((_, i) => i % step === 0) : shown;
}

function colour(name: string): string {
  return getComputedStyle(document.documentElement).getPropertyValue(name).trim();
}

/** Bands behind the lines in the colours of the states. */
function drawStates(plot: uPlot, shown: readonly Sample[]): void {
  const { ctx, bbox } = plot;
  const { states } = readPalette();
  ctx.save();
  for (let i = 0; i < shown.length; ++i) {
    const { state } = shown[i]!;
    const begin = i;
    while (i + 1 < shown.length && shown[i + 1]!.state === state) ++i;
    const left = plot.valToPos(plot.data[0]![begin]!, "x", true);
    const right = plot.valToPos(plot.data[0]![Math.min(i + 1, shown.length - 1)]!, "x", true);
    ctx.fillStyle = states[state] ?? states[0]!;
    ctx.globalAlpha = 1;
    ctx.fillRect(left, bbox.top + bbox.height - 4, Math.max(1, right - left), 4);
    if (state === 2) continue;
    ctx.globalAlpha = 0.12;
    ctx.fillRect(left, bbox.top, Math.max(1, right - left), bbox.height);
  }
  ctx.restore();
}

function drawMark(plot: uPlot, mark: number): void {
  const { ctx, bbox } = plot;
  const y = plot.valToPos(mark, "y", true);
  if (y < bbox.top || y > bbox.top + bbox.height) return;
  ctx.save();
  ctx.strokeStyle = colour("--text-soft");
  ctx.setLineDash([6, 5]);
  ctx.beginPath();
  ctx.moveTo(bbox.left, y);
  ctx.lineTo(bbox.left + bbox.width, y);
  ctx.stroke();
  ctx.restore();
}

/** A time line of the last minute. */
export function Chart({ title, lines, samples, nowMs, mark, markLabel, tick }: Props) {
  const least = markLabel ? 1.2 * (mark ?? 0) : 1e-3;
  const frame = useRef<HTMLDivElement>(null);
  const plot = useRef<uPlot>();
  const shown = useRef<Sample[]>([]);
  const theme = currentTheme();

  useEffect(() => {
    const element = frame.current!;
    const axis: uPlot.Axis = {
      stroke: colour("--text-soft"),
      font: "11px 'Inter Variable', sans-serif",
      grid: { stroke: colour("--map-grid"), width: 1 },
      ticks: { show: false },
    };
    const made = new uPlot(
      {
        width: element.clientWidth,
        height: HEIGHT_PX,
        legend: { show: false },
        cursor: { sync: { key: "session" }, y: false },
        scales: {
          x: { time: false, range: () => [-SHOWN_MS / 1000, 0] },
          y: {
            range: (_, low, high) => [Math.min(0, low ?? 0), Math.max(least, (high ?? 1) * 1.1)],
          },
        },
        axes: [
          { ...axis, size: 22, values: (_, ticks) => ticks.map((n) => `${n} s`) },
          { ...axis, size: 46 },
        ],
        series: [
          {},
          ...lines.map((line) => ({
            label: line.label,
            stroke: colour(`--chart-${line.colour}`),
            width: 1.6,
            points: { show: false },
          })),
        ],
        hooks: {
          drawClear: [(self) => drawStates(self, shown.current)],
          draw: [(self) => mark !== undefined && drawMark(self, mark)],
        },
      },
      [[], ...lines.map(() => [])],
      element,
    );
    plot.current = made;
    const resizing = new ResizeObserver(() =>
      made.setSize({ width: element.clientWidth, height: HEIGHT_PX }),
    );
    resizing.observe(element);
    return () => {
      resizing.disconnect();
      made.destroy();
    };
  }, [theme, mark]);

  useEffect(() => {
    shown.current = shownOf(samples, nowMs);
    const times = shown.current.map((sample) => (sample.timeMs - nowMs) / 1000);
    plot.current?.setData([times, ...lines.map((line) => shown.current.map((sample) => orGap(line.value(sample))))]);
  }, [tick, theme, mark]);

  const last = samples[samples.length - 1];
  return (
    <figure class="chart">
      <figcaption>
        {title}
        <span class="chart-values">
          {markLabel && <span class="soft">{markLabel}</span>}
          {lines.map((line) => (
            <span key={line.label} class={`chart-${line.colour}`}>
              {lines.length > 1 && `${line.label} `}
              {last && formatted(line.value(last))}
            </span>
          ))}
        </span>
      </figcaption>
      <div ref={frame} />
    </figure>
  );
}

function formatted(value: number): string {
  if (!Number.isFinite(value)) return "–";
  if (Math.abs(value) >= 100 || Number.isInteger(value)) return value.toFixed(0);
  return value.toPrecision(3);
}
