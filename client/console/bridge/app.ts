import type { IncomingMessage, ServerResponse } from "node:http";
import { status } from "@grpc/grpc-js";
import { AdminService } from "proto/dcloc/v1/admin_service_pb.ts";
import { MapService } from "proto/dcloc/v1/map_service_pb.ts";
import type { Guard } from "./guard.ts";
import {
  RequestError,
  addressOf,
  answerFailure,
  answerJson,
  cookieOf,
  isAborted,
  parameter,
  readBody,
} from "./http.ts";
import { type Caller, type Login, type Logins, callerOf } from "./logins.ts";
import type { PageFiles } from "./page_files.ts";
import { Recordings } from "./recordings.ts";
import { SharedWatches } from "./shared_watch.ts";
import { signIn } from "./sign_in.ts";
import { LiveStreams, answerWatch } from "./streams.ts";
import { answerDownload, takeUpload } from "./transfers.ts";
import { type Failure, type Upstream, failureOf } from "./upstream.ts";

const MAX_REQUEST_BYTES = 64 << 10;
/** Activating and deleting wait for maps to load and sessions to move. */
const DEADLINE_MS = 60_000;

/** The unary methods that the page may call: all there are of maps and administration. */
const UNARY_METHODS = new Set(
  [AdminService, MapService].flatMap((service) =>
    service.methods
      .filter((method) => method.methodKind === "unary")
      .map((method) => `/${service.typeName}/${method.name}`),
  ),
);
/** Methods that take a stream, of which the page sends one message: an update of a map needs no more. */
const ONE_MESSAGE_METHODS = new Set([
  `/${MapService.typeName}/${MapService.method.startMapBuild.name}`,
]);

interface Exchange {
  request: IncomingMessage;
  response: ServerResponse;
  url: URL;
  caller: Caller;
}

/** Answers the browsers' requests. */
export class App {
  private readonly live: LiveStreams;
  private readonly watches: SharedWatches;
  private readonly recordings: Recordings;
  private readonly cookieName: string;

  constructor(
    private readonly parts: {
      upstreams: readonly Upstream[];
      logins: Logins;
      guard: Guard;
      page: PageFiles;
      tls: boolean;
      maxWatchCount: number;
      maxRecordingCount: number;
      /** Told of faults of our own. */
      log: (text: string) => void;
    },
  ) {
    this.live = new LiveStreams(parts.upstreams);
    this.watches = new SharedWatches(parts.maxWatchCount);
    this.recordings = new Recordings(parts.maxRecordingCount);
    // The prefix makes browsers refuse the cookie from anybody but this host over TLS.
    this.cookieName = parts.tls ? "__Host-dcloc" : "dcloc-console";
  }

  async answer(request: IncomingMessage, response: ServerResponse): Promise<void> {
    try {
      this.parts.guard.protect(response);
      const refusal = this.parts.guard.refusal(request);
      if (refusal !== undefined) throw new RequestError(status.PERMISSION_DENIED, refusal);
      await this.route(addressOf(request), request, response);
    } catch (error) {
      if (isAborted(request)) response.destroy();
      else this.answerError(error, response);
    }
  }

  private async route(url: URL, request: IncomingMessage, response: ServerResponse): Promise<void> {
    const [, first = "", second = "", ...rest] = url.pathname.split("/");
    const method = request.method ?? "";
    if (first === "api" && method === "GET" && second === "session") {
      return answerJson(response, this.describe(this.loginOf(request)));
    }
    if (first === "api" && method === "POST") return this.changeLogin(second, request, response);
    const isData = ["rpc", "feed", "watch", "record", "upload", "download"].includes(first);
    if (!isData) {
      if (method !== "GET" && method !== "HEAD") {
        throw new RequestError(status.UNIMPLEMENTED, `${method} is not answered here`);
      }
      return this.parts.page.answer(url.pathname, request, response);
    }
    const login = this.loginOf(request);
    if (!login) throw new RequestError(status.UNAUTHENTICATED, "sign in first");
    const caller = callerOf(login, url.searchParams.get("tenant") ?? "");
    return this.answerData(first, second, rest, { request, response, url, caller });
  }

