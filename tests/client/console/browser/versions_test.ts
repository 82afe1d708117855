import assert from "node:assert/strict";
import type { ChildProcess } from "node:child_process";
import { after, test } from "node:test";
import type { Page } from "playwright-core";
import { seriousFindings } from "./accessibility.ts";
import { signIn, until } from "./harness.ts";
import { TownScene, staged, testNothingWentWrong } from "./scene.ts";
import { stopVehicles } from "./town.ts";

let page: Page;
const scene = staged(new TownScene({ versions: ["first drive", "second drive"], vehicles: 3, isGraded: true }), async (scene) => {
  ({ page } = scene);
  await signIn(page);
  await page.getByRole("button", { name: "3 Tracking" }).waitFor();
});
let more: ChildProcess | undefined;

after(() => stopVehicles(more));

test("activating says what it does to how many sessions, asks once, and moves them", async () => {
  await scene.goto("/maps/dcloc/town");
  await scene.choose("v2");
  await page.getByText("second drive").waitFor();
  await page.getByRole("button", { name: "Activate" }).click();
  await scene.dialog.getByText("New sessions get v2 instead of v1. 3 sessions are open in this map.").waitFor();
  await scene.dialog.getByLabel("Move running sessions as well").check();
  await scene.dialog.getByText("3 of them may be moved").waitFor();
  assert.deepEqual(await seriousFindings(page), []);
  await scene.dialog.getByRole("button", { name: "Activate" }).click();
  await scene.dialog.waitFor({ state: "hidden" });
  await scene.versionRow("v2").getByText("Active").waitFor();
  await scene.versionRow("v2").getByText("Sessions: 3").waitFor();
});

test("a canary begins and ends, a version is rolled back, and one in use is not deleted", async () => {
  const { dialog } = scene;
  await scene.choose("v1");
  await page.getByRole("button", { name: "Canary …" }).click();
  await dialog.getByLabel("Share of the vehicles").fill("25");
  await dialog.getByText("25 % of the vehicles get v1").waitFor();
  await dialog.getByRole("button", { name: "Canary" }).click();
  await scene.versionRow("v1").getByText("Canary, 25 %").waitFor();
  await page.getByRole("button", { name: "End the canary" }).click();
  await dialog.getByRole("button", { name: "End the canary" }).click();
  await page.getByText("Canary, 25 %").waitFor({ state: "hidden" });
  await page.getByRole("button", { name: "Roll back" }).click();
  await dialog.getByRole("button", { name: "Roll back" }).click();
  await scene.versionRow("v1").getByText("Active").waitFor();
  await scene.choose("v2");
  await scene.versionRow("v2").getByRole("button", { name: "Delete" }).click();
  await dialog.getByText("3 sessions use this version").waitFor();
  await dialog.getByText("While sessions use it, the server refuses.").waitFor();
  await dialog.getByRole("button", { name: "Delete" }).click();
  await dialog.getByRole("alert").waitFor();
  await dialog.getByRole("button", { name: "Cancel" }).click();
  await scene.goto("/servers");
  const row = page.getByRole("row").filter({ hasText: "DeleteMapVersion" });
  await row.getByText("failed").waitFor();
});

test("the street has the colour of what vehicles can expect there, where a version tells it", async () => {
  await scene.goto("/maps/dcloc/town");
  await scene.choose("v3");
  await page.getByText("Expected within 0.1 m").waitFor();
  // Of the colours of street that the legend names, those that the map shows.
  const shown = (): Promise<string[]> =>
    page.evaluate(() => {
      const canvas = document.querySelector("canvas")!;
      const { data } = canvas.getContext("2d")!.getImageData(0, 0, canvas.width, canvas.height);
      const pixels = new Set<string>();
      for (let i = 0; i < data.length; i += 4) pixels.add(`rgb(${data[i]}, ${data[i + 1]}, ${data[i + 2]})`);
      return [...document.querySelectorAll<HTMLElement>(".legend [class*='street-']")]
        .filter((swatch) => pixels.has(getComputedStyle(swatch).backgroundColor))
        .map((swatch) => swatch.className.replace("swatch street-", ""));
    });
  await until(async () => (await shown()).join() === "good", "the street is good");
  assert.deepEqual(await seriousFindings(page), []);
  await scene.choose("v1");
  await page.getByText("Expected within 0.1 m").waitFor({ state: "hidden" });
  await until(async () => (await shown()).join() === "unknown", "nothing is known of the street");
});

