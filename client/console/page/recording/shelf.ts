import { t } from "../texts/texts.ts";
import { CallFailure, Code } from "../wire/failure.ts";
import { MAX_RECORDING_BYTES, NoRecording, readRecording, writeRecording } from "./file.ts";
import { Recorder } from "./recorder.ts";
import { Recording } from "./recording.ts";

/** Each that runs keeps a connection, of which a browser has six to a host over HTTP/1.1: with all of
 * them taken, no call of the page would get through. */
const MAX_RUNNING_COUNT = 3;

/** A recording that the page holds: made here, or opened from a file. */
export interface Item {
  id: number;
  /** Of the vehicle, or of the file. */
  name: string;
  recording: Recording;
  recorder?: Recorder;
  /** Of the file, while it is read. */
  readShare?: number;
  refusal?: NoRecording;
  isSaved: boolean;
}

/** The recordings that the page holds until they are put away or the page is closed. */
export class Shelf {
  items: Item[] = [];
  private nextId = 1;
  private readonly listeners = new Set<() => void>();
  private readonly reads = new Map<number, AbortController>();

  subscribe(listener: () => void): () => void {
    this.listeners.add(listener);
    return () => this.listeners.delete(listener);
  }

  find(id: string): Item | undefined {
    return this.items.find((item) => String(item.id) === id);
  }

  /** Whether something would be lost if the page were closed. */
  get hasUnsaved(): boolean {
    return this.items.some((item) => item.recorder && item.recording.header && !item.isSaved);
  }

  record(server: string, vehicle: string): Item {
    const recording = new Recording();
    const onChange = (): void => this.tell();
    const running = this.items.filter((item) => item.recorder && item.recorder.state !== "ended");
    const refusal =
      running.length < MAX_RUNNING_COUNT
        ? undefined
        : new CallFailure(Code.ResourceExhausted, t("record_too_many", { count: MAX_RUNNING_COUNT }));
    const recorder = new Recorder(server, vehicle, recording, onChange, refusal);
    return this.add({ name: vehicle, recording, recorder, isSaved: false });
  }

  open(file: File): Item {
    const item = this.add({ name: file.name, recording: new Recording(), readShare: 0, isSaved: true });
    const stop = new AbortController();
    this.reads.set(item.id, stop);
    const onShare = (share: number): void => this.change(item, { readShare: share });
    readFile(file, item.recording, onShare, stop.signal)
      .catch((error: unknown) => {
        if (stop.signal.aborted) return;
        item.refusal = error instanceof NoRecording ? error : new NoRecording("damaged", 0);
      })
      .finally(() => {
        this.reads.delete(item.id);
        delete item.readShare;
        this.tell();
      });
    return item;
  }

  /** Stops it and lets go of what it holds. */
  putAway(item: Item): void {
    item.recorder?.stop();
    this.reads.get(item.id)?.abort();
    this.items = this.items.filter((other) => other !== item);
    this.tell();
  }

  clear(): void {
    for (const item of this.items) this.putAway(item);
  }

  /** Hands the file to the browser. */
  save(item: Item): void {
    const { header, steps } = item.recording;
    if (!header) return;
    const link = document.createElement("a");
    link.href = URL.createObjectURL(new Blob(writeRecording(item.recording, header)));
    link.download = `${(header.open?.vehicleId || item.name).replace(/[^\w.-]/g, "_")}-${steps.length}.dclocrec`;
    link.click();
    setTimeout(() => URL.revokeObjectURL(link.href), 60_000);
    // What is still being recorded goes on and is not in the file.
    this.change(item, { isSaved: item.recording.ending !== undefined });
  }

  private add(item: Omit<Item, "id">): Item {
    const added = { ...item, id: this.nextId++ };
    this.items = [...this.items, added];
    this.tell();
    return added;
  }

  private change(item: Item, values: Partial<Item>): void {
    Object.assign(item, values);
    this.tell();
  }

  private tell(): void {
    for (const listener of this.listeners) listener();
  }
}

async function readFile(
  file: File,
  recording: Recording,
  onShare: (share: number) => void,
  stop: AbortSignal,
): Promise<void> {
  if (file.size > MAX_RECORDING_BYTES) throw new NoRecording("too_large", file.size);
  await readRecording(new Uint8Array(await file.arrayBuffer()), recording, onShare, stop);
}
