import assert from "node:assert/strict";
import { test } from "node:test";
import { create } from "@bufbuild/protobuf";
import { ExpectedAccuracySchema } from "proto/dcloc/v1/map_service_pb.ts";
import { ACCURACY_GRADES, gradeOf } from "../../../../client/console/page/map/accuracy_grade.ts";

const gradeName = (more: object | undefined): string =>
  ACCURACY_GRADES[gradeOf(more && create(ExpectedAccuracySchema, more))]!;

test("the larger deviation decides", () => {
  assert.equal(gradeName({ alongSigmaM: 0.02, acrossSigmaM: 0.1 }), "good");
  assert.equal(gradeName({ alongSigmaM: 0.2, acrossSigmaM: 0.1 }), "fair");
  assert.equal(gradeName({ alongSigmaM: 0.02, acrossSigmaM: 0.31 }), "poor");
});

test("a tunnel, a place that looks alike and one without a pose are poor; a map may not say", () => {
  assert.equal(gradeName({ alongSigmaM: 0.02, acrossSigmaM: 0.02, isTunnel: true }), "poor");
  assert.equal(gradeName({ alongSigmaM: 0.02, acrossSigmaM: 0.02, isAlias: true }), "poor");
  assert.equal(gradeName({}), "poor");
  assert.equal(gradeName(undefined), "unknown");
});
