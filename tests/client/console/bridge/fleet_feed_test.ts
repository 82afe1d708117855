import assert from "node:assert/strict";
import { test } from "node:test";
import { create, fromBinary, toBinary } from "@bufbuild/protobuf";
import {
  type ListSessionsRequest,
  ListSessionsRequestSchema,
  ListSessionsResponseSchema,
  type Session,
  SessionSchema,
} from "proto/dcloc/v1/admin_service_pb.ts";
import { FleetFeed } from "../../../../client/console/bridge/fleet_feed.ts";
import type { Upstream } from "../../../../client/console/bridge/upstream.ts";
import type { LiveFrame } from "../../../../client/console/shared/live.ts";

function session(sessionId: string, state: number, replica = ""): Session {
  const pose = {
    pose: { translationM: { x: 7, y: 0, z: 0 }, rotation: { w: 1, x: 0, y: 0, z: 0 } },
    covariance: new Array<number>(36).fill(0),
  };
  const vehicleId = `car-${sessionId}`;
  return create(SessionSchema, { sessionId, vehicleId, mapName: "town", state, pose, replica });
}

/** A server with these sessions, which counts how often it was asked. */
class FakeServer {
  sessions: Session[] = [];
  failure: Error | undefined;
  silent: string[] = [];
  calls = 0;
  readonly name = "a";

  lastRequest: ListSessionsRequest | undefined;

  unary(_method: string, _caller: object, request: Buffer): Promise<Buffer> {
    ++this.calls;
    this.lastRequest = fromBinary(ListSessionsRequestSchema, request);
    if (this.failure) return Promise.reject(this.failure);
    const unanswered = this.silent.map((address) => ({ address, fault: "timed out" }));
    const response = create(ListSessionsResponseSchema, { sessions: this.sessions, unanswered });
    return Promise.resolve(Buffer.from(toBinary(ListSessionsResponseSchema, response)));
  }
}

/** Until something holds; the feed reads in its own time. */
async function until(holds: () => boolean): Promise<void> {
  for (let i = 0; i < 500 && !holds(); ++i) await new Promise((resolve) => setTimeout(resolve, 10));
  assert.ok(holds());
}

function readerOf(feed: FleetFeed): { frames: LiveFrame[]; leave: () => void; keepsUp: boolean } {
  const reader = { frames: [] as LiveFrame[], leave: (): void => undefined, keepsUp: true };
  reader.leave = feed.subscribe((line) => {
    if (reader.keepsUp) reader.frames.push(JSON.parse(line) as LiveFrame);
    return reader.keepsUp;
  });
  return reader;
}

function begin(periodMs = 30): { server: FakeServer; feed: FleetFeed } {
  const server = new FakeServer();
  server.sessions = [session("1", 2), session("2", 2)];
  return { server, feed: new FleetFeed(server as unknown as Upstream, { token: "", tenant: "" }, { periodMs }) };
}

test("a server is asked for its own sessions alone where the others are asked as well", async () => {
  for (const isOneOfSeveral of [false, true]) {
    const { server } = begin();
    const feed = new FleetFeed(server as unknown as Upstream, { token: "", tenant: "" }, { periodMs: 30, isOneOfSeveral });
    const { frames, leave } = readerOf(feed);
    await until(() => frames.length > 0);
    leave();
    assert.equal(server.lastRequest!.thisReplicaOnly, isOneOfSeveral);
  }
});

test("all first, then what has changed", async () => {
  const { server, feed } = begin();
  const { frames, leave } = readerOf(feed);
  await until(() => frames.length > 0);
  assert.equal(frames[0]?.full, true);
  assert.deepEqual(frames[0]?.set?.map((s) => s.id), ["1", "2"]);
  frames.length = 0;
  server.sessions = [session("1", 4)];
  await until(() => frames.some((frame) => frame.gone?.length === 1));
  const change = frames.find((frame) => frame.gone?.length === 1)!;
  assert.deepEqual(change.set?.map((s) => [s.id, s.state]), [["1", 4]]);
  assert.deepEqual(change.gone, ["2"]);
  leave();
});

