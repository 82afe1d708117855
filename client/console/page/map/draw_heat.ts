import type { Camera } from "./camera.ts";
import type { Loss } from "./fleet.ts";
import type { Palette } from "./palette.ts";

const RADIUS_PX = 26;
const SIDE_PX = 2 * RADIUS_PX;

/** Draws where vehicles got lost, the brighter the more of them: thousands of copies of one glow. */
export class HeatBrush {
  private glow: { theme: string; ratio: number; image: ImageBitmap } | undefined;

  draw(context: CanvasRenderingContext2D, camera: Camera, palette: Palette, losses: readonly Loss[]): void {
    if (losses.length === 0) return;
    const image = this.prepared(palette, context.getTransform().a);
    for (const loss of losses) {
      const left = Math.round(camera.toScreenX(loss.x) - RADIUS_PX);
      const top = Math.round(camera.toScreenY(loss.y) - RADIUS_PX);
      if (left < -SIDE_PX || left > camera.width || top < -SIDE_PX || top > camera.height) continue;
      context.drawImage(image, left, top, SIDE_PX, SIDE_PX);
    }
  }

  close(): void {
    this.glow?.image.close();
  }

  private prepared(palette: Palette, ratio: number): ImageBitmap {
    if (this.glow?.theme !== palette.theme || this.glow.ratio !== ratio) {
      this.close();
      this.glow = { theme: palette.theme, ratio, image: paint(palette, ratio) };
    }
    return this.glow.image;
  }
}

function paint({ heat: [r, g, b] }: Palette, ratio: number): ImageBitmap {
  const side = Math.round(SIDE_PX * ratio);
  const canvas = new OffscreenCanvas(side, side);
  const context = canvas.getContext("2d")!;
  const glow = context.createRadialGradient(side / 2, side / 2, 0, side / 2, side / 2, side / 2);
  glow.addColorStop(0, `rgba(${r}, ${g}, ${b}, 0.35)`);
  glow.addColorStop(1, `rgba(${r}, ${g}, ${b}, 0)`);
  context.fillStyle = glow;
  context.fillRect(0, 0, side, side);
  return canvas.transferToImageBitmap();
}
