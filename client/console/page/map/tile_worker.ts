// Paints tiles beside the page's own thread, which so stays free for who uses it.
import { type PaintOrder, type PaintedTile, BITMAP_PX } from "./paint_order.ts";
import { boundsOf, sideOf } from "./tile_grid.ts";
import { rasterize, withPlacesBetween } from "./tile_raster.ts";

/** A keyframe stands for the street around it. */
const STREET_HALF_WIDTH_M = 7;
/** Keyframes further apart may have no street between them. */
const MAX_KEYFRAME_GAP_M = 16;
const MIN_STREET_PX = 1.2;
const WEAK_DBSM = -10;
const STRONG_DBSM = 25;

function paint({ id, data, colours }: PaintOrder): ImageBitmap {
  const { minX, maxY } = boundsOf(id);
  const pxPerM = BITMAP_PX / sideOf(id.level);
  const left = data.originXM - minX;
  const top = maxY - data.originYM;
  const toX = (x: number): number => (left + x) * pxPerM;
  const toY = (y: number): number => (top - y) * pxPerM;
  const keyframes = [data.keyframeXM.map(toX), data.keyframeYM.map(toY)] as const;
  // Where the discs are a few pixels small, notches do not show.
  const gap = STREET_HALF_WIDTH_M * pxPerM > 2 ? MAX_KEYFRAME_GAP_M * pxPerM : 0;
  const places = withPlacesBetween(...keyframes, gap);
  const shapes = {
    keyframeX: places.x,
    keyframeY: places.y,
    keyframeGrade: places.keyframe.map((i) => data.keyframeGrade[i]!),
    streetRadiusPx: Math.max(STREET_HALF_WIDTH_M * pxPerM, MIN_STREET_PX),
    pointX: data.xM.map(toX),
    pointY: data.yM.map(toY),
    strength: (i: number) => ((data.rcsDbsm[i] ?? 0) - WEAK_DBSM) / (STRONG_DBSM - WEAK_DBSM),
    pointPx: Math.min(3.2, Math.max(1.5, 0.4 * pxPerM)),
  };
  const canvas = new OffscreenCanvas(BITMAP_PX, BITMAP_PX);
  const image = new ImageData(rasterize(BITMAP_PX, shapes, colours), BITMAP_PX, BITMAP_PX);
  canvas.getContext("2d")!.putImageData(image, 0, 0);
  return canvas.transferToImageBitmap();
}

/** What of a worker's global scope is used here; the page's own types know windows alone. */
interface WorkerScope {
  onmessage: (event: MessageEvent<PaintOrder>) => void;
  postMessage: (message: PaintedTile, transfer: Transferable[]) => void;
}

const scope = globalThis as unknown as WorkerScope;

scope.onmessage = ({ data: order }) => {
  const image = paint(order);
  scope.postMessage({ number: order.number, image }, [image]);
};
