import { useMemo } from "preact/hooks";
import { t } from "../texts/texts.ts";
import { Chart, type Line } from "./chart.tsx";
import type { History } from "./history.ts";

interface Panel {
  title: string;
  lines: Line[];
  mark?: number;
}

function panels(): Panel[] {
  return [
    {
      title: t("chart_sigma"),
      lines: [{ label: "σ", colour: 1, value: (s) => s.sigmaM }],
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
    },
    {
      title: t("chart_latency"),
      lines: [
        { label: t("total"), colour: 1, value: (s) => s.totalMs },
        { label: t("registration"), colour: 2, value: (s) => s.registrationMs },
        { label: t("queue"), colour: 3, value: (s) => s.queueMs },
      ],
    },
  ];
}

/** The time lines of a session, under one cursor. */
export function SessionCharts({ history, tick }: { history: History; tick: number }) {
  const shown = useMemo(panels, [t("chart_sigma")]);
  const nowMs = performance.now();
  return (
    <div class="charts">
      {shown.map((panel) => (
        <Chart key={panel.title} {...panel} samples={history.samples} nowMs={nowMs} tick={tick} />
      ))}
    </div>
  );
}
