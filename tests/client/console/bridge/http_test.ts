import assert from "node:assert/strict";
import type { IncomingMessage } from "node:http";
import { test } from "node:test";
import { RequestError, addressOf } from "../../../../client/console/bridge/http.ts";

const requestOf = (url: string): IncomingMessage => ({ url }) as IncomingMessage;

test("a path is what a request is addressed to, with its parameters", () => {
  const url = addressOf(requestOf("/watch/east?session=1%2F2"));
  assert.equal(url.pathname, "/watch/east");
  assert.equal(url.searchParams.get("session"), "1/2");
});

test("what is no path is refused with a word, and no path leads to another host", () => {
  for (const path of ["", "//", "//evil.example/rpc/x", "http://evil.example/", "*", "evil.example:443", "/\\evil.example/x"]) {
    assert.throws(() => addressOf(requestOf(path)), RequestError, path);
  }
  assert.equal(addressOf(requestOf("/../../etc/passwd")).pathname, "/etc/passwd");
});
