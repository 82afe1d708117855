import assert from "node:assert/strict";
import type { ChildProcess } from "node:child_process";
import { createHash } from "node:crypto";
import { readFileSync, writeFileSync } from "node:fs";
import { request } from "node:http";
import { join } from "node:path";
import { after, before, test } from "node:test";
import type { Browser, Page } from "playwright-core";
import { seriousFindings } from "./accessibility.ts";
import {
  type Program,
  Town,
  dcloc,
  launch,
  openPage,
  signIn,
  startConsole,
  startServer,
} from "./harness.ts";

const HOSTILE_DRIVE = `<script>document.title="executed"</script>`;

const town = new Town();
const store = join(town.folder, "store");
let server: Program;
let bridge: Program;
let browser: Browser;
let vehicles: ChildProcess | undefined;
let page: Page;
let faults: string[];

const settled = (ms: number): Promise<void> => new Promise((resolve) => setTimeout(resolve, ms));
const dialog = () => page.getByRole("dialog");

before(async () => {
  server = await startServer(store);
  const map = town.makeMap("first.dclm", "first drive");
  dcloc("map", "upload", "--server", server.address, "--map", "town", "--activate", map);
  vehicles = town.drive(server.address, "town", 5);
  bridge = await startConsole([server.address]);
  browser = await launch();
  ({ page, faults } = await openPage(browser, bridge.address));
});

after(async () => {
  vehicles?.kill();
  await browser?.close();
  await bridge?.stop();
  await server?.stop();
  town.remove();
});

/** The row of a version in the view of a map; other rows may name it, too. */
const versionRow = (name: string) =>
  page.locator(".row").filter({ has: page.locator("strong", { hasText: new RegExp(`^${name}\\b`) }) });

test("without a token where servers need none, and the vehicles are there, moving", async () => {
  assert.deepEqual(await seriousFindings(page), []);
  await signIn(page);
  await page.getByRole("button", { name: "5 Tracking" }).waitFor();
  await page.locator(".row").first().getByRole("button").first().click();
  await page.getByRole("button", { name: "Follow" }).click();
  const canvas = page.locator("canvas");
  const before = await canvas.screenshot();
  await settled(1_500);
  assert.ok(!before.equals(await canvas.screenshot()), "a followed vehicle drives through the map");
  await page.keyboard.press("Escape");
});

test("no axe finding is serious, in light colours and in dark ones", async () => {
  for (const view of ["/live", "/maps", "/maps/dcloc/town", "/recordings", "/servers"]) {
    await page.goto(bridge.address + view);
    await page.locator("main button, main table").first().waitFor();
    assert.deepEqual(await seriousFindings(page), [], view);
    await page.getByRole("button", { name: /colours$/ }).click();
    assert.deepEqual(await seriousFindings(page), [], view);
  }
});

/** Leaves the first bytes of a file on the server, as a page that is closed while it uploads does. */
async function uploadPart(path: string, size: number): Promise<void> {
  const bytes = readFileSync(path);
  const sha256 = createHash("sha256").update(bytes).digest("hex");
  const query = new URLSearchParams({ map: "town", size: String(bytes.length), sha256, offset: "0" });
  const [cookie] = await page.context().cookies();
  const headers = { origin: bridge.address, cookie: `${cookie!.name}=${cookie!.value}` };
  const url = `${bridge.address}/upload/dcloc?${query}`;
  const sent = request(url, { method: "PUT", headers: { ...headers, "content-length": bytes.length } });
  sent.on("error", () => undefined);
  sent.write(bytes.subarray(0, size));
  await settled(700);
  sent.destroy();
  await settled(300);
}

test("an upload goes on where it stopped, after the page was closed and the network was cut", async () => {
  const file = town.makeMap("second.dclm", HOSTILE_DRIVE);
  await page.goto(`${bridge.address}/maps`);
  await uploadPart(file, 20_000);
  const offsets: number[] = [];
  let cuts = 0;
  await page.route("**/upload/**", (route) => {
    offsets.push(Number(new URL(route.request().url()).searchParams.get("offset")));
    return cuts++ === 0 ? route.abort("connectionreset") : route.continue();
  });
  await page.getByRole("button", { name: "Upload a map" }).click();
  await dialog().getByLabel("Name of the map").fill("town");
  await dialog().getByLabel("Map file").setInputFiles(file);
  await dialog().getByRole("button", { name: "Upload a map" }).click();
  await dialog().getByText("town v2 is on the server.").waitFor();
  await page.unroute("**/upload/**");
  assert.deepEqual(offsets, [20_000, 20_000]);
  await dialog().getByRole("button", { name: "Close" }).click();
});

