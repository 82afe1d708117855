import assert from "node:assert/strict";
import { test } from "node:test";
import { create } from "@bufbuild/protobuf";
import { LocalizationResultSchema } from "proto/dcloc/v1/localization_service_pb.ts";
import { sampleOf } from "../../../../client/console/page/session/history.ts";

const POSE = {
  pose: { translationM: { x: 3, y: 4, z: 0 }, rotation: { w: 1, x: 0, y: 0, z: 0 } },
  covariance: Array.from({ length: 36 }, (_, i) => (i === 0 ? 0.25 : i === 7 ? 0.04 : 0)),
};

const sample = (more: { protectionLevelM?: number }) =>
  sampleOf(create(LocalizationResultSchema, { state: 2, pose: POSE, ...more }), 1_000)!;

test("sigma is the largest one in the plane", () => {
  assert.equal(sample({}).sigmaM, 0.5);
});

test("a level of protection is taken as it is told, and is none where nothing is promised", () => {
  assert.equal(sample({ protectionLevelM: 1.75 }).protectionM, 1.75);
  assert.ok(Number.isNaN(sample({}).protectionM));
});

test("an answer without a pose is no sample", () => {
  assert.equal(sampleOf(create(LocalizationResultSchema, { state: 1 }), 0), undefined);
});
