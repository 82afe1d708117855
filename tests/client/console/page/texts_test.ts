import assert from "node:assert/strict";
import { test } from "node:test";
import "./browser_globals.ts";
import { de } from "../../../../client/console/page/texts/de.ts";
import { en } from "../../../../client/console/page/texts/en.ts";
import { shownName } from "../../../../client/console/page/texts/shortened.ts";
import { numbered, t } from "../../../../client/console/page/texts/texts.ts";

const placeholders = (text: string): string[] => (text.match(/\{\w+\}/g) ?? []).sort();

test("every text has the same placeholders in each language", () => {
  for (const [key, text] of Object.entries(en)) {
    const german = de[key as keyof typeof en];
    assert.deepEqual([...new Set(placeholders(german))], [...new Set(placeholders(text))], key);
    assert.notEqual(german.trim(), "", key);
  }
});

test("values are put in as they are", () => {
  assert.equal(t("just_lost", { vehicle: "{vehicle} $& <img>" }), "{vehicle} $& <img> is lost.");
});

test("signs that are not seen but turn or break the text are shown as such, and lengths are bounded", () => {
  assert.equal(t("just_lost", { vehicle: "a\u202eb\nc\u0000" }), "a\ufffdb c\ufffd is lost.");
  assert.equal(shownName("x".repeat(10_000)).length, 81);
});

test("a number that is not known gets the other text", () => {
  assert.equal(numbered("state_", 2, "?"), "Tracking");
  assert.equal(numbered("state_", 99, "?"), "?");
});
