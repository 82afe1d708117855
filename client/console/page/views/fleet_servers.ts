import { AdminService, type GetServerStateResponse } from "proto/dcloc/v1/admin_service_pb.ts";
import { type ServerName, call } from "../wire/calls.ts";
import { type CallFailure, Code, failureOf } from "../wire/failure.ts";

/** A server, as one that the bridge knows tells of it. */
export interface FleetServer {
  /** What it is called here: its address among the others, or its name at the bridge. */
  name: string;
  /** The server that is asked for it. */
  via: ServerName;
  /** Its address among the others; empty for the one that is asked. */
  replica: string;
  /** The last one that it told, where it does not answer now. */
  state?: GetServerStateResponse;
  /** Why there is no state, as the others tell it. */
  fault?: string;
  failure?: CallFailure;
}

async function askForOne(via: ServerName, signal: AbortSignal): Promise<FleetServer[]> {
  const state = await call(via.name, AdminService.method.getServerState, {}, signal);
  return [{ name: state.replica || via.name, via, replica: state.replica, state }];
}

/** The servers of the fleet that one of them belongs to; older ones know of themselves alone. */
async function askForAll(via: ServerName, signal: AbortSignal): Promise<FleetServer[]> {
  try {
    const { replicas } = await call(via.name, AdminService.method.listReplicas, {}, signal);
    return replicas.map(({ address, state, fault }) => ({
      name: address || via.name,
      via,
      replica: address,
      ...(state ? { state } : { fault }),
    }));
  } catch (error) {
    if (failureOf(error).code !== Code.Unimplemented) throw error;
    return askForOne(via, signal);
  }
}

/** Each server once: several that the bridge knows may tell of the same one, and one has its state. */
export function merged(answers: readonly FleetServer[][]): FleetServer[] {
  const servers = new Map<string, FleetServer>();
  for (const server of answers.flat()) {
    const old = servers.get(server.name);
    if (!old || (!old.state && server.state)) servers.set(server.name, server);
  }
  return [...servers.values()];
}

/**
 * Servers as they are told now, with the last state of those that tell none. Where nobody could be
 * asked for a server, it stays, with the failure.
 */
export function withLastStates(
  now: readonly FleetServer[],
  before: readonly FleetServer[],
): FleetServer[] {
  const failures = new Map<string, CallFailure>();
  for (const { via, failure } of now) if (failure) failures.set(via.name, failure);
  const old = before.filter(({ via }) => failures.has(via.name));
  const told = now.filter(({ failure, via }) => !failure || !old.some((o) => o.via.name === via.name));
  const names = new Set(told.map(({ name }) => name));
  const kept = old
    .filter(({ name }) => !names.has(name))
    .map((server) => ({ ...server, failure: failures.get(server.via.name)! }));
  const last = new Map(before.map(({ name, state }) => [name, state]));
  return [...told, ...kept]
    .map((server) => {
      const state = server.state ?? last.get(server.name);
      return state ? { ...server, state } : server;
    })
    .sort((a, b) => a.name.localeCompare(b.name));
}

/** Every server that those of the bridge know of. One that does not answer is there with its failure. */
export async function listServers(
  servers: readonly ServerName[],
  signal: AbortSignal,
): Promise<FleetServer[]> {
  const answers = await Promise.all(
    servers.map((via) =>
      askForAll(via, signal).catch((error: unknown): FleetServer[] => [
        { name: via.name, via, replica: "", failure: failureOf(error) },
      ]),
    ),
  );
  return merged(answers);
}
