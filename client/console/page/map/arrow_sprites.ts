import type { Palette } from "./palette.ts";
import { type Raster, type Stamp, press, stampOf } from "./stamp.ts";

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

interface Layer extends Raster {
  canvas: OffscreenCanvas;
  context: OffscreenCanvasRenderingContext2D;
  image: ImageData;
}

/**
 * Arrows in all states and headings, drawn once and then pressed into a layer of their own, pixel by
 * pixel: thousands of them cost a canvas without a GPU ten times as much, as paths or as pictures.
 */
export class ArrowSprites {
  private sheet: { theme: string; ratio: number; stamps: Stamp[][] } | undefined;
  private layer: Layer | undefined;

  constructor(private readonly drawArrow: DrawArrow) {}

  /** Begins a frame. Adds the arrow of a state at a place of the screen; `lay` lays all over the context. */
  prepared(context: CanvasRenderingContext2D, palette: Palette) {
    const ratio = context.getTransform().a;
    const stamps = this.stampsFor(palette, ratio);
    const layer = this.clearedLayer(context.canvas);
    const add = (state: number, yaw: number, x: number, y: number): void => {
      const heading = Math.round((yaw / (2 * Math.PI)) * HEADING_COUNT);
      const column = ((heading % HEADING_COUNT) + HEADING_COUNT) % HEADING_COUNT;
      press(layer, (stamps[state] ?? stamps[0]!)[column]!, Math.round(x * ratio), Math.round(y * ratio));
    };
    const lay = (): void => {
      layer.context.putImageData(layer.image, 0, 0);
      context.save();
      context.resetTransform();
      context.drawImage(layer.canvas, 0, 0);
      context.restore();
    };
    return { add, lay };
  }

  private stampsFor(palette: Palette, ratio: number): Stamp[][] {
    const { theme } = palette;
    if (this.sheet?.theme !== theme || this.sheet.ratio !== ratio) {
      this.sheet = { theme, ratio, stamps: this.makeStamps(palette, ratio) };
    }
    return this.sheet.stamps;
  }

  /** A row of stamps for each state, one for each heading. */
  private makeStamps({ states, halo }: Palette, ratio: number): Stamp[][] {
    const side = Math.round(SIDE_PX * ratio);
    const canvas = new OffscreenCanvas(side * HEADING_COUNT, side);
    const context = canvas.getContext("2d", { willReadFrequently: true })!;
    return states.map((colour) => {
      context.resetTransform();
      context.clearRect(0, 0, canvas.width, side);
      for (let column = 0; column < HEADING_COUNT; ++column) {
        const middle = Math.floor(side / 2) + 0.5;
        context.setTransform(ratio, 0, 0, ratio, column * side + middle, middle);
        this.drawArrow(context, (2 * Math.PI * column) / HEADING_COUNT, colour, halo);
      }
      const sheet = context.getImageData(0, 0, canvas.width, side);
      return Array.from({ length: HEADING_COUNT }, (_, column) => stampOf(sheet, column * side, 0, side));
    });
  }

  private clearedLayer(shown: HTMLCanvasElement): Layer {
    const [width, height] = [Math.max(1, shown.width), Math.max(1, shown.height)];
    if (this.layer?.width !== width || this.layer.height !== height) {
      const canvas = new OffscreenCanvas(width, height);
      const context = canvas.getContext("2d", { willReadFrequently: true })!;
      const image = context.createImageData(width, height);
      this.layer = { canvas, context, image, width, height, data: image.data };
    }
    this.layer.data.fill(0);
    return this.layer;
  }
}
