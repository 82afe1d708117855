import assert from "node:assert/strict";
import { createServer } from "node:http";
import type { AddressInfo } from "node:net";
import { test } from "node:test";
import { LiveStreams } from "../../../../client/console/bridge/streams.ts";

test("a page hears from the bridge also while no server has anything to tell", async () => {
  const streams = new LiveStreams([], 20);
  const caller = { token: "", tenant: "", key: "" };
  const server = createServer((_, response) => streams.answer(caller, response));
  await new Promise<void>((resolve) => server.listen(0, "127.0.0.1", resolve));
  const stop = new AbortController();
  const { port } = server.address() as AddressInfo;
  const reader = (await fetch(`http://127.0.0.1:${port}`, { signal: stop.signal })).body!.getReader();
  for (let i = 0; i < 3; ++i) {
    const { value } = await reader.read();
    assert.match(new TextDecoder().decode(value), /^\n+$/);
  }
  stop.abort();
  await new Promise((resolve) => server.close(resolve));
});
