/** Measures what the console promises, and prints one line for each figure. See measure/run. */
import { readFileSync, readdirSync, statSync } from "node:fs";
import { join } from "node:path";
import type { Browser, CDPSession, Locator, Page } from "playwright-core";
import { Program, launch, openPage, signIn, startConsole } from "../browser/harness.ts";
import { EmptyPage } from "./empty_page.ts";
import { measureLoad } from "./load.ts";
import { type Notes, type ThreadTimes, interactionQuantile, note, quantile, readNotes, threadTimes } from "./notes.ts";

const VEHICLE_COUNT = 2_000;
const MINUTES = Number(process.env["MINUTES"] ?? "2");
/** "page" or "load": that part alone. */
const ONLY = process.env["ONLY"] ?? "";
const MIB = 2 ** 20;

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

/** The page's process: what it alone holds in memory, its canvases with it. */
async function residentBytes(browser: Browser): Promise<number> {
  const session = await browser.newBrowserCDPSession();
  const { processInfo } = (await session.send("SystemInfo.getProcessInfo")) as {
    processInfo: { id: number; type: string }[];
  };
  await session.detach();
  const sizes = processInfo
    .filter(({ type }) => type === "renderer")
    .map(({ id }) => /Pss_Anon:\s+(\d+) kB/.exec(readFileSync(`/proc/${id}/smaps_rollup`, "utf8")))
    .map((match) => 1024 * Number(match?.[1] ?? 0));
  return Math.max(0, ...sizes);
}

async function heapBytes(devtools: CDPSession): Promise<number> {
  await devtools.send("HeapProfiler.collectGarbage");
  const { metrics } = await devtools.send("Performance.getMetrics");
  return metrics.find(({ name }) => name === "JSHeapUsedSize")!.value;
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
  print("first useful paint, vehicles listed, median of 5", `${quantile(useful, 0.5).toFixed(0)} ms`, "1500 ms");
}

function printInteractions(name: string, notes: Notes, goal: string): void {
  const slow = notes.interactions.filter((ms) => ms > 100).length;
  const [p50, p98] = [0.5, 0.98].map((share) => interactionQuantile(notes, share).toFixed(0));
  print(`${name}: ${notes.interactionCount}; p50, p98`, `${p50}, ${p98} ms; ${slow} above 100 ms`, goal);
}

function printThread(before: ThreadTimes, after: ThreadTimes, seconds: number): void {
  const share = (name: keyof ThreadTimes): string => ((100 * (after[name] - before[name])) / seconds).toFixed(0);
  const parts = `scripts ${share("scripts")}, layout ${share("layout")}, styles ${share("styles")}`;
  print("processor time of the page's thread, of one core", `${share("all")} % (${parts})`, "");
}

async function measureUse(browser: Browser, page: Page): Promise<void> {
  const devtools = await page.context().newCDPSession(page);
  // Processor time of the page's thread, not the time that passes.
  await devtools.send("Performance.enable", { timeDomain: "threadTicks" });
  await page.waitForTimeout(3_000);
  const empty = await EmptyPage.open(browser);
  const first = { heap: await heapBytes(devtools), resident: await residentBytes(browser) };
  const places = await findPlaces(page);
  const times = await threadTimes(devtools);
  const begin = Date.now();
  let most = 0;
  do {
    await page.bringToFront();
    await interact(page, places);
    most = Math.max(most, await residentBytes(browser));
    await empty.interact();
  } while (Date.now() < begin + MINUTES * 60_000);
  printThread(times, await threadTimes(devtools), (Date.now() - begin) / 1000);
  const notes = await readNotes(page);
  printInteractions("interactions", notes, "100 ms");
  printInteractions("  of an empty page, in between", await empty.notes(), "");
  print(
    `frames: ${notes.frames.length}; p50, p95, p99`,
    `${[0.5, 0.95, 0.99].map((q) => quantile(notes.frames, q).toFixed(1)).join(", ")} ms`,
    "16.7 ms",
  );
  const heap = await heapBytes(devtools);
  print(
    `memory after ${MINUTES} min: heap; process, most`,
    `${(heap / MIB).toFixed(0)} MiB (${(first.heap / MIB).toFixed(0)} at first); ${(most / MIB).toFixed(0)} MiB (${(first.resident / MIB).toFixed(0)})`,
    "300 MiB",
  );
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
