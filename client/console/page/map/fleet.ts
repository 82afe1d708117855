import type { LiveFrame, LiveLoss, LivePose, LiveSession, SilentReplica } from "../../shared/live.ts";

/** LocalizationState of the contract. */
export const enum State {
  None = 0,
  Initializing = 1,
  Tracking = 2,
  DeadReckoning = 3,
  Lost = 4,
}

const TRAIL_LENGTH = 90;
/** A vehicle further from its last pose than this was found elsewhere: it does not glide there. */
const MAX_GLIDE_M = 60;
const MAX_LOSS_COUNT = 2_000;
export const LOSS_MEMORY_MS = 60 * 60_000;

/** A vehicle as it is drawn: between the last two poses that were told, so that it moves evenly. */
export interface Vehicle extends LiveSession {
  server: string;
  before?: LivePose;
  /** When the last pose came, on the page's clock, and how long after the one before. */
  arrivalMs: number;
  intervalMs: number;
  /** x and y of the last poses, the oldest first. */
  trail: number[];
}

/** A place where a vehicle got lost. */
export interface Loss extends Omit<LiveLoss, "agoMs"> {
  server: string;
  /** On the page's clock. */
  timeMs: number;
}

export interface ServerFault {
  code: number;
  message: string;
}

/** All that is known of the fleet. */
export class Fleet {
  readonly vehicles = new Map<string, Vehicle>();
  readonly faults = new Map<string, ServerFault>();
  /** By server: those of its fleet that did not answer it. */
  readonly silent = new Map<string, readonly SilentReplica[]>();
  readonly heardOf = new Set<string>();
  losses: Loss[] = [];

  static key(server: string, id: string): string {
    return `${server}/${id}`;
  }

  take(frame: LiveFrame, nowMs: number): void {
    const { server } = frame;
    this.heardOf.add(server);
    if (frame.failure) {
      this.faults.set(server, frame.failure);
      return;
    }
    this.faults.delete(server);
    this.silent.set(server, frame.silent ?? []);
    this.takeLosses(frame, nowMs);
    if (frame.full) this.dropOthers(server, new Set((frame.set ?? []).map(({ id }) => id)));
    for (const session of frame.set ?? []) this.takeSession(server, session, nowMs);
    for (const id of frame.gone ?? []) this.vehicles.delete(Fleet.key(server, id));
  }

  /** Where a vehicle is drawn now. */
  static poseOf(vehicle: Vehicle, nowMs: number): LivePose | undefined {
    const { pose, before } = vehicle;
    if (!pose || !before) return pose;
    const share = Math.min(1, (nowMs - vehicle.arrivalMs) / vehicle.intervalMs);
    const turn = Math.atan2(Math.sin(pose.yaw - before.yaw), Math.cos(pose.yaw - before.yaw));
    return {
      ...pose,
      x: before.x + share * (pose.x - before.x),
      y: before.y + share * (pose.y - before.y),
      yaw: before.yaw + share * turn,
    };
  }

  private takeSession(server: string, session: LiveSession, nowMs: number): void {
    const key = Fleet.key(server, session.id);
    const old = this.vehicles.get(key);
    const vehicle: Vehicle = { ...session, server, arrivalMs: nowMs, intervalMs: 1000, trail: old?.trail ?? [] };
    if (session.pose) this.moveOn(vehicle, old, nowMs);
    this.vehicles.set(key, vehicle);
  }

  private takeLosses({ server, full, losses = [] }: LiveFrame, nowMs: number): void {
    if (!full && losses.length === 0) return;
    const fresh = losses.map(({ agoMs, ...loss }) => ({ ...loss, server, timeMs: nowMs - agoMs }));
    this.losses = this.losses
      .filter((loss) => nowMs - loss.timeMs < LOSS_MEMORY_MS && !(full && loss.server === server))
      .concat(fresh)
      .slice(-MAX_LOSS_COUNT);
  }

  private moveOn(vehicle: Vehicle, old: Vehicle | undefined, nowMs: number): void {
    const pose = vehicle.pose!;
    const shown = old && Fleet.poseOf(old, nowMs);
    const isNear = shown && Math.hypot(shown.x - pose.x, shown.y - pose.y) < MAX_GLIDE_M;
    if (!isNear) {
      vehicle.trail = [];
    } else {
      vehicle.before = shown;
      vehicle.intervalMs = Math.min(3000, Math.max(200, nowMs - old.arrivalMs));
    }
    vehicle.trail.push(pose.x, pose.y);
    if (vehicle.trail.length > 2 * TRAIL_LENGTH) vehicle.trail.splice(0, 2);
  }

  private dropOthers(server: string, ids: Set<string>): void {
    for (const [key, vehicle] of this.vehicles) {
      if (vehicle.server === server && !ids.has(vehicle.id)) this.vehicles.delete(key);
    }
  }
}