test("a file that is no map is refused with a word, and the one that is goes on", async () => {
  const file = join(town.folder, "broken.dclm");
  const bytes = readFileSync(join(town.folder, "second.dclm"));
  bytes.fill(0xff, Math.floor(bytes.length / 2));
  writeFileSync(file, bytes);
  await page.getByRole("button", { name: "Upload a map" }).click();
  await dialog().getByLabel("Name of the map").fill("town");
  await dialog().getByLabel("Map file").setInputFiles(file);
  await dialog().getByRole("button", { name: "Upload a map" }).click();
  await dialog().getByRole("alert").waitFor();
  assert.match(await dialog().getByRole("alert").innerText(), /\w{4}/);
  await dialog().getByRole("button", { name: "Close" }).click();
  await page.getByRole("row", { name: /^town/ }).getByText("2", { exact: true }).waitFor();
});

test("activating says what it does to how many sessions, asks once, and moves them", async () => {
  await page.goto(`${bridge.address}/maps/dcloc/town`);
  await versionRow("v2").getByRole("button").first().click();
  await page.getByText(HOSTILE_DRIVE).waitFor();
  await page.getByRole("button", { name: "Activate" }).click();
  await dialog().getByText("New sessions get v2 instead of v1. 5 sessions are open in this map.").waitFor();
  await dialog().getByLabel("Move running sessions as well").check();
  await dialog().getByText("5 of them may be moved").waitFor();
  assert.deepEqual(await seriousFindings(page), []);
  await dialog().getByRole("button", { name: "Activate" }).click();
  await dialog().waitFor({ state: "hidden" });
  await versionRow("v2").getByText("Active").waitFor();
  await versionRow("v2").getByText("Sessions: 5").waitFor();
});

test("a canary begins and ends, a version is rolled back, and one in use is not deleted", async () => {
  await versionRow("v1").getByRole("button").first().click();
  await page.getByRole("button", { name: "Canary …" }).click();
  await dialog().getByLabel("Share of the vehicles").fill("25");
  await dialog().getByText("25 % of the vehicles get v1").waitFor();
  await dialog().getByRole("button", { name: "Canary" }).click();
  await versionRow("v1").getByText("Canary, 25 %").waitFor();
  await page.getByRole("button", { name: "End the canary" }).click();
  await dialog().getByRole("button", { name: "End the canary" }).click();
  await page.getByText("Canary, 25 %").waitFor({ state: "hidden" });
  await page.getByRole("button", { name: "Roll back" }).click();
  await dialog().getByRole("button", { name: "Roll back" }).click();
  await versionRow("v1").getByText("Active").waitFor();
  await versionRow("v2").getByRole("button").first().click();
  await versionRow("v2").getByRole("button", { name: "Delete" }).click();
  await dialog().getByText("5 sessions use this version").waitFor();
  await dialog().getByRole("button", { name: "Delete" }).click();
  await dialog().getByRole("alert").waitFor();
  await dialog().getByRole("button", { name: "Cancel" }).click();
});

test("two versions are compared, under an address that can be shared", async () => {
  await versionRow("v2").getByRole("link", { name: "Compare with v1" }).click();
  await page.getByText(/^(\d+) of \1 squares of the map compared$/).waitFor();
  // The same drive made both: nothing differs.
  const counts = (name: string) => page.getByRole("row", { name }).locator("td").innerText();
  assert.deepEqual([await counts("only in v1"), await counts("only in v2")], ["0", "0"]);
  assert.ok(Number((await counts("in both")).replace(",", "")) > 100);
  assert.deepEqual(await seriousFindings(page), []);
  await page.goto(page.url());
  await page.getByRole("heading", { name: "town: v1 and v2" }).waitFor();
  await page.goto(`${bridge.address}/compare/dcloc/town/1/77`);
  await page.getByText("There is nothing here").waitFor();
  await page.goto(`${bridge.address}/maps/dcloc/town`);
  await versionRow("v2").getByRole("button").first().click();
});

