import { create, fromBinary, toBinary } from "@bufbuild/protobuf";
import {
  ListSessionsRequestSchema,
  ListSessionsResponseSchema,
} from "proto/dcloc/v1/admin_service_pb.ts";
import type { LiveFrame, LiveSession, SilentReplica } from "../shared/live.ts";
import { liveSession } from "./live_row.ts";
import { LossLog } from "./loss_log.ts";
import { type CallHeaders, type Upstream, failureOf } from "./upstream.ts";

const PERIOD_MS = 1_000;
/** A server is asked at most this share of the time, however long its answers take. */
const MAX_DUTY = 0.2;
const DEADLINE_MS = 10_000;
const PAGE_SIZE = 1_000;
const MAX_PAGE_COUNT = 20;
const METHOD = "/dcloc.v1.AdminService/ListSessions";

/** Receives frames as text; returns whether the reader keeps up. */
export type FrameListener = (line: string) => boolean;

interface Row {
  session: LiveSession;
  /** Of the session, to be compared and sent. */
  json: string;
}

export interface FeedOptions {
  periodMs?: number;
  /** The server's own sessions alone: the others of its fleet are asked, too. */
  isOneOfSeveral?: boolean;
  /** Where vehicles got lost before somebody looked again. */
  losses?: LossLog;
}

/** What a server's list says: its sessions by id, and the servers of its fleet that did not answer. */
interface Listing {
  rows: Map<string, Row>;
  silent: SilentReplica[];
}

/**
 * One server's sessions as one token sees them. The list is read once a second while somebody looks,
 * once for all pages with this token. A page that is too slow gets no queue: it misses frames, and
 * then one with everything.
 */
export class FleetFeed {
  private readonly periodMs: number;
  private readonly isOneOfSeveral: boolean;
  private readonly losses: LossLog;
  private rows = new Map<string, Row>();
  private silent: SilentReplica[] = [];
  private known = false;
  private failure: LiveFrame["failure"];
  private readonly listeners = new Map<FrameListener, { behind: boolean }>();
  private timer: NodeJS.Timeout | undefined;
  private reading = false;

  constructor(
    private readonly upstream: Upstream,
    private readonly caller: CallHeaders,
    options: FeedOptions = {},
  ) {
    this.periodMs = options.periodMs ?? PERIOD_MS;
    this.isOneOfSeveral = options.isOneOfSeveral ?? false;
    this.losses = options.losses ?? new LossLog();
  }

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
      this.forget();
    };
  }

  get isWatched(): boolean {
    return this.listeners.size > 0;
  }

  /** Nobody looked: what is known grows old, and the next one may have lost the right to see it. */
  private forget(): void {
    this.known = false;
    this.failure = undefined;
    this.rows = new Map();
    this.silent = [];
  }

  private async read(): Promise<void> {
    this.timer = undefined;
    this.reading = true;
    const begin = Date.now();
    try {
      const listing = await this.list();
      if (this.isWatched) this.take(listing);
    } catch (error) {
      this.failure = failureOf(error);
      this.tell(this.line({ failure: this.failure }));
    }
    this.reading = false;
    if (!this.isWatched) return this.forget();
    const wait = Math.max(this.periodMs, (Date.now() - begin) / MAX_DUTY);
    this.timer = setTimeout(() => void this.read(), wait);
  }

  private async list(): Promise<Listing> {
    const rows = new Map<string, Row>();
    const silent = new Map<string, SilentReplica>();
    let pageToken = "";
    for (let page = 0; page < MAX_PAGE_COUNT; ++page) {
      const request = create(ListSessionsRequestSchema, {
        pageSize: PAGE_SIZE,
        pageToken,
        thisReplicaOnly: this.isOneOfSeveral,
      });
      const bytes = Buffer.from(toBinary(ListSessionsRequestSchema, request));
      const answer = await this.upstream.unary(METHOD, this.caller, bytes, DEADLINE_MS);
      const response = fromBinary(ListSessionsResponseSchema, answer);
      for (const listed of response.sessions) {
        const session = liveSession(listed);
        rows.set(session.id, { session, json: JSON.stringify(session) });
      }
      for (const { address, fault } of response.unanswered) silent.set(address, { address, fault });
      pageToken = response.nextPageToken;
      if (pageToken === "") break;
    }
    return { rows, silent: [...silent.values()] };
  }

  private take({ rows, silent }: Listing): void {
    const wasKnown = this.known && !this.failure;
    const before = this.rows;
    keepOfSilent(rows, before, silent);
    this.rows = rows;
    this.silent = silent;
    this.known = true;
    this.failure = undefined;
    const losses = this.losses.take([...rows.values()].map((row) => row.session), Date.now());
    if (!wasKnown) return this.tell(this.fullFrame());
    const changed = [...rows].filter(([id, { json }]) => before.get(id)?.json !== json);
    const gone = [...before.keys()].filter((id) => !rows.has(id));
    const news = losses.length > 0 ? { gone, losses } : { gone };
    this.tell(this.line(news, changed.map(([, row]) => row)));
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
    const losses = this.losses.all(Date.now());
    return this.line({ full: true, losses }, [...this.rows.values()]);
  }

  private line(frame: Omit<LiveFrame, "server">, rows: Row[] = []): string {
    const silent = this.silent.length > 0 ? { silent: this.silent } : {};
    const head = JSON.stringify({ server: this.upstream.name, ...frame, ...silent });
    return `${head.slice(0, -1)},"set":[${rows.map(({ json }) => json).join(",")}]}\n`;
  }
}

/** Adds to `rows` the last known sessions of servers that did not answer, but for vehicles that are
 * elsewhere by now. */
function keepOfSilent(
  rows: Map<string, Row>,
  before: ReadonlyMap<string, Row>,
  silent: readonly SilentReplica[],
): void {
  if (silent.length === 0) return;
  const addresses = new Set(silent.map(({ address }) => address));
  const listed = new Set([...rows.values()].map(({ session }) => session.vehicle));
  for (const [id, row] of before) {
    const { replica, vehicle } = row.session;
    if (replica && addresses.has(replica) && !rows.has(id) && !listed.has(vehicle)) rows.set(id, row);
  }
}
