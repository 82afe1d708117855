import { useEffect, useRef, useState } from "preact/hooks";
import { Dialog } from "../parts/dialog.tsx";
import { Link } from "../parts/link.tsx";
import { Notice, failureText } from "../parts/notice.tsx";
import { go, pathOf } from "../parts/route.ts";
import type { NoRecording } from "../recording/file.ts";
import type { Item, Shelf } from "../recording/shelf.ts";
import { shownName } from "../texts/shortened.ts";
import { clock, count, decimals, megabytes, t } from "../texts/texts.ts";
import type { ServerName } from "../wire/calls.ts";

/** Shown again twice a second: recordings grow. */
const SHOW_MS = 500;

/** Shows its user again when the shelf changes, and while something on it grows. */
export function useShelf(shelf: Shelf): void {
  const [, setRound] = useState(0);
  useEffect(() => {
    const show = (): void => setRound((n) => n + 1);
    const leave = shelf.subscribe(show);
    const timer = setInterval(() => {
      if (shelf.items.some(({ recorder }) => recorder?.state === "recording")) show();
    }, SHOW_MS);
    return () => {
      leave();
      clearInterval(timer);
    };
  }, [shelf]);
}

export function refusalText({ reason, value }: NoRecording): string {
  switch (reason) {
    case "not_one":
      return t("file_not_one");
    case "too_large":
      return t("file_too_large", { size: megabytes(value) });
    case "newer":
      return t("file_newer", { version: value });
    default:
      return t("file_damaged", { at: count(value) });
  }
}

/** What an item is, or does, in words. */
export function itemText(item: Item): string {
  const { recorder, recording, readShare, refusal } = item;
  if (refusal) return refusalText(refusal);
  if (readShare !== undefined) return t("file_reading", { percent: decimals(100 * readShare, 0) });
  const size = t("recording_size", {
    scans: count(recording.scanCount),
    time: clock(recording.durationMs),
    size: megabytes(recording.byteCount),
  });
  if (recorder?.failure) return `${size} · ${failureText(recorder.failure)}`;
  if (recorder?.isFull) return `${size} · ${t("recording_full")}`;
  if (recorder?.state === "asking") return t("recording_asking");
  if (recorder?.state === "waiting") return t("recording_waiting");
  if (recorder?.state === "recording") return `${t("recording_runs")} · ${size}`;
  const reason = recording.ending?.reason;
  return reason ? `${size} · ${t("recording_ended", { reason })}` : size;
}

interface Props {
  shelf: Shelf;
  servers: readonly ServerName[];
}

/** The recordings that the page holds, and where others are opened. */
export function RecordingsView({ shelf, servers }: Props) {
  const [isAsking, setAsking] = useState(false);
  useShelf(shelf);
  return (
    <div class="sheet">
      <div class="sheet-head">
        <h1>{t("recordings")}</h1>
        <button class="primary" onClick={() => setAsking(true)}>
          {t("record_vehicle")}
        </button>
      </div>
      <DropZone shelf={shelf} />
      {shelf.items.length === 0 ? (
        <Notice title={t("no_recordings_title")}>
          <p>{t("no_recordings_text")}</p>
        </Notice>
      ) : (
        <ul class="items">
          {shelf.items.map((item) => (
            <Row key={item.id} item={item} shelf={shelf} />
          ))}
        </ul>
      )}
      <p class="hint">{t("recordings_hint")}</p>
      {isAsking && <RecordDialog shelf={shelf} servers={servers} onClose={() => setAsking(false)} />}
    </div>
  );
}

function Row({ item, shelf }: { item: Item; shelf: Shelf }) {
  const { recorder, recording, refusal } = item;
  const isRunning = recorder !== undefined && recorder.state !== "ended";
  const isFault = refusal !== undefined || recorder?.failure !== undefined;
  return (
    <li class="item">
      <div class="row-text">
        <strong>{shownName(item.name)}</strong>
        <span class={isFault ? "fault-text" : "soft"} role={isFault ? "alert" : undefined}>
          {itemText(item)}
        </span>
      </div>
      <div class="row-actions">
        {recording.header && (
          <Link class="button primary" to={pathOf("recordings", item.id)}>
            {t(recorder?.state === "recording" ? "watch" : "replay")}
          </Link>
        )}
        {recorder && recording.header && <button onClick={() => shelf.save(item)}>{t("download")}</button>}
        {isRunning && <button onClick={() => recorder.stop()}>{t("stop")}</button>}
        <button class="danger" onClick={() => shelf.putAway(item)}>
          {t("put_away")}
        </button>
      </div>
    </li>
  );
}

/** Takes files that are chosen or dropped. */
function DropZone({ shelf }: { shelf: Shelf }) {
  const [isOver, setOver] = useState(false);
  const input = useRef<HTMLInputElement>(null);
  const open = (files: FileList | null | undefined): void => {
    const items = [...(files ?? [])].map((file) => shelf.open(file));
    if (items.length === 1) go(pathOf("recordings", items[0]!.id));
  };
  return (
    <div
      class={isOver ? "drop-zone over" : "drop-zone"}
      onDragOver={(event) => {
        event.preventDefault();
        setOver(true);
      }}
      onDragLeave={() => setOver(false)}
      onDrop={(event) => {
        event.preventDefault();
        setOver(false);
        open(event.dataTransfer?.files);
      }}
    >
      <label>
        {t("open_recording")}
        <input
          ref={input}
          type="file"
          multiple
          onChange={(event) => {
            open(event.currentTarget.files);
            event.currentTarget.value = "";
          }}
        />
      </label>
      <p class="hint">{t("open_recording_hint")}</p>
    </div>
  );
}

interface RecordProps extends Props {
  onClose: () => void;
}

/** Asks which vehicle's next session is to be recorded; it need not be there yet. */
function RecordDialog({ shelf, servers, onClose }: RecordProps) {
  const [server, setServer] = useState(servers[0]?.name ?? "");
  const [vehicle, setVehicle] = useState("");
  return (
    <Dialog
      title={t("record_title")}
      action={t("record")}
      isReady={vehicle !== ""}
      onClose={onClose}
      onDo={async () => shelf.record(server, vehicle)}
    >
      <p>{t("record_text")}</p>
      {servers.length > 1 && (
        <label>
          {t("server")}
          <select value={server} onChange={(event) => setServer(event.currentTarget.value)}>
            {servers.map(({ name }) => (
              <option key={name}>{name}</option>
            ))}
          </select>
        </label>
      )}
      <label>
        {t("vehicle")}
        <input
          required
          maxLength={64}
          value={vehicle}
          onInput={(event) => setVehicle(event.currentTarget.value)}
        />
      </label>
    </Dialog>
  );
}
