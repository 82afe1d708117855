import type { Pose, Vector3 } from "proto/dcloc/v1/geometry_pb.ts";
import type { RadarModel, Scan } from "proto/dcloc/v1/scan_pb.ts";

/** A scan's targets in the plane of the map frame; columns of equal length. */
export interface Targets {
  x_map: Float64Array;
  y_map: Float64Array;
  rangeRateMps: Float32Array;
}

/** Far above what a radar gives; a file may say anything. */
const MAX_TARGET_COUNT = 20_000;

/** Measured range = range + beta * range rate: beta as given, or by the waveform (METHOD eq 5). */
function betaOf({ coupling }: RadarModel): number {
  if (coupling.case === "betaS") return coupling.value;
  if (coupling.case !== "chirp" || coupling.value.slopeHzPerS === 0) return 0;
  return coupling.value.centreFrequencyHz / coupling.value.slopeHzPerS;
}

/** p_parent = rotation * p_child + translation. */
export function transform(T_parent_child: Pose, [x, y, z]: Triple): Triple {
  const q = T_parent_child.rotation ?? { w: 1, x: 0, y: 0, z: 0 };
  const t: Pick<Vector3, "x" | "y" | "z"> = T_parent_child.translationM ?? { x: 0, y: 0, z: 0 };
  // v + 2 w (q x v) + 2 q x (q x v)
  const cx = 2 * (q.y * z - q.z * y);
  const cy = 2 * (q.z * x - q.x * z);
  const cz = 2 * (q.x * y - q.y * x);
  return [
    x + q.w * cx + q.y * cz - q.z * cy + t.x,
    y + q.w * cy + q.z * cx - q.x * cz + t.y,
    z + q.w * cz + q.x * cy - q.y * cx + t.z,
  ];
}

export type Triple = [number, number, number];

/**
 * Where a scan's targets lie when the vehicle is at `T_map_vehicle`: ranges compensated for the
 * coupling and the bias that the rig tells. What the server learned of the rig is not in it.
 */
export function targetsOf(scan: Scan, radar: RadarModel | undefined, T_map_vehicle: Pose): Targets {
  const { rangeM, rangeRateMps, azimuthRad, elevationRad } = scan;
  const count = Math.min(rangeM.length, rangeRateMps.length, azimuthRad.length, MAX_TARGET_COUNT);
  const targets: Targets = {
    x_map: new Float64Array(count),
    y_map: new Float64Array(count),
    rangeRateMps: Float32Array.from(rangeRateMps.slice(0, count)),
  };
  const beta = radar ? betaOf(radar) : 0;
  const bias = radar?.rangeBiasM ?? 0;
  for (let i = 0; i < count; ++i) {
    const range = rangeM[i]! - beta * rangeRateMps[i]! - bias;
    const elevation = elevationRad[i] ?? 0;
    const flat = range * Math.cos(elevation);
    const p_radar: Triple = [
      flat * Math.cos(azimuthRad[i]!),
      flat * Math.sin(azimuthRad[i]!),
      range * Math.sin(elevation),
    ];
    const p_vehicle = radar?.tVehicleRadar ? transform(radar.tVehicleRadar, p_radar) : p_radar;
    [targets.x_map[i], targets.y_map[i]] = transform(T_map_vehicle, p_vehicle);
  }
  return targets;
}
