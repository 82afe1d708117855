import assert from "node:assert/strict";
import { test } from "node:test";
import { create } from "@bufbuild/protobuf";
import {
  AdminService,
  GetServerStateResponseSchema,
  ReplicaFaultSchema,
  ReplicaSchema,
} from "proto/dcloc/v1/admin_service_pb.ts";
import {
  MapBuildSchema,
  type MapBuildState,
  MapService,
  MapVersionSchema,
  ReadMapTileResponseSchema,
} from "proto/dcloc/v1/map_service_pb.ts";
import { threadTimes } from "../measure/notes.ts";
import { seriousFindings } from "./accessibility.ts";
import { sessionAt } from "./fake_server.ts";
import { until } from "./harness.ts";
import { FakeScene, staged } from "./scene.ts";

const scene = staged(new FakeScene());
const { fake } = scene;

const HOSTILE = `<img src=x onerror="document.title='executed'">'"\`\${1}</script>\u202e\u0000\n`;
const SHOWN = `<img src=x onerror="document.title='executed'">'"\`\${1}</script>\ufffd\ufffd `;

test("hostile names and values are shown, and nothing is executed", async () => {
  const strange = sessionAt("../../x?y#z", HOSTILE, 99, Number.NaN, 1e300);
  strange.mapName = HOSTILE;
  fake.sessions = [strange, sessionAt("2", "__proto__", 4, 1e12, -1e12)];
  await scene.visit(async (page) => {
    const choice = page.locator(".place select");
    await choice.waitFor();
    const places = await choice.locator("option").allTextContents();
    assert.ok(places.includes(SHOWN), places.join());
    await choice.selectOption({ index: places.indexOf(SHOWN) });
    await page.locator(".row", { hasText: "<img src=x" }).waitFor();
    assert.equal(await page.title(), "dcloc console");
    assert.equal(await page.locator("img").count(), 0);
  });
});

test("names of ten thousand signs and from right to left fill no page", async () => {
  const long = "\u05d0".repeat(10_000);
  fake.sessions = [sessionAt("1", long, 4, 0, 0), sessionAt("2", "a\nb\u202ec", 4, 5, 0)];
  fake.sessions[0]!.replica = long;
  fake.unanswered = [create(ReplicaFaultSchema, { address: `x\n${long}`, fault: HOSTILE })];
  await scene.visit(async (page) => {
    await page.locator(".row", { hasText: "a b\ufffdc" }).waitFor();
    await page.getByText("does not answer; its vehicles are shown as they last were").waitFor();
    const box = (await page.locator(".row", { hasText: "\u05d0" }).boundingBox())!;
    assert.ok(box.height < 160, `a row of ${box.height} pixels`);
    const width = await page.evaluate(() => document.documentElement.scrollWidth);
    assert.ok(width <= 1280, `a page of ${width} pixels`);
    assert.equal(await page.title(), "dcloc console");
    fake.unanswered = [];
  });
});

test("a server of the fleet that does not answer is named, and its vehicles stay", async () => {
  const at = (id: string, replica: string) => {
    const session = sessionAt(id, `car-${id}`, 2, 10 * Number(id), 0);
    session.replica = replica;
    return session;
  };
  const state = create(GetServerStateResponseSchema, { serverVersion: "9.9", sessionCount: 1, maxSessionCount: 9 });
  fake.sessions = [at("1", "east:1"), at("2", "west:1")];
  fake.replicas = ["east:1", "west:1"].map((address) => create(ReplicaSchema, { address, state }));
  await scene.visit(async (page) => {
    await page.getByLabel("Server").selectOption("west:1");
    await page.locator(".row", { hasText: "car-2" }).waitFor();
    assert.equal(await page.locator(".row").count(), 1);
    await page.getByLabel("Server").selectOption("");
    await page.locator(".row", { hasText: "car-1" }).waitFor();
    fake.sessions = [at("1", "east:1")];
    fake.unanswered = [create(ReplicaFaultSchema, { address: "west:1", fault: "timed out" })];
    fake.replicas = [fake.replicas![0]!, create(ReplicaSchema, { address: "west:1", fault: "timed out" })];
    await page.getByText("west:1 does not answer; its vehicles are shown as they last were.").waitFor();
    await page.locator(".row", { hasText: "car-2" }).waitFor();
    await page.getByRole("link", { name: "Servers" }).click();
    const west = page.getByRole("article", { name: "west:1" });
    await west.getByText("It does not answer the others: timed out").waitFor();
    assert.equal(await west.getByRole("button", { name: "Drain" }).count(), 0);
    await page.getByRole("article", { name: "east:1" }).getByText("Serving").waitFor();
    assert.deepEqual(await seriousFindings(page), []);
    fake.unanswered = [];
    await page.getByRole("link", { name: "Live" }).click();
    await page.locator(".row", { hasText: "car-2" }).waitFor({ state: "hidden" });
    fake.replicas = undefined;
  });
});

