import { LandmarkGrid } from "../map/landmark_grid.ts";
import { type TileId, sideOf, tilesIn } from "../map/tile_grid.ts";
import { type Tile, TileStore } from "../map/tile_store.ts";

/** A target has a landmark nearby when one lies within this distance in the plane. */
export const NEAR_M = 1;
/** Squares of 256 m: a few hold all that a radar sees. */
const LEVEL = 4;
/** So far from the vehicle landmarks are read. */
const REACH_M = 150;
const MAX_POINT_COUNT = 50_000;
const EVERYWHERE = { minX: -1e9, minY: -1e9, maxX: 1e9, maxY: 1e9 };

/** The landmarks around a vehicle, read square by square as it drives. */
export class Surroundings {
  private readonly store: TileStore;
  private readonly grids = new WeakMap<Tile, LandmarkGrid>();

  constructor(server: string, map: string, version: number, onTile: () => void) {
    this.store = new TileStore(server, map, version, onTile, () => MAX_POINT_COUNT);
  }

  moveTo(x: number, y: number): void {
    const reach = { minX: x - REACH_M, minY: y - REACH_M, maxX: x + REACH_M, maxY: y + REACH_M };
    if (Number.isFinite(x) && Number.isFinite(y)) this.store.want(tilesIn(reach, EVERYWHERE, LEVEL));
  }

  /** Whether a landmark is nearby; undefined where the map is not read yet, or not all of it. */
  hasNear(x: number, y: number): boolean | undefined {
    const side = sideOf(LEVEL);
    const id: TileId = { level: LEVEL, column: Math.floor(x / side), row: Math.floor(y / side) };
    const tile = this.store.get(id);
    if (!tile) return undefined;
    let grid = this.grids.get(tile);
    if (!grid) {
      grid = new LandmarkGrid(tile.data.xM, tile.data.yM, NEAR_M);
      this.grids.set(tile, grid);
    }
    const { originXM, originYM, xM, pointCount } = tile.data;
    const isNear = grid.hasNear(x - originXM, y - originYM);
    const isWhole = pointCount === xM.length;
    return isNear || isWhole ? isNear : undefined;
  }

  close(): void {
    this.store.close();
  }
}
