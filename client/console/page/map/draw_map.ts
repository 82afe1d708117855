import type { Bounds, Camera } from "./camera.ts";
import type { Palette } from "./palette.ts";
import { type TileId, boundsOf, keyOf, levelFor, parentOf, sideOf, tilesIn } from "./tile_grid.ts";
import type { Tile, TileStore } from "./tile_store.ts";

const BITMAP_PX = 896;
/** Kept drawn beside those in view, for who goes back and forth. */
const SPARE_BITMAP_COUNT = 12;
/** A keyframe stands for the street around it. */
const STREET_HALF_WIDTH_M = 7;
const WEAK_DBSM = -10;
const STRONG_DBSM = 25;
const GRID_PX = 90;

/** A tile's street and landmarks, once for all frames that show it. */
function paint({ id, data }: Tile, palette: Palette): HTMLCanvasElement {
  const canvas = document.createElement("canvas");
  canvas.width = canvas.height = BITMAP_PX;
  const context = canvas.getContext("2d")!;
  const { minX, maxY } = boundsOf(id);
  const pxPerM = BITMAP_PX / sideOf(id.level);
  const left = (data.originM?.x ?? 0) - minX;
  const top = maxY - (data.originM?.y ?? 0);

  context.fillStyle = palette.coverage;
  const half = Math.max(STREET_HALF_WIDTH_M * pxPerM, 1.2);
  context.beginPath();
  for (let i = 0; i < data.keyframeXM.length; ++i) {
    const x = (left + data.keyframeXM[i]!) * pxPerM;
    const y = (top - data.keyframeYM[i]!) * pxPerM;
    context.moveTo(x + half, y);
    context.arc(x, y, half, 0, 2 * Math.PI);
  }
  context.fill();

  const [r, g, b] = palette.landmark;
  const size = Math.min(3.2, Math.max(1.5, 0.4 * pxPerM));
  // Few steps of brightness, so that the colour changes seldom.
  for (let step = 0; step < 4; ++step) {
    context.fillStyle = `rgba(${r}, ${g}, ${b}, ${0.5 + 0.16 * step})`;
    for (let i = 0; i < data.xM.length; ++i) {
      const strength = ((data.rcsDbsm[i] ?? 0) - WEAK_DBSM) / (STRONG_DBSM - WEAK_DBSM);
      if (Math.min(3, Math.max(0, Math.floor(4 * strength))) !== step) continue;
      context.fillRect((left + data.xM[i]!) * pxPerM, (top - data.yM[i]!) * pxPerM, size, size);
    }
  }
  return canvas;
}

function blit(
  context: CanvasRenderingContext2D,
  camera: Camera,
  palette: Palette,
  tile: Tile,
  part: TileId,
): void {
  if (tile.bitmap?.theme !== palette.theme) {
    tile.bitmap = { theme: palette.theme, image: paint(tile, palette) };
  }
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

/** Draws what there is of the map, and asks the store for what is missing. */
export function drawTiles(
  context: CanvasRenderingContext2D,
  camera: Camera,
  palette: Palette,
  store: TileStore,
  extent: Bounds,
): { shown: number; count: number } {
  const wanted = tilesIn(camera.bounds, extent, levelFor(camera.scale));
  const missing: TileId[] = [];
  let blitCount = 0;
  let shown = 0;
  let count = 0;
  for (const id of wanted) {
    let tile = store.get(id);
    if (tile) {
      shown += tile.data.xM.length;
      count += Number(tile.data.pointCount);
    } else {
      missing.push(id);
    }
    // Until it is there, the part of a coarser one.
    for (let up = parentOf(id); !tile && up; up = parentOf(up)) tile = store.get(up);
    if (!tile) continue;
    blit(context, camera, palette, tile, id);
    ++blitCount;
  }
  store.keepBitmaps(blitCount + SPARE_BITMAP_COUNT);
  // The coarse ones first, in a map that is seen for the first time: they are there at once.
  const coarse = new Map<string, TileId>();
  for (const id of missing) {
    const up = id.level > 1 ? tilesIn(boundsOf(id), boundsOf(id), 1)[0]! : undefined;
    if (up && !store.get(up)) coarse.set(keyOf(up), up);
  }
  store.want([...coarse.values(), ...wanted]);
  return { shown, count };
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
