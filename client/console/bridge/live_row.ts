import { type Health, SourceFault } from "proto/dcloc/v1/localization_service_pb.ts";
import type { Session } from "proto/dcloc/v1/admin_service_pb.ts";
import type { LivePose, LiveSession } from "../shared/live.ts";

const SILENT_STEP_S = 5;
/** Longer names than any server takes fill no page. */
const MAX_NAME_LENGTH = 200;
const NS_PER_S = 1_000_000_000n;

function millimetres(value: number): number {
  return Math.round(value * 1000) / 1000;
}

function poseOf(session: Session): LivePose | undefined {
  const t = session.pose?.pose?.translationM;
  const q = session.pose?.pose?.rotation;
  const covariance = session.pose?.covariance;
  if (!t || !q || covariance?.length !== 36) return undefined;
  const yaw = Math.atan2(2 * (q.w * q.z + q.x * q.y), 1 - 2 * (q.y * q.y + q.z * q.z));
  const pose = {
    x: millimetres(t.x),
    y: millimetres(t.y),
    yaw: Math.round(yaw * 1e4) / 1e4,
    xx: Number(covariance[0]!.toPrecision(4)),
    xy: Number(covariance[1]!.toPrecision(4)),
    yy: Number(covariance[7]!.toPrecision(4)),
    stampMs: Number(session.poseStampNs / 1_000_000n),
  };
  return Object.values(pose).every(Number.isFinite) ? pose : undefined;
}

/** The sources of a vehicle that do not take part, or have a fault. */
export function faultySources(health: Health | undefined): string[] {
  if (!health) return [];
  const isFaulty = (source: { used: boolean; fault: SourceFault }): boolean =>
    !source.used || source.fault > SourceFault.NONE;
  const faulty: string[] = [];
  if (health.wheelSpeed && isFaulty(health.wheelSpeed)) faulty.push("wheel_speed");
  if (health.yawRate && isFaulty(health.yawRate)) faulty.push("yaw_rate");
  for (const radar of health.radars) if (isFaulty(radar)) faulty.push(radar.radarId);
  return faulty;
}

export function liveSession(session: Session): LiveSession {
  const idleS = Number(session.idleDurationNs / NS_PER_S);
  const pose = poseOf(session);
  return {
    id: session.sessionId,
    vehicle: session.vehicleId.slice(0, MAX_NAME_LENGTH),
    map: session.mapName,
    version: Number(session.mapVersion),
    state: session.state,
    detached: session.detached,
    silentS: Math.floor(idleS / SILENT_STEP_S) * SILENT_STEP_S,
    faults: faultySources(session.health),
    ...(pose ? { pose } : {}),
    ...(session.replica ? { replica: session.replica } : {}),
  };
}
