import type { ComponentChildren } from "preact";
import { shortened, shownName } from "../texts/shortened.ts";
import { t } from "../texts/texts.ts";
import { type CallFailure, Code } from "../wire/failure.ts";

interface NoticeProps {
  title: string;
  children?: ComponentChildren;
  kind?: "plain" | "alarm";
}

/** What stands where there is nothing to show. */
export function Notice({ title, children, kind = "plain" }: NoticeProps) {
  return (
    <div class={`notice ${kind}`} role={kind === "alarm" ? "alert" : "status"}>
      <h2>{shownName(title)}</h2>
      {children}
    </div>
  );
}

function wordsOf(failure: CallFailure): { title: string; text: string } {
  switch (failure.code) {
    case Code.Unavailable:
      return { title: t("cut_title"), text: failure.message || t("cut_text") };
    case Code.PermissionDenied:
      return { title: t("denied_title"), text: t("denied_text", { message: failure.message }) };
    case Code.NotFound:
      return { title: t("not_found_title"), text: failure.message };
    case Code.Unimplemented:
      return { title: t("failed_title"), text: t("older_server") };
    default:
      return { title: t("failed_title"), text: failure.message };
  }
}

/** A call that failed, in a sentence. */
export function failureText({ code, message }: CallFailure): string {
  if (code === Code.PermissionDenied) return t("denied_text", { message });
  if (code === Code.Unimplemented) return t("older_server");
  return message || t("cut_text");
}

/** A call that failed, in words, with what can be done. */
export function FailureNotice({ failure, retry }: { failure: CallFailure; retry?: () => void }) {
  const { title, text } = wordsOf(failure);
  return (
    <Notice title={title} kind="alarm">
      <p>{shortened(text, 1000)}</p>
      {retry && <button onClick={retry}>{t("try_again")}</button>}
    </Notice>
  );
}

export function Loading() {
  return (
    <div class="loading" role="status">
      <span class="spinner" aria-hidden="true" /> {t("loading")}
    </div>
  );
}
