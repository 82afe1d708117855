/** A rectangle of the map frame, in metres. */
export interface Bounds {
  minX: number;
  minY: number;
  maxX: number;
  maxY: number;
}

const MIN_SCALE = 0.0005;
const MAX_SCALE = 60;
const MARGIN = 0.08;

/** What part of the map frame is on the screen; the map's y axis points up. */
export class Camera {
  x = 0;
  y = 0;
  /** Pixels in a metre. */
  scale = 1;
  width = 1;
  height = 1;

  toScreenX(x: number): number {
    return (x - this.x) * this.scale + this.width / 2;
  }

  toScreenY(y: number): number {
    return this.height / 2 - (y - this.y) * this.scale;
  }

  toMapX(screenX: number): number {
    return (screenX - this.width / 2) / this.scale + this.x;
  }

  toMapY(screenY: number): number {
    return (this.height / 2 - screenY) / this.scale + this.y;
  }

  get bounds(): Bounds {
    const halfWidth = this.width / 2 / this.scale;
    const halfHeight = this.height / 2 / this.scale;
    return {
      minX: this.x - halfWidth,
      maxX: this.x + halfWidth,
      minY: this.y - halfHeight,
      maxY: this.y + halfHeight,
    };
  }

  /** Zooms by `factor` about a point of the screen, which stays where it is. */
  zoom(factor: number, screenX = this.width / 2, screenY = this.height / 2): void {
    const x = this.toMapX(screenX);
    const y = this.toMapY(screenY);
    this.scale = Math.min(MAX_SCALE, Math.max(MIN_SCALE, this.scale * factor));
    this.x += x - this.toMapX(screenX);
    this.y += y - this.toMapY(screenY);
  }

  pan(screenDx: number, screenDy: number): void {
    this.x -= screenDx / this.scale;
    this.y += screenDy / this.scale;
  }

  /** Shows all of the rectangle. */
  fit({ minX, minY, maxX, maxY }: Bounds): void {
    this.x = (minX + maxX) / 2;
    this.y = (minY + maxY) / 2;
    const room = 1 - 2 * MARGIN;
    const scaleX = (this.width * room) / Math.max(maxX - minX, 20);
    const scaleY = (this.height * room) / Math.max(maxY - minY, 20);
    this.scale = Math.min(MAX_SCALE, Math.max(MIN_SCALE, Math.min(scaleX, scaleY)));
  }
}
