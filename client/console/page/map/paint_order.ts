import type { TileId } from "./tile_grid.ts";
import type { TileColours } from "./tile_raster.ts";
import type { TileData } from "./tile_store.ts";

/** Side of a painted tile. It is drawn at most 700 pixels wide before the next level is taken. */
export const BITMAP_PX = 768;

/** What the page asks of the worker. */
export interface PaintOrder {
  number: number;
  id: TileId;
  data: TileData;
  colours: TileColours;
}

/** What the worker answers. */
export interface PaintedTile {
  number: number;
  image: ImageBitmap;
}
