import { create, toBinary } from "@bufbuild/protobuf";
import { status } from "@grpc/grpc-js";
import {
  GetSessionRequestSchema,
  WatchSessionRequestSchema,
} from "proto/dcloc/v1/admin_service_pb.ts";
import type { StreamEnd } from "../shared/live.ts";
import { RequestError } from "./http.ts";
import type { Caller } from "./logins.ts";
import { type Bytes, type ServerStream, type Upstream, failureOf } from "./upstream.ts";

const DEADLINE_MS = 10_000;

export interface WatchListener {
  /** A WatchSessionResponse. */
  onAnswer(bytes: Bytes): void;
  onEnd(end: StreamEnd): void;
}

interface Watch {
  stream: ServerStream;
  listeners: Set<WatchListener>;
}

/**
 * Watched sessions: one stream from the server for each, however many pages look at it. Whether a
 * page may look is asked of the server each time, with the page's own token.
 */
export class SharedWatches {
  private readonly watches = new Map<string, Watch>();

  constructor(private readonly maxCount: number) {}

  /** Gives a function that ends the listening. Rejects with what the server says. */
  async join(
    upstream: Upstream,
    caller: Caller,
    sessionId: string,
    listener: WatchListener,
  ): Promise<() => void> {
    const question = create(GetSessionRequestSchema, { sessionId });
    const bytes = Buffer.from(toBinary(GetSessionRequestSchema, question));
    const method = "/dcloc.v1.AdminService/GetSession";
    await upstream.unary(method, caller, bytes, DEADLINE_MS);

    const key = `${upstream.name}/${sessionId}`;
    const watch = this.watches.get(key) ?? this.open(key, upstream, caller, sessionId);
    watch.listeners.add(listener);
    return () => {
      watch.listeners.delete(listener);
      if (watch.listeners.size > 0) return;
      // At once, so that who comes now gets a stream that lives.
      if (this.watches.get(key) === watch) this.watches.delete(key);
      watch.stream.cancel();
    };
  }

  get size(): number {
    return this.watches.size;
  }

  private open(key: string, upstream: Upstream, caller: Caller, sessionId: string): Watch {
    if (this.watches.size >= this.maxCount) {
      const message = `${this.watches.size} sessions are watched already, at most ${this.maxCount}`;
      throw new RequestError(status.RESOURCE_EXHAUSTED, message);
    }
    const request = create(WatchSessionRequestSchema, { sessionId, positionFixes: true, scans: true });
    const stream = upstream.serverStream(
      "/dcloc.v1.AdminService/WatchSession",
      caller,
      Buffer.from(toBinary(WatchSessionRequestSchema, request)),
    );
    const watch: Watch = { stream, listeners: new Set() };
    this.watches.set(key, watch);
    const end = (failure: StreamEnd): void => {
      if (this.watches.get(key) === watch) this.watches.delete(key);
      for (const listener of watch.listeners) listener.onEnd(failure);
      watch.listeners.clear();
    };
    stream.on("data", (bytes: Bytes) => {
      for (const listener of watch.listeners) listener.onAnswer(bytes);
    });
    stream.on("error", (error) => end(failureOf(error)));
    stream.on("end", () => end({ code: 0, message: "" }));
    return watch;
  }
}
