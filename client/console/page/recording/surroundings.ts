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

/** Landmarks by squares as wide as NEAR_M, so that the nearest ones of a place are in nine of them. */
export class LandmarkGrid {
  private readonly cells = new Map<number, number[]>();

  /** Coordinates in metres, of any frame; `all` is false where landmarks were left out. */
  constructor(
    private readonly x: ArrayLike<number>,
    private readonly y: ArrayLike<number>,
    readonly all = true,
    private readonly radiusM = NEAR_M,
  ) {
    for (let i = 0; i < x.length; ++i) {
      const key = this.keyAt(this.cellOf(x[i]!), this.cellOf(y[i]!));
      const cell = this.cells.get(key);
      if (cell) cell.push(i);
      else this.cells.set(key, [i]);
    }
  }

  hasNear(x: number, y: number): boolean {
    const [column, row] = [this.cellOf(x), this.cellOf(y)];
    const limit = this.radiusM * this.radiusM;
    for (let dc = -1; dc <= 1; ++dc) {
      for (let dr = -1; dr <= 1; ++dr) {
        for (const i of this.cells.get(this.keyAt(column + dc, row + dr)) ?? []) {
          if ((this.x[i]! - x) ** 2 + (this.y[i]! - y) ** 2 <= limit) return true;
        }
      }
    }
    return false;
  }

  private cellOf(metres: number): number {
    return Math.floor(metres / this.radiusM);
  }

  private keyAt(column: number, row: number): number {
    return column * 2 ** 25 + row;
  }
}

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
      const { xM, yM, pointCount } = tile.data;
      grid = new LandmarkGrid(xM, yM, Number(pointCount) === xM.length);
      this.grids.set(tile, grid);
    }
    const { originM } = tile.data;
    const isNear = grid.hasNear(x - (originM?.x ?? 0), y - (originM?.y ?? 0));
    return isNear || grid.all ? isNear : undefined;
  }

  close(): void {
    this.store.close();
  }
}
