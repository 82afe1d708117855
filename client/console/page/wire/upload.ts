import { sha256 } from "@noble/hashes/sha2";
import { bytesToHex } from "@noble/hashes/utils";
import { fromBinary } from "@bufbuild/protobuf";
import {
  MapService,
  type MapVersion,
  UploadMapResponseSchema,
} from "proto/dcloc/v1/map_service_pb.ts";
import { call } from "./calls.ts";
import { expected } from "./expected.ts";
import { CallFailure, Code, failureOf } from "./failure.ts";
import { inTenant } from "./tenant.ts";

const HASH_CHUNK_BYTES = 4 << 20;
const MAX_WAIT_MS = 15_000;

/** What an upload is doing; `share` is of the file. */
export interface UploadProgress {
  step: "hashing" | "sending" | "waiting" | "checking";
  share: number;
}

export interface UploadOrder {
  server: string;
  map: string;
  file: File;
  activate: boolean;
}

async function hash(file: File, onShare: (share: number) => void, stop: AbortSignal): Promise<string> {
  const hasher = sha256.create();
  for (let at = 0; at < file.size; at += HASH_CHUNK_BYTES) {
    stop.throwIfAborted();
    hasher.update(new Uint8Array(await file.slice(at, at + HASH_CHUNK_BYTES).arrayBuffer()));
    onShare(at / file.size);
  }
  return bytesToHex(hasher.digest());
}

/** Sends the file from `offset` on. XMLHttpRequest, for it alone tells how much is sent. */
function send(
  order: UploadOrder,
  digest: string,
  offset: number,
  onSent: (bytes: number) => void,
  stop: AbortSignal,
): Promise<Uint8Array> {
  const query = new URLSearchParams({
    map: order.map,
    size: String(order.file.size),
    sha256: digest,
    offset: String(offset),
    activate: String(order.activate),
  });
  return new Promise((resolve, reject) => {
    const request = new XMLHttpRequest();
    request.open("PUT", inTenant(`/upload/${order.server}?${query}`));
    request.responseType = "arraybuffer";
    request.upload.onprogress = (event) => onSent(offset + event.loaded);
    request.onload = () => {
      const bytes = new Uint8Array(request.response as ArrayBuffer);
      if (request.status === 200) return resolve(bytes);
      try {
        const told = JSON.parse(new TextDecoder().decode(bytes)) as { code: number; message: string };
        reject(new CallFailure(told.code, told.message));
      } catch {
        reject(new CallFailure(Code.Unavailable, `HTTP ${request.status}`));
      }
    };
    request.onerror = () => reject(new CallFailure(Code.Unavailable, ""));
    request.onabort = () => reject(new CallFailure(Code.Cancelled, ""));
    stop.addEventListener("abort", () => request.abort());
    request.send(order.file.slice(offset));
  });
}

/**
 * Uploads a map. When the connection breaks it goes on from where the server says, as often as it
 * takes; so does an upload of the same file after the page was loaded again. Rejects with CallFailure.
 */
export async function uploadMap(
  order: UploadOrder,
  onProgress: (progress: UploadProgress) => void,
  stop: AbortSignal,
): Promise<MapVersion> {
  const { file, server } = order;
  const onHashed = (share: number): void => onProgress({ step: "hashing", share });
  const digest = await hash(file, onHashed, stop);
  for (let waitMs = 500; ; waitMs = Math.min(2 * waitMs, MAX_WAIT_MS)) {
    try {
      const known = await call(server, MapService.method.getMapUpload, { sha256: digest }, stop);
      const offset = known.stored ? file.size : Number(known.durableSizeBytes);
      const onSent = (bytes: number): void => {
        const share = bytes / file.size;
        onProgress({ step: share < 1 ? "sending" : "checking", share });
        if (bytes > offset) waitMs = 500;
      };
      onSent(offset);
      const answer = await send(order, digest, offset, onSent, stop);
      return expected(fromBinary(UploadMapResponseSchema, answer).version);
    } catch (error) {
      const failure = failureOf(error);
      if (failure.code !== Code.Unavailable || stop.aborted) throw failure;
      onProgress({ step: "waiting", share: Number.NaN });
      await new Promise((resolve) => setTimeout(resolve, waitMs));
    }
  }
}
