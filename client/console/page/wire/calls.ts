import {
  type DescMethodClientStreaming,
  type DescMethodUnary,
  type DescMessage,
  type MessageInitShape,
  type MessageShape,
  create,
  fromBinary,
  toBinary,
} from "@bufbuild/protobuf";
import { failureOf, failureOfResponse } from "./failure.ts";
import { inTenant } from "./tenant.ts";

/**
 * Calls a method of a server through the bridge; of one that takes a stream, with this request alone.
 * Rejects with CallFailure.
 */
export async function call<I extends DescMessage, O extends DescMessage>(
  server: string,
  method: DescMethodUnary<I, O> | DescMethodClientStreaming<I, O>,
  request: MessageInitShape<I>,
  signal?: AbortSignal,
): Promise<MessageShape<O>> {
  try {
    const response = await fetch(inTenant(`/rpc/${server}/${method.parent.typeName}/${method.name}`), {
      method: "POST",
      headers: { "Content-Type": "application/x-protobuf" },
      body: toBinary(method.input, create(method.input, request)) as Uint8Array<ArrayBuffer>,
      ...(signal ? { signal } : {}),
    });
    if (!response.ok) throw await failureOfResponse(response);
    return fromBinary(method.output, new Uint8Array(await response.arrayBuffer()));
  } catch (error) {
    throw failureOf(error);
  }
}

export interface ServerName {
  name: string;
  address: string;
}

/** Who is signed in, and at which servers. */
export interface Visit {
  signedIn: boolean;
  hasToken?: boolean;
  servers?: ServerName[];
}

async function api(method: "GET" | "POST", path: string, body?: object): Promise<Visit> {
  try {
    const response = await fetch(`/api/${path}`, {
      method,
      ...(body ? { body: JSON.stringify(body) } : {}),
    });
    if (!response.ok) throw await failureOfResponse(response);
    return (await response.json()) as Visit;
  } catch (error) {
    throw failureOf(error);
  }
}

export const readVisit = (): Promise<Visit> => api("GET", "session");
export const signIn = (token: string): Promise<Visit> => api("POST", "login", { token });
export const signOut = (): Promise<Visit> => api("POST", "logout", {});
