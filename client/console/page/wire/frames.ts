import { FRAME_HEADER_BYTES, FrameKind } from "../../shared/live.ts";
import { failureOfResponse } from "./failure.ts";
import { inTenant } from "./tenant.ts";

/** Joins what comes into whole frames, wherever it is cut. */
export class FrameReader {
  private bytes = new Uint8Array(0);

  *take(chunk: Uint8Array): Generator<[FrameKind, Uint8Array]> {
    const joined = new Uint8Array(this.bytes.length + chunk.length);
    joined.set(this.bytes);
    joined.set(chunk, this.bytes.length);
    let at = 0;
    while (joined.length - at >= FRAME_HEADER_BYTES) {
      const view = new DataView(joined.buffer, at);
      const end = at + FRAME_HEADER_BYTES + view.getUint32(1);
      if (end > joined.length) break;
      yield [view.getUint8(0), joined.subarray(at + FRAME_HEADER_BYTES, end)];
      at = end;
    }
    this.bytes = joined.slice(at);
  }
}

/**
 * The frames of one of the bridge's streams, until its `End` with it. Throws CallFailure if it is
 * refused, and TypeError if the connection breaks.
 */
export async function* readFrames(
  address: string,
  stop: AbortSignal,
  onOpen?: () => void,
): AsyncGenerator<[FrameKind, Uint8Array]> {
  const response = await fetch(inTenant(address), { signal: stop });
  if (!response.ok) throw await failureOfResponse(response);
  onOpen?.();
  const frames = new FrameReader();
  const body = response.body!.getReader();
  for (;;) {
    const { done, value } = await body.read();
    if (done) throw new TypeError("cut off");
    for (const frame of frames.take(value)) {
      yield frame;
      if (frame[0] === FrameKind.End) return;
    }
  }
}