test("a server is asked once for all pages, and not at all without pages", async () => {
  const { server, feed } = begin(100_000);
  const readers = Array.from({ length: 20 }, () => readerOf(feed));
  await until(() => readers.every(({ frames }) => frames.length === 1));
  assert.equal(server.calls, 1);
  for (const { leave } of readers) leave();
  assert.equal(feed.isWatched, false);
});

test("a page that was behind gets everything at once", async () => {
  const { server, feed } = begin();
  const reader = readerOf(feed);
  await until(() => reader.frames.length > 0);
  reader.keepsUp = false;
  const { calls } = server;
  server.sessions = [session("3", 2)];
  await until(() => server.calls > calls + 2);
  reader.frames.length = 0;
  reader.keepsUp = true;
  await until(() => reader.frames.length > 0);
  assert.equal(reader.frames[0]?.full, true);
  assert.deepEqual(reader.frames[0]?.set?.map((s) => s.id), ["3"]);
  reader.leave();
});

test("a server that leaves is told, and comes back whole", async () => {
  const { server, feed } = begin();
  const { frames, leave } = readerOf(feed);
  await until(() => frames.length > 0);
  server.failure = Object.assign(new Error("14 UNAVAILABLE: gone"), { code: 14, details: "gone" });
  await until(() => frames.some((frame) => frame.failure !== undefined));
  assert.deepEqual(frames.find((f) => f.failure)?.failure, { code: 14, message: "gone" });
  frames.length = 0;
  server.failure = undefined;
  await until(() => frames.some((frame) => frame.full));
  assert.equal(frames.find((frame) => frame.full)?.set?.length, 2);
  leave();
});

test("of a server of the fleet that does not answer the last is kept, and it is named", async () => {
  const { server, feed } = begin();
  server.sessions = [session("1", 2, "a:1"), session("2", 2, "b:1"), session("3", 2, "b:1")];
  const { frames, leave } = readerOf(feed);
  await until(() => frames.length > 0);
  assert.equal(frames[0]?.silent, undefined);
  frames.length = 0;
  // The vehicle of session 3 has gone on at the other server, under another id.
  const moved = session("3b", 2, "a:1");
  moved.vehicleId = "car-3";
  server.sessions = [session("1", 2, "a:1"), moved];
  server.silent = ["b:1"];
  await until(() => frames.some((frame) => frame.silent !== undefined));
  const frame = frames.find(({ silent }) => silent !== undefined)!;
  assert.deepEqual(frame.silent, [{ address: "b:1", fault: "timed out" }]);
  assert.deepEqual(frame.gone, ["3"]);
  frames.length = 0;
  server.silent = [];
  await until(() => frames.some(({ gone }) => gone?.length === 1));
  assert.deepEqual(frames.find(({ gone }) => gone?.length === 1)!.gone, ["2"]);
  leave();
});

test("who comes later still learns where vehicles got lost", async () => {
  const { server, feed } = begin();
  const first = readerOf(feed);
  await until(() => first.frames.length > 0);
  server.sessions = [session("1", 4), session("2", 2)];
  await until(() => first.frames.some(({ losses }) => losses?.length === 1));
  first.leave();
  const second = readerOf(feed);
  await until(() => second.frames.length > 0);
  assert.deepEqual(second.frames[0]?.losses?.map(({ vehicle, x }) => [vehicle, x]), [["car-1", 7]]);
  second.leave();
});

test("who comes later sees nothing that the server would not tell now", async () => {
  const { server, feed } = begin();
  const first = readerOf(feed);
  await until(() => first.frames.length > 0);
  first.leave();
  server.failure = Object.assign(new Error("16"), { code: 16, details: "revoked" });
  const second = readerOf(feed);
  await until(() => second.frames.length > 0);
  assert.equal(second.frames[0]?.failure?.code, 16);
  assert.deepEqual(second.frames[0]?.set, []);
  second.leave();
});
