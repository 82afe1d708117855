import assert from "node:assert/strict";
import { test } from "node:test";
import { create } from "@bufbuild/protobuf";
import { SessionSchema } from "proto/dcloc/v1/admin_service_pb.ts";
import { liveSession } from "../../../../client/console/bridge/live_row.ts";

const HALF_TURN = { w: Math.SQRT1_2, x: 0, y: 0, z: Math.SQRT1_2 };

function withPose(covariance: number[], x = 12.34567) {
  return create(SessionSchema, {
    sessionId: "s",
    vehicleId: "car",
    pose: { pose: { translationM: { x, y: -1, z: 0 }, rotation: HALF_TURN }, covariance },
    poseStampNs: 1_500_000_000n,
  });
}

test("a pose becomes position, heading and covariance in the plane", () => {
  const covariance = Array.from({ length: 36 }, (_, i) => i / 100);
  const { pose } = liveSession(withPose(covariance));
  assert.deepEqual(pose, { x: 12.346, y: -1, yaw: 1.5708, xx: 0, xy: 0.01, yy: 0.07, stampMs: 1500 });
});

test("a pose that is none is left out", () => {
  assert.equal(liveSession(withPose([])).pose, undefined);
  assert.equal(liveSession(withPose(new Array(36).fill(0), Number.NaN)).pose, undefined);
  assert.equal(liveSession(create(SessionSchema, {})).pose, undefined);
});

test("silence is told in steps, so that it does not change each second", () => {
  const of = (s: number) =>
    liveSession(create(SessionSchema, { idleDurationNs: BigInt(s) * 1_000_000_000n })).silentS;
  assert.deepEqual([0, 4, 5, 9, 12].map(of), [0, 0, 5, 5, 10]);
});

test("faulty sources are named", () => {
  const session = create(SessionSchema, {
    health: {
      wheelSpeed: { used: true, fault: 6 },
      yawRate: { used: true, fault: 1 },
      radars: [
        { radarId: "front", used: true, fault: 1 },
        { radarId: "rear", used: false, fault: 2 },
      ],
    },
  });
  assert.deepEqual(liveSession(session).faults, ["wheel_speed", "rear"]);
});
