import { readFileSync } from "node:fs";
import type { Browser, CDPSession } from "playwright-core";

const MIB = 2 ** 20;
const MS_PER_HOUR = 3_600_000;

/** What a page holds at a time. */
export interface MemorySample {
  ms: number;
  heapMib: number;
  /** Of its process: its canvases with it. */
  processMib: number;
}

/** The page's process: what it alone holds in memory. */
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

/** What is in use once all that is not has been given back. */
async function heapBytes(devtools: CDPSession): Promise<number> {
  await devtools.send("HeapProfiler.collectGarbage");
  const { metrics } = await devtools.send("Performance.getMetrics");
  return metrics.find(({ name }) => name === "JSHeapUsedSize")!.value;
}

export async function sampleMemory(browser: Browser, devtools: CDPSession): Promise<MemorySample> {
  const processMib = (await residentBytes(browser)) / MIB;
  return { ms: Date.now(), heapMib: (await heapBytes(devtools)) / MIB, processMib };
}

/** By how much a figure grows, MiB an hour: the line of least squares through the later half. */
export function growth(samples: readonly MemorySample[], of: (sample: MemorySample) => number): number {
  const later = samples.slice(Math.floor(samples.length / 2));
  const mean = (values: number[]): number => values.reduce((sum, v) => sum + v, 0) / values.length;
  const hours = later.map(({ ms }) => ms / MS_PER_HOUR);
  const meanHour = mean(hours);
  const meanSize = mean(later.map(of));
  const spread = hours.reduce((sum, h) => sum + (h - meanHour) ** 2, 0);
  const common = later.reduce((sum, sample, i) => sum + (hours[i]! - meanHour) * (of(sample) - meanSize), 0);
  return spread > 0 ? common / spread : Number.NaN;
}