test("what is downloaded is what was uploaded", async () => {
  const download = page.waitForEvent("download");
  await versionRow("v2").getByRole("link", { name: "Download" }).click();
  const file = await download;
  assert.equal(file.suggestedFilename(), "town-v2.dclm");
  assert.ok(readFileSync(await file.path()).equals(readFileSync(join(town.folder, "second.dclm"))));
});

/** Where a session's vehicle is, as nearly as a click can say it: its map shows the whole town. */
async function proposeByClick(): Promise<void> {
  await page.getByRole("button", { name: "Propose a pose" }).click();
  const form = page.getByRole("region", { name: "Propose a pose" });
  const submit = form.getByRole("button", { name: "Propose" });
  assert.ok(await submit.isDisabled(), "no place is chosen yet");
  await page.locator(".session-map canvas").click({ position: { x: 60, y: 60 } });
  const x = form.getByLabel("x, m");
  for (let i = 0; i < 100 && (await x.inputValue()) === ""; ++i) await settled(50);
  assert.match(await x.inputValue(), /^-?\d/);
  await x.fill("");
  await x.pressSequentially("-10.05");
  assert.equal(await x.inputValue(), "-10.05");
  await form.getByLabel("Heading").fill("90");
  await form.getByLabel("Spread").fill("30");
  assert.deepEqual(await seriousFindings(page), []);
  await submit.click();
  // Somewhere else in the town, or near enough: the radars decide.
  await form.getByText(/^(The radars contradict it|It is fused|It guides)/).waitFor();
  await form.getByRole("button", { name: "Close" }).click();
}

test("a session is told in words and time lines, and can be ended", async () => {
  await page.goto(`${bridge.address}/live`);
  await page.locator(".row").first().getByRole("button").first().click();
  await page.getByRole("link", { name: "Details" }).click();
  await page.getByText("The scans agree with the map").waitFor();
  assert.equal(await page.locator(".chart canvas").count(), 6);
  await page.getByRole("img", { name: /^States over time: Tracking/ }).waitFor();
  await page.getByRole("heading", { name: "Sources" }).waitFor();
  assert.deepEqual(await seriousFindings(page), []);
  await proposeByClick();
  await page.getByRole("button", { name: "End the session" }).click();
  await dialog().getByLabel("Reason").fill("<b>maintenance</b>");
  await dialog().getByRole("button", { name: "End the session" }).click();
  await page.getByText("The session is over").waitFor();
});

test("who changed what is listed, and what is hostile in it is only shown", async () => {
  await page.goto(`${bridge.address}/servers`);
  const row = (call: string) => page.getByRole("row").filter({ hasText: call }).first();
  await row("EndSession").getByText("<b>maintenance</b>").waitFor();
  await row("DeleteMapVersion").getByText("failed").waitFor();
  await row("ProposePose").getByText("anonymous").waitFor();
  await page.getByText("There are none: everyone who reaches the server is an admin.").waitFor();
  assert.deepEqual(await seriousFindings(page), []);
});

test("a server that leaves is told, and its vehicles are back when it is", async () => {
  await page.goto(`${bridge.address}/live`);
  await page.locator(".row").first().waitFor();
  const { address } = server;
  vehicles?.kill();
  await server.stop("SIGKILL");
  await page.getByText("does not answer; its vehicles are shown as they last were").waitFor();
  server = await startServer(store, address);
  vehicles = town.drive(address, "town", 3);
  await page.getByRole("button", { name: "3 Tracking" }).waitFor();
  await page.getByText("does not answer").waitFor({ state: "hidden" });
});

test("a page that is cut off from its bridge says so, and goes on", async () => {
  await page.context().setOffline(true);
  const cut = page.getByText("Cut off from the bridge");
  // What is open already stays open offline; a new start of the bridge closes it.
  const { address } = bridge;
  await bridge.stop();
  await cut.waitFor();
  bridge = await startConsole([server.address], new URL(address).host);
  await page.context().setOffline(false);
  // The bridge has forgotten who signed in.
  await page.getByText("The servers no longer know your token").waitFor();
  await signIn(page);
  await page.getByRole("button", { name: "3 Tracking" }).waitFor();
});

test("German is there as well", async () => {
  await page.getByLabel("Language").selectOption("de");
  await page.getByRole("navigation").getByRole("link", { name: "Karten" }).click();
  await page.getByRole("heading", { name: "Karten" }).waitFor();
  await page.getByLabel("Sprache").selectOption("en");
});

test("in all of this nothing was uncaught, and no other host was asked", () => {
  assert.deepEqual(faults, []);
});
