import { create, fromBinary, toBinary } from "@bufbuild/protobuf";
import { RecordSessionResponseSchema } from "proto/dcloc/v1/admin_service_pb.ts";
import { type RecordingEntry, RecordingEntrySchema } from "proto/dcloc/v1/recording_pb.ts";
import { FrameKind, type StreamEnd } from "../../shared/live.ts";
import { CallFailure, Code, failureOf } from "../wire/failure.ts";
import { readFrames } from "../wire/frames.ts";
import { MAX_RECORDING_BYTES, MAX_STEP_COUNT } from "./file.ts";
import type { Recording } from "./recording.ts";

/** What a recording in the making does; `waiting`: for the vehicle to open its next session. */
export type RecorderState = "asking" | "waiting" | "recording" | "ended";

/** Records a vehicle's next session, with the visitor's rights. */
export class Recorder {
  state: RecorderState = "asking";
  /** Why it ended before the session did: the server's refusal, a broken connection. */
  failure: CallFailure | undefined;
  /** The page holds no more; the recording ends there, and is whole so far. */
  isFull = false;
  private readonly abort = new AbortController();

  constructor(
    readonly server: string,
    readonly vehicle: string,
    readonly recording: Recording,
    private readonly onChange: () => void,
    /** Why it may not begin. */
    refusal?: CallFailure,
  ) {
    (refusal ? Promise.reject(refusal) : this.run()).then(
      (reason) => this.end(reason),
      (error: unknown) => {
        const failure = failureOf(error);
        if (failure.code !== Code.Cancelled) this.failure = failure;
        this.end(failure.message || (this.failure ? "the connection broke" : "stopped by a person"));
      },
    );
  }

  /** Ends it here; what was recorded stays. */
  stop(): void {
    this.abort.abort();
  }

  private async run(): Promise<string> {
    const address = `/record/${this.server}?vehicle=${encodeURIComponent(this.vehicle)}`;
    const onOpen = (): void => this.become("waiting");
    for await (const [kind, payload] of readFrames(address, this.abort.signal, onOpen)) {
      if (kind === FrameKind.Message) this.take(payload);
      else if (kind === FrameKind.End) return this.reasonOf(payload);
      const { byteCount, steps } = this.recording;
      if (byteCount < MAX_RECORDING_BYTES - (8 << 20) && steps.length < MAX_STEP_COUNT - 1) continue;
      this.isFull = true;
      return "the page holds no more";
    }
    return "";
  }

  private reasonOf(payload: Uint8Array): string {
    const end = JSON.parse(new TextDecoder().decode(payload)) as StreamEnd;
    if (end.code === 0) return "the session ended";
    this.failure = new CallFailure(end.code, end.message);
    return end.message;
  }

  private take(payload: Uint8Array): void {
    const { message } = fromBinary(RecordSessionResponseSchema, payload);
    const { recording } = this;
    if (message.case === "header") {
      recording.header = message.value;
      this.become("recording");
    } else if (message.case === "scan") {
      recording.takeScan(message.value, entryBytes({ case: "scan", value: message.value }));
    } else if (message.case === "fix") {
      recording.takeFix(message.value, entryBytes({ case: "fix", value: message.value }));
    }
  }

  private end(reason: string): void {
    this.abort.abort();
    this.recording.ending = { reason };
    this.become("ended");
  }

  private become(state: RecorderState): void {
    this.state = state;
    this.onChange();
  }
}

function entryBytes(entry: RecordingEntry["entry"]): Uint8Array {
  return toBinary(RecordingEntrySchema, create(RecordingEntrySchema, { entry }));
}
