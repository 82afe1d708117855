/** Measures what the console promises, and prints one line for each figure. See measure/run. */
import { readdirSync, statSync } from "node:fs";
import { join } from "node:path";
import type { Browser, Locator, Page } from "playwright-core";
import { Program, launch, openPage, signIn, startConsole } from "../browser/harness.ts";
import { EmptyPage } from "./empty_page.ts";
import { measureLoad } from "./load.ts";
import { type MemorySample, growth, sampleMemory } from "./memory.ts";
import {
  type Notes,
  type ThreadTimes,
  countAbove,
  interactionQuantile,
  note,
  quantile,
  readNotes,
  threadTimes,
  total,
} from "./notes.ts";

const VEHICLE_COUNT = Number(process.env["VEHICLES"] ?? "2000");
const MINUTES = Number(process.env["MINUTES"] ?? "2");
/** Between two rounds of interactions nobody presses anything for so long. */
const PAUSE_MS = 1000 * Number(process.env["PAUSE_S"] ?? "0");
const SAMPLE_PERIOD_MS = 60_000;
/** "page" or "load": that part alone. */
const ONLY = process.env["ONLY"] ?? "";

function print(name: string, figure: string, goal: string): void {
  console.log(`${name.padEnd(58)} ${figure.padEnd(34)} ${goal}`);
}

/** Where the page's parts are: found once, for finding takes the page's thread longer than to click. */
async function findPlaces(page: Page) {
  const middleOf = async (part: Locator): Promise<[number, number]> => {
    const box = (await part.boundingBox())!;
    return [box.x + box.width / 2, box.y + box.height / 2];
  };
  return {
    lost: await middleOf(page.getByRole("button", { name: /Lost$/ })),
    filter: await middleOf(page.getByLabel("Filter by name")),
    row: await middleOf(page.locator(".row").first()),
    map: await middleOf(page.locator("canvas")),
  };
}

/** What somebody does who looks for a vehicle: filters, a choice, and moving the map. */
async function interact(page: Page, places: Awaited<ReturnType<typeof findPlaces>>): Promise<void> {
  await page.mouse.click(...places.lost);
  await page.mouse.click(...places.lost);
  await page.mouse.click(...places.filter);
  await page.keyboard.type("car-12");
  await page.mouse.click(...places.row);
  await page.mouse.click(...places.filter, { clickCount: 3 });
  await page.keyboard.press("Delete");
  const [x, y] = places.map;
  await page.mouse.move(x, y);
  for (let i = 0; i < 6; ++i) await page.mouse.wheel(0, -300);
  await page.mouse.down();
  for (let i = 0; i < 40; ++i) await page.mouse.move(x + 8 * i, y + 4 * i);
  await page.mouse.up();
  await page.keyboard.press("0");
  for (let i = 0; i < 3; ++i) await page.mouse.wheel(0, 200);
}

function bundleBytes(folder: string): number {
  const files = readdirSync(folder).filter((name) => /\.(br|woff2)$/.test(name));
  return files.reduce((sum, name) => sum + statSync(join(folder, name)).size, 0);
}

/** Loads the page some times; it has noted when its vehicles were listed. */
async function measureLoading(page: Page): Promise<void> {
  const useful: number[] = [];
  for (let i = 0; i < 5; ++i) {
    await page.reload();
    await page.waitForFunction(() => (window as unknown as { notes: Notes }).notes.usefulMs > 0);
    useful.push((await readNotes(page)).usefulMs);
  }
  const [, , median] = useful.sort((a, b) => a - b);
  print("first useful paint, vehicles listed, median of 5", `${median!.toFixed(0)} ms`, "1500 ms");
}

function printInteractions(name: string, notes: Notes, goal: string): void {
  const slow = countAbove(notes.interactions, 100);
  const [p50, p98] = [0.5, 0.98].map((share) => interactionQuantile(notes, share).toFixed(0));
  print(`${name}: ${notes.interactionCount}; p50, p98`, `${p50}, ${p98} ms; ${slow} above 100 ms`, goal);
}

