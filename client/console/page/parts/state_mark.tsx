import { numbered, t } from "../texts/texts.ts";

/** A sign's shape tells the state to who does not see its colour. */
const SHAPES = ["M3 8h10", "M8 3v5l3 2", "M3.500 8.500l3 3 6-7", "M3 8h2m2 0h2m2 0h2", "M4 4l8 8m0-8l-8 8"];

/** The words for a state of the contract. */
export const stateName = (state: number): string =>
  numbered("state_", state, t("state_unknown", { state }));

export function StateMark({ state, label = true }: { state: number; label?: boolean }) {
  const name = stateName(state);
  return (
    <span class={`state state-${state}`}>
      <svg viewBox="0 0 16 16" width="16" height="16" aria-hidden={label} role="img">
        {!label && <title>{name}</title>}
        <circle cx="8" cy="8" r="8" fill="currentColor" />
        <path d={SHAPES[state] ?? SHAPES[0]} class="state-sign" />
      </svg>
      {label && <span>{name}</span>}
    </span>
  );
}
