/** Takes a picture of each view and state of the console, to be looked at. See run. */
import { join } from "node:path";
import type { Page } from "playwright-core";
import { dcloc, openPage, signIn } from "../browser/harness.ts";
import { FakeScene, TownScene } from "../browser/scene.ts";
import { sessionAt } from "../browser/fake_server.ts";

const FOLDER = process.env["DCLOC_CONSOLE_PICTURES"]!;
const DESKTOP = { width: 1280, height: 800 };
const PHONE = { width: 390, height: 844 };

/** In dark colours, or in light ones. */
async function take(page: Page, name: string, theme: "dark" | "light" = "dark"): Promise<void> {
  const button = page.getByRole("button", { name: theme === "dark" ? "Dark colours" : "Light colours" });
  // A question lets nobody past it; it has the colours of the picture before.
  const isAsked = (await page.getByRole("dialog").count()) > 0;
  if (!isAsked && (await button.count()) > 0) await button.click();
  await page.mouse.move(0, 0);
  await page.waitForTimeout(1_000);
  await page.screenshot({ path: join(FOLDER, `${name}.png`) });
}

/** The same view on a phone, from its top to its end. */
async function takeOnPhone(page: Page, name: string): Promise<void> {
  await page.setViewportSize(PHONE);
  await page.waitForTimeout(500);
  await page.screenshot({ path: join(FOLDER, `phone-${name}.png`) });
  const height = await page.evaluate(() => document.querySelector("main")!.scrollHeight + 100);
  await page.setViewportSize({ ...PHONE, height: Math.max(PHONE.height, Math.min(height, 4_000)) });
  await page.waitForTimeout(500);
  await page.screenshot({ path: join(FOLDER, `phone-${name}-whole.png`) });
  await page.setViewportSize(DESKTOP);
}

async function takeTown(scene: TownScene): Promise<void> {
  const { page } = scene;
  await take(page, "sign-in");
  await signIn(page);
  await take(page, "live-empty");
  await scene.goto("/recordings");
  await page.getByText("No recordings").waitFor();
  await take(page, "recordings-empty");
  await page.getByRole("button", { name: "Record a vehicle" }).click();
  await take(page, "record-dialog");
  await scene.dialog.getByLabel("Vehicle").fill("load-00003");
  await scene.dialog.getByRole("button", { name: "Record", exact: true }).click();
  scene.drive(6);
  await page.getByText(/^Recording · \d\d\d scans/).waitFor();
  await page.getByRole("link", { name: "Watch" }).click();
  await page.getByText("What the data says").waitFor();
  await page.waitForTimeout(20_000);
  await take(page, "replay");
  await take(page, "replay-light", "light");
  await takeOnPhone(page, "replay");
  await takeViews(scene);
  await takeLost(scene);
}

async function takeViews(scene: TownScene): Promise<void> {
  const { page } = scene;
  await page.getByRole("link", { name: "Live" }).click();
  await page.getByRole("button", { name: /^[1-9]\d* Tracking/ }).waitFor();
  await page.waitForTimeout(20_000);
  await page.locator(".row").first().getByRole("button").first().click();
  await take(page, "live");
  await take(page, "live-light", "light");
  await takeOnPhone(page, "live");
  await scene.openSession();
  await page.waitForTimeout(10_000);
  await take(page, "session");
  await take(page, "session-light", "light");
  await page.getByRole("link", { name: "Maps" }).first().click();
  await page.getByRole("link", { name: "town" }).waitFor();
  await take(page, "maps");
  await take(page, "maps-light", "light");
  await takeOnPhone(page, "maps");
  await page.getByRole("link", { name: "town" }).click();
  await page.getByText("Download").waitFor();
  await take(page, "map");
  await take(page, "map-light", "light");
  await takeOnPhone(page, "map");
  await scene.choose("v2");
  await take(page, "map-version");
  await page.getByRole("button", { name: "Activate" }).click();
  await scene.dialog.getByText(/sessions are open/).waitFor();
  await take(page, "activate-dialog");
  await page.keyboard.press("Escape");
  await scene.versionRow("v2").getByRole("link", { name: "Compare with v1" }).click();
  await page.getByText(/^(\d+) of \1 squares of the map compared$/).waitFor();
  await take(page, "compare");
  await page.getByRole("link", { name: "Servers" }).click();
  await page.getByText("UploadMap").first().waitFor();
  await take(page, "servers");
  await take(page, "servers-light", "light");
  await takeOnPhone(page, "servers");
}

