import assert from "node:assert/strict";
import { test } from "node:test";
import type { Page } from "playwright-core";
import { seriousFindings } from "./accessibility.ts";
import { signIn } from "./harness.ts";
import { TownScene, staged, testNothingWentWrong } from "./scene.ts";

const WIDTH_PX = 390;
const NARROWEST_PX = 320;

let page: Page;
const scene = staged(new TownScene({ versions: ["first drive", "second drive"], vehicles: 3 }), async (scene) => {
  ({ page } = scene);
  await signIn(page);
  await page.setViewportSize({ width: WIDTH_PX, height: 844 });
});

/** What stands in each view when it is there. */
const VIEWS: Record<string, { path?: string; sign: RegExp }> = {
  live: { path: "/live", sign: /^load-00002/ },
  maps: { path: "/maps", sign: /^town$/ },
  map: { path: "/maps/dcloc/town", sign: /^Download$/ },
  compare: { path: "/compare/dcloc/town/1/2", sign: /squares of the map compared$/ },
  recordings: { path: "/recordings", sign: /^No recordings$/ },
  servers: { path: "/servers", sign: /^ActivateMapVersion$|^UploadMap$/ },
  session: { sign: /^Sources$/ },
};

async function open(name: string): Promise<void> {
  const { path, sign } = VIEWS[name]!;
  await (path === undefined ? scene.openSession() : scene.goto(path));
  await page.locator("#content").getByText(sign).first().waitFor();
}

/** The parts of the page that are wider inside than out: they scroll sideways, or are cut off. */
const sidewaysParts = (): Promise<string[]> =>
  page.evaluate(() => {
    const isWider = (part: Element): boolean => part.scrollWidth > part.clientWidth + 1;
    const mayCut = (part: Element): boolean =>
      getComputedStyle(part).textOverflow === "ellipsis" || part.closest(".unseen, .skip, .data thead") !== null;
    return [...document.querySelectorAll("html, body, body *")]
      .filter((part) => part instanceof HTMLElement && getComputedStyle(part).display !== "inline")
      .filter((part) => isWider(part) && !mayCut(part))
      .map((part) => `${part.tagName}.${part.className} ${part.scrollWidth} > ${part.clientWidth}`);
  });

for (const name of Object.keys(VIEWS)) {
  test(`on a phone: ${name} needs no sideways scrolling, and no axe finding is serious`, async () => {
    await open(name);
    assert.deepEqual(await sidewaysParts(), []);
    assert.deepEqual(await seriousFindings(page), []);
    await page.setViewportSize({ width: NARROWEST_PX, height: 640 });
    await page.getByLabel("Language").selectOption("de");
    const inGerman = await sidewaysParts();
    await page.getByLabel("Sprache").selectOption("en");
    await page.setViewportSize({ width: WIDTH_PX, height: 844 });
    assert.deepEqual(inGerman, [], "in German, on the narrowest phone");
  });
}

test("on a phone: all that the bar at the top has is in view", async () => {
  for (const part of await page.locator(".top").locator("a, button, select").all()) {
    const { x, width } = (await part.boundingBox())!;
    assert.ok(x >= 0 && x + width <= WIDTH_PX, `${await part.innerText()} at ${x} to ${x + width}`);
  }
});

test("on a phone: a vehicle's name stays on one line", async () => {
  await open("session");
  assert.ok((await page.getByRole("heading", { level: 1 }).boundingBox())!.height < 45);
});

test("on a phone: a short name in a table stays on one line, and cells say what they are", async () => {
  await open("maps");
  const row = page.getByRole("row").filter({ has: page.getByRole("link", { name: "town" }) });
  assert.ok((await row.getByRole("link").boundingBox())!.height < 30);
  assert.equal(await row.getByRole("cell").count(), 4);
  await open("servers");
  const who = page.getByRole("row").filter({ hasText: "UploadMap" }).getByRole("rowheader").first();
  assert.ok((await who.boundingBox())!.width >= 90);
});

test("with keys alone: to the content, into a question and out of it", async () => {
  await open("map");
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

testNothingWentWrong(scene);
