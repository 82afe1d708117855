import type { Camera } from "../map/camera.ts";
import type { Palette } from "../map/palette.ts";
import { boundsOf } from "../map/tile_grid.ts";
import type { Comparison, Square } from "./comparison.ts";
import type { Points } from "./match.ts";

/** More landmarks than these cannot be told apart, and slow the view down. */
const MAX_DRAWN_COUNT = 40_000;
const BOTH_PX = 2;
const ONLY_PX = 5;

function drawPoints(
  camera: Camera,
  points: Points,
  draw: (left: number, top: number) => void,
): void {
  const { minX, minY, maxX, maxY } = camera.bounds;
  for (let i = 0; i < points.length; i += 2) {
    const [x, y] = [points[i]!, points[i + 1]!];
    if (x < minX || x > maxX || y < minY || y > maxY) continue;
    draw(camera.toScreenX(x), camera.toScreenY(y));
  }
}

/** A filled square is in the second version alone, an empty one in the first, a point in both. */
function drawLandmarks(
  context: CanvasRenderingContext2D,
  camera: Camera,
  palette: Palette,
  squares: readonly Square[],
): void {
  const half = ONLY_PX / 2;
  context.fillStyle = palette.both;
  for (const { difference } of squares) {
    if (!difference) continue;
    drawPoints(camera, difference.both, (x, y) => context.fillRect(x - 1, y - 1, BOTH_PX, BOTH_PX));
  }
  context.strokeStyle = palette.onlyFrom;
  context.lineWidth = 1.3;
  context.fillStyle = palette.onlyTo;
  for (const { difference } of squares) {
    if (!difference) continue;
    const { onlyFrom, onlyTo } = difference;
    drawPoints(camera, onlyFrom, (x, y) => context.strokeRect(x - half, y - half, ONLY_PX, ONLY_PX));
    drawPoints(camera, onlyTo, (x, y) => context.fillRect(x - half, y - half, ONLY_PX, ONLY_PX));
  }
}

/** From afar: how much of a square's landmarks is in one version alone, as the height of a bar. */
function drawShares(
  context: CanvasRenderingContext2D,
  camera: Camera,
  palette: Palette,
  squares: Iterable<Square>,
): void {
  for (const { id, counts } of squares) {
    if (!counts) continue;
    const total = counts.both + counts.onlyFrom + counts.onlyTo;
    if (total === 0) continue;
    const { minX, minY, maxX, maxY } = boundsOf(id);
    const [left, top] = [camera.toScreenX(minX), camera.toScreenY(maxY)];
    const width = camera.toScreenX(maxX) - left;
    const height = camera.toScreenY(minY) - top;
    if (left > camera.width || top > camera.height || left + width < 0 || top + height < 0) continue;
    let bottom = top + height;
    const bar = (count: number, colour: string): void => {
      const share = (count / total) * height;
      bottom -= share;
      context.fillStyle = colour;
      context.fillRect(left + 1, bottom, Math.max(1, width - 2), share);
    };
    context.globalAlpha = 0.55;
    bar(counts.onlyTo, palette.onlyTo);
    bar(counts.onlyFrom, palette.onlyFrom);
    context.globalAlpha = 0.16;
    bar(counts.both, palette.both);
    context.globalAlpha = 1;
  }
}

/** Draws what is known of a comparison. Returns whether single landmarks are shown. */
export function drawDifference(
  context: CanvasRenderingContext2D,
  camera: Camera,
  palette: Palette,
  comparison: Comparison,
): boolean {
  const seen = comparison.look(camera.bounds);
  const count = seen.reduce(
    (sum, { counts }) => sum + (counts ? counts.both + counts.onlyFrom + counts.onlyTo : 0),
    0,
  );
  const isDetailed = seen.length > 0 && count <= MAX_DRAWN_COUNT && seen.every((s) => s.difference ?? !s.counts);
  if (isDetailed) drawLandmarks(context, camera, palette, seen);
  else drawShares(context, camera, palette, comparison.squares.values());
  return isDetailed;
}
