import assert from "node:assert/strict";
import { test } from "node:test";
import type { Page } from "playwright-core";
import { signIn, startServer } from "./harness.ts";
import { TownScene, staged, testNothingWentWrong } from "./scene.ts";
import { stopVehicles } from "./town.ts";

let page: Page;
const scene = staged(new TownScene({ vehicles: 2 }), async (scene) => {
  ({ page } = scene);
  await signIn(page);
  await page.getByRole("button", { name: "2 Tracking" }).waitFor();
  await page.getByRole("link", { name: "Servers" }).click();
});

test("a server is drained after one question that says to how many sessions, until none is left", async () => {
  const card = page.getByRole("article");
  await card.getByText(/^Sessions: 2 of/).waitFor();
  await card.getByRole("button", { name: "Drain" }).click();
  await scene.dialog.getByText("tells its 2 sessions to move").waitFor();
  await scene.dialog.getByRole("button", { name: "Drain" }).click();
  await scene.dialog.waitFor({ state: "hidden" });
  await card.getByText("Draining").waitFor();
  assert.equal(await card.getByRole("button", { name: "Drain" }).count(), 0);
  await card.getByText(/^Sessions: 0 of/).waitFor();
  await page.getByRole("row").filter({ hasText: "Drain" }).getByText("done").waitFor();
  await page.getByRole("link", { name: "Live" }).click();
  await page.getByText("A vehicle appears here as soon as it opens a session.").waitFor();
});

test("a drained server that was started anew serves again", async () => {
  const { address } = scene.server;
  await stopVehicles(scene.vehicles);
  await scene.server.stop();
  scene.server = await startServer(scene.store, address);
  scene.drive(1);
  await page.getByRole("button", { name: "1 Tracking" }).waitFor();
  await page.getByRole("link", { name: "Servers" }).click();
  await page.getByRole("article").getByText("Serving").waitFor();
});

testNothingWentWrong(scene);
