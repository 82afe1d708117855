import type { CDPSession, Page } from "playwright-core";

/** What a page itself notes from its beginning on. */
export interface Notes {
  usefulMs: number;
  /** Of each interaction that took 16 ms or more until its result was on the screen [ms]. */
  interactions: number[];
  /** Of all interactions, the quick ones as well. */
  interactionCount: number;
  frames: number[];
}

/** Runs in the page, before all else. */
export function note(): void {
  const notes = { usefulMs: 0, frames: [] as number[], longest: new Map<number, number>() };
  Object.assign(window, { notes });
  new PerformanceObserver((list) => {
    // A click is several events; the longest of them is what somebody waits for.
    for (const entry of list.getEntries() as PerformanceEventTiming[]) {
      const { interactionId, duration } = entry as PerformanceEventTiming & { interactionId: number };
      if (interactionId === 0) continue;
      notes.longest.set(interactionId, Math.max(duration, notes.longest.get(interactionId) ?? 0));
    }
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

export const readNotes = (page: Page): Promise<Notes> =>
  page.evaluate(() => {
    const { notes } = window as unknown as {
      notes: { usefulMs: number; frames: number[]; longest: Map<number, number> };
    };
    const { interactionCount } = performance as Performance & { interactionCount: number };
    const { usefulMs, frames, longest } = notes;
    return { usefulMs, frames, interactions: [...longest.values()], interactionCount };
  });

export function quantile(values: readonly number[], share: number): number {
  const sorted = [...values].sort((a, b) => a - b);
  return sorted[Math.min(sorted.length - 1, Math.floor(share * sorted.length))] ?? 0;
}

/** Of all interactions, those below 16 ms counted as 0. */
export function interactionQuantile({ interactions, interactionCount }: Notes, share: number): number {
  const quick = new Array<number>(Math.max(0, interactionCount - interactions.length)).fill(0);
  return quantile([...quick, ...interactions], share);
}

/** Processor time of a page's own thread so far [s], other programs' not in it. */
export interface ThreadTimes {
  all: number;
  scripts: number;
  layout: number;
  styles: number;
}

export async function threadTimes(devtools: CDPSession): Promise<ThreadTimes> {
  const { metrics } = await devtools.send("Performance.getMetrics");
  const value = (name: string): number => metrics.find((metric) => metric.name === name)?.value ?? 0;
  return {
    all: value("TaskDuration"),
    scripts: value("ScriptDuration"),
    layout: value("LayoutDuration"),
    styles: value("RecalcStyleDuration"),
  };
}