test("the first map with vehicles is shown, though maps without any were listed before", async () => {
  fake.sessions = [];
  fake.on(MapService.method.listMaps, () => ({ maps: [{ name: "airport", versionCount: 1 }] }));
  await scene.visit(async (page) => {
    const map = page.locator(".place select");
    await map.getByText("airport").waitFor({ state: "attached" });
    fake.sessions = [sessionAt("1", "car", 2, 0, 0)];
    await page.locator(".row", { hasText: "car" }).waitFor();
    const bus = (id: string) => Object.assign(sessionAt(id, `bus-${id}`, 2, 0, 0), { mapName: "harbour" });
    fake.sessions = [...fake.sessions, bus("2"), bus("3")];
    await map.getByText("harbour").waitFor({ state: "attached" });
    assert.equal(await map.inputValue(), "dcloc/town", "what somebody looks at stays, though others have more");
  });
  fake.on(MapService.method.listMaps, () => ({}));
});

test("a filter for a version of one map does not hide the vehicles of another", async () => {
  const at = (id: string, mapName: string, mapVersion: bigint) =>
    Object.assign(sessionAt(id, `car-${id}`, 2, 0, 0), { mapName, mapVersion });
  fake.sessions = [at("1", "town", 1n), at("2", "town", 2n), at("3", "harbour", 9n)];
  await scene.visit(async (page) => {
    await page.getByLabel("Version").selectOption("2");
    await page.locator(".row", { hasText: "car-1" }).waitFor({ state: "hidden" });
    await page.locator(".row", { hasText: "car-2" }).waitFor();
    await page.locator(".place select").selectOption("dcloc/harbour");
    await page.locator(".row", { hasText: "car-3" }).waitFor();
  });
});

test("where vehicles got lost is told over time, also after the page was loaded again", async () => {
  fake.sessions = [sessionAt("1", "car-1", 2, 0, 0), sessionAt("2", "car-2", 2, 5, 0)];
  await scene.visit(async (page) => {
    await page.getByRole("button", { name: "2 Tracking" }).waitFor();
    fake.sessions = [sessionAt("1", "car-1", 4, 0, 0), sessionAt("2", "car-2", 4, 5, 0)];
    const panel = page.getByRole("group", { name: "Where vehicles got lost" });
    await panel.getByText("Got lost in this time: 2").waitFor();
    await page.getByText("2 vehicles got lost within 50 m in the last 10 minutes.").waitFor();
    await page.setViewportSize({ width: 390, height: 844 });
    const alarm = (await page.getByRole("alert").boundingBox())!;
    const below = (await panel.boundingBox())!;
    assert.ok(alarm.y + alarm.height <= below.y, "on a phone the alarm stands over the panel, not under it");
    await page.setViewportSize({ width: 1280, height: 800 });
    await panel.getByLabel("How long a time").selectOption("5");
    await panel.getByLabel("Until when").fill("-30");
    await panel.getByText("Got lost in this time: 0").waitFor();
    assert.deepEqual(await seriousFindings(page), []);
    await page.reload();
    await panel.getByText("Got lost in this time: 2").waitFor();
  });
});

