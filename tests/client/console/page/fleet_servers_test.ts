import assert from "node:assert/strict";
import { test } from "node:test";
import "./browser_globals.ts";
import { create } from "@bufbuild/protobuf";
import { GetServerStateResponseSchema } from "proto/dcloc/v1/admin_service_pb.ts";
import {
  type FleetServer,
  merged,
  withLastStates,
} from "../../../../client/console/page/views/fleet_servers.ts";
import { CallFailure, Code } from "../../../../client/console/page/wire/failure.ts";

const state = create(GetServerStateResponseSchema, { sessionCount: 7 });
const via = (name: string) => ({ name, address: `${name}:1` });
const failure = new CallFailure(Code.Unavailable, "gone");

const server = (name: string, more: Partial<FleetServer> = {}): FleetServer => ({
  name,
  via: via("a"),
  replica: name,
  ...more,
});

test("a server of which two tell is there once, with the state that one of them got", () => {
  const one = [server("x", { fault: "timed out" }), server("y", { state })];
  const other = [server("x", { state, via: via("b") }), server("y", { fault: "timed out" })];
  const all = merged([one, other]);
  assert.deepEqual(all.map(({ name, fault }) => [name, fault]), [["x", undefined], ["y", undefined]]);
  assert.equal(all[0]!.via.name, "b");
});

test("a server that falls silent keeps its last figures, with the fault", () => {
  const [silent] = withLastStates([server("x", { fault: "timed out" })], [server("x", { state })]);
  assert.deepEqual([silent?.fault, silent?.state?.sessionCount], ["timed out", 7]);
});

test("where nobody can be asked for a fleet, its servers stay, with the failure", () => {
  const before = [server("x", { state }), server("y", { state }), server("z", { via: via("b"), state })];
  const now = [server("a", { failure }), server("z", { via: via("b"), state })];
  const all = withLastStates(now, before);
  assert.deepEqual(all.map(({ name, failure: f }) => [name, f?.message]), [
    ["x", "gone"],
    ["y", "gone"],
    ["z", undefined],
  ]);
});

test("one that was never reached is there by its name at the bridge", () => {
  assert.deepEqual(withLastStates([server("a", { failure })], []).map(({ name }) => name), ["a"]);
});
