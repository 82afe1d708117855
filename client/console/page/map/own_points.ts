import { type TileId, boundsOf } from "./tile_grid.ts";
import type { TileData } from "./tile_store.ts";

/** Landmarks of a tile: those that were read, and how many there are. */
export interface PointCounts {
  shown: number;
  count: number;
}

/**
 * Of a tile alone: it is read with a margin, whose landmarks its neighbours have as well. Where only
 * some were read, how many there are is reckoned from the share of them that lies within.
 */
export function ownPoints(id: TileId, { originXM, originYM, xM, yM, pointCount }: TileData): PointCounts {
  const { minX, minY, maxX, maxY } = boundsOf(id);
  let shown = 0;
  for (let i = 0; i < xM.length; ++i) {
    const [x, y] = [originXM + xM[i]!, originYM + yM[i]!];
    if (x >= minX && x < maxX && y >= minY && y < maxY) ++shown;
  }
  const all = Math.max(pointCount, xM.length);
  return { shown, count: xM.length > 0 ? Math.round((shown / xM.length) * all) : 0 };
}
