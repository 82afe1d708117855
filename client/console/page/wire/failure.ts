/** The gRPC status codes that the page tells apart. */
export const enum Code {
  Cancelled = 1,
  NotFound = 5,
  PermissionDenied = 7,
  ResourceExhausted = 8,
  FailedPrecondition = 9,
  Unimplemented = 12,
  Internal = 13,
  Unavailable = 14,
  Unauthenticated = 16,
}

/** A call that did not succeed; the message is the server's own. */
export class CallFailure extends Error {
  constructor(
    readonly code: number,
    message: string,
  ) {
    super(message);
  }
}

export function failureOf(error: unknown): CallFailure {
  if (error instanceof CallFailure) return error;
  if (error instanceof DOMException && error.name === "AbortError") {
    return new CallFailure(Code.Cancelled, "");
  }
  // fetch says no more than that it did not reach anybody.
  if (error instanceof TypeError) return new CallFailure(Code.Unavailable, "");
  return new CallFailure(Code.Internal, error instanceof Error ? error.message : String(error));
}

/** What the bridge answered instead of the result. */
export async function failureOfResponse(response: Response): Promise<CallFailure> {
  try {
    const { code, message } = (await response.json()) as { code: number; message: string };
    return new CallFailure(code, message);
  } catch {
    return new CallFailure(Code.Unavailable, `HTTP ${response.status}`);
  }
}
