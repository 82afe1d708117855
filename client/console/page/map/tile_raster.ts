import type { Rgb } from "./palette.ts";

/** What a tile shows; coordinates in pixels of the raster, y downwards. */
export interface TileShapes {
  /** Keyframes, each of which stands for the street within `streetRadiusPx`. */
  keyframeX: ArrayLike<number>;
  keyframeY: ArrayLike<number>;
  /** Which of the colours of street each has. */
  keyframeGrade: ArrayLike<number>;
  streetRadiusPx: number;
  pointX: ArrayLike<number>;
  pointY: ArrayLike<number>;
  /** In [0, 1]. */
  strength: (point: number) => number;
  /** Side of a landmark's square. */
  pointPx: number;
}

export interface TileColours {
  /** Of street, by grade. */
  street: readonly Rgb[];
  landmark: Rgb;
}

const WEAKEST = 0.5;
const STRONGEST = 0.98;

/** How much of a pixel lies in [begin, end). */
const shareOf = (pixel: number, begin: number, end: number): number =>
  Math.min(end, pixel + 1) - Math.max(begin, pixel);

/**
 * Keyframes, and three places between each two that follow one another within `gap`: their discs leave
 * no notches in the street. Each belongs to the keyframe nearest to it.
 */
export function withPlacesBetween(
  x: ArrayLike<number>,
  y: ArrayLike<number>,
  gap: number,
): { x: number[]; y: number[]; keyframe: number[] } {
  const places = { x: [] as number[], y: [] as number[], keyframe: [] as number[] };
  for (let i = 0; i < x.length; ++i) {
    const [dx, dy] = i > 0 ? [x[i]! - x[i - 1]!, y[i]! - y[i - 1]!] : [Infinity, Infinity];
    const shares = Math.hypot(dx, dy) <= gap ? [0.75, 0.5, 0.25, 0] : [0];
    for (const share of shares) {
      places.x.push(share === 0 ? x[i]! : x[i]! - share * dx);
      places.y.push(share === 0 ? y[i]! : y[i]! - share * dy);
      places.keyframe.push(share > 0.5 ? i - 1 : i);
    }
  }
  return places;
}

/** How much of each pixel, of 255, is street, and of which grade. */
function streetMask(side: number, shapes: TileShapes): { mask: Uint8Array; grade: Uint8Array } {
  const { keyframeX, keyframeY, keyframeGrade, streetRadiusPx: radius } = shapes;
  const mask = new Uint8Array(side * side);
  const grade = new Uint8Array(side * side);
  for (let i = 0; i < keyframeX.length; ++i) {
    const [x, y] = [keyframeX[i]!, keyframeY[i]!];
    const lastRow = Math.min(side - 1, Math.floor(y + radius));
    for (let row = Math.max(0, Math.floor(y - radius)); row <= lastRow; ++row) {
      const dy = row + 0.5 - y;
      const half = Math.sqrt(Math.max(0, radius * radius - dy * dy));
      const last = Math.min(side - 1, Math.floor(x + half));
      for (let column = Math.max(0, Math.floor(x - half)); column <= last; ++column) {
        const share = Math.round(255 * Math.min(1, shareOf(column, x - half, x + half)));
        const at = row * side + column;
        if (share <= mask[at]!) continue;
        mask[at] = share;
        grade[at] = keyframeGrade[i]!;
      }
    }
  }
  return { mask, grade };
}

/** Lays a colour over a pixel that may be transparent so far. */
export function layOver(rgba: Uint8ClampedArray, at: number, [r, g, b]: Rgb, alpha: number): void {
  const below = (rgba[at + 3]! / 255) * (1 - alpha);
  const sum = alpha + below;
  if (sum <= 0) return;
  rgba[at] = (r * alpha + rgba[at]! * below) / sum;
  rgba[at + 1] = (g * alpha + rgba[at + 1]! * below) / sum;
  rgba[at + 2] = (b * alpha + rgba[at + 2]! * below) / sum;
  rgba[at + 3] = 255 * sum;
}

function layPoints(
  rgba: Uint8ClampedArray,
  side: number,
  { pointX, pointY, pointPx, strength }: TileShapes,
  colour: Rgb,
): void {
  for (let i = 0; i < pointX.length; ++i) {
    const [left, top] = [pointX[i]!, pointY[i]!];
    const alpha = WEAKEST + (STRONGEST - WEAKEST) * Math.min(1, Math.max(0, strength(i)));
    const lastRow = Math.min(side - 1, Math.ceil(top + pointPx) - 1);
    const lastColumn = Math.min(side - 1, Math.ceil(left + pointPx) - 1);
    for (let row = Math.max(0, Math.floor(top)); row <= lastRow; ++row) {
      const rowAlpha = alpha * shareOf(row, top, top + pointPx);
      for (let column = Math.max(0, Math.floor(left)); column <= lastColumn; ++column) {
        const share = shareOf(column, left, left + pointPx);
        layOver(rgba, 4 * (row * side + column), colour, rowAlpha * share);
      }
    }
  }
}

/**
 * A tile's picture, four bytes a pixel, transparent where there is nothing. Pixel by pixel, for a path
 * of ten thousand circles takes a browser half a second.
 */
export function rasterize(
  side: number,
  shapes: TileShapes,
  { street, landmark }: TileColours,
): Uint8ClampedArray<ArrayBuffer> {
  const rgba = new Uint8ClampedArray(4 * side * side);
  const { mask, grade } = streetMask(side, shapes);
  for (let i = 0; i < mask.length; ++i) {
    if (mask[i] === 0) continue;
    rgba.set(street[grade[i]!]!, 4 * i);
    rgba[4 * i + 3] = mask[i]!;
  }
  layPoints(rgba, side, shapes, landmark);
  return rgba;
}
