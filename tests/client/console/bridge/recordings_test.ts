import assert from "node:assert/strict";
import { type Server, createServer } from "node:http";
import type { AddressInfo } from "node:net";
import { PassThrough } from "node:stream";
import { after, before, test } from "node:test";
import { Recordings } from "../../../../client/console/bridge/recordings.ts";
import type { ServerStream, Upstream } from "../../../../client/console/bridge/upstream.ts";
import { FrameKind } from "../../../../client/console/shared/live.ts";
import { FrameReader } from "../../../../client/console/page/wire/frames.ts";

const CALLER = { token: "secret", tenant: "", key: "key" };
const recordings = new Recordings(1);
type FakeStream = PassThrough & { cancel(): void };
let onStream: (stream: FakeStream) => void = () => undefined;
let server: Server;
let address: string;

const refusal = (code: number, details: string): Error =>
  Object.assign(new Error(details), { code, details });

function openStream(): ServerStream {
  const stream: FakeStream = Object.assign(new PassThrough({ objectMode: true }), {
    cancel: () => void stream.destroy(refusal(1, "cancelled")),
  });
  onStream(stream);
  return stream as unknown as ServerStream;
}

/** The stream to the server that the next request opens. */
const nextStream = (): Promise<FakeStream> => new Promise((resolve) => (onStream = resolve));

before(async () => {
  const upstream = { serverStream: openStream } as unknown as Upstream;
  server = createServer((_, response) => {
    recordings.answer(upstream, CALLER, "car-1", response).catch((error: Error) => {
      response.writeHead(500);
      response.end(error.message);
    });
  });
  await new Promise<void>((resolve) => server.listen(0, "127.0.0.1", resolve));
  address = `http://127.0.0.1:${(server.address() as AddressInfo).port}`;
});

after(() => server.close());

async function* framesOf(response: Response): AsyncGenerator<[FrameKind, string]> {
  const frames = new FrameReader();
  for await (const chunk of response.body as unknown as AsyncIterable<Uint8Array>) {
    for (const [kind, payload] of frames.take(chunk)) yield [kind, new TextDecoder().decode(payload)];
  }
}

test("messages are handed on as they come, and the server's word ends them", async () => {
  const opened = nextStream();
  const answer = fetch(address);
  const stream = await opened;
  stream.emit("metadata");
  const frames = framesOf(await answer);
  stream.write(Buffer.from("one"));
  assert.deepEqual((await frames.next()).value, [FrameKind.Message, "one"]);
  stream.write(Buffer.from("two"));
  assert.deepEqual((await frames.next()).value, [FrameKind.Message, "two"]);
  stream.destroy(refusal(8, "read too slowly"));
  const end = JSON.stringify({ code: 8, message: "read too slowly" });
  assert.deepEqual((await frames.next()).value, [FrameKind.End, end]);
  assert.equal((await frames.next()).done, true);
  assert.equal(recordings.count, 0);
});

test("what is refused before it begins is no stream", async () => {
  const opened = nextStream();
  const answer = fetch(address);
  (await opened).destroy(refusal(7, "not permitted"));
  const response = await answer;
  assert.deepEqual([response.status, await response.text()], [500, "not permitted"]);
  assert.equal(recordings.count, 0);
});

test("there are at most so many, and one whose page leaves ends at the server", async () => {
  const stop = new AbortController();
  const opened = nextStream();
  const first = fetch(address, { signal: stop.signal });
  const stream = await opened;
  stream.emit("metadata");
  await first;
  assert.equal(await (await fetch(address)).text(), "1 recordings run already, at most 1");
  assert.ok(!stream.destroyed);
  const closed = new Promise((resolve) => stream.once("close", resolve));
  stop.abort();
  await closed;
  while (recordings.count > 0) await new Promise(setImmediate);
});
