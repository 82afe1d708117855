import assert from "node:assert/strict";
import type { IncomingMessage } from "node:http";
import { test } from "node:test";
import { Guard, ownOrigins } from "../../../../client/console/bridge/guard.ts";

const guard = new Guard([...ownOrigins("127.0.0.1", 8080, false), "https://console.example"], false);

const refusal = (method: string, headers: Record<string, string>): string | undefined =>
  guard.refusal({ method, headers } as unknown as IncomingMessage);

test("the page's own requests pass", () => {
  assert.equal(refusal("GET", { host: "localhost:8080" }), undefined);
  assert.equal(refusal("GET", { host: "console.example" }), undefined);
  const own = { host: "127.0.0.1:8080", origin: "http://127.0.0.1:8080", "sec-fetch-site": "same-origin" };
  assert.equal(refusal("POST", own), undefined);
});

test("a name that is not ours is refused, so that DNS cannot be rebound", () => {
  assert.match(refusal("GET", { host: "evil.example" })!, /not called "evil.example"/);
  assert.match(refusal("GET", {})!, /not called/);
});

test("other pages are refused", () => {
  const host = "localhost:8080";
  assert.match(refusal("POST", { host, origin: "https://evil.example" })!, /another page/);
  assert.match(refusal("POST", { host, origin: "null" })!, /another page/);
  assert.match(refusal("POST", { host })!, /names no origin/);
  assert.match(refusal("GET", { host, "sec-fetch-site": "cross-site", "sec-fetch-mode": "cors" })!, /another site/);
});

test("a link from elsewhere may open the page", () => {
  const link = { host: "localhost:8080", "sec-fetch-site": "cross-site", "sec-fetch-mode": "navigate" };
  assert.equal(refusal("GET", link), undefined);
});
