import type { IncomingMessage, ServerResponse } from "node:http";
import { status } from "@grpc/grpc-js";
import type { Failure } from "./upstream.ts";

const HTTP_STATUS: Partial<Record<number, number>> = {
  [status.INVALID_ARGUMENT]: 400,
  [status.UNAUTHENTICATED]: 401,
  [status.PERMISSION_DENIED]: 403,
  [status.NOT_FOUND]: 404,
  [status.ALREADY_EXISTS]: 409,
  [status.ABORTED]: 409,
  [status.FAILED_PRECONDITION]: 412,
  [status.RESOURCE_EXHAUSTED]: 429,
  [status.UNIMPLEMENTED]: 501,
  [status.UNAVAILABLE]: 503,
  [status.DEADLINE_EXCEEDED]: 504,
};

/** A request that is answered with a failure, as the page reads it. */
export class RequestError extends Error {
  constructor(
    readonly code: number,
    message: string,
  ) {
    super(message);
  }
}

export function answerJson(response: ServerResponse, value: unknown, httpStatus = 200): void {
  const body = Buffer.from(JSON.stringify(value));
  response.writeHead(httpStatus, {
    "Content-Type": "application/json",
    "Content-Length": body.length,
    "Cache-Control": "no-store",
  });
  response.end(body);
}

export function answerFailure(response: ServerResponse, failure: Failure): void {
  answerJson(response, failure, HTTP_STATUS[failure.code] ?? 500);
}

/** What the request is addressed to. Throws RequestError if it is nothing. */
export function addressOf(request: IncomingMessage): URL {
  const base = new URL("http://console");
  try {
    const url = new URL(request.url ?? "", base);
    // Two slashes begin the name of a host.
    if (request.url?.startsWith("/") && url.host === base.host) return url;
  } catch {
    // It is refused as well.
  }
  throw new RequestError(status.INVALID_ARGUMENT, "the request names no path of this page");
}

/** Whether the caller left before all of the request had come. */
export function isAborted(request: IncomingMessage): boolean {
  return request.destroyed && !request.complete;
}

/** Reads a body of at most `maxBytes`. Throws RequestError. */
export async function readBody(request: IncomingMessage, maxBytes: number): Promise<Buffer> {
  const chunks: Buffer[] = [];
  let size = 0;
  for await (const chunk of request as AsyncIterable<Buffer>) {
    size += chunk.length;
    if (size > maxBytes) {
      const message = `the request is larger than ${maxBytes} bytes`;
      throw new RequestError(status.RESOURCE_EXHAUSTED, message);
    }
    chunks.push(chunk);
  }
  return Buffer.concat(chunks);
}

/** A cookie of the request. */
export function cookieOf(request: IncomingMessage, name: string): string | undefined {
  for (const part of (request.headers.cookie ?? "").split(";")) {
    const [key, value] = part.trim().split("=", 2);
    if (key === name) return value;
  }
  return undefined;
}

/** A parameter of the address. Throws RequestError if it is missing. */
export function parameter(url: URL, name: string): string {
  const value = url.searchParams.get(name);
  if (value === null) throw new RequestError(status.INVALID_ARGUMENT, `${name} is missing`);
  return value;
}

/** A whole number >= 0 of the address. Throws RequestError. */
export function countParameter(url: URL, name: string): number {
  const text = parameter(url, name);
  const value = Number(text);
  if (!/^\d{1,16}$/.test(text) || !Number.isSafeInteger(value)) {
    throw new RequestError(status.INVALID_ARGUMENT, `${name} is "${text}"; it must be a number >= 0`);
  }
  return value;
}

/** Waits until the answer may be written on, or its reader is gone. */
export function drained(response: ServerResponse): Promise<void> {
  if (!response.writableNeedDrain || response.destroyed) return Promise.resolve();
  return new Promise((resolve) => {
    const done = (): void => {
      response.off("drain", done).off("close", done);
      resolve();
    };
    response.on("drain", done).on("close", done);
  });
}
