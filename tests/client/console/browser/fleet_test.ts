import assert from "node:assert/strict";
import { after, before, test } from "node:test";
import type { Browser } from "playwright-core";
import { FakeServer, sessionAt } from "./fake_server.ts";
import { type Program, launch, openPage, signIn, startConsole } from "./harness.ts";

const fake = new FakeServer();
let bridge: Program;
let browser: Browser;

before(async () => {
  bridge = await startConsole([await fake.start()]);
  browser = await launch();
});

after(async () => {
  await browser?.close();
  await bridge?.stop();
  fake.stop();
});

const HOSTILE = `<img src=x onerror="document.title='executed'">'"\`\${1}</script>\u202e\u0000`;

test("hostile names and values are shown, and nothing is executed", async () => {
  const strange = sessionAt("../../x?y#z", HOSTILE, 99, Number.NaN, 1e300);
  strange.mapName = HOSTILE;
  fake.sessions = [strange, sessionAt("2", "__proto__", 4, 1e12, -1e12)];
  const { page, faults } = await openPage(browser, bridge.address);
  await signIn(page);
  const choice = page.locator(".place select");
  await choice.waitFor();
  const places = await choice.locator("option").allTextContents();
  assert.ok(places.includes(HOSTILE.replace("\u0000", "\ufffd")) || places.includes(HOSTILE));
  await choice.selectOption({ index: places.findIndex((p) => p.startsWith("<img")) });
  await page.locator(".row", { hasText: "<img src=x" }).waitFor();
  assert.equal(await page.title(), "dcloc console");
  assert.equal(await page.locator("img").count(), 0);
  assert.deepEqual(faults, []);
  await page.close();
});

test("an older server is told by name, call by call, and the rest goes on", async () => {
  fake.sessions = [sessionAt("1", "car", 2, 0, 0)];
  const { page, faults } = await openPage(browser, bridge.address);
  await signIn(page);
  await page.locator(".row").first().getByRole("button").first().click();
  await page.getByRole("link", { name: "Details" }).click();
  await page.getByText("This server is older and does not know that.").waitFor();
  await page.getByRole("link", { name: "Recordings" }).click();
  await page.getByRole("button", { name: "Record a vehicle" }).click();
  await page.getByRole("dialog").getByLabel("Vehicle").fill("car");
  await page.getByRole("dialog").getByRole("button", { name: "Record", exact: true }).click();
  await page.locator(".item").getByText("This server is older and does not know that.").waitFor();
  await page.goto(`${bridge.address}/compare/dcloc/town/1/2`);
  await page.getByText("This server is older and does not know that.").waitFor();
  await page.getByRole("link", { name: "Live" }).click();
  await page.locator(".row", { hasText: "car" }).waitFor();
  assert.deepEqual(faults, []);
  await page.close();
});

test("ten thousand vehicles: the page answers, and shows those that need somebody", async () => {
  fake.sessions = Array.from({ length: 10_000 }, (_, i) => {
    const state = i === 7_777 ? 4 : 2;
    return sessionAt(String(i), `car-${i}`, state, (i % 100) * 20, Math.floor(i / 100) * 20);
  });
  const { page, faults } = await openPage(browser, bridge.address);
  await signIn(page);
  await page.getByRole("button", { name: "9,999 Tracking" }).waitFor();
  assert.match(await page.locator(".rows .row").first().innerText(), /car-7777/);
  assert.ok((await page.locator(".rows .row").count()) <= 200);
  const begin = Date.now();
  await page.getByLabel("Filter by name").fill("car-123");
  await page.locator(".row", { hasText: "car-1234" }).first().waitFor();
  assert.ok(Date.now() - begin < 5_000);
  assert.deepEqual(faults, []);
  await page.close();
});

test("twenty pages with one token ask a server no more often than one", async () => {
  fake.sessions = [sessionAt("1", "car", 2, 0, 0)];
  const { page } = await openPage(browser, bridge.address);
  await signIn(page);
  await page.locator(".row").waitFor();
  const cookies = (await page.context().cookies()).map(({ name, value }) => `${name}=${value}`);
  const stop = new AbortController();
  const readers = await Promise.all(
    Array.from({ length: 19 }, () =>
      fetch(`${bridge.address}/feed`, { headers: { cookie: cookies.join(";") }, signal: stop.signal }),
    ),
  );
  assert.ok(readers.every((response) => response.ok));
  const first = fake.listCount;
  await new Promise((resolve) => setTimeout(resolve, 3_100));
  assert.ok(fake.listCount - first <= 4, `${fake.listCount - first} calls in 3 s`);
  stop.abort();
  await page.close();
});
