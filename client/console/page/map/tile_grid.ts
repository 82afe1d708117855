import type { Bounds } from "./camera.ts";

export const ROOT_SIDE_M = 4096;
/** What is drawn wider than a point reaches over a tile's edge; with it a tile is read, and then still
 * smaller than the largest rectangle that a server reads at once (5 km). */
export const MARGIN_M = 16;
const MAX_LEVEL = 5;
/** A tile is drawn at most so large before the next level is taken. */
const MAX_TILE_PX = 700;
/** Beyond it the map is too small on the screen to be read tile by tile. */
const MAX_TILE_COUNT = 400;

/** A square of a map; level 0 is 4 km wide, each further one half as wide. */
export interface TileId {
  level: number;
  column: number;
  row: number;
}

export const sideOf = (level: number): number => ROOT_SIDE_M / 2 ** level;

export const keyOf = ({ level, column, row }: TileId): string => `${level}/${column}/${row}`;

export function boundsOf({ level, column, row }: TileId): Bounds {
  const side = sideOf(level);
  return {
    minX: column * side,
    minY: row * side,
    maxX: (column + 1) * side,
    maxY: (row + 1) * side,
  };
}

export function parentOf({ level, column, row }: TileId): TileId | undefined {
  if (level === 0) return undefined;
  return { level: level - 1, column: Math.floor(column / 2), row: Math.floor(row / 2) };
}

/** Each level has a share of the landmarks; the finest one has all that the server gives. */
export const pointCountOf = (level: number): number => [3000, 8000, 12000, 20000, 30000, 50000][level]!;

/** The coarsest level whose tiles are not drawn too large at this scale [pixels/m]. */
export function levelFor(scale: number): number {
  const level = Math.ceil(Math.log2((ROOT_SIDE_M * scale) / MAX_TILE_PX));
  return Math.min(MAX_LEVEL, Math.max(0, level));
}

/** The tiles of a level that show `view` and have something of `map`, the nearest to the centre first. */
export function tilesIn(view: Bounds, map: Bounds, level: number): TileId[] {
  const side = sideOf(level);
  const first = {
    column: Math.floor(Math.max(view.minX, map.minX) / side),
    row: Math.floor(Math.max(view.minY, map.minY) / side),
  };
  const last = {
    column: Math.floor(Math.min(view.maxX, map.maxX) / side),
    row: Math.floor(Math.min(view.maxY, map.maxY) / side),
  };
  const tiles: (TileId & { distance: number })[] = [];
  const centre = { x: (view.minX + view.maxX) / 2 / side, y: (view.minY + view.maxY) / 2 / side };
  for (let row = first.row; row <= last.row && tiles.length < MAX_TILE_COUNT; ++row) {
    for (let column = first.column; column <= last.column; ++column) {
      const distance = Math.hypot(column + 0.5 - centre.x, row + 0.5 - centre.y);
      tiles.push({ level, column, row, distance });
    }
  }
  return tiles.sort((a, b) => a.distance - b.distance).slice(0, MAX_TILE_COUNT);
}
