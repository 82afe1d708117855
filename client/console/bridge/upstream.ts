import * as grpc from "@grpc/grpc-js";
import type { Caller } from "./logins.ts";

/** A message as it is on the wire: the bridge passes it on and does not look inside. */
export type Bytes = Buffer;

/** What tells a server who calls. */
export type CallHeaders = Pick<Caller, "token" | "tenant">;

export type ServerStream = grpc.ClientReadableStream<Bytes>;
export type Upload = grpc.ClientWritableStream<Bytes>;

const asIs = (bytes: Bytes): Bytes => bytes;
const MAX_MESSAGE_BYTES = 32 << 20;
const MAX_RECONNECT_MS = 5_000;

/** One dcloc server. Connects when it is first called, and again by itself after a break. */
export class Upstream {
  private readonly client: grpc.Client;

  /** `ca` is the authority's certificate (PEM); without it the connection is plaintext. */
  constructor(
    readonly name: string,
    readonly address: string,
    ca: Buffer | undefined,
  ) {
    const credentials = ca ? grpc.credentials.createSsl(ca) : grpc.credentials.createInsecure();
    this.client = new grpc.Client(address, credentials, {
      "grpc.max_receive_message_length": MAX_MESSAGE_BYTES,
      "grpc.max_reconnect_backoff_ms": MAX_RECONNECT_MS,
      "grpc.initial_reconnect_backoff_ms": 500,
      // Notices within half a minute that a server is gone without a word.
      "grpc.keepalive_time_ms": 30_000,
      "grpc.keepalive_timeout_ms": 10_000,
      // A server's proxy must not be found through the environment: the token would go there.
      "grpc.enable_http_proxy": 0,
    });
  }

  /** Rejects with grpc.ServiceError. `signal` cancels the call. */
  unary(
    method: string,
    caller: CallHeaders,
    request: Bytes,
    deadlineMs: number,
    signal?: AbortSignal,
  ): Promise<Bytes> {
    const options = { deadline: Date.now() + deadlineMs };
    return answered(signal, (done) =>
      this.client.makeUnaryRequest(method, asIs, asIs, request, metadataOf(caller), options, done),
    );
  }

  /** As `unary`, of a method that takes a stream of requests: this one alone. */
  streamOfOne(
    method: string,
    caller: CallHeaders,
    request: Bytes,
    deadlineMs: number,
    signal?: AbortSignal,
  ): Promise<Bytes> {
    const options = { deadline: Date.now() + deadlineMs };
    return answered(signal, (done) => {
      const metadata = metadataOf(caller);
      const call = this.client.makeClientStreamRequest(method, asIs, asIs, metadata, options, done);
      call.end(request);
      return call;
    });
  }

  serverStream(method: string, caller: CallHeaders, request: Bytes): ServerStream {
    return this.client.makeServerStreamRequest(method, asIs, asIs, request, metadataOf(caller));
  }

  upload(method: string, caller: CallHeaders, done: grpc.requestCallback<Bytes>): Upload {
    return this.client.makeClientStreamRequest(method, asIs, asIs, metadataOf(caller), done);
  }

  close(): void {
    this.client.close();
  }
}

/** The answer of a call that is begun with what to do with it; `signal` cancels the call. */
function answered(
  signal: AbortSignal | undefined,
  begin: (done: grpc.requestCallback<Bytes>) => { cancel(): void },
): Promise<Bytes> {
  return new Promise((resolve, reject) => {
    const call = begin((error, response) => (error ? reject(error) : resolve(response!)));
    signal?.addEventListener("abort", () => call.cancel(), { once: true });
  });
}

function metadataOf({ token, tenant }: CallHeaders): grpc.Metadata {
  const metadata = new grpc.Metadata();
  if (token !== "") metadata.set("authorization", `Bearer ${token}`);
  if (tenant !== "") metadata.set("dcloc-tenant", tenant);
  return metadata;
}

/** What the page is told of a failed call. */
export interface Failure {
  /** A gRPC status code. */
  code: number;
  message: string;
}

export function failureOf(error: unknown): Failure {
  if (error instanceof Error && "code" in error && typeof error.code === "number") {
    const details = "details" in error ? String(error.details) : error.message;
    // grpc-js ends so where there is nothing to note.
    return { code: error.code, message: details.replace(/\s*Resolution note:\s*$/, "") };
  }
  return { code: grpc.status.INTERNAL, message: "the bridge failed; its log says why" };
}
