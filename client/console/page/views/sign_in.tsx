import type { ComponentChild } from "preact";
import { useState } from "preact/hooks";
import { t } from "../texts/texts.ts";
import { type Visit, signIn } from "../wire/calls.ts";
import { Code, failureOf } from "../wire/failure.ts";

interface Props {
  wasEnded: boolean;
  onVisit: (visit: Visit) => void;
  settings: ComponentChild;
}

/** Takes a token. It goes into the body of one request, and nowhere else. */
export function SignIn({ wasEnded, onVisit, settings }: Props) {
  const [token, setToken] = useState("");
  const [fault, setFault] = useState(wasEnded ? t("signed_out_by_server") : "");
  const [isBusy, setBusy] = useState(false);
  const submit = (given: string) => (event: Event) => {
    event.preventDefault();
    setBusy(true);
    setFault("");
    signIn(given).then(onVisit, (error: unknown) => {
      const { code, message } = failureOf(error);
      setBusy(false);
      if (code === Code.Unauthenticated) setFault(t("refused"));
      else if (code === Code.Unavailable) setFault(t("unreachable_servers"));
      else setFault(message);
    });
  };
  return (
    <main class="sign-in">
      <form onSubmit={submit(token)}>
        <svg viewBox="4 2 24 22" width="48" height="44" aria-hidden="true" class="sign-in-mark">
          <path d="M5 20a14 14 0 0 1 6.500-9M27 20a14 14 0 0 0-6.500-9" class="brand-waves" />
          <path d="M16 5l7 17-7-3-7 3z" fill="currentColor" />
        </svg>
        <h1>dcloc console</h1>
        <p class="soft">{t("tagline")}</p>
        {fault && (
          <p class="fault" role="alert">
            {fault}
          </p>
        )}
        <label>
          {t("token")}
          <input
            type="password"
            autoComplete="current-password"
            autoFocus
            value={token}
            onInput={(event) => setToken(event.currentTarget.value)}
            aria-describedby="token-hint"
          />
        </label>
        <p id="token-hint" class="hint">
          {t("token_hint")}
        </p>
        <button class="primary wide" disabled={isBusy || token.trim() === ""}>
          {isBusy ? t("signing_in") : t("sign_in")}
        </button>
        <button type="button" class="wide quiet" disabled={isBusy} onClick={submit("")}>
          {t("without_token")}
        </button>
        {settings}
      </form>
    </main>
  );
}
