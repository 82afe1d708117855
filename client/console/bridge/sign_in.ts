import { create, toBinary } from "@bufbuild/protobuf";
import { status } from "@grpc/grpc-js";
import { ListMapsRequestSchema } from "proto/dcloc/v1/map_service_pb.ts";
import { RequestError } from "./http.ts";
import { type Failure, type Upstream, failureOf } from "./upstream.ts";

const DEADLINE_MS = 5_000;
const MAX_TOKEN_LENGTH = 4_096;
/** What a header may carry and a token may be. */
const TOKEN = /^[\x21-\x7e]*$/;

function tokenOf(body: Buffer): string {
  let token: unknown;
  try {
    token = (JSON.parse(body.toString("utf8")) as { token?: unknown }).token;
  } catch {
    // Said below; the text is not repeated, for it may hold the token.
  }
  if (typeof token !== "string") {
    throw new RequestError(status.INVALID_ARGUMENT, 'the body is no JSON with a "token"');
  }
  const trimmed = token.trim();
  if (trimmed.length > MAX_TOKEN_LENGTH || !TOKEN.test(trimmed)) {
    const message = `a token is at most ${MAX_TOKEN_LENGTH} characters without blanks`;
    throw new RequestError(status.INVALID_ARGUMENT, message);
  }
  return trimmed;
}

/**
 * The token of the body, once one of the servers knows it. A token without permissions is known.
 * Throws RequestError: UNAUTHENTICATED if each server that answers refuses it, UNAVAILABLE if none
 * answers.
 */
export async function signIn(upstreams: readonly Upstream[], body: Buffer): Promise<string> {
  const token = tokenOf(body);
  const question = create(ListMapsRequestSchema, { pageSize: 1 });
  const bytes = Buffer.from(toBinary(ListMapsRequestSchema, question));
  const method = "/dcloc.v1.MapService/ListMaps";
  const failures = await Promise.all(
    upstreams.map((upstream) =>
      upstream.unary(method, { token, tenant: "" }, bytes, DEADLINE_MS).then(
        (): Failure => ({ code: status.OK, message: "" }),
        (error: unknown) => failureOf(error),
      ),
    ),
  );
  if (failures.some(({ code }) => code === status.OK || code === status.PERMISSION_DENIED)) {
    return token;
  }
  const refused = failures.find(({ code }) => code === status.UNAUTHENTICATED);
  const told = refused ?? failures[0]!;
  throw new RequestError(told.code, told.message);
}
