import { create } from "@bufbuild/protobuf";
import type { Session } from "proto/dcloc/v1/admin_service_pb.ts";
import {
  MapVersionSchema,
  type ReadMapTileRequest,
  type ReadMapTileResponse,
  ReadMapTileResponseSchema,
} from "proto/dcloc/v1/map_service_pb.ts";
import { type FakeMap, sessionAt } from "../browser/fake_server.ts";

/** A grid of streets: 25 along each direction, 20 km long: 1,000 km. */
const STREET_COUNT = 25;
const LENGTH_M = 20_000;
const GAP_M = LENGTH_M / STREET_COUNT;
/** Landmarks along a street, to either side of it. */
const LANDMARK_STEP_M = 1;
const KEYFRAME_STEP_M = 10;
const ASIDE_M = 12;

/** From the numbers of a landmark: the same each time, and spread evenly in [0, 1). */
function noise(a: number, b: number): number {
  const value = Math.sin(a * 12.9898 + b * 78.233) * 43758.5453;
  return value - Math.floor(value);
}

/** Calls `take` for all steps along all streets within the request's rectangle. */
function alongStreets(
  { minXM, minYM, maxXM, maxYM }: ReadMapTileRequest,
  step: number,
  take: (x: number, y: number, isAlongX: boolean, i: number, street: number) => void,
): void {
  const walk = (isAlongX: boolean, low: number, high: number, least: number, most: number): void => {
    for (let street = 0; street < STREET_COUNT; ++street) {
      const aside = (street + 0.5) * GAP_M;
      if (aside < least - ASIDE_M || aside > most + ASIDE_M) continue;
      const [first, last] = [Math.max(0, Math.ceil(low / step)), Math.min(LENGTH_M, high) / step];
      for (let i = first; i <= last; ++i) {
        if (isAlongX) take(i * step, aside, true, i, street);
        else take(aside, i * step, false, i, street);
      }
    }
  };
  walk(true, minXM, maxXM, minYM, maxYM);
  walk(false, minYM, maxYM, minXM, maxXM);
}

function readTile(request: ReadMapTileRequest): ReadMapTileResponse {
  const points: [number, number, number][] = [];
  alongStreets(request, LANDMARK_STEP_M, (x, y, isAlongX, i, street) => {
    for (const side of [-1, 1]) {
      const aside = side * (4 + (ASIDE_M - 4) * noise(i, street + side));
      points.push([isAlongX ? x : x + aside, isAlongX ? y + aside : y, 30 * noise(street, i)]);
    }
  });
  const keyframes: [number, number][] = [];
  alongStreets(request, KEYFRAME_STEP_M, (x, y) => keyframes.push([x, y]));
  const thinned = points.filter((_, i) => i % Math.ceil(points.length / request.maxPointCount) === 0);
  const shown = keyframes.slice(0, 10_000);
  return create(ReadMapTileResponseSchema, {
    version: 1n,
    originM: { x: 0, y: 0, z: 0 },
    pointCount: BigInt(points.length),
    xM: thinned.map(([x]) => x),
    yM: thinned.map(([, y]) => y),
    rcsDbsm: thinned.map(([, , rcs]) => rcs - 5),
    keyframeXM: shown.map(([x]) => x),
    keyframeYM: shown.map(([, y]) => y),
  });
}

/** A map of 1,000 km of street. */
export const LARGE_MAP: FakeMap = {
  version: create(MapVersionSchema, {
    mapName: "town",
    version: 1n,
    sha256: "0".repeat(64),
    info: {
      lengthM: 2 * STREET_COUNT * LENGTH_M,
      pointCount: BigInt((4 * STREET_COUNT * LENGTH_M) / LANDMARK_STEP_M),
      minMapM: { x: 0, y: 0, z: 0 },
      maxMapM: { x: LENGTH_M, y: LENGTH_M, z: 0 },
    },
  }),
  readTile,
};

const SPEED_MPS = 14;

/** Vehicles on the streets, of which a few are not well. */
export class LargeFleet {
  private readonly sessions: Session[];

  constructor(count: number) {
    this.sessions = Array.from({ length: count }, (_, i) => sessionAt(String(i), `car-${i}`, 2, 0, 0));
  }

  /** Where they are at a time: the same objects each time. */
  at(timeS: number): Session[] {
    this.sessions.forEach((session, i) => {
      const along = (LENGTH_M * noise(i, 1) + SPEED_MPS * timeS) % LENGTH_M;
      const aside = (Math.floor(STREET_COUNT * noise(i, 2)) + 0.5) * GAP_M;
      const translation = session.pose!.pose!.translationM!;
      [translation.x, translation.y] = i % 2 === 0 ? [along, aside] : [aside, along];
      session.state = noise(i, Math.floor(timeS / 20)) < 0.01 ? 4 : i % 40 === 0 ? 3 : 2;
    });
    return this.sessions;
  }
}
