import assert from "node:assert/strict";
import { test } from "node:test";
import { Logins, callerOf } from "../../../../client/console/bridge/logins.ts";

test("a cookie finds its token, and no other", () => {
  const logins = new Logins(1000);
  const cookie = logins.add("secret");
  assert.equal(logins.find(cookie)?.token, "secret");
  assert.equal(logins.find(`${cookie}x`), undefined);
  assert.equal(logins.find(undefined), undefined);
  assert.ok(!cookie.includes("secret"));
  assert.ok(!logins.find(cookie)!.tokenKey.includes("secret"));
});

test("equal tokens share a key, different ones do not", () => {
  const logins = new Logins(1000);
  const [a, b, c] = [logins.add("x"), logins.add("x"), logins.add("y")].map((s) => logins.find(s)!);
  assert.equal(a!.tokenKey, b!.tokenKey);
  assert.notEqual(a!.tokenKey, c!.tokenKey);
});

test("callers of different tenants share nothing, and a tenant is a name that a header can hold", () => {
  const logins = new Logins(1000);
  const login = logins.find(logins.add("x"))!;
  assert.deepEqual(callerOf(login, "acme"), { token: "x", tenant: "acme", key: `${login.tokenKey}/acme` });
  assert.notEqual(callerOf(login, "").key, callerOf(login, "acme").key);
  for (const tenant of ["a/b", "a\r\nb", "Acme", "x".repeat(201)]) {
    assert.throws(() => callerOf(login, tenant), /a tenant has/);
  }
});

test("idle sign-ins are forgotten, used ones are not", () => {
  let now = 0;
  const logins = new Logins(1000, () => now);
  const idle = logins.add("idle");
  const used = logins.add("used");
  now = 900;
  assert.ok(logins.find(used));
  now = 1500;
  assert.equal(logins.find(idle), undefined);
  assert.ok(logins.find(used));
  logins.remove(used);
  assert.equal(logins.find(used), undefined);
});

test("their number is bounded: the one idle for longest goes", () => {
  let now = 0;
  const logins = new Logins(1e9, () => now);
  const first = logins.add("first");
  for (let i = 0; i < 1000; ++i) {
    now += 1;
    logins.add(`token ${i}`);
  }
  assert.equal(logins.size, 1000);
  assert.equal(logins.find(first), undefined);
});