test("a map whose landmarks cannot be read is told, and tried again", async () => {
  fake.sessions = [sessionAt("1", "car", 2, 0, 0)];
  const info = { minMapM: { x: 0, y: 0, z: 0 }, maxMapM: { x: 100, y: 100, z: 0 } };
  const version = create(MapVersionSchema, { mapName: "town", version: 1n, sha256: "0", info });
  const readTile = (): never => {
    throw new Error("landmark 17 is not finite");
  };
  fake.map = { version, readTile };
  await scene.visit(async (page) => {
    await page.getByText("The map cannot be read now: landmark 17 is not finite").waitFor();
    await page.locator(".row", { hasText: "car" }).waitFor();
    fake.map = { version, readTile: () => create(ReadMapTileResponseSchema, { version: 1n }) };
    await page.getByText("The map cannot be read now").waitFor({ state: "hidden" });
    fake.map = undefined;
  });
});

test("a build that is under way is cancelled after one question; states of newer servers are shown", async () => {
  fake.builds = [
    create(MapBuildSchema, { buildId: "1", mapName: "harbour", state: 1, scanCount: 90n, doneScanCount: 30n }),
    create(MapBuildSchema, { buildId: "2", mapName: HOSTILE, state: 77 as MapBuildState }),
  ];
  await scene.visit(async (page) => {
    await page.getByRole("navigation").getByRole("link", { name: "Maps" }).click();
    await page.getByText("30 of 90 scans").waitFor();
    await page.locator(".builds li", { hasText: "<img src=x" }).getByText("77").waitFor();
    assert.deepEqual(await seriousFindings(page), []);
    await page.getByRole("button", { name: "Cancel the build: harbour" }).click();
    const dialog = page.getByRole("dialog");
    await dialog.getByText("No version comes of it").waitFor();
    await dialog.getByRole("button", { name: "Cancel the build" }).click();
    await page.locator(".builds li", { hasText: "harbour" }).getByText("Cancelled").waitFor();
    assert.equal(await page.title(), "dcloc console");
    fake.builds = [];
  });
});

test("a survey and an update tell their stage, their drives and what came of them", async () => {
  const drive = { name: HOSTILE, inMap: false, reason: "it stands" };
  const version = create(MapVersionSchema, { mapName: "harbour", version: 7n });
  const update = { addedCount: 1200n, removedCount: 30n, oldErrorM: 0.25, newErrorM: 0.125, isBetter: true };
  fake.builds = [
    create(MapBuildSchema, { buildId: "1", mapName: "a", state: 1, method: 2, stage: "loops", stageShare: 0.25 }),
    create(MapBuildSchema, { buildId: "2", mapName: "b", state: 2, method: 3, version, update, drives: [drive] }),
    create(MapBuildSchema, { buildId: "3", mapName: "c", state: 1, method: 3, stage: "x", stageShare: Number.NaN, attemptCount: 3 }),
  ];
  await scene.visit(async (page) => {
    await page.getByRole("navigation").getByRole("link", { name: "Maps" }).click();
    const row = (name: string) => page.locator(".builds li").filter({ has: page.locator("strong", { hasText: name }) });
    await row("a").getByText("survey without poses").waitFor();
    await row("a").getByText("loops, 25 %").waitFor();
    await row("b").getByText("became v7").waitFor();
    await row("b").getByText("1,200 came, 30 went. Error of a pass kept out: 0.250 m before, 0.125 m after.").waitFor();
    await row("b").getByText("0 of 1 drives used").waitFor();
    await row("b").getByText(`${SHOWN}: it stands`).waitFor();
    await row("c").getByText("x, 0 %").waitFor();
    await row("c").getByText("begun anew 2 times").waitFor();
    assert.equal(await page.locator("img").count(), 0);
    assert.deepEqual(await seriousFindings(page), []);
    fake.builds = [];
  });
});

