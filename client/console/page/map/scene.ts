import { BaseLayer } from "./base_layer.ts";
import { BehindFrame } from "./behind_frame.ts";
import { type Bounds, Camera } from "./camera.ts";
import { type MapDrawn, drawGrid, drawTiles } from "./draw_map.ts";
import { arrowSprites } from "./draw_arrow.ts";
import { HeatBrush } from "./draw_heat.ts";
import { drawVehicles, vehicleAt } from "./draw_vehicles.ts";
import { Fleet, type Loss, type Vehicle } from "./fleet.ts";
import { nextMovementMs } from "./pace.ts";
import { type Palette, readPalette } from "./palette.ts";
import { TilePainter } from "./tile_painter.ts";
import type { TileStore } from "./tile_store.ts";

/** Draws something between the map and its vehicles. */
export type Overlay = (context: CanvasRenderingContext2D, camera: Camera, palette: Palette) => void;

const PICK_RADIUS_PX = 18;
const PAN_STEP_PX = 80;
const ZOOM_STEP = 1.5;
const SCREEN_FRAME_MS = 1000 / 60;

/** What a scene shows. */
export interface SceneContent {
  tiles: TileStore | undefined;
  extent: Bounds | undefined;
  /** What is shown at first; all of the extent where it is absent. */
  firstView?: Bounds;
  overlay?: Overlay;
  vehicles: () => Iterable<Vehicle>;
  losses: readonly Loss[];
  chosen: string | undefined;
  follow: boolean;
  onChoose?: (vehicle: Vehicle | undefined) => void;
  /** A click means this place, and chooses no vehicle. */
  onPlace?: (x: number, y: number) => void;
  onDrawn?: (drawn: MapDrawn) => void;
}

/** Draws a map and its vehicles on a canvas, and moves the view by pointer, wheel and keys. */
export class Scene {
  readonly camera = new Camera();
  private content: SceneContent;
  private palette: Palette = readPalette();
  private isFitted = false;
  private timer: ReturnType<typeof setTimeout> | undefined;
  private readonly drawing = new BehindFrame(() => this.draw());
  private readonly stop = new AbortController();
  private readonly resizing: ResizeObserver;
  private readonly themes: MutationObserver;
  private readonly pointers = new Map<number, { x: number; y: number }>();
  private dragged = 0;
  private readonly sprites = arrowSprites();
  private readonly heat = new HeatBrush();
  private readonly base = new BaseLayer();
  private readonly painter = new TilePainter(() => this.redrawMap());

