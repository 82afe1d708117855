import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { join } from "node:path";
import { test } from "node:test";
import { openPage, serverCommand, signIn } from "./harness.ts";
import { TownScene, staged } from "./scene.ts";

const scene = staged(new TownScene());

/** Lets the time of a token be over: the shortest that can be given is a day. */
function expire(name: string): void {
  const change = `UPDATE identity SET expire_time_ns = 1 WHERE name = '${name}'`;
  const code = "import sqlite3, sys; c = sqlite3.connect(sys.argv[1]); c.execute(sys.argv[2]); c.commit()";
  execFileSync("python3", ["-c", code, join(scene.store, "identities.sqlite"), change]);
}

test("who may only look is told so by the server, and loses nothing", async () => {
  const token = scene.token("eve", "viewer");
  const { page, faults } = await openPage(scene.browser, scene.bridge.address);
  await signIn(page, "not-a-token");
  await page.getByText("No server knows this token").waitFor();
  await signIn(page, token);
  await page.getByRole("navigation").getByRole("link", { name: "Maps" }).click();
  await page.getByRole("link", { name: "town" }).click();
  await page.getByRole("button", { name: "Delete the map" }).click();
  const dialog = page.getByRole("dialog");
  await dialog.getByRole("button", { name: "Delete" }).click();
  await dialog.getByText("Your token does not permit this").waitFor();
  assert.ok(!page.url().includes(token));
  assert.ok(!(await page.content()).includes(token));
  assert.deepEqual(await page.evaluate(() => document.cookie), "");
  assert.ok(!scene.bridge.log.join("").includes(token));
  assert.deepEqual(faults, []);
  await page.close();
});

test("a vehicle's token sees that it may see nothing", async () => {
  await scene.visit(async (page) => {
    await page.getByText("Not permitted").waitFor();
    await page.getByRole("navigation").getByRole("link", { name: "Maps" }).click();
    await page.getByText("Not permitted").waitFor();
    await page.getByRole("link", { name: "Servers" }).click();
    await page.getByText("Not permitted").first().waitFor();
    await page.getByText("Only admins of the default tenant see who is let in.").waitFor();
  }, scene.token("car-1", "vehicle"));
});

test("a token that is revoked while the page is open ends the visit with a word", async () => {
  const token = scene.token("bob", "admin");
  await scene.visit(async (page) => {
    await page.getByText("A vehicle appears here").or(page.getByText("no vehicles")).first().waitFor();
    const list = serverCommand("token", "list", "--data", scene.store);
    const id = list.split("\n").find((line) => line.includes("bob"))!.trim().split(/\s+/)[0]!;
    serverCommand("token", "revoke", "--data", scene.store, "--id", id);
    await page.getByText("The servers no longer know your token").waitFor();
  }, token);
});

test("a token that expires while the page is open ends the visit with a word, and another one goes on", async () => {
  const next = scene.token("dora", "admin");
  await scene.visit(async (page) => {
    await page.getByRole("link", { name: "Servers" }).click();
    await page.getByText("Serving").waitFor();
    expire("carl");
    await page.getByText("The servers no longer know your token").waitFor();
    await signIn(page, next);
    await page.getByText("Serving").waitFor();
  }, scene.token("carl", "admin"));
});

test("an admin sees who is let in, and revokes one", async () => {
  const revoked = scene.token("mallory", "operator");
  await scene.visit(async (page) => {
    await page.getByRole("link", { name: "Servers" }).click();
    await page.getByRole("button", { name: "Revoke: mallory" }).click();
    const dialog = page.getByRole("dialog");
    await dialog.getByText("Sessions that are open go on").waitFor();
    await dialog.getByRole("button", { name: "Revoke" }).click();
    await page.getByRole("row").filter({ hasText: "mallory" }).getByText("revoked").waitFor();
    await page.getByRole("row").filter({ hasText: "RevokeIdentity" }).getByText("alice").waitFor();
    assert.ok(!(await page.content()).includes(revoked));
  }, scene.token("alice", "admin"));
});

test("the bridge answers nobody else", async () => {
  const { address } = scene.bridge;
  const as = (headers: Record<string, string>, path = "/feed", method = "GET") =>
    fetch(address + path, { method, headers }).then(({ status }) => status);
  assert.equal(await as({}), 401);
  assert.equal(await as({ cookie: "dcloc-console=guess" }), 401);
  assert.equal(await as({}, "/api/login", "POST"), 403);
  assert.equal(await as({ origin: "https://evil.example" }, "/api/login", "POST"), 403);
  assert.equal(await as({ origin: address }, "/api/login", "POST"), 400);
  assert.equal(await as({}, "/../../etc/passwd"), 200);
  assert.equal(await as({}, "/console.txt"), 404);
  const text = await (await fetch(`${address}/%2e%2e/%2e%2e/etc/passwd`)).text();
  assert.match(text, /<title>dcloc console<\/title>|no such file/);
});
