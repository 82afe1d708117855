import assert from "node:assert/strict";
import type { ChildProcess } from "node:child_process";
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

const WIDTH_PX = 390;

const town = new Town();
const store = join(town.folder, "store");
let server: Program;
let bridge: Program;
let browser: Browser;
let vehicles: ChildProcess | undefined;
let page: Page;
let faults: string[];

before(async () => {
  server = await startServer(store);
  const upload = ["map", "upload", "--server", server.address, "--map", "town"];
  dcloc(...upload, "--activate", town.makeMap("first.dclm", "first drive"));
  dcloc(...upload, town.makeMap("second.dclm", "second drive"));
  vehicles = town.drive(server.address, "town", 3);
  bridge = await startConsole([server.address]);
  browser = await launch();
  ({ page, faults } = await openPage(browser, bridge.address));
  await signIn(page);
  await page.setViewportSize({ width: WIDTH_PX, height: 844 });
});

after(async () => {
  vehicles?.kill();
  await browser?.close();
  await bridge?.stop();
  await server?.stop();
  town.remove();
});

/** Keeps a picture of the page, where somebody wants to look at it. */
async function keepPicture(name: string): Promise<void> {
  const folder = process.env["DCLOC_CONSOLE_PICTURES"];
  if (folder) await page.screenshot({ path: join(folder, `${name}.png`), fullPage: true });
}

async function openSession(): Promise<void> {
  await page.goto(`${bridge.address}/live`);
  await page.locator(".row").first().getByRole("button").first().click();
  await page.getByRole("link", { name: "Details" }).click();
  await page.getByText("The scans agree with the map").waitFor();
}

const VIEWS: Record<string, () => Promise<unknown>> = {
  live: () => page.goto(`${bridge.address}/live`),
  maps: () => page.goto(`${bridge.address}/maps`),
  map: () => page.goto(`${bridge.address}/maps/dcloc/town`),
  compare: () => page.goto(`${bridge.address}/compare/dcloc/town/1/2`),
  recordings: () => page.goto(`${bridge.address}/recordings`),
  servers: () => page.goto(`${bridge.address}/servers`),
  session: openSession,
};

for (const [name, open] of Object.entries(VIEWS)) {
  test(`on a phone: ${name} needs no sideways scrolling, and no axe finding is serious`, async () => {
    await open();
    await page.locator("main button, main table").first().waitFor();
    const width = await page.evaluate(() => document.documentElement.scrollWidth);
    await keepPicture(`phone-${name}`);
    assert.ok(width <= WIDTH_PX, `a page of ${width} pixels`);
    assert.deepEqual(await seriousFindings(page), []);
  });
}

test("on a phone: a vehicle's name stays on one line", async () => {
  await openSession();
  assert.ok((await page.getByRole("heading", { level: 1 }).boundingBox())!.height < 45);
});

test("on a phone: a short name in a table stays on one line", async () => {
  await VIEWS["maps"]!();
  const name = page.getByRole("row").getByRole("link", { name: "town" });
  assert.ok((await name.boundingBox())!.height < 30);
  await VIEWS["servers"]!();
  const who = page.getByRole("row").filter({ hasText: "UploadMap" }).getByRole("rowheader").first();
  assert.ok((await who.boundingBox())!.width >= 90);
});

test("with keys alone: to the content, into a question and out of it", async () => {
  await page.goto(`${bridge.address}/maps/dcloc/town`);
  await page.getByRole("button", { name: "Delete the map" }).waitFor();
  await page.keyboard.press("Tab");
  assert.equal(await page.evaluate(() => document.activeElement?.textContent), "Skip to the content");
  await page.keyboard.press("Enter");
  await page.getByRole("button", { name: "Delete the map" }).focus();
  await page.keyboard.press("Enter");
  await page.getByRole("dialog").waitFor();
  await page.keyboard.press("Escape");
  await page.getByRole("dialog").waitFor({ state: "hidden" });
  const focused = await page.evaluate(() => document.activeElement?.textContent);
  assert.equal(focused, "Delete the map", "who closes a question is where he was");
});

test("in all of this nothing was uncaught, and no other host was asked", () => {
  assert.deepEqual(faults, []);
});
