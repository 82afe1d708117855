import assert from "node:assert/strict";
import { test } from "node:test";
import { create } from "@bufbuild/protobuf";
import { PoseWithCovarianceSchema } from "proto/dcloc/v1/geometry_pb.ts";
import { type Proposal, isPlaced, poseOf } from "../../../../client/console/page/session/proposal.ts";

const messageOf = (proposal: Proposal) => create(PoseWithCovarianceSchema, poseOf(proposal));
const PLACED = { x: 12, y: -3, yawDeg: undefined, sigmaM: 5, yawSigmaDeg: 10 };

test("a proposal needs a place and a spread; its heading may be any", () => {
  assert.ok(isPlaced(PLACED));
  assert.ok(!isPlaced({ ...PLACED, x: undefined }));
  assert.ok(!isPlaced({ ...PLACED, sigmaM: undefined }));
  assert.ok(!isPlaced({ ...PLACED, yawDeg: Number.NaN }));
});

test("it becomes a pose with a covariance", () => {
  const { pose, covariance } = messageOf({ ...PLACED, yawDeg: 90 });
  assert.equal(pose!.translationM!.x, 12);
  assert.equal(pose!.translationM!.y, -3);
  assert.ok(Math.abs(pose!.rotation!.w - Math.SQRT1_2) < 1e-12);
  assert.ok(Math.abs(pose!.rotation!.z - Math.SQRT1_2) < 1e-12);
  assert.equal(covariance.length, 36);
  assert.equal(covariance[0], 25);
  assert.equal(covariance[7], 25);
  assert.ok(Math.abs(covariance[35]! - (Math.PI / 18) ** 2) < 1e-12);
  assert.equal(covariance[1], 0);
});

test("a heading that is not given is spread over all of them", () => {
  const { covariance } = messageOf(PLACED);
  assert.ok(Math.abs(covariance[35]! - Math.PI ** 2 / 3) < 1e-12);
});
