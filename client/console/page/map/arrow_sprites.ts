import type { Palette } from "./palette.ts";

/** So many headings are told apart: 5.6 degrees each, where an arrow is 17 pixels long. */
const HEADING_COUNT = 64;
/** Room for an arrow with its halo in any direction. */
const SIDE_PX = 26;

/** Draws an arrow around the origin of the context. */
export type DrawArrow = (
  context: OffscreenCanvasRenderingContext2D,
  yaw: number,
  colour: string,
  halo: string,
) => void;

/** Arrows in all states and headings, drawn once: thousands of copies cost less than as many paths. */
export class ArrowSprites {
  private sheet: { theme: string; ratio: number; image: ImageBitmap } | undefined;

  constructor(private readonly drawArrow: DrawArrow) {}

  /** For one frame: draws the arrow of a state at a place of the screen. */
  prepared(
    context: CanvasRenderingContext2D,
    palette: Palette,
  ): (state: number, yaw: number, x: number, y: number) => void {
    const ratio = context.getTransform().a;
    if (this.sheet?.theme !== palette.theme || this.sheet.ratio !== ratio) {
      this.sheet?.image.close();
      this.sheet = { theme: palette.theme, ratio, image: this.paint(palette, ratio) };
    }
    const { image } = this.sheet;
    const side = Math.round(SIDE_PX * ratio);
    return (state, yaw, x, y) => {
      const heading = Math.round((yaw / (2 * Math.PI)) * HEADING_COUNT);
      const column = ((heading % HEADING_COUNT) + HEADING_COUNT) % HEADING_COUNT;
      const row = state in palette.states ? state : 0;
      const [left, top] = [Math.round(x - SIDE_PX / 2), Math.round(y - SIDE_PX / 2)];
      context.drawImage(image, column * side, row * side, side, side, left, top, SIDE_PX, SIDE_PX);
    };
  }

  private paint({ states, halo }: Palette, ratio: number): ImageBitmap {
    const side = Math.round(SIDE_PX * ratio);
    const canvas = new OffscreenCanvas(side * HEADING_COUNT, side * states.length);
    const context = canvas.getContext("2d")!;
    states.forEach((colour, row) => {
      for (let column = 0; column < HEADING_COUNT; ++column) {
        context.setTransform(ratio, 0, 0, ratio, (column + 0.5) * side, (row + 0.5) * side);
        this.drawArrow(context, (2 * Math.PI * column) / HEADING_COUNT, colour, halo);
      }
    });
    return canvas.transferToImageBitmap();
  }
}
