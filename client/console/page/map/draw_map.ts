import type { Bounds, Camera } from "./camera.ts";
import { BITMAP_PX } from "./paint_order.ts";
import type { Palette } from "./palette.ts";
import { type TileId, boundsOf, keyOf, levelFor, parentOf, sideOf, tilesIn } from "./tile_grid.ts";
import type { TilePainter } from "./tile_painter.ts";
import type { Tile, TileStore } from "./tile_store.ts";

/** Kept drawn beside those in view, for who goes back and forth. */
const SPARE_BITMAP_COUNT = 8;
const GRID_PX = 90;

/** Draws the part of a painted tile that `part` is. */
function blit(context: CanvasRenderingContext2D, camera: Camera, tile: PaintedTile, part: TileId): void {
  const whole = boundsOf(tile.id);
  const bounds = boundsOf(part);
  const px = BITMAP_PX / sideOf(tile.id.level);
  const side = sideOf(part.level);
  context.drawImage(
    tile.bitmap.image,
    (bounds.minX - whole.minX) * px,
    (whole.maxY - bounds.maxY) * px,
    side * px,
    side * px,
    camera.toScreenX(bounds.minX),
    camera.toScreenY(bounds.maxY),
    side * camera.scale + 0.5,
    side * camera.scale + 0.5,
  );
}

type PaintedTile = Tile & { bitmap: NonNullable<Tile["bitmap"]> };

const isPainted = (tile: Tile | undefined): tile is PaintedTile => tile?.bitmap !== undefined;
const isTile = (tile: Tile | undefined): tile is Tile => tile !== undefined;

/** The tile, or else the least coarse one around it that there is, of those that may be taken. */
function nearest(
  id: TileId,
  store: TileStore,
  mayBe: (tile: Tile) => boolean = () => true,
): Tile | undefined {
  for (let at: TileId | undefined = id; at; at = parentOf(at)) {
    const tile = store.get(at);
    if (tile && mayBe(tile)) return tile;
  }
  return undefined;
}

/** The tiles to be read: the coarse ones first, in a map that is seen for the first time, for they are
 * there at once. */
function tilesToRead(wanted: TileId[], store: TileStore): TileId[] {
  const coarse = new Map<string, TileId>();
  for (const id of wanted) {
    if (id.level <= 1 || store.get(id)) continue;
    const up = tilesIn(boundsOf(id), boundsOf(id), 1)[0]!;
    if (!store.get(up)) coarse.set(keyOf(up), up);
  }
  return [...coarse.values(), ...wanted];
}

export interface MapSource {
  store: TileStore;
  painter: TilePainter;
  extent: Bounds;
}

/** What of a map is in view. */
export interface MapDrawn {
  /** Landmarks that are shown. */
  shown: number;
  /** Landmarks that there are. */
  count: number;
  /** The map says how well vehicles can know where they are in it. */
  isGraded: boolean;
}

/**
 * Draws what there is of the map, and has what is missing read and painted.
 */
export function drawTiles(
  context: CanvasRenderingContext2D,
  camera: Camera,
  palette: Palette,
  { store, painter, extent }: MapSource,
): MapDrawn {
  const wanted = tilesIn(camera.bounds, extent, levelFor(camera.scale));
  const there = wanted.map((id) => store.get(id)).filter(isTile);
  const best = new Set(wanted.map((id) => nearest(id, store)).filter(isTile));
  painter.want([...best].filter(({ bitmap }) => bitmap?.theme !== palette.theme), palette);
  let blitCount = 0;
  for (const id of wanted) {
    // In the colours of before it would be glaring.
    const tile = nearest(id, store, ({ bitmap }) => bitmap?.theme === palette.theme);
    if (!isPainted(tile)) continue;
    blit(context, camera, tile, id);
    ++blitCount;
  }
  store.keepBitmaps(blitCount + SPARE_BITMAP_COUNT);
  store.want(tilesToRead(wanted, store));
  const shown = there.reduce((sum, { own }) => sum + own.shown, 0);
  const count = there.reduce((sum, { own }) => sum + own.count, 0);
  const isGraded = there.some(({ data }) => data.isGraded);
  return { shown, count, isGraded };
}

/** A grid of metres, and how long its side is. */
export function drawGrid(context: CanvasRenderingContext2D, camera: Camera, palette: Palette): void {
  const rough = GRID_PX / camera.scale;
  const power = 10 ** Math.floor(Math.log10(rough));
  const side = [1, 2, 5, 10].map((n) => n * power).find((s) => s >= rough)!;
  const { minX, minY, maxX, maxY } = camera.bounds;
  context.strokeStyle = palette.grid;
  context.lineWidth = 1;
  context.beginPath();
  for (let x = Math.ceil(minX / side) * side; x <= maxX; x += side) {
    const px = Math.round(camera.toScreenX(x)) + 0.5;
    context.moveTo(px, 0);
    context.lineTo(px, camera.height);
  }
  for (let y = Math.ceil(minY / side) * side; y <= maxY; y += side) {
    const px = Math.round(camera.toScreenY(y)) + 0.5;
    context.moveTo(0, px);
    context.lineTo(camera.width, px);
  }
  context.stroke();

  const length = side * camera.scale;
  const [x, y] = [16, camera.height - 18];
  context.strokeStyle = palette.gridText;
  context.lineWidth = 1.5;
  context.beginPath();
  context.moveTo(x, y - 5);
  context.lineTo(x, y);
  context.lineTo(x + length, y);
  context.lineTo(x + length, y - 5);
  context.stroke();
  context.fillStyle = palette.gridText;
  context.font = "500 11px 'Inter Variable', sans-serif";
  context.textAlign = "left";
  context.fillText(side >= 1000 ? `${side / 1000} km` : `${side} m`, x + 6, y - 6);
}
