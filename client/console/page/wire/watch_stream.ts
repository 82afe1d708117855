import { fromBinary } from "@bufbuild/protobuf";
import {
  type WatchSessionResponse,
  WatchSessionResponseSchema,
} from "proto/dcloc/v1/admin_service_pb.ts";
import { FrameKind, type StreamEnd } from "../../shared/live.ts";
import { readFrames } from "./frames.ts";
import { failureOf } from "./failure.ts";

export interface WatchReader {
  onAnswer(answer: WatchSessionResponse): void;
  /** Answers that this page was too slow for, so far. */
  onMissed(count: number): void;
  onEnd(end: StreamEnd): void;
}

/** Reads a session's answers until it ends, is refused, or the connection breaks. */
export function watchSession(server: string, sessionId: string, reader: WatchReader): () => void {
  const stop = new AbortController();
  const run = async (): Promise<void> => {
    const address = `/watch/${server}?session=${encodeURIComponent(sessionId)}`;
    for await (const [kind, payload] of readFrames(address, stop.signal)) {
      if (kind === FrameKind.Message) {
        reader.onAnswer(fromBinary(WatchSessionResponseSchema, payload));
      } else if (kind === FrameKind.Missed) {
        reader.onMissed(Number(new TextDecoder().decode(payload)));
      } else {
        return reader.onEnd(JSON.parse(new TextDecoder().decode(payload)) as StreamEnd);
      }
    }
  };
  run().catch((error: unknown) => {
    const { code, message } = failureOf(error);
    if (!stop.signal.aborted) reader.onEnd({ code, message });
  });
  return () => stop.abort();
}
