import assert from "node:assert/strict";
import { mock, test } from "node:test";
import { create, toBinary } from "@bufbuild/protobuf";
import {
  ListSessionsResponseSchema,
  type Session,
  SessionSchema,
} from "proto/dcloc/v1/admin_service_pb.ts";
import { FleetFeed } from "../../../../client/console/bridge/fleet_feed.ts";
import type { Upstream } from "../../../../client/console/bridge/upstream.ts";
import type { LiveFrame } from "../../../../client/console/shared/live.ts";

function session(sessionId: string, state: number): Session {
  return create(SessionSchema, { sessionId, vehicleId: `car-${sessionId}`, mapName: "town", state });
}

/** A server with these sessions, which counts how often it was asked. */
class FakeServer {
  sessions: Session[] = [];
  failure: Error | undefined;
  calls = 0;
  readonly name = "a";

  unary(): Promise<Buffer> {
    ++this.calls;
    if (this.failure) return Promise.reject(this.failure);
    const response = create(ListSessionsResponseSchema, { sessions: this.sessions });
    return Promise.resolve(Buffer.from(toBinary(ListSessionsResponseSchema, response)));
  }
}

const settle = async (): Promise<void> => {
  for (let i = 0; i < 20; ++i) await Promise.resolve();
};

async function nextSecond(): Promise<void> {
  mock.timers.tick(1_001);
  await settle();
}

function readerOf(feed: FleetFeed): { frames: LiveFrame[]; leave: () => void; keepsUp: boolean } {
  const reader = { frames: [] as LiveFrame[], leave: (): void => undefined, keepsUp: true };
  reader.leave = feed.subscribe((line) => {
    if (reader.keepsUp) reader.frames.push(JSON.parse(line) as LiveFrame);
    return reader.keepsUp;
  });
  return reader;
}

function begin(): { server: FakeServer; feed: FleetFeed } {
  mock.timers.reset();
  mock.timers.enable({ apis: ["setTimeout", "Date"] });
  const server = new FakeServer();
  server.sessions = [session("1", 2), session("2", 2)];
  return { server, feed: new FleetFeed(server as unknown as Upstream, { token: "" }) };
}

test("all first, then what has changed", async () => {
  const { server, feed } = begin();
  const { frames, leave } = readerOf(feed);
  await settle();
  assert.equal(frames[0]?.full, true);
  assert.deepEqual(frames[0]?.set?.map((s) => s.id), ["1", "2"]);
  server.sessions = [session("1", 4)];
  await nextSecond();
  assert.deepEqual(frames[1]?.set?.map((s) => [s.id, s.state]), [["1", 4]]);
  assert.deepEqual(frames[1]?.gone, ["2"]);
  leave();
});

test("a server is asked once for all pages, and not at all without pages", async () => {
  const { server, feed } = begin();
  const readers = Array.from({ length: 20 }, () => readerOf(feed));
  await settle();
  await nextSecond();
  assert.equal(server.calls, 2);
  for (const { frames } of readers) assert.equal(frames.length, 2);
  for (const { leave } of readers) leave();
  await nextSecond();
  assert.equal(server.calls, 2);
});

test("a page that was behind gets everything at once", async () => {
  const { server, feed } = begin();
  const reader = readerOf(feed);
  await settle();
  reader.keepsUp = false;
  server.sessions = [session("3", 2)];
  await nextSecond();
  reader.keepsUp = true;
  await nextSecond();
  const last = reader.frames[reader.frames.length - 1]!;
  assert.equal(last.full, true);
  assert.deepEqual(last.set?.map((s) => s.id), ["3"]);
  reader.leave();
});

test("a server that leaves is told, and comes back whole", async () => {
  const { server, feed } = begin();
  const { frames, leave } = readerOf(feed);
  await settle();
  server.failure = Object.assign(new Error("14 UNAVAILABLE: gone"), { code: 14, details: "gone" });
  await nextSecond();
  assert.deepEqual(frames[1]?.failure, { code: 14, message: "gone" });
  server.failure = undefined;
  await nextSecond();
  assert.equal(frames[2]?.full, true);
  assert.equal(frames[2]?.set?.length, 2);
  leave();
});
