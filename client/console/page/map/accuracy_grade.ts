import type { ExpectedAccuracy } from "proto/dcloc/v1/map_service_pb.ts";

/** How well a vehicle can know where it is: the map does not say, to keep the middle of a lane, its
 *  lane, or worse; worse also where a tunnel or another place that looks alike may mislead it. */
export const ACCURACY_GRADES = ["unknown", "good", "fair", "poor"] as const;

const GOOD_M = 0.1;
const FAIR_M = 0.3;

/** The index of its grade. */
export function gradeOf(accuracy: ExpectedAccuracy | undefined): number {
  if (!accuracy) return 0;
  const { alongSigmaM, acrossSigmaM, isTunnel, isAlias } = accuracy;
  if (alongSigmaM === undefined || acrossSigmaM === undefined || isTunnel || isAlias) return 3;
  const sigmaM = Math.max(alongSigmaM, acrossSigmaM);
  if (sigmaM <= GOOD_M) return 1;
  return sigmaM <= FAIR_M ? 2 : 3;
}