function printThread(before: ThreadTimes, after: ThreadTimes, seconds: number): void {
  const share = (name: keyof ThreadTimes): string => ((100 * (after[name] - before[name])) / seconds).toFixed(0);
  const parts = `scripts ${share("scripts")}, layout ${share("layout")}, styles ${share("styles")}`;
  print("processor time of the page's thread, of one core", `${share("all")} % (${parts})`, "");
}

function printMemory(samples: readonly MemorySample[]): void {
  const tell = (name: string, of: (sample: MemorySample) => number, goal: string): void => {
    const sizes = samples.map(of);
    const [first, last, most] = [sizes[0]!, sizes.at(-1)!, Math.max(...sizes)].map((size) => size.toFixed(1));
    const slope = growth(samples, of).toFixed(1);
    print(`${name}, first, last, most of ${sizes.length}`, `${first}, ${last}, ${most} MiB; ${slope} MiB/h`, goal);
  };
  tell(`heap in ${MINUTES} min`, (sample) => sample.heapMib, "");
  tell("page's process", (sample) => sample.processMib, "300 MiB");
}

async function measureUse(browser: Browser, page: Page): Promise<void> {
  const devtools = await page.context().newCDPSession(page);
  // Processor time of the page's thread, not the time that passes.
  await devtools.send("Performance.enable", { timeDomain: "threadTicks" });
  await page.waitForTimeout(3_000);
  const empty = await EmptyPage.open(browser);
  const memory: MemorySample[] = [await sampleMemory(browser, devtools)];
  const places = await findPlaces(page);
  const times = await threadTimes(devtools);
  const begin = Date.now();
  do {
    await page.bringToFront();
    await interact(page, places);
    await empty.interact();
    await page.bringToFront();
    await page.waitForTimeout(PAUSE_MS);
    if (Date.now() > memory.at(-1)!.ms + SAMPLE_PERIOD_MS) memory.push(await sampleMemory(browser, devtools));
  } while (Date.now() < begin + MINUTES * 60_000);
  printThread(times, await threadTimes(devtools), (Date.now() - begin) / 1000);
  const notes = await readNotes(page);
  printInteractions("interactions", notes, "100 ms");
  printInteractions("  of an empty page, in between", await empty.notes(), "");
  print(
    `frames: ${total(notes.frames)}; p50, p95, p99`,
    `${[0.5, 0.95, 0.99].map((q) => quantile(notes.frames, q).toFixed(1)).join(", ")} ms`,
    "16.7 ms",
  );
  memory.push(await sampleMemory(browser, devtools));
  printMemory(memory);
  await empty.close();
}

async function measurePage(browser: Browser, bridge: Program): Promise<void> {
  const { page, faults } = await openPage(browser, bridge.address);
  page.setDefaultTimeout(120_000);
  await signIn(page);
  await page.locator(".row").first().waitFor();
  await page.addInitScript(note);
  await measureLoading(page);
  await measureUse(browser, page);
  print("errors that nothing caught", String(faults.length), "0");
  if (faults.length > 0) throw new Error(faults.join("\n"));
  await page.close();
}

async function measureConsole(): Promise<void> {
  const page = join(process.env["DCLOC_CONSOLE"]!, "../page");
  print("bundle, compressed, with its font", `${(bundleBytes(page) / 1000).toFixed(0)} kB`, "1500 kB");
  const fleet = await Program.start(process.execPath, [
    join(__dirname, "fleet_server.cjs"),
    String(VEHICLE_COUNT),
  ]);
  const bridge = await startConsole([fleet.address]);
  const browser = await launch();
  try {
    await measurePage(browser, bridge);
  } finally {
    await browser.close();
    await bridge.stop();
    await fleet.stop();
  }
}

async function main(): Promise<void> {
  if (ONLY !== "load") await measureConsole();
  if (ONLY === "page") return;
  for (const { text, without, withPages } of await measureLoad()) {
    print(text, `${without} without, ${withPages} with`, "equal");
  }
}

main().catch((error: unknown) => {
  console.error(error);
  process.exitCode = 1;
});
