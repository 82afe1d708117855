import assert from "node:assert/strict";
import { test } from "node:test";
import { create } from "@bufbuild/protobuf";
import type { Page } from "playwright-core";
import { AdminService } from "proto/dcloc/v1/admin_service_pb.ts";
import { LocalizationState, SourceFault } from "proto/dcloc/v1/localization_service_pb.ts";
import { MapService, MapVersionSchema } from "proto/dcloc/v1/map_service_pb.ts";
import { sessionAt } from "./fake_server.ts";
import { until } from "./harness.ts";
import { FakeScene, staged } from "./scene.ts";

const scene = staged(new FakeScene());
const { fake } = scene;

const LONG = `<b onmouseover=alert(1)>\u202e\n${"w\u05d0".repeat(1_000)}`;
const BOUNDS = { minMapM: { x: 0, y: 0, z: 0 }, maxMapM: { x: 100, y: 100, z: 0 } };

const town = (info: object) =>
  create(MapVersionSchema, { mapName: "town", version: 1n, sha256: LONG, info: { driveName: LONG, ...info } });

/** Nothing wider than the page, and nothing executed. */
async function isInBounds(page: Page): Promise<void> {
  const width = await page.evaluate(() => document.documentElement.scrollWidth);
  assert.ok(width <= 1280, `a page of ${width} pixels`);
  assert.equal(await page.title(), "dcloc console");
  assert.equal(await page.locator("b").count(), 0);
}

test("maps, drives, radars and callers with hostile names of 2,000 signs fill no page", async () => {
  const version = town({ ...BOUNDS, description: LONG });
  const session = sessionAt("1", LONG, 4, 10, 10);
  const radars = [{ radarId: LONG, used: false, fault: SourceFault.SILENT }];
  const lost = { state: LocalizationState.LOST, pose: session.pose! };
  fake.sessions = [session];
  fake.map = { version, readTile: () => ({ $typeName: "dcloc.v1.ReadMapTileResponse" }) as never };
  fake.on(MapService.method.listMaps, () => ({ maps: [{ name: LONG, versionCount: 1, activeVersion: 1n }] }));
  fake.on(MapService.method.getMap, () => ({ map: { name: LONG, versionCount: 1, activeVersion: 1n } }));
  fake.on(MapService.method.listMapVersions, () => ({ versions: [version] }));
  fake.on(AdminService.method.getSession, () => ({ session: { ...session, peer: LONG, mapName: LONG } }));
  fake.onStream(AdminService.method.watchSession, () => [
    { answer: { message: { case: "result" as const, value: { ...lost, health: { radars } } } } },
    { answer: { message: { case: "rejected" as const, value: { message: LONG } } } },
  ]);
  const operation = { principal: LONG, role: LONG, peer: LONG, method: LONG, request: LONG, statusMessage: LONG };
  fake.on(AdminService.method.listOperations, () => ({ operations: [{ ...operation, statusCode: 3 }] }));
  const identity = { id: 1n, name: LONG, role: LONG, tenant: LONG };
  fake.on(AdminService.method.listIdentities, () => ({ identities: [identity] }));
  await scene.visit(async (page) => {
    await page.getByRole("navigation").getByRole("link", { name: "Maps" }).click();
    await page.locator("tbody th a").click();
    await page.getByText("Download").waitFor();
    await isInBounds(page);
    await page.getByRole("button", { name: "Delete the map" }).click();
    await page.getByRole("dialog").getByText("The files are gone for good").waitFor();
    await isInBounds(page);
    await page.keyboard.press("Escape");
    await page.getByRole("link", { name: "Live" }).click();
    await page.locator(".row").first().getByRole("button").first().click();
    await page.getByRole("link", { name: "Details" }).click();
    await page.getByText("Rejected scans in the last minute: 1.").waitFor();
    await isInBounds(page);
    await page.getByRole("button", { name: "Record the next session" }).click();
    await page.getByText("This server is older and does not know that.").waitFor();
    await isInBounds(page);
    await page.getByRole("link", { name: "Servers" }).click();
    await page.getByRole("button", { name: /^Revoke/ }).waitFor();
    await isInBounds(page);
  });
});

const NOT_A_MAP: Record<string, object> = {
  "has no bounds": {},
  "has bounds that are no numbers": { minMapM: { x: Number.NaN, y: 0 }, maxMapM: { x: 1, y: Infinity } },
  "ends before it begins": { minMapM: { x: 5, y: 5 }, maxMapM: { x: -5, y: -5 } },
  "is as large as numbers go": { minMapM: { x: -1e308, y: -1e308 }, maxMapM: { x: 1e308, y: 1e308 } },
};

for (const [what, info] of Object.entries(NOT_A_MAP)) {
  test(`a map that ${what}: its vehicles are listed, and the page answers`, async () => {
    fake.sessions = [sessionAt("1", "car", 2, 1, 1)];
    fake.map = {
      version: town(info),
      // Fewer values along one axis than along the other, and none of them of use.
      readTile: () => ({ xM: [Number.NaN, 1e38, 3], yM: [Infinity], rcsDbsm: [], pointCount: -5n }) as never,
    };
    await scene.visit(async (page) => {
      await page.locator(".row", { hasText: "car" }).waitFor();
      await page.locator("canvas").focus();
      for (const key of ["0", "+", "ArrowLeft", "-", "0"]) await page.keyboard.press(key);
      await page.locator(".row").first().getByRole("button").first().click();
      await page.getByRole("button", { name: "Follow" }).click();
      const asked = fake.listCount;
      await until(() => fake.listCount > asked + 1, "the page goes on");
      await page.getByLabel("Filter by name").fill("nobody");
      await page.getByText("No vehicle matches the filter.").waitFor();
    });
  });
}
