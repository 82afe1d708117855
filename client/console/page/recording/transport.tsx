import { clock, decimals, t } from "../texts/texts.ts";
import { type Player, SPEEDS } from "./player.ts";
import type { Recording } from "./recording.ts";

const SEEK_MS = 1_000;

/** Does something with the player, and shows what came of it. */
export type Act = (change: () => void) => void;

/** To the next scan or fix, or the one before. */
function step(player: Player, recording: Recording, direction: 1 | -1): void {
  const { steps, durationMs } = recording;
  player.isPlaying = false;
  const after = recording.countUntil(player.positionMs);
  if (direction > 0) return player.seek(steps[after]?.timeMs ?? durationMs, durationMs);
  let before = after - 1;
  while (before >= 0 && steps[before]!.timeMs >= player.positionMs) --before;
  player.seek(steps[before]?.timeMs ?? 0, durationMs);
}

/** What keys do anywhere on the page, but where something is typed or chosen. */
export function keyAction(event: KeyboardEvent, player: Player, recording: Recording, act: Act): void {
  const target = event.target as Element;
  if (event.ctrlKey || event.metaKey || event.altKey) return;
  if (/^(INPUT|SELECT|TEXTAREA|CANVAS)$/.test(target.tagName)) return;
  const { durationMs } = recording;
  const far = event.shiftKey ? 10 : 1;
  const actions: Record<string, () => void> = {
    ArrowLeft: () => player.seek(player.positionMs - far * SEEK_MS, durationMs),
    ArrowRight: () => player.seek(player.positionMs + far * SEEK_MS, durationMs),
    Home: () => player.seek(0, durationMs),
    End: () => player.seek(durationMs, durationMs),
    ",": () => step(player, recording, -1),
    ".": () => step(player, recording, 1),
    "+": () => player.changeSpeed(1),
    "-": () => player.changeSpeed(-1),
  };
  // A button that has the focus takes the space bar itself.
  if (target.tagName !== "BUTTON" && target.tagName !== "SUMMARY") {
    actions[" "] = () => player.toggle(durationMs);
  }
  const action = actions[event.key];
  if (!action) return;
  event.preventDefault();
  act(action);
}

interface Props {
  player: Player;
  recording: Recording;
  act: Act;
}

/** Play, pause, steps, speed, and where it is. */
export function Transport({ player, recording, act }: Props) {
  const { durationMs } = recording;
  const isGrowing = recording.ending === undefined;
  return (
    <div class="transport" role="group" aria-label={t("replay")}>
      <button
        class="primary"
        onClick={() => act(() => player.toggle(durationMs))}
        aria-label={t(player.isPlaying ? "pause" : "play")}
        title={t(player.isPlaying ? "pause" : "play")}
      >
        {player.isPlaying ? "❚❚" : "▶"}
      </button>
      <button
        onClick={() => act(() => step(player, recording, -1))}
        aria-label={t("step_back")}
        title={t("step_back")}
      >
        ‹
      </button>
      <button
        onClick={() => act(() => step(player, recording, 1))}
        aria-label={t("step_on")}
        title={t("step_on")}
      >
        ›
      </button>
      <output>
        {clock(player.positionMs)} / {clock(durationMs)}
      </output>
      <select
        aria-label={t("speed")}
        value={player.speed}
        onChange={(event) => {
          const speed = Number(event.currentTarget.value);
          act(() => (player.speed = speed));
        }}
      >
        {SPEEDS.map((speed) => (
          <option key={speed} value={speed}>
            {decimals(speed, speed < 1 ? 2 : 0)}×
          </option>
        ))}
      </select>
      {isGrowing && (
        <button aria-pressed={player.isFollowing} onClick={() => act(() => player.follow())}>
          {t("live")}
        </button>
      )}
      <span class="hint">{t("replay_keys")}</span>
    </div>
  );
}
