import { MapService, type ReadMapTileResponse } from "proto/dcloc/v1/map_service_pb.ts";
import { call } from "../wire/calls.ts";
import { type CallFailure, Code, failureOf } from "../wire/failure.ts";
import { gradeOf } from "./accuracy_grade.ts";
import { type PointCounts, ownPoints } from "./own_points.ts";
import { MARGIN_M, type TileId, boundsOf, keyOf, pointCountOf } from "./tile_grid.ts";

const MAX_TILE_COUNT = 128;
const MAX_CALL_COUNT = 4;
const RETRY_MS = 5_000;

/** What was read of a tile, in columns; coordinates relative to the origin. */
export interface TileData {
  originXM: number;
  originYM: number;
  /** Landmarks in the tile, of which those below are all or some. */
  pointCount: number;
  xM: Float32Array;
  yM: Float32Array;
  rcsDbsm: Float32Array;
  keyframeXM: Float32Array;
  keyframeYM: Float32Array;
  /** How well vehicles can know where they are there, by `ACCURACY_GRADES`. */
  keyframeGrade: Uint8Array;
  /** The map says so of one of them at least. */
  isGraded: boolean;
}

/** In single precision, as it came: half of what a list of numbers takes. */
function dataOf(answer: ReadMapTileResponse): TileData {
  const column = (values: readonly number[], length: number): Float32Array => {
    const all = new Float32Array(length);
    all.set(values.slice(0, length));
    return all;
  };
  const count = answer.xM.length;
  const keyframeCount = answer.keyframeXM.length;
  return {
    originXM: answer.originM?.x ?? 0,
    originYM: answer.originM?.y ?? 0,
    pointCount: Number(answer.pointCount),
    xM: column(answer.xM, count),
    yM: column(answer.yM, count),
    rcsDbsm: column(answer.rcsDbsm, count),
    keyframeXM: column(answer.keyframeXM, keyframeCount),
    keyframeYM: column(answer.keyframeYM, keyframeCount),
    keyframeGrade: Uint8Array.from({ length: keyframeCount }, (_, i) => gradeOf(answer.keyframeAccuracies[i])),
    isGraded: answer.keyframeAccuracies.length > 0,
  };
}

export interface Tile {
  id: TileId;
  data: TileData;
  own: PointCounts;
  /** The store has let go of it. */
  isDropped?: boolean;
  /** The tile drawn, in the colours of `theme`; made when it is first shown. */
  bitmap?: { theme: string; image: ImageBitmap };
}

/** The tiles of one version of a map: read as they are wanted, the ones not shown for longest dropped. */
export class TileStore {
  private readonly tiles = new Map<string, Tile>();
  private readonly failedUntil = new Map<string, number>();
  private readonly calls = new Map<string, AbortController>();
  private wanted: TileId[] = [];
  private failure: CallFailure | undefined;
  private retry: ReturnType<typeof setTimeout> | undefined;

  constructor(
    private readonly server: string,
    private readonly map: string,
    private readonly version: number,
    private readonly onTile: () => void,
    /** How many landmarks a tile of a level may have; of more, some are left out. */
    private readonly countOf: (level: number) => number = pointCountOf,
  ) {}

  /** Why the last tile could not be read; it is tried again. */
  get fault(): CallFailure | undefined {
    return this.failure;
  }

  /** What is there of a tile; counts as shown. */
  get(id: TileId): Tile | undefined {
    const key = keyOf(id);
    const tile = this.tiles.get(key);
    if (tile) {
      this.tiles.delete(key);
      this.tiles.set(key, tile);
    }
    return tile;
  }

  /** Lets go of the drawn tiles not shown for longest, beyond `count`: each takes some megabytes. */
  keepBitmaps(count: number): void {
    const drawn = [...this.tiles.values()].filter((tile) => tile.bitmap);
    for (const tile of drawn.slice(0, Math.max(0, drawn.length - count))) dropBitmap(tile);
  }

  /** Reads these, in this order, and no longer those that were wanted before. */
  want(ids: TileId[]): void {
    this.wanted = ids.filter((id) => !this.tiles.has(keyOf(id)));
    const keys = new Set(ids.map(keyOf));
    for (const [key, stop] of this.calls) if (!keys.has(key)) stop.abort();
    this.readOn();
  }

  close(): void {
    clearTimeout(this.retry);
    this.want([]);
    for (const [key, tile] of this.tiles) this.drop(key, tile);
  }

  private readOn(): void {
    const now = Date.now();
    while (this.calls.size < MAX_CALL_COUNT) {
      const next = this.wanted.findIndex((id) => (this.failedUntil.get(keyOf(id)) ?? 0) < now);
      if (next < 0) return;
      const [id] = this.wanted.splice(next, 1);
      if (!this.calls.has(keyOf(id!))) void this.read(id!);
    }
  }

  private async read(id: TileId): Promise<void> {
    const key = keyOf(id);
    const stop = new AbortController();
    this.calls.set(key, stop);
    const { minX, minY, maxX, maxY } = boundsOf(id);
    try {
      const answer = await call(
        this.server,
        MapService.method.readMapTile,
        {
          mapName: this.map,
          version: BigInt(this.version),
          minXM: minX - MARGIN_M,
          minYM: minY - MARGIN_M,
          maxXM: maxX + MARGIN_M,
          maxYM: maxY + MARGIN_M,
          maxPointCount: this.countOf(id.level),
        },
        stop.signal,
      );
      const data = dataOf(answer);
      this.keep({ id, data, own: ownPoints(id, data) });
      this.failedUntil.delete(key);
      this.failure = undefined;
    } catch (error) {
      const failure = failureOf(error);
      if (failure.code !== Code.Cancelled) {
        this.failedUntil.set(key, Date.now() + RETRY_MS);
        this.retry ??= setTimeout(() => this.askAgain(), RETRY_MS);
        this.failure = failure;
      }
    }
    this.calls.delete(key);
    this.onTile();
    this.readOn();
  }

  /** Has the tiles wanted anew: also of a view that stays as it is. */
  private askAgain(): void {
    const now = Date.now();
    const isEarly = [...this.failedUntil.values()].some((until) => until >= now);
    this.retry = isEarly ? setTimeout(() => this.askAgain(), RETRY_MS / 2) : undefined;
    this.onTile();
  }

  private drop(key: string, tile: Tile): void {
    tile.isDropped = true;
    dropBitmap(tile);
    this.tiles.delete(key);
  }

  private keep(tile: Tile): void {
    this.tiles.set(keyOf(tile.id), tile);
    for (const [key, oldest] of this.tiles) {
      if (this.tiles.size <= MAX_TILE_COUNT) break;
      this.drop(key, oldest);
    }
  }
}

/** At once; an image that is only forgotten waits for the garbage collection. */
function dropBitmap(tile: Tile): void {
  if (!tile.bitmap) return;
  tile.bitmap.image.close();
  delete tile.bitmap;
}
