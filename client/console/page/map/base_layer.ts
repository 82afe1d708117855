import type { Camera } from "./camera.ts";

/**
 * What is drawn below all that moves, kept as a picture while the view stays: a tile is scaled once for
 * a view, not for each step of a vehicle. While the view moves it is drawn each time, without a copy.
 */
export class BaseLayer {
  private picture: OffscreenCanvas | undefined;
  private keptView = "";
  private lastView = "";

  /** What is drawn has changed, though the view has not. */
  invalidate(): void {
    this.keptView = this.lastView = "";
  }

  /** Draws by `paint`, or a picture of what it drew at the same view; `look` names all else it depends on. */
  draw(
    context: CanvasRenderingContext2D,
    { x, y, scale, width, height }: Camera,
    look: string,
    paint: (context: CanvasRenderingContext2D) => void,
  ): void {
    const { canvas } = context;
    const view = [x, y, scale, width, height, canvas.width, canvas.height, look].join();
    if (view !== this.keptView) {
      paint(context);
      // Kept from the second time on: a view that moves has no second time.
      if (view === this.lastView) this.keep(canvas, view);
      this.lastView = view;
      return;
    }
    context.save();
    context.resetTransform();
    context.drawImage(this.picture!, 0, 0);
    context.restore();
  }

  private keep(canvas: HTMLCanvasElement, view: string): void {
    if (canvas.width === 0 || canvas.height === 0) return;
    if (this.picture?.width !== canvas.width || this.picture.height !== canvas.height) {
      this.picture = new OffscreenCanvas(canvas.width, canvas.height);
    }
    this.picture.getContext("2d", { alpha: false })!.drawImage(canvas, 0, 0);
    this.keptView = view;
  }
}
