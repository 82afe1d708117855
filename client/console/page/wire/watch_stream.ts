import { fromBinary } from "@bufbuild/protobuf";
import {
  type WatchSessionResponse,
  WatchSessionResponseSchema,
} from "proto/dcloc/v1/admin_service_pb.ts";
import { WATCH_HEADER_BYTES, type WatchEnd, WatchFrameKind } from "../../shared/live.ts";
import { failureOf, failureOfResponse } from "./failure.ts";

/** Joins what comes into whole frames, wherever it is cut. */
export class FrameReader {
  private bytes = new Uint8Array(0);

  *take(chunk: Uint8Array): Generator<[WatchFrameKind, Uint8Array]> {
    const joined = new Uint8Array(this.bytes.length + chunk.length);
    joined.set(this.bytes);
    joined.set(chunk, this.bytes.length);
    let at = 0;
    while (joined.length - at >= WATCH_HEADER_BYTES) {
      const view = new DataView(joined.buffer, at);
      const end = at + WATCH_HEADER_BYTES + view.getUint32(1);
      if (end > joined.length) break;
      yield [view.getUint8(0), joined.subarray(at + WATCH_HEADER_BYTES, end)];
      at = end;
    }
    this.bytes = joined.slice(at);
  }
}

export interface WatchReader {
  onAnswer(answer: WatchSessionResponse): void;
  /** Answers that this page was too slow for, so far. */
  onMissed(count: number): void;
  onEnd(end: WatchEnd): void;
}

/** Reads a session's answers until it ends, is refused, or the connection breaks. */
export function watchSession(server: string, sessionId: string, reader: WatchReader): () => void {
  const stop = new AbortController();
  const run = async (): Promise<void> => {
    const address = `/watch/${server}?session=${encodeURIComponent(sessionId)}`;
    const response = await fetch(address, { signal: stop.signal });
    if (!response.ok) throw await failureOfResponse(response);
    const frames = new FrameReader();
    const body = response.body!.getReader();
    for (;;) {
      const { done, value } = await body.read();
      if (done) throw new TypeError("cut off");
      for (const [kind, payload] of frames.take(value)) {
        if (kind === WatchFrameKind.Answer) {
          reader.onAnswer(fromBinary(WatchSessionResponseSchema, payload));
        } else if (kind === WatchFrameKind.Missed) {
          reader.onMissed(Number(new TextDecoder().decode(payload)));
        } else {
          return reader.onEnd(JSON.parse(new TextDecoder().decode(payload)) as WatchEnd);
        }
      }
    }
  };
  run().catch((error: unknown) => {
    const { code, message } = failureOf(error);
    if (!stop.signal.aborted) reader.onEnd({ code, message });
  });
  return () => stop.abort();
}
