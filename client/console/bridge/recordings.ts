import type { ServerResponse } from "node:http";
import { create, toBinary } from "@bufbuild/protobuf";
import { status } from "@grpc/grpc-js";
import { RecordSessionRequestSchema } from "proto/dcloc/v1/admin_service_pb.ts";
import { FrameKind, type StreamEnd } from "../shared/live.ts";
import { beginStream, frame } from "./frames.ts";
import { RequestError, drained } from "./http.ts";
import type { Caller } from "./logins.ts";
import { type Bytes, type ServerStream, type Upstream, failureOf } from "./upstream.ts";

/** The recordings that pages make through this bridge: at most so many at once. */
export class Recordings {
  private runningCount = 0;

  constructor(private readonly maxCount: number) {}

  /**
   * The next session of a vehicle, as frames of RecordSessionResponse; the answer begins once the
   * server waits for that session. Rejects, before anything is answered, if the visitor may not.
   * Nothing is left out: a page that reads too slowly holds the server back, which then ends the
   * recording and says so.
   */
  async answer(
    upstream: Upstream,
    caller: Caller,
    vehicleId: string,
    response: ServerResponse,
  ): Promise<void> {
    if (this.runningCount >= this.maxCount) {
      const message = `${this.runningCount} recordings run already, at most ${this.maxCount}`;
      throw new RequestError(status.RESOURCE_EXHAUSTED, message);
    }
    ++this.runningCount;
    const request = create(RecordSessionRequestSchema, { vehicleId, positionFixes: true });
    const stream = upstream.serverStream(
      "/dcloc.v1.AdminService/RecordSession",
      caller,
      Buffer.from(toBinary(RecordSessionRequestSchema, request)),
    );
    response.on("close", () => stream.cancel());
    try {
      await handOn(stream, response);
    } finally {
      --this.runningCount;
      stream.cancel();
    }
  }

  get count(): number {
    return this.runningCount;
  }
}

async function handOn(stream: ServerStream, response: ServerResponse): Promise<void> {
  // Only a server that takes the vehicle's next session sends headers.
  stream.on("metadata", () => {
    if (!response.headersSent && !response.destroyed) {
      beginStream(response, "application/octet-stream");
    }
  });
  let end: StreamEnd = { code: 0, message: "" };
  try {
    for await (const message of stream as AsyncIterable<Bytes>) {
      response.write(frame(FrameKind.Message, message));
      await drained(response);
    }
  } catch (error) {
    if (!response.headersSent) throw error;
    end = failureOf(error);
  }
  if (response.destroyed) return;
  response.end(frame(FrameKind.End, Buffer.from(JSON.stringify(end))));
}
