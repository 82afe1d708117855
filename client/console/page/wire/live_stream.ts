import type { LiveFrame } from "../../shared/live.ts";
import { Code, failureOf, failureOfResponse } from "./failure.ts";
import { inTenant } from "./tenant.ts";

/** How the page's connection to the bridge stands. */
export type Link = "connecting" | "open" | "cut" | "refused";

const SILENCE_MS = 15_000;
const MAX_WAIT_MS = 10_000;

/** Splits what comes into lines, wherever it is cut. Empty ones are left out: they say nothing. */
export class LineSplitter {
  private rest = "";
  private readonly decoder = new TextDecoder();

  take(chunk: Uint8Array): string[] {
    const lines = (this.rest + this.decoder.decode(chunk, { stream: true })).split("\n");
    this.rest = lines.pop()!;
    return lines.filter((line) => line !== "");
  }
}

/** Reads the fleet's frames for ever: after a break it connects again, later each time. */
export function followFleet(
  onFrame: (frame: LiveFrame) => void,
  onLink: (link: Link) => void,
): () => void {
  const stop = new AbortController();
  let waitMs = 500;

  const readOnce = async (): Promise<void> => {
    const silence = new AbortController();
    stop.signal.addEventListener("abort", () => silence.abort());
    const response = await fetch(inTenant("/feed"), { signal: silence.signal });
    if (!response.ok) throw await failureOfResponse(response);
    const reader = response.body!.getReader();
    const splitter = new LineSplitter();
    onLink("open");
    waitMs = 500;
    for (;;) {
      // A bridge tells something, if only that it is there; one that does not is gone without a word.
      const timer = setTimeout(() => silence.abort(), SILENCE_MS);
      const { done, value } = await reader.read().finally(() => clearTimeout(timer));
      if (done) return;
      for (const line of splitter.take(value)) onFrame(JSON.parse(line) as LiveFrame);
    }
  };

  const run = async (): Promise<void> => {
    while (!stop.signal.aborted) {
      try {
        await readOnce();
      } catch (error) {
        if (failureOf(error).code === Code.Unauthenticated) return onLink("refused");
      }
      if (stop.signal.aborted) return;
      onLink("cut");
      await new Promise((resolve) => setTimeout(resolve, waitMs));
      waitMs = Math.min(2 * waitMs, MAX_WAIT_MS);
    }
  };
  onLink("connecting");
  void run();
  return () => stop.abort();
}
