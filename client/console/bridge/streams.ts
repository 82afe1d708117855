import type { ServerResponse } from "node:http";
import { FrameKind } from "../shared/live.ts";
import { FleetFeed } from "./fleet_feed.ts";
import { beginStream, frame } from "./frames.ts";
import type { Caller } from "./logins.ts";
import { LossLog } from "./loss_log.ts";
import type { SharedWatches } from "./shared_watch.ts";
import type { Upstream } from "./upstream.ts";

/** What a page that does not read may hold here; beyond it answers are left out, and counted. */
const MAX_UNREAD_BYTES = 1 << 20;
const MAX_LOSS_LOG_COUNT = 100;
/** An empty line, so often: a slow server is listed seldom, and the page must not take that for a cut. */
const SIGN_OF_LIFE_MS = 4_000;

/** The live view: frames of every server, as LiveFrame lines. */
export class LiveStreams {
  private readonly feeds = new Map<string, FleetFeed>();
  /** Outlive the feeds: a page that is loaded again still shows where vehicles got lost. */
  private readonly losses = new Map<string, LossLog>();

  constructor(
    private readonly upstreams: readonly Upstream[],
    private readonly signOfLifeMs = SIGN_OF_LIFE_MS,
  ) {}

  answer(caller: Caller, response: ServerResponse): void {
    beginStream(response, "application/x-ndjson");
    const leave = this.upstreams.map((upstream) =>
      this.feedOf(upstream, caller).subscribe((line) => {
        if (response.writableLength > MAX_UNREAD_BYTES || response.destroyed) return false;
        response.write(line);
        return true;
      }),
    );
    const timer = setInterval(() => response.write("\n"), this.signOfLifeMs);
    response.on("close", () => {
      clearInterval(timer);
      for (const unsubscribe of leave) unsubscribe();
      for (const [key, feed] of this.feeds) if (!feed.isWatched) this.feeds.delete(key);
    });
  }

  private feedOf(upstream: Upstream, caller: Caller): FleetFeed {
    const key = `${upstream.name}/${caller.key}`;
    let feed = this.feeds.get(key);
    if (feed === undefined) {
      const isOneOfSeveral = this.upstreams.length > 1;
      feed = new FleetFeed(upstream, caller, { isOneOfSeveral, losses: this.lossesOf(key) });
      this.feeds.set(key, feed);
    }
    return feed;
  }

  /** Of a token at a server. Those that were used least recently are forgotten beyond a number. */
  private lossesOf(key: string): LossLog {
    const log = this.losses.get(key) ?? new LossLog();
    this.losses.delete(key);
    this.losses.set(key, log);
    for (const oldest of this.losses.keys()) {
      if (this.losses.size <= MAX_LOSS_LOG_COUNT) break;
      this.losses.delete(oldest);
    }
    return log;
  }
}

/** One session's answers as they come. Rejects, before anything is answered, if it may not be. */
export async function answerWatch(
  watches: SharedWatches,
  upstream: Upstream,
  caller: Caller,
  sessionId: string,
  response: ServerResponse,
): Promise<void> {
  let missed = 0;
  let toldMissed = 0;
  const waiting: Buffer[] = [];
  let begun = false;
  const write = (bytes: Buffer): void => {
    if (!begun) waiting.push(bytes);
    else if (!response.destroyed) response.write(bytes);
  };
  const leave = await watches.join(upstream, caller, sessionId, {
    onAnswer(bytes) {
      if (response.writableLength > MAX_UNREAD_BYTES) {
        ++missed;
        return;
      }
      if (missed !== toldMissed) {
        write(frame(FrameKind.Missed, Buffer.from(String(missed))));
        toldMissed = missed;
      }
      write(frame(FrameKind.Message, bytes));
    },
    onEnd(end) {
      write(frame(FrameKind.End, Buffer.from(JSON.stringify(end))));
      response.end();
    },
  });
  if (response.destroyed) return leave();
  response.on("close", leave);
  beginStream(response, "application/octet-stream");
  begun = true;
  for (const bytes of waiting) response.write(bytes);
}
