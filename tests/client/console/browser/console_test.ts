import assert from "node:assert/strict";
import { test } from "node:test";
import type { Page } from "playwright-core";
import { seriousFindings } from "./accessibility.ts";
import { signIn, startConsole, startServer, until } from "./harness.ts";
import { TownScene, staged, testNothingWentWrong } from "./scene.ts";
import { stopVehicles } from "./town.ts";

let page: Page;
const scene = staged(new TownScene({ vehicles: 5 }), async (scene) => {
  ({ page } = scene);
});

test("who chooses colours or a language before signing in is not signed in by that", async () => {
  const colours = page.getByRole("button", { name: /colours$/ });
  const before = await colours.getAttribute("aria-label");
  await colours.click();
  assert.notEqual(await colours.getAttribute("aria-label"), before);
  await colours.click();
  await page.getByLabel("Language").selectOption("de");
  await page.getByLabel("Sprache").selectOption("en");
  const cookies = await page.context().cookies();
  assert.deepEqual(cookies, []);
  await page.getByRole("button", { name: "Continue without a token" }).waitFor();
});

test("without a token where servers need none, and the vehicles are there, moving", async () => {
  assert.deepEqual(await seriousFindings(page), []);
  await signIn(page);
  await page.getByRole("button", { name: "5 Tracking" }).waitFor();
  await page.locator(".row").first().getByRole("button").first().click();
  await page.getByRole("button", { name: "Follow" }).click();
  const canvas = page.locator("canvas");
  const before = await canvas.screenshot();
  const hasMoved = async (): Promise<boolean> => !before.equals(await canvas.screenshot());
  await until(hasMoved, "a followed vehicle drives through the map");
  await page.keyboard.press("Escape");
});

test("no axe finding is serious, in light colours and in dark ones", async () => {
  for (const view of ["/live", "/maps", "/maps/dcloc/town", "/recordings", "/servers"]) {
    await scene.goto(view);
    await page.locator("#content button, #content table").first().waitFor();
    assert.deepEqual(await seriousFindings(page), [], view);
    await page.getByRole("button", { name: /colours$/ }).click();
    assert.deepEqual(await seriousFindings(page), [], view);
  }
});

/** Somewhere near the vehicle, as its map shows; then at another place, typed. */
async function proposeByClick(): Promise<void> {
  await page.getByRole("button", { name: "Propose a pose" }).click();
  const form = page.getByRole("region", { name: "Propose a pose" });
  const submit = form.getByRole("button", { name: "Propose" });
  assert.ok(await submit.isDisabled(), "no place is chosen yet");
  await page.locator(".session-map canvas").click({ position: { x: 60, y: 60 } });
  const x = form.getByLabel("x, m");
  await until(async () => /^-?\d/.test(await x.inputValue()), "the click says a place");
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

/** Most of what a vehicle that is tracking sees has its landmark. */
async function theScanLiesOnTheMap(): Promise<void> {
  const counts = page.getByRole("region", { name: "Scans" }).getByText(/targets have/);
  const isLaid = async (): Promise<boolean> => {
    const [near, all] = (await counts.textContent())!.match(/\d+/g)!.map(Number) as [number, number];
    return all > 20 && near > all / 2;
  };
  await until(isLaid, "a scan lies on the map");
}

test("a session is told in words and time lines, and can be ended", async () => {
  await scene.openSession();
  assert.equal(await page.locator(".chart canvas").count(), 6);
  await page.getByRole("img", { name: /^States over time: Tracking/ }).waitFor();
  await page.getByRole("heading", { name: "Sources" }).waitFor();
  await theScanLiesOnTheMap();
  assert.deepEqual(await seriousFindings(page), []);
  await proposeByClick();
  await page.getByRole("button", { name: "End the session" }).click();
  await scene.dialog.getByLabel("Reason").fill("<b>maintenance</b>");
  await scene.dialog.getByRole("button", { name: "End the session" }).click();
  await page.getByText("The session is over").waitFor();
});

test("who changed what is listed, and what is hostile in it is only shown", async () => {
  await scene.goto("/servers");
  const row = (call: string) => page.getByRole("row").filter({ hasText: call }).first();
  await row("EndSession").getByText("<b>maintenance</b>").waitFor();
  await row("ProposePose").getByText("anonymous").waitFor();
  await page.getByText("There are none: everyone who reaches the server is an admin.").waitFor();
  assert.deepEqual(await seriousFindings(page), []);
});

test("a server that leaves is told, and its vehicles are back when it is", async () => {
  await scene.goto("/live");
  await page.locator(".row").first().waitFor();
  const { address } = scene.server;
  await stopVehicles(scene.vehicles);
  await scene.server.stop("SIGKILL");
  await page.getByText("does not answer; its vehicles are shown as they last were").waitFor();
  scene.server = await startServer(scene.store, address);
  scene.drive(3);
  await page.getByRole("button", { name: "3 Tracking" }).waitFor();
  await page.getByText("does not answer").waitFor({ state: "hidden" });
});

test("a page that is cut off from its bridge says so, and goes on", async () => {
  await page.context().setOffline(true);
  const cut = page.getByText("Cut off from the bridge");
  // What is open already stays open offline; a new start of the bridge closes it.
  const { address } = scene.bridge;
  await scene.bridge.stop();
  await cut.waitFor();
  scene.bridge = await startConsole([scene.server.address], new URL(address).host);
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

testNothingWentWrong(scene);
