import type { LivePose } from "../../shared/live.ts";
import { shownName } from "../texts/shortened.ts";
import type { ArrowSprites } from "./arrow_sprites.ts";
import type { Camera } from "./camera.ts";
import { LENGTH_M, bodyPainter, colourOf } from "./draw_arrow.ts";
import { Fleet, State, type Vehicle } from "./fleet.ts";
import type { Palette } from "./palette.ts";

/** Of a two-dimensional normal distribution: the ellipse that has 95 %. */
const SIGMAS_OF_95 = 2.4477;
const MAX_LABEL_COUNT = 40;
/** Nearer to one another, two labels cannot be read. */
const LABEL_WIDTH_PX = 90;
const LABEL_HEIGHT_PX = 15;
const MAX_TRAIL_COUNT = 300;
/** Beyond so many, arrows are copied, in whole pixels. */
const MAX_PATH_COUNT = 200;

export interface Ellipse {
  major: number;
  minor: number;
  /** Of the major axis, from x. */
  angle: number;
}

/** The ellipse that holds the position with 95 %; half axes in metres. */
export function ellipseOf({ xx, xy, yy }: Pick<LivePose, "xx" | "xy" | "yy">): Ellipse {
  const mean = (xx + yy) / 2;
  const spread = Math.hypot((xx - yy) / 2, xy);
  return {
    major: SIGMAS_OF_95 * Math.sqrt(Math.max(0, mean + spread)),
    minor: SIGMAS_OF_95 * Math.sqrt(Math.max(0, mean - spread)),
    angle: Math.atan2(2 * xy, xx - yy) / 2,
  };
}

/** A place and how well it is known. */
export type UncertainPose = Pick<LivePose, "x" | "y" | "yaw" | "xx" | "xy" | "yy">;

export function drawEllipse(
  context: CanvasRenderingContext2D,
  camera: Camera,
  pose: UncertainPose,
  colour: string,
): void {
  const { major, minor, angle } = ellipseOf(pose);
  if (major * camera.scale < 4) return;
  context.beginPath();
  context.ellipse(
    camera.toScreenX(pose.x),
    camera.toScreenY(pose.y),
    Math.min(major * camera.scale, 1e4),
    Math.max(1, Math.min(minor * camera.scale, 1e4)),
    -angle,
    0,
    2 * Math.PI,
  );
  context.globalAlpha = 0.14;
  context.fillStyle = colour;
  context.fill();
  context.globalAlpha = 0.8;
  context.strokeStyle = colour;
  context.lineWidth = 1.2;
  context.stroke();
  context.globalAlpha = 1;
}

function drawTrail(context: CanvasRenderingContext2D, camera: Camera, trail: number[]): void {
  context.beginPath();
  for (let i = 0; i + 1 < trail.length; i += 2) {
    context.lineTo(camera.toScreenX(trail[i]!), camera.toScreenY(trail[i + 1]!));
  }
  context.stroke();
}

function drawLabel(
  context: CanvasRenderingContext2D,
  camera: Camera,
  pose: LivePose,
  text: string,
  palette: Palette,
): void {
  const x = camera.toScreenX(pose.x) + Math.max(12, 0.6 * LENGTH_M * camera.scale);
  const y = camera.toScreenY(pose.y) + 4;
  context.lineWidth = 3;
  context.strokeStyle = palette.halo;
  context.strokeText(text, x, y);
  context.fillStyle = palette.ink;
  context.fillText(text, x, y);
}

/** A lost vehicle is told by a ring as well, not by its colour alone; so is a chosen one. */
function drawRing(
  context: CanvasRenderingContext2D,
  camera: Camera,
  pose: LivePose,
  colour: string,
  radius: number,
): void {
  context.beginPath();
  context.arc(camera.toScreenX(pose.x), camera.toScreenY(pose.y), radius, 0, 2 * Math.PI);
  context.strokeStyle = colour;
  context.lineWidth = 2;
  context.stroke();
}

interface Placed {
  vehicle: Vehicle;
  pose: LivePose;
}

