import type { PaintOrder, PaintedTile } from "./paint_order.ts";
import type { Palette } from "./palette.ts";
import type { Tile } from "./tile_store.ts";

/** The address of tile_worker.ts; the build puts it in. */
declare const TILE_WORKER: string;

/** While one is painted the next is on its way; more would be painted after the view has moved on. */
const MAX_ORDER_COUNT = 2;

/** Has tiles painted by a worker, a few at a time. */
export class TilePainter {
  private worker: Worker | undefined;
  private readonly orders = new Map<number, { tile: Tile; theme: string }>();
  private lastNumber = 0;

  constructor(private readonly onPainted: () => void) {}

  /** Paints the first of these, in the palette's colours; the others when they are wanted again. */
  want(tiles: readonly Tile[], palette: Palette): void {
    const { theme, street, landmark } = palette;
    for (const tile of tiles) {
      if (this.orders.size >= MAX_ORDER_COUNT) return;
      if ([...this.orders.values()].some((order) => order.tile === tile)) continue;
      const number = ++this.lastNumber;
      this.orders.set(number, { tile, theme });
      const order: PaintOrder = { number, id: tile.id, data: tile.data, colours: { street, landmark } };
      (this.worker ??= this.start()).postMessage(order);
    }
  }

  close(): void {
    this.worker?.terminate();
  }

  private start(): Worker {
    const worker = new Worker(TILE_WORKER, { type: "module" });
    worker.onmessage = ({ data }: MessageEvent<PaintedTile>) => this.take(data);
    return worker;
  }

  private take({ number, image }: PaintedTile): void {
    const order = this.orders.get(number);
    this.orders.delete(number);
    if (!order || order.tile.isDropped) image.close();
    else {
      order.tile.bitmap?.image.close();
      order.tile.bitmap = { theme: order.theme, image };
    }
    this.onPainted();
  }
}
