import type { LiveLoss, LiveSession } from "../shared/live.ts";

const KEPT_MS = 60 * 60_000;
const MAX_COUNT = 2_000;
/** Who was not looked at for longer got lost at a time and a place that nobody knows. */
const MAX_GAP_MS = 60_000;
const LOST = 4;

interface Entry extends Omit<LiveLoss, "agoMs"> {
  timeMs: number;
}

/** Where vehicles got lost in the last hour: as long as somebody looked, and also for who comes later. */
export class LossLog {
  private entries: Entry[] = [];
  /** The sessions that were lost, or not, when they were last listed. */
  private lost = new Set<string>();
  private known = new Set<string>();
  private lastMs = -Infinity;

  /** Takes all sessions as they are now; gives those that have got lost since they were last taken. */
  take(sessions: Iterable<LiveSession>, nowMs: number): LiveLoss[] {
    const isRecent = nowMs - this.lastMs <= MAX_GAP_MS;
    const [known, lost] = [new Set<string>(), new Set<string>()];
    const fresh: Entry[] = [];
    for (const { id, vehicle, map, state, pose } of sessions) {
      known.add(id);
      if (state !== LOST) continue;
      lost.add(id);
      if (!isRecent || !pose || !this.known.has(id) || this.lost.has(id)) continue;
      fresh.push({ vehicle, map, x: pose.x, y: pose.y, timeMs: nowMs });
    }
    [this.known, this.lost, this.lastMs] = [known, lost, nowMs];
    const kept = this.entries.filter(({ timeMs }) => nowMs - timeMs < KEPT_MS);
    this.entries = [...kept, ...fresh].slice(-MAX_COUNT);
    return fresh.map((entry) => asLoss(entry, nowMs));
  }

  /** Those of the last hour, the oldest first. */
  all(nowMs: number): LiveLoss[] {
    return this.entries
      .filter(({ timeMs }) => nowMs - timeMs < KEPT_MS)
      .map((entry) => asLoss(entry, nowMs));
  }
}

const asLoss = ({ timeMs, ...place }: Entry, nowMs: number): LiveLoss => ({
  ...place,
  agoMs: Math.round(nowMs - timeMs),
});
