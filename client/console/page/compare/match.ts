import type { ReadMapTileResponse } from "proto/dcloc/v1/map_service_pb.ts";
import type { Bounds } from "../map/camera.ts";
import { LandmarkGrid } from "../map/landmark_grid.ts";

/** A landmark of one version is in the other as well when that has one within this distance. */
export const SAME_M = 0.5;

/** Landmarks in the map frame: x and y in turn. */
export type Points = Float64Array;

/** What two versions have in one square. */
export interface SquareDifference {
  /** As the first version has them. */
  both: Points;
  onlyFrom: Points;
  onlyTo: Points;
  /** A version has more landmarks here than a server reads at once: the figures are of a part. */
  isPart: boolean;
}

export interface Counts {
  both: number;
  onlyFrom: number;
  onlyTo: number;
}

type Tile = Pick<ReadMapTileResponse, "originM" | "xM" | "yM" | "pointCount">;

function pointsOf({ originM, xM, yM }: Tile): Points {
  const points = new Float64Array(2 * Math.min(xM.length, yM.length));
  for (let i = 0; 2 * i < points.length; ++i) {
    points[2 * i] = (originM?.x ?? 0) + xM[i]!;
    points[2 * i + 1] = (originM?.y ?? 0) + yM[i]!;
  }
  return points;
}

const column = (points: Points, offset: 0 | 1): Float64Array =>
  Float64Array.from({ length: points.length / 2 }, (_, i) => points[2 * i + offset]!);

/** Those of `points` within the square that have, or have not, a landmark of `other` nearby. */
function split(points: Points, other: Points, square: Bounds): { near: number[]; alone: number[] } {
  const grid = new LandmarkGrid(column(other, 0), column(other, 1), SAME_M);
  const near: number[] = [];
  const alone: number[] = [];
  for (let i = 0; i < points.length; i += 2) {
    const [x, y] = [points[i]!, points[i + 1]!];
    // Each landmark belongs to one square; those around it are there to be compared with.
    if (!(x >= square.minX && x < square.maxX && y >= square.minY && y < square.maxY)) continue;
    (grid.hasNear(x, y) ? near : alone).push(x, y);
  }
  return { near, alone };
}

/** Compares what two versions have in a square; the tiles reach over its edges. */
export function differenceOf(from: Tile, to: Tile, square: Bounds): SquareDifference {
  const [a, b] = [pointsOf(from), pointsOf(to)];
  const ofFrom = split(a, b, square);
  return {
    both: Float64Array.from(ofFrom.near),
    onlyFrom: Float64Array.from(ofFrom.alone),
    onlyTo: Float64Array.from(split(b, a, square).alone),
    isPart: Number(from.pointCount) > from.xM.length || Number(to.pointCount) > to.xM.length,
  };
}

export const countsOf = ({ both, onlyFrom, onlyTo }: SquareDifference): Counts => ({
  both: both.length / 2,
  onlyFrom: onlyFrom.length / 2,
  onlyTo: onlyTo.length / 2,
});