  private async answerData(
    kind: string,
    serverName: string,
    rest: string[],
    { request, response, url, caller }: Exchange,
  ): Promise<void> {
    const wanted = { rpc: "POST", upload: "PUT" }[kind] ?? "GET";
    if (request.method !== wanted) {
      throw new RequestError(status.UNIMPLEMENTED, `/${kind} takes ${wanted} alone`);
    }
    if (kind === "feed") return this.live.answer(caller, response);
    const upstream = this.parts.upstreams.find((u) => u.name === serverName);
    if (!upstream) throw new RequestError(status.NOT_FOUND, "there is no server of that name");
    switch (kind) {
      case "watch": {
        const sessionId = parameter(url, "session");
        return answerWatch(this.watches, upstream, caller, sessionId, response);
      }
      case "record":
        return this.recordings.answer(upstream, caller, parameter(url, "vehicle"), response);
      case "download":
        return answerDownload(upstream, caller, url, response);
      case "upload":
        return answerBytes(response, await takeUpload(upstream, caller, url, request));
      default:
        return this.pass(upstream, `/${rest.join("/")}`, { request, response, url, caller });
    }
  }

  /** Hands a call with one request and one answer on, as it is. */
  private async pass(upstream: Upstream, method: string, exchange: Exchange): Promise<void> {
    const isUnary = UNARY_METHODS.has(method);
    if (!isUnary && !ONE_MESSAGE_METHODS.has(method)) {
      throw new RequestError(status.UNIMPLEMENTED, "the page may not call that");
    }
    const { request, response, caller } = exchange;
    const body = await readBody(request, MAX_REQUEST_BYTES);
    const gone = new AbortController();
    response.on("close", () => gone.abort());
    const form = isUnary ? "unary" : "streamOfOne";
    const answer = await upstream[form](method, caller, body, DEADLINE_MS, gone.signal);
    answerBytes(response, answer);
  }

  private async changeLogin(
    action: string,
    request: IncomingMessage,
    response: ServerResponse,
  ): Promise<void> {
    const secret = cookieOf(request, this.cookieName);
    if (action === "logout") {
      this.parts.logins.remove(secret);
      response.setHeader("Set-Cookie", this.cookie("", 0));
      return answerJson(response, {});
    }
    if (action !== "login") throw new RequestError(status.NOT_FOUND, "there is no such address");
    const token = await signIn(this.parts.upstreams, await readBody(request, MAX_REQUEST_BYTES));
    this.parts.logins.remove(secret);
    const added = this.parts.logins.add(token);
    response.setHeader("Set-Cookie", this.cookie(added));
    answerJson(response, this.describe(this.parts.logins.find(added)));
  }

  private cookie(value: string, maxAgeS?: number): string {
    const secure = this.parts.tls ? "; Secure" : "";
    const age = maxAgeS === undefined ? "" : `; Max-Age=${maxAgeS}`;
    return `${this.cookieName}=${value}; Path=/; HttpOnly; SameSite=Strict${secure}${age}`;
  }

  private describe(login: Login | undefined): object {
    const servers = this.parts.upstreams.map(({ name, address }) => ({ name, address }));
    return login ? { signedIn: true, hasToken: login.token !== "", servers } : { signedIn: false };
  }

  private loginOf(request: IncomingMessage): Login | undefined {
    return this.parts.logins.find(cookieOf(request, this.cookieName));
  }

  private answerError(error: unknown, response: ServerResponse): void {
    const failure: Failure =
      error instanceof RequestError ? { code: error.code, message: error.message } : failureOf(error);
    if (failure.code === status.INTERNAL && error instanceof Error) {
      this.parts.log(error.stack ?? error.message);
    }
    if (response.headersSent || response.destroyed) response.destroy();
    else answerFailure(response, failure);
  }
}

function answerBytes(response: ServerResponse, bytes: Buffer): void {
  response.writeHead(200, {
    "Content-Type": "application/x-protobuf",
    "Content-Length": bytes.length,
    "Cache-Control": "no-store",
  });
  response.end(bytes);
}
