import type { ServerResponse } from "node:http";
import { FRAME_HEADER_BYTES, type FrameKind } from "../shared/live.ts";

/** Begins an answer that goes on: nothing on its way may keep it or hold it back. */
export function beginStream(response: ServerResponse, type: string): void {
  response.writeHead(200, {
    "Content-Type": type,
    "Cache-Control": "no-store",
    // A proxy must hand on each frame at once.
    "X-Accel-Buffering": "no",
  });
  response.flushHeaders();
}

export function frame(kind: FrameKind, payload: Uint8Array): Buffer {
  const bytes = Buffer.allocUnsafe(FRAME_HEADER_BYTES + payload.length);
  bytes.writeUInt8(kind, 0);
  bytes.writeUInt32BE(payload.length, 1);
  bytes.set(payload, FRAME_HEADER_BYTES);
  return bytes;
}
