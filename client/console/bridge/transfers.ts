import { once } from "node:events";
import type { IncomingMessage, ServerResponse } from "node:http";
import { create, fromBinary, toBinary } from "@bufbuild/protobuf";
import { status } from "@grpc/grpc-js";
import {
  DownloadMapRequestSchema,
  DownloadMapResponseSchema,
  type MapChunk,
  type UploadMapRequest,
  UploadMapRequestSchema,
} from "proto/dcloc/v1/map_service_pb.ts";
import { RequestError, countParameter, drained, parameter } from "./http.ts";
import type { Caller } from "./logins.ts";
import { type Bytes, type Upload, type Upstream, failureOf } from "./upstream.ts";

/** A message of the contract takes at most 1 MiB; smaller ones show progress sooner. */
const CHUNK_BYTES = 256 << 10;

type UploadMessage = Exclude<UploadMapRequest["message"], { case: undefined }>;

function uploadBytes(message: UploadMessage): Bytes {
  return Buffer.from(toBinary(UploadMapRequestSchema, create(UploadMapRequestSchema, { message })));
}

async function sendBody(request: IncomingMessage, call: Upload, begin: number): Promise<void> {
  let offset = begin;
  for await (const part of request as AsyncIterable<Buffer>) {
    for (let at = 0; at < part.length; at += CHUNK_BYTES) {
      const data = part.subarray(at, at + CHUNK_BYTES);
      const value = { $typeName: "dcloc.v1.MapChunk", offsetBytes: BigInt(offset), data };
      offset += data.length;
      // The server reads as fast as its disk takes it, and so holds back the browser.
      const message = { case: "chunk", value: value as MapChunk } as const;
      if (!call.write(uploadBytes(message))) await once(call, "drain");
    }
  }
}

/**
 * PUT with the file's bytes from `offset` on. Resolves with the UploadMapResponse. A browser that goes
 * away leaves the bytes so far on the server, which says where to go on.
 */
export function takeUpload(
  upstream: Upstream,
  caller: Caller,
  url: URL,
  request: IncomingMessage,
): Promise<Bytes> {
  const offset = countParameter(url, "offset");
  const header = {
    mapName: parameter(url, "map"),
    sizeBytes: BigInt(countParameter(url, "size")),
    sha256: parameter(url, "sha256"),
    activate: url.searchParams.get("activate") === "true",
  };
  return new Promise((resolve, reject) => {
    const method = "/dcloc.v1.MapService/UploadMap";
    const call = upstream.upload(method, caller, (error, response) => {
      if (error) reject(error);
      else resolve(response!);
    });
    request.on("close", () => {
      if (!request.complete) call.cancel();
    });
    call.on("error", () => undefined); // The callback has it.
    const value = { $typeName: "dcloc.v1.UploadMapHeader" as const, ...header };
    call.write(uploadBytes({ case: "header", value }));
    sendBody(request, call, offset).then(
      () => call.end(),
      () => call.cancel(),
    );
  });
}

/** GET of a version's file. Rejects, before anything is answered, with what the server says. */
export async function answerDownload(
  upstream: Upstream,
  caller: Caller,
  url: URL,
  response: ServerResponse,
): Promise<void> {
  const mapName = parameter(url, "map");
  const version = BigInt(countParameter(url, "version"));
  const question = create(DownloadMapRequestSchema, { mapName, version });
  const bytes = Buffer.from(toBinary(DownloadMapRequestSchema, question));
  const stream = upstream.serverStream("/dcloc.v1.MapService/DownloadMap", caller, bytes);
  response.on("close", () => stream.cancel());
  try {
    for await (const message of stream as AsyncIterable<Bytes>) {
      const part = fromBinary(DownloadMapResponseSchema, message).message;
      if (part.case === "version") {
        const { value } = part;
        response.writeHead(200, {
          "Content-Type": "application/octet-stream",
          "Content-Length": String(value.sizeBytes),
          // The server's names have no character that could end the quotes.
          "Content-Disposition": `attachment; filename="${fileName(value.mapName, value.version)}"`,
          "Cache-Control": "no-store",
        });
      } else if (part.case === "chunk") {
        response.write(part.value.data);
        await drained(response);
      }
    }
    response.end();
  } catch (error) {
    // Cut off, so that the browser does not take a part for the whole.
    if (response.headersSent) response.destroy();
    else throw asRequestError(error);
  }
}

function fileName(mapName: string, version: bigint): string {
  return `${mapName.replace(/[^a-z0-9_-]/g, "_")}-v${version}.dclm`;
}

function asRequestError(error: unknown): RequestError {
  const failure = failureOf(error);
  return new RequestError(failure.code ?? status.INTERNAL, failure.message);
}
