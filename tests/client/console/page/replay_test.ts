import assert from "node:assert/strict";
import { test } from "node:test";
import { create } from "@bufbuild/protobuf";
import { PoseSchema } from "proto/dcloc/v1/geometry_pb.ts";
import { HealthSchema, SourceFault } from "proto/dcloc/v1/localization_service_pb.ts";
import { RadarModelSchema, ScanSchema } from "proto/dcloc/v1/scan_pb.ts";
import { colourStep } from "../../../../client/console/page/scan/draw_scan.ts";
import { Player } from "../../../../client/console/page/recording/player.ts";
import { LandmarkGrid } from "../../../../client/console/page/map/landmark_grid.ts";
import { targetsOf } from "../../../../client/console/page/scan/targets.ts";
import { Bands, faultOf, isUsed } from "../../../../client/console/page/session/bands.ts";

const QUARTER = Math.SQRT1_2;

test("a target lies where mount, pose and compensation put it", () => {
  // The vehicle at (10, 20) looks north; its radar, 2 m ahead, looks to the left: west.
  const north = { w: QUARTER, x: 0, y: 0, z: QUARTER };
  const T_map_vehicle = create(PoseSchema, { translationM: { x: 10, y: 20, z: 0 }, rotation: north });
  const radar = create(RadarModelSchema, {
    tVehicleRadar: { translationM: { x: 2, y: 0, z: 0 }, rotation: north },
    coupling: { case: "betaS", value: 0.04 },
    rangeBiasM: 0.5,
  });
  const scan = create(ScanSchema, { rangeM: [5.1], rangeRateMps: [-10], azimuthRad: [0] });
  const { x_map, y_map } = targetsOf(scan, radar, T_map_vehicle);
  // 5.1 = range + 0.04 * -10 + 0.5, so the range is 5 m.
  assert.ok(Math.abs(x_map[0]! - 5) < 1e-6);
  assert.ok(Math.abs(y_map[0]! - 22) < 1e-6);
  const chirp = { case: "chirp" as const, value: { centreFrequencyHz: 77e9, slopeHzPerS: 1.925e12 } };
  const byChirp = create(RadarModelSchema, { ...radar, coupling: chirp as never });
  assert.ok(Math.abs(targetsOf(scan, byChirp, T_map_vehicle).x_map[0]! - 5) < 1e-6);
});

test("columns of unequal length give as many targets as are whole", () => {
  const scan = create(ScanSchema, { rangeM: [1, 2, 3], rangeRateMps: [0], azimuthRad: [0, 0] });
  assert.equal(targetsOf(scan, undefined, create(PoseSchema)).x_map.length, 1);
});

test("a landmark is near within a metre, across the edges of its square", () => {
  const grid = new LandmarkGrid([0.95, -3.02], [0.1, -7.9], 1);
  assert.ok(grid.hasNear(1.9, 0.1));
  assert.ok(!grid.hasNear(2, 0.1));
  assert.ok(grid.hasNear(-2.5, -8.1));
  assert.ok(!grid.hasNear(0.1, 1.2));
  assert.ok(!grid.hasNear(Number.NaN, 0));
});

test("colours tell approaching from receding, and end somewhere", () => {
  assert.equal(colourStep(-1e9), 0);
  assert.equal(colourStep(0), 4);
  assert.equal(colourStep(1e9), 8);
});

test("a player plays, ends, begins anew, and follows what grows", () => {
  const player = new Player(false);
  player.toggle(1000);
  player.speed = 10;
  player.advance(50, 1000);
  assert.equal(player.positionMs, 500);
  player.advance(80, 1000);
  assert.deepEqual([player.positionMs, player.isPlaying], [1000, false]);
  player.toggle(1000);
  assert.deepEqual([player.positionMs, player.isPlaying], [0, true]);
  player.seek(-5, 1000);
  assert.equal(player.positionMs, 0);
  player.changeSpeed(1);
  assert.equal(player.speed, 25);
  const growing = new Player(true);
  growing.advance(10, 7000);
  assert.equal(growing.positionMs, 7000);
  growing.seek(3000, 7000);
  growing.advance(10, 8000);
  assert.equal(growing.positionMs, 3000);
});

test("bands join what is equal, and leave a hole where nothing was told", () => {
  const bands = new Bands();
  const health = create(HealthSchema, {
    wheelSpeed: { used: false, fault: SourceFault.SLIP },
    radars: [{ radarId: "front", used: true, fault: SourceFault.NONE }],
  });
  for (const timeMs of [0, 100, 200, 9000]) bands.take(timeMs, 2, health);
  assert.deepEqual(
    bands.states.map(({ beginMs, endMs }) => [beginMs, endMs]),
    [
      [0, 200],
      [9000, 9000],
    ],
  );
  const [state, wheels, front] = bands.all;
  assert.deepEqual([state!.name, wheels!.name, front!.name], ["state", "wheel_speed", "radar:front"]);
  const { value } = wheels!.segments[0]!;
  assert.deepEqual([isUsed(value), faultOf(value)], [false, SourceFault.SLIP]);
  // However hostile the session, what is kept is bounded.
  for (let i = 0; i < 20_000; ++i) bands.take(10_000 + i, i % 2, undefined);
  assert.ok(bands.states.length <= 5_000);
});
