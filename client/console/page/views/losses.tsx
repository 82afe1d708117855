import { useMemo } from "preact/hooks";
import { LOSS_MEMORY_MS, type Loss } from "../map/fleet.ts";
import { worstPlace } from "../map/worst_place.ts";
import { count, t } from "../texts/texts.ts";

const MINUTE_MS = 60_000;
const MEMORY_MINUTES = LOSS_MEMORY_MS / MINUTE_MS;
const WINDOWS_MIN: readonly number[] = [5, 15, 60];
const ALARM_RADIUS_M = 50;
const ALARM_MINUTES = 10;

/** A part of the last hour. */
export interface LossWindow {
  minutes: number;
  /** Before now. */
  endMinutes: number;
}

export const WHOLE_HOUR: LossWindow = { minutes: MEMORY_MINUTES, endMinutes: 0 };

export function lossesWithin(
  losses: readonly Loss[],
  { minutes, endMinutes }: LossWindow,
  nowMs: number,
): Loss[] {
  const endMs = nowMs - endMinutes * MINUTE_MS;
  return losses.filter(({ timeMs }) => timeMs <= endMs && endMs - timeMs < minutes * MINUTE_MS);
}

/** How many vehicles got lost in each minute of the memory, the oldest first. */
export function lossesByMinute(losses: readonly Loss[], nowMs: number): number[] {
  const counts = new Array<number>(MEMORY_MINUTES).fill(0);
  for (const { timeMs } of losses) {
    const minute = MEMORY_MINUTES - 1 - Math.floor((nowMs - timeMs) / MINUTE_MS);
    if (minute >= 0 && minute < MEMORY_MINUTES) ++counts[minute]!;
  }
  return counts;
}

interface Props {
  /** Of the map that is shown. */
  losses: readonly Loss[];
  window: LossWindow;
  onWindow: (window: LossWindow) => void;
  isShown: boolean;
  onShown: (isShown: boolean) => void;
}

/** Chooses whether, and of which time, the map shows where vehicles got lost. */
export function LossPanel({ losses, window, onWindow, isShown, onShown }: Props) {
  const nowMs = performance.now();
  return (
    <div class="chip heat-panel" role="group" aria-label={t("heat")}>
      <label class="choice">
        <input type="checkbox" checked={isShown} onChange={(e) => onShown(e.currentTarget.checked)} />
        {t("heat")}
      </label>
      {isShown && losses.length > 0 && (
        <>
          <LossBars counts={lossesByMinute(losses, nowMs)} window={window} />
          <WindowChoice window={window} onWindow={onWindow} />
          <span class="soft">
            {t("losses_in_window", { count: count(lossesWithin(losses, window, nowMs).length) })}
          </span>
        </>
      )}
    </div>
  );
}

function LossBars({ counts, window }: { counts: readonly number[]; window: LossWindow }) {
  const most = Math.max(1, ...counts);
  const last = MEMORY_MINUTES - window.endMinutes;
  return (
    <div class="loss-bars" aria-hidden="true">
      {counts.map((value, minute) => (
        <span
          key={minute}
          class={minute < last && minute >= last - window.minutes ? "within" : ""}
          style={{ height: `${value === 0 ? 1 : 4 + Math.round((22 * value) / most)}px` }}
        />
      ))}
    </div>
  );
}

function WindowChoice({ window, onWindow }: Pick<Props, "window" | "onWindow">) {
  const latest = MEMORY_MINUTES - window.minutes;
  const text = window.endMinutes === 0 ? t("now") : t("minutes_ago", { minutes: window.endMinutes });
  return (
    <div class="loss-window">
      <select
        aria-label={t("loss_window")}
        value={window.minutes}
        onChange={(event) => {
          const minutes = Number(event.currentTarget.value);
          onWindow({ minutes, endMinutes: Math.min(window.endMinutes, MEMORY_MINUTES - minutes) });
        }}
      >
        {WINDOWS_MIN.map((minutes) => (
          <option key={minutes} value={minutes}>
            {t("loss_minutes", { minutes })}
          </option>
        ))}
      </select>
      {latest > 0 && (
        <input
          type="range"
          min={-latest}
          max={0}
          value={-window.endMinutes}
          aria-label={t("loss_until")}
          aria-valuetext={text}
          onInput={(event) => onWindow({ ...window, endMinutes: -event.currentTarget.valueAsNumber })}
        />
      )}
      <span class="soft">{t("loss_until_text", { time: text })}</span>
    </div>
  );
}

/** Several vehicles that got lost in one place are no fault of the vehicles. */
export function LossAlarm({ losses }: { losses: readonly Loss[] }) {
  // Anew where there are new losses, and as old ones pass by.
  const minute = Math.floor(performance.now() / MINUTE_MS);
  const worst = useMemo(
    () => worstPlace(losses, ALARM_RADIUS_M, (minute - ALARM_MINUTES) * MINUTE_MS),
    [losses, minute],
  );
  if (!worst) return null;
  return (
    <div class="alarm" role="alert">
      {t("lost_here", { count: worst.count, radius: ALARM_RADIUS_M, minutes: ALARM_MINUTES })}
    </div>
  );
}
