/** Landmarks by squares as wide as a radius, so that those near a place are in nine of them. */
export class LandmarkGrid {
  private readonly cells = new Map<number, number[]>();

  /** Coordinates in metres, in any frame. */
  constructor(
    private readonly x: ArrayLike<number>,
    private readonly y: ArrayLike<number>,
    private readonly radiusM: number,
  ) {
    for (let i = 0; i < x.length; ++i) {
      const key = keyAt(this.cellOf(x[i]!), this.cellOf(y[i]!));
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
        for (const i of this.cells.get(keyAt(column + dc, row + dr)) ?? []) {
          if ((this.x[i]! - x) ** 2 + (this.y[i]! - y) ** 2 <= limit) return true;
        }
      }
    }
    return false;
  }

  private cellOf(metres: number): number {
    return Math.floor(metres / this.radiusM);
  }
}

/** Equal only for equal cells, in maps up to some thousand kilometres. */
const keyAt = (column: number, row: number): number => column * 2 ** 25 + row;
