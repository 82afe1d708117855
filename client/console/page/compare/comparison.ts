import { MapService, type ReadMapTileResponse } from "proto/dcloc/v1/map_service_pb.ts";
import type { Bounds } from "../map/camera.ts";
import { MARGIN_M, type TileId, boundsOf, keyOf, sideOf } from "../map/tile_grid.ts";
import { call } from "../wire/calls.ts";
import { type CallFailure, Code, failureOf } from "../wire/failure.ts";
import { type Counts, type SquareDifference, countsOf, differenceOf } from "./match.ts";

/** Squares of 512 m. */
const LEVEL = 3;
const MAX_POINT_COUNT = 50_000;
/** Of a map of some 1,000 km of street. */
const MAX_SQUARE_COUNT = 6_000;
const MAX_CALL_COUNT = 3;
/** Single landmarks are kept for so many squares, those looked at last; counts for all. */
const MAX_KEPT_COUNT = 48;

/** Two versions of a map of a server. */
export interface Pair {
  server: string;
  map: string;
  from: number;
  to: number;
}

export interface Square {
  id: TileId;
  counts?: Counts;
  difference?: SquareDifference;
}

/** Compares two versions square by square, first what is looked at, and then all the rest. */
export class Comparison {
  readonly squares = new Map<string, Square>();
  readonly counts: Counts = { both: 0, onlyFrom: 0, onlyTo: 0 };
  doneCount = 0;
  partCount = 0;
  /** The map has more squares than are compared. */
  readonly isCut: boolean;
  failure: CallFailure | undefined;
  private readonly stop = new AbortController();
  private waiting: Square[] = [];
  private readonly kept = new Set<Square>();
  private callCount = 0;

  /** `extent` holds the landmarks of both; `onChange` is called after each square. */
  constructor(
    private readonly pair: Pair,
    private readonly extent: Bounds,
    private readonly onChange: () => void,
  ) {
    const ids = squaresOf(extent);
    this.isCut = ids.length > MAX_SQUARE_COUNT;
    for (const id of ids.slice(0, MAX_SQUARE_COUNT)) this.squares.set(keyOf(id), { id });
    this.waiting = [...this.squares.values()];
    this.readOn();
  }

  /** The squares of a view; their landmarks are read (again) before all others. */
  look(view: Bounds): Square[] {
    const shown = {
      minX: Math.max(view.minX, this.extent.minX),
      minY: Math.max(view.minY, this.extent.minY),
      maxX: Math.min(view.maxX, this.extent.maxX),
      maxY: Math.min(view.maxY, this.extent.maxY),
    };
    const seen = squaresOf(shown, MAX_KEPT_COUNT).flatMap((id) => this.squares.get(keyOf(id)) ?? []);
    if (seen.length > MAX_KEPT_COUNT) return seen;
    for (const square of seen) {
      if (square.difference) this.keep(square);
    }
    const missing = seen.filter(({ difference }) => !difference);
    if (missing.length > 0) {
      this.waiting = [...missing, ...this.waiting.filter((square) => !missing.includes(square))];
      this.readOn();
    }
    return seen;
  }

  close(): void {
    this.stop.abort();
    this.waiting = [];
  }

  private readOn(): void {
    while (this.callCount < MAX_CALL_COUNT && !this.failure) {
      const square = this.waiting.shift();
      if (!square) return;
      ++this.callCount;
      void this.read(square).finally(() => {
        --this.callCount;
        this.onChange();
        this.readOn();
      });
    }
  }

  private async read(square: Square): Promise<void> {
    const { from, to } = this.pair;
    const bounds = boundsOf(square.id);
    try {
      const tiles = await Promise.all([this.readTile(bounds, from), this.readTile(bounds, to)]);
      square.difference = differenceOf(...tiles, bounds);
      this.keep(square);
      if (!square.counts) this.count(square.difference, square);
    } catch (error) {
      const failure = failureOf(error);
      if (failure.code !== Code.Cancelled) this.failure = failure;
    }
  }

  private count(difference: SquareDifference, square: Square): void {
    square.counts = countsOf(difference);
    this.counts.both += square.counts.both;
    this.counts.onlyFrom += square.counts.onlyFrom;
    this.counts.onlyTo += square.counts.onlyTo;
    ++this.doneCount;
    if (difference.isPart) ++this.partCount;
  }

  private async readTile(bounds: Bounds, version: number): Promise<ReadMapTileResponse> {
    const request = {
      mapName: this.pair.map,
      version: BigInt(version),
      minXM: bounds.minX - MARGIN_M,
      minYM: bounds.minY - MARGIN_M,
      maxXM: bounds.maxX + MARGIN_M,
      maxYM: bounds.maxY + MARGIN_M,
      maxPointCount: MAX_POINT_COUNT,
    };
    return call(this.pair.server, MapService.method.readMapTile, request, this.stop.signal);
  }

  private keep(square: Square): void {
    this.kept.delete(square);
    this.kept.add(square);
    for (const oldest of this.kept) {
      if (this.kept.size <= MAX_KEPT_COUNT) break;
      this.kept.delete(oldest);
      delete oldest.difference;
    }
  }
}

/** The squares of a rectangle, row by row; a few more than `atLeast` where there are too many. */
function squaresOf({ minX, minY, maxX, maxY }: Bounds, atLeast = MAX_SQUARE_COUNT): TileId[] {
  const side = sideOf(LEVEL);
  const ids: TileId[] = [];
  for (let row = Math.floor(minY / side); row * side <= maxY && ids.length <= atLeast; ++row) {
    for (let column = Math.floor(minX / side); column * side <= maxX; ++column) {
      ids.push({ level: LEVEL, column, row });
      if (ids.length > atLeast) break;
    }
  }
  return ids;
}
