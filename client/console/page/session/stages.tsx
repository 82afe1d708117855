import { type TextKey, decimals, t } from "../texts/texts.ts";
import { STAGES, type Sample, type Stage } from "./history.ts";

/** Of so many answers, the last ones. */
const ANSWER_COUNT = 100;

const NAMES: Record<Stage, TextKey> = {
  queue: "queue",
  conversion: "stage_conversion",
  compensation: "stage_compensation",
  submap: "stage_submap",
  registration: "registration",
  posegraph: "stage_posegraph",
};

/** Of a stage, or of all together: half of the answers took at most `medianMs`, none more than `mostMs`. */
interface StageTimes {
  medianMs: number;
  mostMs: number;
}

function timesOf(values: number[]): StageTimes {
  const sorted = values.sort((a, b) => a - b);
  return { medianMs: sorted[Math.floor(sorted.length / 2)] ?? 0, mostMs: sorted.at(-1) ?? 0 };
}

/** The last answers' times: one entry for each stage, and the last for all together. */
export function stageTimes(samples: readonly Sample[]): StageTimes[] {
  const last = samples.slice(-ANSWER_COUNT);
  return [
    ...STAGES.map((_, i) => timesOf(last.map(({ stagesMs }) => stagesMs[i] ?? 0))),
    timesOf(last.map(({ totalMs }) => totalMs)),
  ];
}

/** Where a scan's time goes in the server. */
export function Stages({ samples }: { samples: readonly Sample[] }) {
  if (samples.length === 0) return null;
  const names = [...STAGES.map((stage) => t(NAMES[stage])), t("total")];
  return (
    <section aria-labelledby="stages">
      <h2 id="stages">{t("stages")}</h2>
      <table class="stages">
        <thead>
          <tr>
            <th scope="col">{t("stage")}</th>
            <th scope="col" class="number">
              {t("median")}
            </th>
            <th scope="col" class="number">
              {t("most")}
            </th>
          </tr>
        </thead>
        <tbody>
          {stageTimes(samples).map(({ medianMs, mostMs }, i) => (
            <tr key={names[i]}>
              <th scope="row">{names[i]}</th>
              <td class="number">{decimals(medianMs, 2)}</td>
              <td class="number">{decimals(mostMs, 2)}</td>
            </tr>
          ))}
        </tbody>
      </table>
      <p class="hint">{t("stages_hint", { count: Math.min(samples.length, ANSWER_COUNT) })}</p>
    </section>
  );
}
