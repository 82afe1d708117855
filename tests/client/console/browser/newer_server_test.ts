import assert from "node:assert/strict";
import { test } from "node:test";
import { AdminService } from "proto/dcloc/v1/admin_service_pb.ts";
import type { FixUse, LocalizationState, SourceFault } from "proto/dcloc/v1/localization_service_pb.ts";
import { MapService } from "proto/dcloc/v1/map_service_pb.ts";
import { seriousFindings } from "./accessibility.ts";
import { sessionAt } from "./fake_server.ts";
import { FakeScene, staged } from "./scene.ts";

// The fake server adds a field to each of its answers that this contract does not have.
const scene = staged(new FakeScene());
const { fake } = scene;
const NEW_STATE = 99 as LocalizationState;
const NEW_FAULT = 77 as SourceFault;

const sessionOfNewer = () => sessionAt("1", "car", NEW_STATE, 3, 4);

test("a state that the console does not know has a word of its own, and the list goes on", async () => {
  fake.sessions = [sessionOfNewer(), sessionAt("2", "bus", 2, 5, 5)];
  await scene.visit(async (page) => {
    const row = page.locator(".row", { hasText: "car" });
    assert.equal(await row.locator("title").textContent(), "Unknown state 99");
    await page.getByRole("button", { name: "1 Tracking" }).waitFor();
    assert.deepEqual(await seriousFindings(page), []);
  });
});

test("a session in such a state, with such faults, says so in words", async () => {
  const session = sessionOfNewer();
  const health = {
    wheelSpeed: { used: false, fault: NEW_FAULT },
    radars: [{ radarId: "front", used: true, fault: 1 as SourceFault }],
  };
  fake.sessions = [session];
  fake.on(AdminService.method.getSession, () => ({ session }));
  fake.onStream(AdminService.method.watchSession, () => [
    { answer: { message: { case: "result" as const, value: { state: NEW_STATE, pose: session.pose!, health } } } },
    // A kind of answer that is not in this contract: only its unknown field is there.
    { answer: {} },
  ]);
  fake.on(AdminService.method.proposePose, () => ({ answer: { use: 42 as FixUse } }));
  await scene.visit(async (page) => {
    await page.locator(".row").first().getByRole("button").first().click();
    await page.getByRole("link", { name: "Details" }).click();
    await page.getByText("The server tells a state that this console does not know (99).").waitFor();
    await page.getByText("Wheel speed is set aside or faulty: unknown to this console (77).").waitFor();
    await page.locator(".sources").getByText("unknown to this console (77)").waitFor();
    await page.locator(".session-head").getByText("Unknown state 99").waitFor();
    await page.getByRole("button", { name: "Propose a pose" }).click();
    await page.getByLabel("x, m").fill("1");
    await page.getByLabel("y, m").fill("2");
    await page.getByRole("button", { name: "Propose", exact: true }).click();
    await page.getByText("The server answered: 42").waitFor();
    assert.deepEqual(await seriousFindings(page), []);
  });
});

test("servers, calls, roles and proofs of a newer contract are shown by what they are called there", async () => {
  fake.replicas = [];
  fake.on(AdminService.method.listReplicas, () => ({
    replicas: [{ address: "east:1", state: { serverVersion: "9.0", sessionCount: 1, maxSessionCount: 2 } }],
  }));
  const by = { principal: "amy", role: "captain" };
  const ended = { statusCode: 99, statusMessage: "not yet" };
  fake.on(AdminService.method.listOperations, () => ({
    operations: [{ ...by, ...ended, method: "/dcloc.v9.Fleet/Teleport", request: "{}" }],
  }));
  fake.on(AdminService.method.listIdentities, () => ({
    identities: [{ id: 1n, name: "amy", role: "captain", proof: 9 }],
  }));
  await scene.visit(async (page) => {
    await page.getByRole("link", { name: "Servers" }).click();
    await page.getByRole("article", { name: "east:1" }).getByText("9.0").waitFor();
    const row = page.getByRole("row").filter({ hasText: "Teleport" });
    await row.getByText("captain").waitFor();
    await row.getByText("failed: not yet").waitFor();
    await page.getByRole("row").filter({ hasText: "Proof 9" }).getByText("captain").waitFor();
    assert.deepEqual(await seriousFindings(page), []);
  });
  fake.replicas = undefined;
});

test("an answer without what it is asked for is told, and the page goes on", async () => {
  fake.sessions = [sessionAt("1", "car", 2, 0, 0)];
  fake.on(MapService.method.listMaps, () => ({ maps: [{ name: "town", versionCount: 1 }] }));
  fake.on(MapService.method.getMap, () => ({}));
  fake.on(MapService.method.listMapVersions, () => ({ versions: [] }));
  fake.on(AdminService.method.getSession, () => ({}));
  await scene.visit(async (page) => {
    await page.getByRole("navigation").getByRole("link", { name: "Maps" }).click();
    await page.getByRole("link", { name: "town" }).click();
    await page.getByText("The server’s answer lacks what was asked for.").waitFor();
    await page.getByRole("link", { name: "Live" }).click();
    await page.locator(".row").first().getByRole("button").first().click();
    await page.getByRole("link", { name: "Details" }).click();
    await page.getByText("The server’s answer lacks what was asked for.").waitFor();
    await page.getByRole("link", { name: "Live" }).click();
    await page.locator(".row", { hasText: "car" }).waitFor();
  });
});
