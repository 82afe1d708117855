import { useMemo } from "preact/hooks";
import { decimals, t } from "../texts/texts.ts";
import { Chart, type Line } from "./chart.tsx";
import { type Sample, stageMs } from "./history.ts";

/** 95 % quantiles of the chi-square distribution: the server's gates of the edge distance. */
const PLANAR_GATE = 7.815;
const SPATIAL_GATE = 12.592;

interface Panel {
  title: string;
  lines: Line[];
  mark?: number;
  markLabel?: string;
}

function panels(isSpatial: boolean): Panel[] {
  const gate = isSpatial ? SPATIAL_GATE : PLANAR_GATE;
  return [
    {
      title: t("chart_sigma"),
      lines: [
        { label: "σ", colour: 1, value: (s) => s.sigmaM },
        { label: t("protection_level"), colour: 2, value: (s) => s.protectionM },
      ],
      mark: 2,
    },
    {
      title: t("chart_overlap"),
      lines: [{ label: "%", colour: 1, value: (s) => 100 * s.overlap }],
    },
    {
      title: t("chart_inliers"),
      lines: [
        { label: t("inliers"), colour: 1, value: (s) => s.inliers },
        { label: t("points"), colour: 2, value: (s) => s.points },
      ],
    },
    {
      title: t("chart_residual"),
      lines: [{ label: "s", colour: 1, value: (s) => s.residual }],
      mark: 1,
    },
    {
      title: t("chart_edge"),
      lines: [{ label: "d²", colour: 1, value: (s) => s.edge }],
      mark: gate,
      markLabel: t("gate", { gate: decimals(gate, 1) }),
    },
    {
      title: t("chart_latency"),
      lines: [
        { label: t("total"), colour: 1, value: (s) => s.totalMs },
        { label: t("registration"), colour: 2, value: (s) => stageMs(s, "registration") },
        { label: t("queue"), colour: 3, value: (s) => stageMs(s, "queue") },
      ],
    },
  ];
}

interface Props {
  samples: readonly Sample[];
  /** The end of the minute that is shown. */
  nowMs: number;
  /** The session is localized in space, not in the plane. */
  isSpatial: boolean;
  tick: number;
}

/** The time lines of a session, under one cursor. */
export function SessionCharts({ samples, nowMs, isSpatial, tick }: Props) {
  const shown = useMemo(() => panels(isSpatial), [t("chart_sigma"), isSpatial]);
  return (
    <div class="charts">
      {shown.map((panel) => (
        <Chart key={panel.title} {...panel} samples={samples} nowMs={nowMs} tick={tick} />
      ))}
    </div>
  );
}
