import type { LocalizeResponse } from "proto/dcloc/v1/localization_service_pb.ts";
import type { Rig, Scan } from "proto/dcloc/v1/scan_pb.ts";
import type { DrawnTarget } from "./draw_scan.ts";
import type { Surroundings } from "./surroundings.ts";
import { type Targets, targetsOf } from "./targets.ts";

/** A scan, laid where its own answer put the vehicle. */
export interface PlacedScan {
  radarId: string;
  targets: Targets;
}

/** Undefined where the answer has no pose. */
export function placeScan(
  scan: Scan | undefined,
  answer: LocalizeResponse | undefined,
  rig: Rig | undefined,
): PlacedScan | undefined {
  const pose = answer?.message.case === "result" ? answer.message.value.pose?.pose : undefined;
  if (!scan || !pose) return undefined;
  const { radarId } = scan;
  const radar = rig?.radars.find((model) => model.radarId === radarId);
  return { radarId, targets: targetsOf(scan, radar, pose) };
}

export function drawnTargets({ targets }: PlacedScan, surroundings: Surroundings | undefined): DrawnTarget[] {
  const { x_map, y_map, rangeRateMps } = targets;
  return Array.from(x_map, (x, i) => {
    const y = y_map[i]!;
    return { x, y, rangeRateMps: rangeRateMps[i]!, isNear: surroundings?.hasNear(x, y) };
  });
}
