import type { LivePose } from "../../shared/live.ts";
import { ArrowSprites } from "./arrow_sprites.ts";
import type { Camera } from "./camera.ts";
import type { Palette } from "./palette.ts";

export const LENGTH_M = 4.6;
const WIDTH_M = 1.9;
/** Below so many pixels a vehicle is an arrow, above its true size. */
export const MIN_LENGTH_PX = 17;
const MIN_WIDTH_PX = 0.62 * MIN_LENGTH_PX;

interface Arrow {
  x: number;
  y: number;
  yaw: number;
  length: number;
  width: number;
  colour: string;
  halo: string;
}

function drawArrow(
  context: CanvasRenderingContext2D | OffscreenCanvasRenderingContext2D,
  { x, y, yaw, length, width, colour, halo }: Arrow,
): void {
  const cos = Math.cos(yaw);
  const sin = -Math.sin(yaw);
  const at = (ahead: number, left: number): [number, number] => [
    x + ahead * cos + left * sin,
    y + ahead * sin - left * cos,
  ];
  context.beginPath();
  context.moveTo(...at(length / 2, 0));
  context.lineTo(...at(-length / 2, width / 2));
  context.lineTo(...at(-0.28 * length, 0));
  context.lineTo(...at(-length / 2, -width / 2));
  context.closePath();
  context.lineWidth = 2.5;
  context.lineJoin = "round";
  context.strokeStyle = halo;
  context.stroke();
  context.fillStyle = colour;
  context.fill();
}

/** An arrow, or the vehicle in its true size. */
export function drawBody(
  context: CanvasRenderingContext2D,
  camera: Camera,
  pose: Pick<LivePose, "x" | "y" | "yaw">,
  colour: string,
  halo: string,
): void {
  drawArrow(context, {
    x: camera.toScreenX(pose.x),
    y: camera.toScreenY(pose.y),
    yaw: pose.yaw,
    length: Math.max(MIN_LENGTH_PX, LENGTH_M * camera.scale),
    width: Math.max(MIN_WIDTH_PX, WIDTH_M * camera.scale),
    colour,
    halo,
  });
}

/** The arrows of vehicles that are too many to be drawn one by one. */
export const arrowSprites = (): ArrowSprites =>
  new ArrowSprites((context, yaw, colour, halo) =>
    drawArrow(context, { x: 0, y: 0, yaw, length: MIN_LENGTH_PX, width: MIN_WIDTH_PX, colour, halo }),
  );

/** Draws the bodies of vehicles; `finish` when all are added. */
export interface BodyPainter {
  add(state: number, pose: LivePose): void;
  finish(): void;
}

/** Copies arrows where `sprites` are there and vehicles are small; otherwise draws each by itself. */
export function bodyPainter(
  context: CanvasRenderingContext2D,
  camera: Camera,
  palette: Palette,
  sprites: ArrowSprites | undefined,
): BodyPainter {
  if (!sprites || LENGTH_M * camera.scale > MIN_LENGTH_PX) {
    return {
      add: (state, pose) => drawBody(context, camera, pose, colourOf(palette, state), palette.halo),
      finish: () => undefined,
    };
  }
  const { add, lay } = sprites.prepared(context, palette);
  return {
    add: (state, pose) => add(state, pose.yaw, camera.toScreenX(pose.x), camera.toScreenY(pose.y)),
    finish: lay,
  };
}

/** Of a LocalizationState, also of one that is not known here. */
export const colourOf = (palette: Palette, state: number): string =>
  palette.states[state] ?? palette.states[0]!;