test("an update is begun after one question, and the server's word on it is shown", async () => {
  await scene.choose("v1");
  await scene.versionRow("v1").getByRole("button", { name: "Update from passes" }).click();
  await scene.dialog.getByText("no version is made unless it is better there").waitFor();
  await scene.dialog.getByText("Nothing is activated").waitFor();
  assert.deepEqual(await seriousFindings(page), []);
  await scene.dialog.getByRole("button", { name: "Update from passes" }).click();
  const builds = page.getByRole("region", { name: "Builds" });
  await builds.getByText("update from passes").waitFor();
  await builds.getByText("Failed").waitFor();
  await builds.getByText("an update needs passes of 3 vehicles or days").waitFor();
});

test("two versions are compared, under an address that can be shared", async () => {
  await scene.goto("/maps/dcloc/town");
  await scene.choose("v2");
  await scene.versionRow("v2").getByRole("link", { name: "Compare with v1" }).click();
  await page.getByText(/^(\d+) of \1 squares of the map compared$/).waitFor();
  // The same drive made both: nothing differs.
  const counts = (name: string) => page.getByRole("row", { name }).locator("td").innerText();
  assert.deepEqual([await counts("only in v1"), await counts("only in v2")], ["0", "0"]);
  assert.ok(Number((await counts("in both")).replace(",", "")) > 100);
  assert.deepEqual(await seriousFindings(page), []);
  await page.goto(page.url());
  await page.getByRole("heading", { name: "town: v1 and v2" }).waitFor();
  await scene.goto("/compare/dcloc/town/1/77");
  await page.getByText("There is nothing here").waitFor();
});

test("the live view shows the vehicles of one version alone, where there are several", async () => {
  await scene.goto("/live");
  await page.getByRole("button", { name: "3 Tracking" }).waitFor();
  assert.equal(await page.getByLabel("Version").count(), 0, "all have one version");
  // v1 is active: vehicles that come now get it, and those that are there keep v2.
  more = scene.town.drive(scene.server.address, "town", 2, ["--seed", "7"]);
  const version = page.getByLabel("Version");
  await version.selectOption("1");
  const rows = page.locator(".rows .row");
  const namesOf = async (): Promise<string[]> => (await rows.locator("strong").allTextContents()).sort();
  await page.waitForFunction(() => document.querySelectorAll(".rows .row").length === 2);
  const ofFirst = await namesOf();
  await version.selectOption("2");
  await page.waitForFunction(() => document.querySelectorAll(".rows .row").length === 3);
  assert.equal((await namesOf()).length + ofFirst.length, 5);
  await page.getByLabel("Filter by name").fill("no such vehicle");
  await page.getByText("No vehicle matches the filter.").waitFor();
  await page.getByLabel("Filter by name").fill("");
  await version.selectOption("0");
  await page.waitForFunction(() => document.querySelectorAll(".rows .row").length === 5);
});

test("a version is deleted after one question, and its sessions are moved to the one that is active", async () => {
  const { dialog } = scene;
  await scene.goto("/maps/dcloc/town");
  await scene.choose("v2");
  await scene.versionRow("v2").getByText("Sessions: 3").waitFor();
  await scene.versionRow("v2").getByRole("button", { name: "Delete" }).click();
  await dialog.getByText("3 sessions use this version").waitFor();
  await dialog.getByLabel("Move or end the sessions that use it").check();
  await dialog.getByText("They are moved to the version that they would get now, or ended.").waitFor();
  await dialog.getByRole("button", { name: "Delete" }).click();
  await dialog.waitFor({ state: "hidden" });
  await scene.versionRow("v2").waitFor({ state: "hidden" });
  await scene.versionRow("v1").getByText("Sessions: 5").waitFor();
  await page.reload();
  await scene.versionRow("v1").waitFor();
  assert.equal(await scene.versionRow("v2").count(), 0);
});

testNothingWentWrong(scene);
