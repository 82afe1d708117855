/** Measures what the console promises, and prints one line for each figure. See measure/run. */
import { readFileSync, readdirSync, statSync } from "node:fs";
import { join } from "node:path";
import type { Browser, CDPSession, Page } from "playwright-core";
import { Program, launch, openPage, signIn, startConsole } from "../browser/harness.ts";
import { measureLoad } from "./load.ts";

const VEHICLE_COUNT = 2_000;
const MINUTES = Number(process.env["MINUTES"] ?? "2");
const MIB = 2 ** 20;

/** What the page itself notes from its beginning on. */
interface Notes {
  usefulMs: number;
  events: number[];
  frames: number[];
}

function note(): void {
  const notes: Notes = { usefulMs: 0, events: [], frames: [] };
  Object.assign(window, { notes });
  new PerformanceObserver((list) => {
    for (const entry of list.getEntries()) notes.events.push(entry.duration);
  }).observe({ type: "event", durationThreshold: 16, buffered: true } as PerformanceObserverInit);
  let before = 0;
  const frame = (now: number): void => {
    if (before > 0) notes.frames.push(now - before);
    before = now;
    if (notes.usefulMs === 0 && document.querySelector(".rows .row")) notes.usefulMs = now;
    requestAnimationFrame(frame);
  };
  requestAnimationFrame(frame);
}

const readNotes = (page: Page): Promise<Notes> =>
  page.evaluate(() => (window as unknown as { notes: Notes }).notes);

function quantile(values: readonly number[], share: number): number {
  const sorted = [...values].sort((a, b) => a - b);
  return sorted[Math.min(sorted.length - 1, Math.floor(share * sorted.length))] ?? 0;
}

function print(name: string, figure: string, goal: string): void {
  console.log(`${name.padEnd(58)} ${figure.padEnd(34)} ${goal}`);
}

/** What somebody does who looks for a vehicle: filters, a choice, and moving the map. */
async function interact(page: Page): Promise<void> {
  await page.getByRole("button", { name: /Lost$/ }).click();
  await page.getByRole("button", { name: /Lost$/ }).click();
  await page.getByLabel("Filter by name").pressSequentially("car-12");
  await page.locator(".row").first().getByRole("button").first().click();
  await page.getByLabel("Filter by name").fill("");
  const box = (await page.locator("canvas").boundingBox())!;
  const [x, y] = [box.x + box.width / 2, box.y + box.height / 2];
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

async function measurePage(browser: Browser, bridge: Program): Promise<void> {
  const { page, faults } = await openPage(browser, bridge.address);
  page.setDefaultTimeout(120_000);
  await signIn(page);
  await page.locator(".row").first().waitFor();
  await page.addInitScript(note);
  const useful: number[] = [];
  for (let i = 0; i < 5; ++i) {
    await page.reload();
    await page.waitForFunction(() => (window as unknown as { notes: Notes }).notes.usefulMs > 0);
    useful.push((await readNotes(page)).usefulMs);
  }
  print("first useful paint, vehicles listed, median of 5", `${quantile(useful, 0.5).toFixed(0)} ms`, "1500 ms");

  const devtools = await page.context().newCDPSession(page);
  await devtools.send("Performance.enable");
  await page.waitForTimeout(3_000);
  const first = { heap: await heapBytes(devtools), resident: await residentBytes(browser) };
  const end = Date.now() + MINUTES * 60_000;
  let most = 0;
  do {
    await interact(page);
    most = Math.max(most, await residentBytes(browser));
  } while (Date.now() < end);
  const { events, frames } = await readNotes(page);
  const slow = events.filter((ms) => ms > 100).length;
  print(
    `interactions that took a frame or more: ${events.length}; p50, p98`,
    `${quantile(events, 0.5).toFixed(0)}, ${quantile(events, 0.98).toFixed(0)} ms; ${slow} above 100 ms`,
    "100 ms",
  );
  print(
    `frames: ${frames.length}; p50, p95, p99`,
    `${[0.5, 0.95, 0.99].map((q) => quantile(frames, q).toFixed(1)).join(", ")} ms`,
    "16.7 ms",
  );
  const heap = await heapBytes(devtools);
  print(
    `memory after ${MINUTES} min: heap; process, most`,
    `${(heap / MIB).toFixed(0)} MiB (${(first.heap / MIB).toFixed(0)} at first); ${(most / MIB).toFixed(0)} MiB (${(first.resident / MIB).toFixed(0)})`,
    "300 MiB",
  );
  if (faults.length > 0) throw new Error(faults.join("\n"));
  await page.close();
}

async function main(): Promise<void> {
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
  for (const { text, without, withPages } of await measureLoad()) {
    print(text, `${without} without, ${withPages} with`, "equal");
  }
}

main().catch((error: unknown) => {
  console.error(error);
  process.exitCode = 1;
});
