import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { mkdtempSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { after, before, test } from "node:test";
import type { Browser } from "playwright-core";
import {
  type Program,
  launch,
  openPage,
  serverCommand,
  signIn,
  startConsole,
  startServer,
} from "./harness.ts";

const folder = mkdtempSync(join(tmpdir(), "dcloc-console-"));
const store = join(folder, "store");
const certificate = join(folder, "localhost.pem");
const key = join(folder, "localhost.key");
const TO_BROWSERS = ["--tls-cert", certificate, "--tls-key", key];
let server: Program;
let browser: Browser;
let token: string;

before(async () => {
  // Made before: the bundle has no path of the tree, its caller does.
  const script = process.env["DCLOC_CERTIFICATES"]!;
  execFileSync(script, ["--out", folder, "--server", "localhost"], { stdio: "ignore" });
  token = serverCommand("token", "create", "--data", store, "--name", "ops", "--role", "admin").trim();
  server = await startServer(store, "127.0.0.1:0", TO_BROWSERS);
  browser = await launch();
});

after(async () => {
  await browser?.close();
  await server?.stop();
  rmSync(folder, { recursive: true, force: true });
});

const startBridge = (...more: string[]): Promise<Program> =>
  startConsole([server.address.replace("127.0.0.1", "localhost")], "127.0.0.1:0", more);

test("TLS to both sides: the token goes to the server, and the cookie over TLS alone", async () => {
  const bridge = await startBridge("--server-ca", join(folder, "ca.pem"), ...TO_BROWSERS);
  assert.match(bridge.address, /^https:/);
  const { page, faults } = await openPage(browser, bridge.address);
  await signIn(page, token);
  await page.getByText("A vehicle appears here as soon as it opens a session.").waitFor();
  const [cookie] = await page.context().cookies();
  assert.equal(cookie!.name, "__Host-dcloc");
  assert.ok(cookie!.secure && cookie!.httpOnly && cookie!.sameSite === "Strict");
  await page.getByRole("link", { name: "Servers" }).click();
  await page.getByText("Certificate until").waitFor();
  assert.deepEqual(faults, []);
  await page.close();
  await bridge.stop();
});

test("a server that shows the certificate of another authority gets no token", async () => {
  const foreign = join(folder, "foreign");
  const script = process.env["DCLOC_CERTIFICATES"]!;
  execFileSync(script, ["--out", foreign, "--server", "localhost"], { stdio: "ignore" });
  const bridge = await startBridge("--server-ca", join(foreign, "ca.pem"), ...TO_BROWSERS);
  const { page, faults } = await openPage(browser, bridge.address);
  await signIn(page, token);
  await page.getByText("No server answers. The token could not be checked.").waitFor();
  assert.deepEqual(faults, []);
  await page.close();
  await bridge.stop();
});
