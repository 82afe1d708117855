import { useEffect, useRef, useState } from "preact/hooks";
import { failureText } from "../parts/notice.tsx";
import { shortened, shownName } from "../texts/shortened.ts";
import { type TextKey, t } from "../texts/texts.ts";
import type { ServerName } from "../wire/calls.ts";
import { Code, failureOf } from "../wire/failure.ts";
import { type UploadProgress, uploadMap } from "../wire/upload.ts";

const MAP_NAME = "[a-z0-9][a-z0-9_\\-]{0,62}";
const UNFINISHED = "dcloc.unfinished-upload";

interface Props {
  servers: readonly ServerName[];
  /** The map that gets the version, where it is known already. */
  map?: string;
  onClose: () => void;
  onDone: () => void;
}

const STEPS: Record<UploadProgress["step"], TextKey> = {
  hashing: "upload_hashing",
  sending: "upload_sending",
  waiting: "upload_waiting",
  checking: "upload_checking",
};

/** Takes a map file, and shows how far it is; it goes on by itself after a break. */
export function UploadDialog({ servers, map = "", onClose, onDone }: Props) {
  const dialog = useRef<HTMLDialogElement>(null);
  const [server, setServer] = useState(servers[0]?.name ?? "");
  const [name, setName] = useState(map);
  const [file, setFile] = useState<File>();
  const [activate, setActivate] = useState(false);
  const [progress, setProgress] = useState<UploadProgress>();
  const [result, setResult] = useState<{ text: string; isFault: boolean }>();
  const stop = useRef<AbortController>();
  const unfinished = localStorage.getItem(UNFINISHED);
  useEffect(() => {
    dialog.current!.showModal();
    return () => stop.current?.abort();
  }, []);

  const start = (event: Event): void => {
    event.preventDefault();
    if (!file || progress) return;
    stop.current = new AbortController();
    setResult(undefined);
    localStorage.setItem(UNFINISHED, file.name);
    const order = { server, map: name, file, activate };
    uploadMap(order, setProgress, stop.current.signal).then(
      (version) => {
        localStorage.removeItem(UNFINISHED);
        const text = t("upload_done", { map: version.mapName, version: String(version.version) });
        setResult({ text, isFault: false });
        setProgress(undefined);
        onDone();
      },
      (error: unknown) => {
        const failure = failureOf(error);
        if (failure.code === Code.Cancelled) return;
        setProgress(undefined);
        const text = shortened(failureText(failure), 1000);
        setResult({ text, isFault: true });
      },
    );
  };

  return (
    <dialog ref={dialog} onClose={onClose} aria-labelledby="upload-title">
      <form onSubmit={start}>
        <h2 id="upload-title">{t("upload_title")}</h2>
        {unfinished && !progress && !result && (
          <p class="hint">{t("upload_unfinished", { file: shownName(unfinished) })}</p>
        )}
        {servers.length > 1 && (
          <label>
            {t("server")}
            <select value={server} onChange={(e) => setServer(e.currentTarget.value)}>
              {servers.map((s) => (
                <option key={s.name}>{s.name}</option>
              ))}
            </select>
          </label>
        )}
        <label>
          {t("map_name")}
          <input
            required
            pattern={MAP_NAME}
            title={t("map_name_hint")}
            value={name}
            disabled={progress !== undefined}
            onInput={(e) => setName(e.currentTarget.value)}
          />
        </label>
        <label>
          {t("map_file")}
          <input
            type="file"
            required
            disabled={progress !== undefined}
            onChange={(e) => setFile(e.currentTarget.files?.[0] ?? undefined)}
          />
        </label>
        <label class="choice">
          <input type="checkbox" checked={activate} onChange={(e) => setActivate(e.currentTarget.checked)} />
          {t("activate_at_once")}
        </label>
        {progress && <Progress progress={progress} />}
        {result && (
          <p class={result.isFault ? "fault" : "good"} role={result.isFault ? "alert" : "status"}>
            {result.text}
          </p>
        )}
        <div class="buttons">
          <button type="button" onClick={onClose}>
            {t(progress ? "cancel" : "close")}
          </button>
          <button class="primary" disabled={!file || progress !== undefined}>
            {t("upload")}
          </button>
        </div>
      </form>
    </dialog>
  );
}

function Progress({ progress: { step, share } }: { progress: UploadProgress }) {
  const text = t(STEPS[step]);
  const isKnown = Number.isFinite(share) && step !== "checking";
  return (
    <div class="progress" role="status">
      <progress max={1} aria-label={text} {...(isKnown ? { value: share } : {})} />
      <span>
        {text} {isKnown && `${Math.floor(100 * share)} %`}
      </span>
    </div>
  );
}