/** Vehicles whose map becomes that of another town get lost, or do not find a place in it. */
async function takeLost(scene: TownScene): Promise<void> {
  const { page } = scene;
  const other = join(scene.town.folder, "other");
  dcloc("simulate", "--out", other, "--length-m", "400", "--seed", "11");
  const file = join(scene.town.folder, "other.dclm");
  dcloc("map", "build", "--dataset", "nuscenes", "--root", other, "--drive", "map", "--name", "other", "--out", file);
  dcloc("map", "upload", "--server", scene.server.address, "--map", "town", file);
  await scene.goto("/maps/dcloc/town");
  await scene.choose("v3");
  await page.getByRole("button", { name: "Activate" }).click();
  await scene.dialog.getByLabel("Move running sessions as well").check();
  await scene.dialog.getByRole("button", { name: "Activate" }).click();
  await scene.dialog.waitFor({ state: "hidden" });
  await scene.goto("/live");
  await page.getByRole("button", { name: /^[1-9]\d* (Lost|Initializing)/ }).waitFor();
  await page.waitForTimeout(5_000);
  await take(page, "live-lost");
  await take(page, "live-lost-light", "light");
  await page.locator(".row").first().getByRole("button").first().click();
  await page.getByRole("link", { name: "Details" }).click();
  await page.getByText("What the data says").waitFor();
  await page.waitForTimeout(8_000);
  await take(page, "session-lost");
  await take(page, "session-lost-light", "light");
  await takeOnPhone(page, "session-lost");
  await page.getByRole("button", { name: "Propose a pose" }).click();
  await take(page, "session-propose");
  await scene.server.stop("SIGKILL");
  await scene.goto("/live");
  await take(page, "server-gone");
  await scene.goto("/maps");
  await page.getByRole("heading", { name: "No connection" }).waitFor();
  await take(page, "server-gone-maps");
  await scene.bridge.stop();
  await page.getByText("Cut off from the bridge").waitFor();
  await take(page, "cut-off");
}

async function takeDenied(scene: TownScene): Promise<void> {
  const { page, faults } = await openPage(scene.browser, scene.bridge.address);
  await signIn(page, "no-token-at-all");
  await take(page, "sign-in-refused");
  await signIn(page, scene.token("car-1", "vehicle"));
  await page.getByText("Not permitted").waitFor();
  await take(page, "denied");
  await page.getByRole("link", { name: "Servers" }).click();
  await page.getByText("Not permitted").first().waitFor();
  await take(page, "denied-servers");
  if (faults.length > 0) throw new Error(faults.join());
}

async function takeCrowd(scene: FakeScene): Promise<void> {
  scene.fake.sessions = Array.from({ length: 2_000 }, (_, i) =>
    sessionAt(String(i), `car-${i}`, i % 97 === 0 ? 4 : i % 31 === 0 ? 3 : 2, (i % 50) * 20, Math.floor(i / 50) * 20),
  );
  await scene.visit(async (page) => {
    await page.locator(".row").first().waitFor();
    await take(page, "live-crowd");
    await page.goto(`${scene.bridge.address}/session/dcloc/1`);
    await page.getByText("This server is older").waitFor();
    await take(page, "older-server");
  });
}

async function main(): Promise<void> {
  const only = process.env["ONLY"];
  const shows: Record<string, () => Promise<void>> = {
    town: async () => {
      const scene = new TownScene({ versions: ["first drive", "second drive"] });
      await scene.open();
      await takeTown(scene).finally(() => scene.close());
    },
    denied: async () => {
      const scene = new TownScene();
      await scene.open();
      scene.token("root", "admin");
      await takeDenied(scene).finally(() => scene.close());
    },
    crowd: async () => {
      const scene = new FakeScene();
      await scene.open();
      await takeCrowd(scene).finally(() => scene.close());
    },
  };
  for (const [name, show] of Object.entries(shows)) if (!only || only === name) await show();
}

main().catch((error: unknown) => {
  console.error(error);
  process.exitCode = 1;
});
