import type { Camera } from "../map/camera.ts";
import type { Palette } from "../map/palette.ts";

/** A target as it is drawn: where it lies in the map, and whether a landmark is nearby. */
export interface DrawnTarget {
  x: number;
  y: number;
  rangeRateMps: number;
  /** Undefined where the map is not read yet. */
  isNear: boolean | undefined;
}

/** Range rates beyond it have the strongest colour. */
const FULL_RATE_MPS = 15;
const STEP_COUNT = 9;
const RADIUS_PX = 3.4;

/** Of [0, STEP_COUNT): approaching fast first, receding fast last. */
export function colourStep(rangeRateMps: number): number {
  const share = (rangeRateMps / FULL_RATE_MPS + 1) / 2;
  return Math.min(STEP_COUNT - 1, Math.max(0, Math.floor(share * STEP_COUNT)));
}

/** A colour from `approaching` over `still` to `receding`. */
export function rateColours({ approaching, still, receding }: Palette): string[] {
  return Array.from({ length: STEP_COUNT }, (_, step) => {
    const share = (2 * step) / (STEP_COUNT - 1) - 1;
    const end = share < 0 ? approaching : receding;
    const mixed = still.map((value, i) => Math.round(value + Math.abs(share) * (end[i]! - value)));
    return `rgb(${mixed.join(" ")})`;
  });
}

/**
 * Draws targets: a disc where a landmark is nearby, a ring where none is, a small dot where that is
 * not known. The colour tells the range rate.
 */
export function drawTargets(
  context: CanvasRenderingContext2D,
  camera: Camera,
  palette: Palette,
  targets: readonly DrawnTarget[],
): void {
  const colours = rateColours(palette);
  const { minX, minY, maxX, maxY } = camera.bounds;
  context.lineWidth = 1.5;
  for (const { x, y, rangeRateMps, isNear } of targets) {
    if (!(x >= minX && x <= maxX && y >= minY && y <= maxY)) continue;
    const colour = colours[colourStep(rangeRateMps)] ?? palette.ink;
    context.beginPath();
    const radius = isNear === undefined ? RADIUS_PX / 2 : RADIUS_PX;
    context.arc(camera.toScreenX(x), camera.toScreenY(y), radius, 0, 2 * Math.PI);
    if (isNear === false) {
      context.strokeStyle = colour;
      context.stroke();
    } else {
      context.fillStyle = colour;
      context.fill();
    }
  }
}