function visibleOf(vehicles: Iterable<Vehicle>, camera: Camera, nowMs: number): Placed[] {
  const { minX, minY, maxX, maxY } = camera.bounds;
  const placed: Placed[] = [];
  for (const vehicle of vehicles) {
    const pose = Fleet.poseOf(vehicle, nowMs);
    if (!pose || pose.x < minX || pose.x > maxX || pose.y < minY || pose.y > maxY) continue;
    placed.push({ vehicle, pose });
  }
  // The lost ones last, on top of all others.
  return placed.sort((a, b) => a.vehicle.state - b.vehicle.state);
}

function drawRings(
  context: CanvasRenderingContext2D,
  camera: Camera,
  palette: Palette,
  placed: readonly Placed[],
  chosen: string | undefined,
): void {
  for (const { vehicle, pose } of placed) {
    if (vehicle.state === State.Lost) drawRing(context, camera, pose, colourOf(palette, vehicle.state), 15);
    if (Fleet.key(vehicle.server, vehicle.id) === chosen) drawRing(context, camera, pose, palette.ink, 20);
  }
}

function drawLabels(
  context: CanvasRenderingContext2D,
  camera: Camera,
  palette: Palette,
  placed: readonly Placed[],
): void {
  context.font = "600 11.5px 'Inter Variable', sans-serif";
  context.textAlign = "left";
  // The state that needs somebody has the first claim to a place.
  const taken: { x: number; y: number }[] = [];
  for (const { vehicle, pose } of [...placed].reverse()) {
    const [x, y] = [camera.toScreenX(pose.x), camera.toScreenY(pose.y)];
    if (taken.some((t) => Math.abs(t.x - x) < LABEL_WIDTH_PX && Math.abs(t.y - y) < LABEL_HEIGHT_PX)) {
      continue;
    }
    taken.push({ x, y });
    drawLabel(context, camera, pose, shownName(vehicle.vehicle), palette);
  }
}

export interface FleetLook {
  palette: Palette;
  sprites: ArrowSprites;
}

/** Draws those of the vehicles that are in view. */
export function drawVehicles(
  context: CanvasRenderingContext2D,
  camera: Camera,
  { palette, sprites }: FleetLook,
  vehicles: Iterable<Vehicle>,
  chosen: string | undefined,
  nowMs: number,
): void {
  const placed = visibleOf(vehicles, camera, nowMs);
  if (placed.length <= MAX_TRAIL_COUNT) {
    context.lineWidth = 2;
    context.globalAlpha = 0.45;
    for (const { vehicle } of placed) {
      context.strokeStyle = colourOf(palette, vehicle.state);
      drawTrail(context, camera, vehicle.trail);
    }
    context.globalAlpha = 1;
  }
  for (const { vehicle, pose } of placed) drawEllipse(context, camera, pose, colourOf(palette, vehicle.state));
  const many = placed.length > MAX_PATH_COUNT ? sprites : undefined;
  const bodies = bodyPainter(context, camera, palette, many);
  for (const { vehicle, pose } of placed) bodies.add(vehicle.state, pose);
  bodies.finish();
  drawRings(context, camera, palette, placed, chosen);
  if (placed.length <= MAX_LABEL_COUNT) drawLabels(context, camera, palette, placed);
}

/** The vehicle drawn nearest to a point of the screen, within `radiusPx`. */
export function vehicleAt(
  vehicles: Iterable<Vehicle>,
  camera: Camera,
  screenX: number,
  screenY: number,
  radiusPx: number,
  nowMs: number,
): Vehicle | undefined {
  let best: { vehicle: Vehicle; distance: number } | undefined;
  for (const { vehicle, pose } of visibleOf(vehicles, camera, nowMs)) {
    const distance = Math.hypot(camera.toScreenX(pose.x) - screenX, camera.toScreenY(pose.y) - screenY);
    if (distance <= radiusPx && distance < (best?.distance ?? Infinity)) best = { vehicle, distance };
  }
  return best?.vehicle;
}
