import type { ComponentChildren } from "preact";
import { useEffect, useRef, useState } from "preact/hooks";
import { shortened } from "../texts/shortened.ts";
import { t } from "../texts/texts.ts";
import { type CallFailure, Code, failureOf } from "../wire/failure.ts";

interface Props {
  title: string;
  /** Of the button that does it. */
  action: string;
  isDangerous?: boolean;
  isReady?: boolean;
  onClose: () => void;
  /** Does it; what it rejects with is shown, and the dialog stays. */
  onDo: () => Promise<unknown>;
  children?: ComponentChildren;
}

/** Asks once before something is done, and says what it will do. */
export function Dialog({ title, action, isDangerous, isReady = true, onClose, onDo, children }: Props) {
  const dialog = useRef<HTMLDialogElement>(null);
  const [failure, setFailure] = useState<CallFailure>();
  const [isBusy, setBusy] = useState(false);
  useEffect(() => {
    const element = dialog.current!;
    element.showModal();
    return () => element.close();
  }, []);
  const act = (event: Event): void => {
    event.preventDefault();
    if (isBusy) return;
    setBusy(true);
    setFailure(undefined);
    onDo().then(onClose, (error: unknown) => {
      setFailure(failureOf(error));
      setBusy(false);
    });
  };
  return (
    <dialog ref={dialog} onClose={onClose} aria-labelledby="dialog-title">
      <form onSubmit={act}>
        <h2 id="dialog-title">{title}</h2>
        <div class="dialog-body">{children}</div>
        {failure && (
          <p class="fault" role="alert">
            {failure.code === Code.PermissionDenied
              ? t("denied_text", { message: failure.message })
              : shortened(failure.message, 1000) || t("cut_text")}
          </p>
        )}
        <div class="buttons">
          <button type="button" onClick={onClose}>
            {t("cancel")}
          </button>
          <button type="submit" class={isDangerous ? "danger" : "primary"} disabled={isBusy || !isReady}>
            {action}
          </button>
        </div>
      </form>
    </dialog>
  );
}