test("an older server is told by name, call by call, and the rest goes on", async () => {
  fake.sessions = [sessionAt("1", "car", 2, 0, 0)];
  await scene.visit(async (page) => {
    await page.locator(".row").first().getByRole("button").first().click();
    await page.getByRole("link", { name: "Details" }).click();
    await page.getByText("This server is older and does not know that.").waitFor();
    await page.getByRole("link", { name: "Recordings" }).click();
    await page.getByRole("button", { name: "Record a vehicle" }).click();
    await page.getByRole("dialog").getByLabel("Vehicle").fill("car");
    await page.getByRole("dialog").getByRole("button", { name: "Record", exact: true }).click();
    await page.locator(".item").getByText("This server is older and does not know that.").waitFor();
    await page.goto(`${scene.bridge.address}/compare/dcloc/town/1/2`);
    await page.getByText("This server is older and does not know that.").waitFor();
    await page.getByRole("link", { name: "Live" }).click();
    await page.locator(".row", { hasText: "car" }).waitFor();
  });
});

test("a page records a few vehicles at a time, says so, and goes on with all else", async () => {
  fake.sessions = [sessionAt("1", "car", 2, 0, 0)];
  // Streams that stay open and say nothing, as for vehicles that open no session.
  fake.onStream(AdminService.method.recordSession, () => []);
  await scene.visit(async (page) => {
    await page.getByRole("link", { name: "Recordings" }).click();
    for (const vehicle of ["a", "b", "c", "d", "e", "f"]) {
      await page.getByRole("button", { name: "Record a vehicle" }).click();
      await page.getByRole("dialog").getByLabel("Vehicle").fill(vehicle);
      await page.getByRole("dialog").getByRole("button", { name: "Record", exact: true }).click();
      await page.getByRole("dialog").waitFor({ state: "hidden" });
    }
    const waiting = page.locator(".item").getByText("Waiting for the vehicle to open its next session");
    await until(async () => (await waiting.count()) === 3, "three wait");
    assert.equal(await page.locator(".item").getByText("A page records 3 vehicles at a time").count(), 3);
    await page.getByRole("navigation").getByRole("link", { name: "Maps" }).click();
    await page.getByText("No maps yet").waitFor();
    await page.getByRole("link", { name: "Live" }).click();
    await page.locator(".row", { hasText: "car" }).waitFor();
  });
});

test("ten thousand vehicles: the page answers, and shows those that need somebody", async () => {
  fake.sessions = Array.from({ length: 10_000 }, (_, i) => {
    const state = i === 7_777 ? 4 : 2;
    return sessionAt(String(i), `car-${i}`, state, (i % 100) * 20, Math.floor(i / 100) * 20);
  });
  await scene.visit(async (page) => {
    await page.getByRole("button", { name: "9,999 Tracking" }).waitFor();
    assert.match(await page.locator(".rows .row").first().innerText(), /car-7777/);
    assert.ok((await page.locator(".rows .row").count()) <= 200);
    // Processor time of the page's own thread: other programs' is not in it.
    const devtools = await page.context().newCDPSession(page);
    await devtools.send("Performance.enable", { timeDomain: "threadTicks" });
    const before = (await threadTimes(devtools)).all;
    await page.getByLabel("Filter by name").fill("car-123");
    await page.locator(".row", { hasText: "car-1234" }).first().waitFor();
    const seconds = (await threadTimes(devtools)).all - before;
    assert.ok(seconds < 3, `${seconds} s of the page's thread`);
  });
});

test("twenty pages with one token ask a server no more often than one", async () => {
  fake.sessions = [sessionAt("1", "car", 2, 0, 0)];
  await scene.visit(async (page) => {
    await page.locator(".row").first().waitFor();
    const cookie = (await page.context().cookies()).map(({ name, value }) => `${name}=${value}`).join(";");
    const stop = new AbortController();
    const feed = `${scene.bridge.address}/feed`;
    const readers = await Promise.all(
      Array.from({ length: 19 }, () => fetch(feed, { headers: { cookie }, signal: stop.signal })),
    );
    assert.ok(readers.every((response) => response.ok));
    const [first, begin] = [fake.listCount, Date.now()];
    await until(() => fake.listCount >= first + 3, "the server is asked again");
    const seconds = (Date.now() - begin) / 1000;
    assert.ok(fake.listCount - first <= seconds + 1, `${fake.listCount - first} calls in ${seconds} s`);
    stop.abort();
  });
});
