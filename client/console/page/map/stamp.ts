import { layOver } from "./tile_raster.ts";

/** A picture, four bytes a pixel, y downwards. */
export interface Raster {
  width: number;
  height: number;
  data: Uint8ClampedArray;
}

/** The pixels of a small picture that are not transparent. */
export interface Stamp {
  /** From the middle of the picture. */
  x: Int16Array;
  y: Int16Array;
  rgba: Uint8ClampedArray;
}

const OPAQUE = 250;

/** The square of a sheet that begins at a column and a row of pixels. */
export function stampOf({ width, data }: Raster, left: number, top: number, side: number): Stamp {
  const x: number[] = [];
  const y: number[] = [];
  const rgba: number[] = [];
  for (let row = 0; row < side; ++row) {
    for (let column = 0; column < side; ++column) {
      const at = 4 * ((top + row) * width + left + column);
      if (data[at + 3] === 0) continue;
      x.push(column - Math.floor(side / 2));
      y.push(row - Math.floor(side / 2));
      rgba.push(...data.subarray(at, at + 4));
    }
  }
  return { x: Int16Array.from(x), y: Int16Array.from(y), rgba: Uint8ClampedArray.from(rgba) };
}

/** Lays a stamp over a raster, with its middle in a whole pixel; what lies outside is left out. */
export function press({ width, height, data }: Raster, { x, y, rgba }: Stamp, atX: number, atY: number): void {
  for (let i = 0; i < x.length; ++i) {
    const [column, row] = [atX + x[i]!, atY + y[i]!];
    if (column < 0 || column >= width || row < 0 || row >= height) continue;
    const at = 4 * (row * width + column);
    const [r, g, b, alpha] = [rgba[4 * i]!, rgba[4 * i + 1]!, rgba[4 * i + 2]!, rgba[4 * i + 3]!];
    if (alpha < OPAQUE && data[at + 3] !== 0) {
      layOver(data, at, [r, g, b], alpha / 255);
      continue;
    }
    data[at] = r;
    data[at + 1] = g;
    data[at + 2] = b;
    data[at + 3] = alpha;
  }
}
