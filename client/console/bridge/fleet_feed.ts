import { create, fromBinary, toBinary } from "@bufbuild/protobuf";
import {
  ListSessionsRequestSchema,
  ListSessionsResponseSchema,
} from "proto/dcloc/v1/admin_service_pb.ts";
import type { LiveFrame } from "../shared/live.ts";
import type { Login } from "./logins.ts";
import { liveSession } from "./live_row.ts";
import { type Upstream, failureOf } from "./upstream.ts";

const PERIOD_MS = 1_000;
/** A server is asked at most this share of the time, however long its answers take. */
const MAX_DUTY = 0.2;
const DEADLINE_MS = 10_000;
const PAGE_SIZE = 1_000;
const MAX_PAGE_COUNT = 20;
const METHOD = "/dcloc.v1.AdminService/ListSessions";

/** Receives frames as text; returns whether the reader keeps up. */
export type FrameListener = (line: string) => boolean;

/**
 * One server's sessions as one token sees them. The list is read once a second while somebody looks,
 * once for all pages with this token. A page that is too slow gets no queue: it misses frames, and
 * then one with everything.
 */
export class FleetFeed {
  /** Each session's JSON, by id. */
  private rows = new Map<string, string>();
  private known = false;
  private failure: LiveFrame["failure"];
  private readonly listeners = new Map<FrameListener, { behind: boolean }>();
  private timer: NodeJS.Timeout | undefined;
  private reading = false;

  constructor(
    private readonly upstream: Upstream,
    private readonly login: Pick<Login, "token">,
    private readonly periodMs = PERIOD_MS,
    /** Its own sessions alone: the others of its fleet are asked, too. */
    private readonly isOneOfSeveral = false,
  ) {}

  /** Calls `listener` with all that is known, and then with each change, until the result is called. */
  subscribe(listener: FrameListener): () => void {
    this.listeners.set(listener, { behind: false });
    if (this.known || this.failure) listener(this.fullFrame());
    if (!this.reading && this.timer === undefined) void this.read();
    return () => {
      this.listeners.delete(listener);
      if (this.listeners.size > 0) return;
      clearTimeout(this.timer);
      this.timer = undefined;
    };
  }

  get isWatched(): boolean {
    return this.listeners.size > 0;
  }

  private async read(): Promise<void> {
    this.timer = undefined;
    this.reading = true;
    const begin = Date.now();
    try {
      this.take(await this.list());
    } catch (error) {
      this.failure = failureOf(error);
      this.tell(this.line({ failure: this.failure }));
    }
    this.reading = false;
    if (this.listeners.size === 0) return;
    const wait = Math.max(this.periodMs, (Date.now() - begin) / MAX_DUTY);
    this.timer = setTimeout(() => void this.read(), wait);
  }

  private async list(): Promise<Map<string, string>> {
    const rows = new Map<string, string>();
    let pageToken = "";
    for (let page = 0; page < MAX_PAGE_COUNT; ++page) {
      const request = create(ListSessionsRequestSchema, {
        pageSize: PAGE_SIZE,
        pageToken,
        thisReplicaOnly: this.isOneOfSeveral,
      });
      const bytes = Buffer.from(toBinary(ListSessionsRequestSchema, request));
      const answer = await this.upstream.unary(METHOD, this.login.token, bytes, DEADLINE_MS);
      const response = fromBinary(ListSessionsResponseSchema, answer);
      for (const session of response.sessions) {
        rows.set(session.sessionId, JSON.stringify(liveSession(session)));
      }
      pageToken = response.nextPageToken;
      if (pageToken === "") break;
    }
    return rows;
  }

  private take(rows: Map<string, string>): void {
    const wasKnown = this.known && !this.failure;
    const before = this.rows;
    this.rows = rows;
    this.known = true;
    this.failure = undefined;
    if (!wasKnown) return this.tell(this.fullFrame());
    const changed = [...rows].filter(([id, row]) => before.get(id) !== row).map(([, row]) => row);
    const gone = [...before.keys()].filter((id) => !rows.has(id));
    this.tell(this.line({ gone }, changed));
  }

  /** Hands a frame to everybody who keeps up; who was behind gets a full one instead. */
  private tell(line: string): void {
    let full: string | undefined;
    for (const [listener, state] of this.listeners) {
      state.behind = !listener(state.behind ? (full ??= this.fullFrame()) : line);
    }
  }

  private fullFrame(): string {
    if (this.failure) return this.line({ failure: this.failure });
    return this.line({ full: true }, [...this.rows.values()]);
  }

  private line(frame: Omit<LiveFrame, "server">, rows: string[] = []): string {
    const head = JSON.stringify({ server: this.upstream.name, ...frame });
    return `${head.slice(0, -1)},"set":[${rows.join(",")}]}\n`;
  }
}