  constructor(
    private readonly canvas: HTMLCanvasElement,
    content: SceneContent,
  ) {
    this.content = content;
    this.resizing = new ResizeObserver(() => this.resize());
    this.resizing.observe(canvas);
    this.themes = new MutationObserver(() => this.recolour());
    this.themes.observe(document.documentElement, { attributeFilter: ["data-theme"] });
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => this.recolour(), {
      signal: this.stop.signal,
    });
    this.listen();
    this.resize();
    // What was written before the font was there.
    void document.fonts.ready.then(() => this.redrawMap());
  }

  set(content: SceneContent): void {
    const { extent, firstView, tiles } = this.content;
    if (content.extent !== extent || content.firstView !== firstView) this.isFitted = false;
    if (content.extent !== extent || content.tiles !== tiles) this.base.invalidate();
    this.content = content;
    this.redraw();
  }

  redraw(): void {
    if (!this.stop.signal.aborted) this.drawing.ask();
  }

  /** Also what does not move: there are other tiles. */
  redrawMap(): void {
    this.base.invalidate();
    this.redraw();
  }

  fit(): void {
    if (this.content.extent) this.camera.fit(this.content.extent);
    this.redraw();
  }

  zoom(factor: number): void {
    this.camera.zoom(factor);
    this.redraw();
  }

  close(): void {
    this.stop.abort();
    this.painter.close();
    this.heat.close();
    this.resizing.disconnect();
    this.themes.disconnect();
    this.drawing.cancel();
    clearTimeout(this.timer);
  }

  private recolour(): void {
    this.palette = readPalette();
    this.redraw();
  }

  private resize(): void {
    const { clientWidth, clientHeight } = this.canvas;
    const ratio = window.devicePixelRatio || 1;
    this.canvas.width = Math.round(clientWidth * ratio);
    this.canvas.height = Math.round(clientHeight * ratio);
    this.camera.width = Math.max(1, clientWidth);
    this.camera.height = Math.max(1, clientHeight);
    this.redraw();
  }

  private draw(): void {
    const { content, camera, palette } = this;
    const context = this.canvas.getContext("2d", { alpha: false });
    if (!context || this.stop.signal.aborted) return;
    const firstView = content.firstView ?? content.extent;
    if (!this.isFitted && firstView && camera.width > 1) {
      camera.fit(firstView);
      this.isFitted = true;
    }
    const now = performance.now();
    this.followChosen(now);
    const ratio = window.devicePixelRatio || 1;
    context.setTransform(ratio, 0, 0, ratio, 0, 0);
    this.base.draw(context, camera, palette.theme, () => this.drawBase(context));
    content.overlay?.(context, camera, palette);
    this.heat.draw(context, camera, palette, content.losses);
    const look = { palette, sprites: this.sprites };
    drawVehicles(context, camera, look, content.vehicles(), content.chosen, now);
    this.drawAfter(nextMovementMs(content.vehicles(), camera, now));
  }

  private drawBase(context: CanvasRenderingContext2D): void {
    const { content, camera, palette, painter } = this;
    context.fillStyle = palette.ground;
    context.fillRect(0, 0, camera.width, camera.height);
    drawGrid(context, camera, palette);
    if (!content.tiles || !content.extent) return;
    const source = { store: content.tiles, painter, extent: content.extent };
    // By itself: where nobody wants to know what was drawn, it is drawn all the same.
    const landmarks = drawTiles(context, camera, palette, source);
    content.onDrawn?.(landmarks);
  }

  /** At once where a frame of the screen is a longer time than that. */
  private drawAfter(waitMs: number): void {
    clearTimeout(this.timer);
    if (waitMs < SCREEN_FRAME_MS) this.redraw();
    else if (waitMs < Infinity) this.timer = setTimeout(() => this.redraw(), waitMs - SCREEN_FRAME_MS);
  }

  private followChosen(now: number): void {
    if (!this.content.follow) return;
    for (const vehicle of this.content.vehicles()) {
      if (Fleet.key(vehicle.server, vehicle.id) !== this.content.chosen) continue;
      const pose = Fleet.poseOf(vehicle, now);
      if (pose) [this.camera.x, this.camera.y] = [pose.x, pose.y];
    }
  }

  private listen(): void {
    const { canvas } = this;
    const options = { signal: this.stop.signal };
    canvas.addEventListener("wheel", (event) => this.onWheel(event), { ...options, passive: false });
    canvas.addEventListener("keydown", (event) => this.onKey(event), options);
    canvas.addEventListener("pointerdown", (event) => this.onDown(event), options);
    canvas.addEventListener("pointermove", (event) => this.onMove(event), options);
    const onUp = (event: PointerEvent): void => this.onUp(event);
    canvas.addEventListener("pointerup", onUp, options);
    canvas.addEventListener("pointercancel", onUp, options);
  }

  private onWheel(event: WheelEvent): void {
    event.preventDefault();
    const lines = event.deltaMode === WheelEvent.DOM_DELTA_LINE ? 30 : 1;
    this.camera.zoom(Math.exp(-0.0016 * lines * event.deltaY), event.offsetX, event.offsetY);
    this.redraw();
  }

  private onKey(event: KeyboardEvent): void {
    const actions: Record<string, () => void> = {
      ArrowLeft: () => this.camera.pan(PAN_STEP_PX, 0),
      ArrowRight: () => this.camera.pan(-PAN_STEP_PX, 0),
      ArrowUp: () => this.camera.pan(0, PAN_STEP_PX),
      ArrowDown: () => this.camera.pan(0, -PAN_STEP_PX),
      "+": () => this.camera.zoom(ZOOM_STEP),
      "=": () => this.camera.zoom(ZOOM_STEP),
      "-": () => this.camera.zoom(1 / ZOOM_STEP),
      "0": () => this.fit(),
    };
    const action = actions[event.key];
    if (!action || event.ctrlKey || event.metaKey) return;
    event.preventDefault();
    action();
    this.redraw();
  }

  private onDown(event: PointerEvent): void {
    this.canvas.setPointerCapture(event.pointerId);
    this.pointers.set(event.pointerId, { x: event.offsetX, y: event.offsetY });
    this.dragged = 0;
  }

  private onMove(event: PointerEvent): void {
    const old = this.pointers.get(event.pointerId);
    if (!old) return;
    const now = { x: event.offsetX, y: event.offsetY };
    this.dragged += Math.hypot(now.x - old.x, now.y - old.y);
    const other = [...this.pointers].find(([id]) => id !== event.pointerId)?.[1];
    if (other) {
      // Two fingers: their distance zooms about the point between them.
      const before = Math.hypot(old.x - other.x, old.y - other.y);
      const after = Math.hypot(now.x - other.x, now.y - other.y);
      this.camera.zoom(after / Math.max(1, before), (now.x + other.x) / 2, (now.y + other.y) / 2);
    } else {
      this.camera.pan(now.x - old.x, now.y - old.y);
    }
    this.pointers.set(event.pointerId, now);
    this.redraw();
  }

  private onUp(event: PointerEvent): void {
    this.pointers.delete(event.pointerId);
    if (event.type !== "pointerup" || this.dragged > 5) return;
    const { vehicles, onChoose, onPlace } = this.content;
    const { offsetX, offsetY } = event;
    if (onPlace) return onPlace(this.camera.toMapX(offsetX), this.camera.toMapY(offsetY));
    const now = performance.now();
    onChoose?.(vehicleAt(vehicles(), this.camera, offsetX, offsetY, PICK_RADIUS_PX, now));
  }
}
