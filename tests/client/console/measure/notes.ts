import type { CDPSession, Page } from "playwright-core";

/** How often each duration [ms] came: as large after an hour as after a minute. */
export type Counts = Record<string, number>;

/** What a page itself notes from its beginning on. */
export interface Notes {
  usefulMs: number;
  /** Interactions that took 16 ms or more until their result was on the screen. */
  interactions: Counts;
  /** Of all interactions, the quick ones as well. */
  interactionCount: number;
  /** Times between frames, in tenths of a millisecond's steps. */
  frames: Counts;
}

/** Runs in the page, before all else. */
export function note(): void {
  const KEPT_COUNT = 200;
  const notes = { usefulMs: 0, frames: {} as Counts, interactions: {} as Counts, newest: new Map<number, number>() };
  Object.assign(window, { notes });
  const add = (counts: Counts, ms: number): void => void (counts[ms] = (counts[ms] ?? 0) + 1);
  new PerformanceObserver((list) => {
    // A click is several events; the longest of them is what somebody waits for.
    for (const entry of list.getEntries() as PerformanceEventTiming[]) {
      const { interactionId, duration } = entry as PerformanceEventTiming & { interactionId: number };
      if (interactionId === 0) continue;
      notes.newest.set(interactionId, Math.max(duration, notes.newest.get(interactionId) ?? 0));
    }
    for (const [id, ms] of notes.newest) {
      if (notes.newest.size <= KEPT_COUNT) break;
      notes.newest.delete(id);
      add(notes.interactions, ms);
    }
  }).observe({ type: "event", durationThreshold: 16, buffered: true } as PerformanceObserverInit);
  let before = 0;
  const frame = (now: number): void => {
    if (before > 0) add(notes.frames, Math.round(10 * (now - before)) / 10);
    before = now;
    if (notes.usefulMs === 0 && document.querySelector(".rows .row")) notes.usefulMs = now;
    requestAnimationFrame(frame);
  };
  requestAnimationFrame(frame);
}

export const readNotes = (page: Page): Promise<Notes> =>
  page.evaluate(() => {
    const { notes } = window as unknown as { notes: Notes & { newest: Map<number, number> } };
    const { interactionCount } = performance as Performance & { interactionCount: number };
    const interactions = { ...notes.interactions };
    for (const ms of notes.newest.values()) interactions[ms] = (interactions[ms] ?? 0) + 1;
    return { usefulMs: notes.usefulMs, frames: { ...notes.frames }, interactions, interactionCount };
  });

export const total = (counts: Counts): number => Object.values(counts).reduce((sum, n) => sum + n, 0);

/** How many were longer than `ms`. */
export const countAbove = (counts: Counts, ms: number): number =>
  Object.entries(counts).reduce((sum, [duration, n]) => sum + (Number(duration) > ms ? n : 0), 0);

export function quantile(counts: Counts, share: number): number {
  const sorted = Object.entries(counts)
    .map(([ms, n]) => [Number(ms), n] as const)
    .sort(([a], [b]) => a - b);
  let rest = Math.floor(share * total(counts));
  for (const [ms, n] of sorted) {
    if (rest < n) return ms;
    rest -= n;
  }
  return sorted.at(-1)?.[0] ?? 0;
}

/** Of all interactions, those below 16 ms counted as 0. */
export function interactionQuantile({ interactions, interactionCount }: Notes, share: number): number {
  const quick = Math.max(0, interactionCount - total(interactions));
  return quantile({ ...interactions, 0: quick }, share);
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
