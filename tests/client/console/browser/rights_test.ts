import assert from "node:assert/strict";
import { join } from "node:path";
import { after, before, test } from "node:test";
import type { Browser } from "playwright-core";
import {
  type Program,
  Town,
  dcloc,
  launch,
  openPage,
  serverCommand,
  signIn,
  startConsole,
  startServer,
} from "./harness.ts";

const town = new Town();
const store = join(town.folder, "store");
let server: Program;
let bridge: Program;
let browser: Browser;

function createToken(name: string, role: string): string {
  return serverCommand("token", "create", "--data", store, "--name", name, "--role", role).trim();
}

before(async () => {
  server = await startServer(store);
  const map = town.makeMap("map.dclm", "drive");
  dcloc("map", "upload", "--server", server.address, "--map", "town", "--activate", map);
  bridge = await startConsole([server.address]);
  browser = await launch();
});

after(async () => {
  await browser?.close();
  await bridge?.stop();
  await server?.stop();
  town.remove();
});

test("who may only look is told so by the server, and loses nothing", async () => {
  const token = createToken("eve", "viewer");
  const { page, faults } = await openPage(browser, bridge.address);
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
  assert.ok(!bridge.log.join("").includes(token));
  assert.deepEqual(faults, []);
  await page.close();
});

test("a vehicle's token sees that it may see nothing", async () => {
  const { page, faults } = await openPage(browser, bridge.address);
  await signIn(page, createToken("car-1", "vehicle"));
  await page.getByText("Not permitted").waitFor();
  await page.getByRole("navigation").getByRole("link", { name: "Maps" }).click();
  await page.getByText("Not permitted").waitFor();
  await page.getByRole("link", { name: "Servers" }).click();
  await page.getByText("Not permitted").first().waitFor();
  await page.getByText("Only admins of the default tenant see who is let in.").waitFor();
  assert.deepEqual(faults, []);
  await page.close();
});

test("a token that is revoked while the page is open ends the visit with a word", async () => {
  const token = createToken("bob", "admin");
  const { page, faults } = await openPage(browser, bridge.address);
  await signIn(page, token);
  await page.getByText("A vehicle appears here").or(page.getByText("no vehicles")).first().waitFor();
  const list = serverCommand("token", "list", "--data", store);
  const id = list.split("\n").find((line) => line.includes("bob"))!.trim().split(/\s+/)[0]!;
  serverCommand("token", "revoke", "--data", store, "--id", id);
  await page.getByText("The servers no longer know your token").waitFor();
  assert.deepEqual(faults, []);
  await page.close();
});

test("an admin sees who is let in, and revokes one", async () => {
  const { page, faults } = await openPage(browser, bridge.address);
  const revoked = createToken("mallory", "operator");
  await signIn(page, createToken("alice", "admin"));
  await page.getByRole("link", { name: "Servers" }).click();
  await page.getByRole("button", { name: "Revoke: mallory" }).click();
  const dialog = page.getByRole("dialog");
  await dialog.getByText("Sessions that are open go on").waitFor();
  await dialog.getByRole("button", { name: "Revoke" }).click();
  await page.getByRole("row").filter({ hasText: "mallory" }).getByText("revoked").waitFor();
  await page.getByRole("row").filter({ hasText: "RevokeIdentity" }).getByText("alice").waitFor();
  assert.ok(!(await page.content()).includes(revoked));
  assert.deepEqual(faults, []);
  await page.close();
});

test("the bridge answers nobody else", async () => {
  const { address } = bridge;
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
