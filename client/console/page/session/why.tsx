import { t } from "../texts/texts.ts";
import type { Finding } from "./explain.ts";

/** What the data says, in sentences. */
export function Why({ findings }: { findings: readonly Finding[] }) {
  return (
    <section class="why" aria-labelledby="why">
      <h2 id="why">{t("why")}</h2>
      {findings.length === 0 ? (
        <p class="soft">{t("waiting_answers")}</p>
      ) : (
        <ul>
          {findings.map(({ kind, text, state }) => (
            <li key={text} class={state === undefined ? kind : `${kind} is-${state}`}>
              {text}
            </li>
          ))}
        </ul>
      )}
    </section>
  );
}
