import assert from "node:assert/strict";
import { createHash } from "node:crypto";
import { readFileSync, writeFileSync } from "node:fs";
import { join } from "node:path";
import { test } from "node:test";
import { create, fromBinary, toBinary } from "@bufbuild/protobuf";
import type { Page } from "playwright-core";
import { MapService } from "proto/dcloc/v1/map_service_pb.ts";
import { signIn, startConsole, until } from "./harness.ts";
import { TownScene, staged, testNothingWentWrong } from "./scene.ts";

const HOSTILE_DRIVE = `<script>document.title="executed"</script>`;
/** A slow line: a map of 48 kB takes it some seconds. */
const SLOW_BYTES_PER_S = 8_000;

let page: Page;
const scene = staged(new TownScene(), async (scene) => {
  ({ page } = scene);
  await signIn(page);
});

/** Opens the dialog, chooses the file, and sends it. */
async function beginUpload(file: string): Promise<void> {
  const { dialog } = scene;
  await page.getByRole("button", { name: "Upload a map" }).click();
  await dialog.getByLabel("Name of the map").fill("town");
  await dialog.getByLabel("Map file").setInputFiles(file);
  await dialog.getByRole("button", { name: "Upload a map" }).click();
}

const closeDialog = (): Promise<void> => scene.dialog.getByRole("button", { name: "Close" }).click();

/** How much of a file the server has for good. */
async function durableBytes(file: string): Promise<number> {
  const { input, output } = MapService.method.getMapUpload;
  const sha256 = createHash("sha256").update(readFileSync(file)).digest("hex");
  const answer = await page.request.post(`${scene.bridge.address}/rpc/dcloc/dcloc.v1.MapService/GetMapUpload`, {
    headers: { origin: scene.bridge.address },
    data: Buffer.from(toBinary(input, create(input, { sha256 }))),
  });
  return Number(fromBinary(output, await answer.body()).durableSizeBytes);
}

/** From which byte on each upload of the page sends the file. */
function offsetsOfUploads(): number[] {
  const offsets: number[] = [];
  page.on("request", (request) => {
    const url = new URL(request.url());
    if (url.pathname.startsWith("/upload/")) offsets.push(Number(url.searchParams.get("offset")));
  });
  return offsets;
}

test("an upload goes on where it stopped, after the network was cut and the page loaded again", async () => {
  const file = scene.town.makeMap("second.dclm", HOSTILE_DRIVE);
  const size = readFileSync(file).length;
  const offsets = offsetsOfUploads();
  const devtools = await page.context().newCDPSession(page);
  const slow = { offline: false, latency: 0, downloadThroughput: -1, uploadThroughput: SLOW_BYTES_PER_S };
  await scene.goto("/maps");
  await devtools.send("Network.enable");
  await devtools.send("Network.emulateNetworkConditions", slow);
  await beginUpload(file);
  await scene.dialog.getByText(/Sending … [1-9]\d %/).waitFor();
  await until(async () => (await durableBytes(file)) > 0, "a part of the file is on the server");
  // The bridge is gone from one moment to the next, with all that is open.
  const { address } = scene.bridge;
  await scene.bridge.stop("SIGKILL");
  await scene.dialog.getByText("The connection broke. Going on in a moment …").waitFor();
  await devtools.send("Network.emulateNetworkConditions", { ...slow, uploadThroughput: -1 });
  scene.bridge = await startConsole([scene.server.address], new URL(address).host);
  await page.reload();
  await signIn(page);
  await page.getByRole("button", { name: "Upload a map" }).click();
  await scene.dialog.getByText("An upload of “second.dclm” was not finished.").waitFor();
  await closeDialog();
  await beginUpload(file);
  await scene.dialog.getByText("town v2 is on the server.").waitFor();
  await closeDialog();
  const first = offsets[0];
  const last = offsets.at(-1)!;
  assert.equal(first, 0);
  assert.ok(last > 0 && last < size, `went on from byte ${last} of ${size}`);
  await page.getByRole("button", { name: "Upload a map" }).click();
  assert.equal(await scene.dialog.getByText("was not finished").count(), 0);
  await closeDialog();
});

test("an upload whose connection breaks goes on by itself, without the page being loaded again", async () => {
  const file = scene.town.makeMap("third.dclm", "third drive");
  const offsets = offsetsOfUploads();
  let cuts = 0;
  await page.route("**/upload/**", (route) =>
    cuts++ === 0 ? route.abort("connectionreset") : route.continue(),
  );
  await beginUpload(file);
  await scene.dialog.getByText("town v3 is on the server.").waitFor();
  await page.unroute("**/upload/**");
  assert.deepEqual(offsets, [0, 0]);
  await closeDialog();
});

test("a file that is no map is refused with a word, and the maps stay as they are", async () => {
  const file = join(scene.town.folder, "broken.dclm");
  const bytes = readFileSync(join(scene.town.folder, "second.dclm"));
  bytes.fill(0xff, Math.floor(bytes.length / 2));
  writeFileSync(file, bytes);
  await beginUpload(file);
  await scene.dialog.getByRole("alert").waitFor();
  assert.match(await scene.dialog.getByRole("alert").innerText(), /\w{4}/);
  await closeDialog();
  await page.getByRole("row", { name: /^town/ }).getByText("3", { exact: true }).waitFor();
});

test("a hostile name of a drive is only shown, and what is downloaded is what was uploaded", async () => {
  await scene.goto("/maps/dcloc/town");
  await scene.choose("v2");
  await page.getByText(HOSTILE_DRIVE).waitFor();
  assert.equal(await page.title(), "dcloc console");
  const landmarks = page.locator(".facts div").filter({ hasText: "Landmarks" }).locator("dd");
  const count = await landmarks.innerText();
  await page.getByText(`${count} of ${count} landmarks in view`).waitFor();
  const download = page.waitForEvent("download");
  await scene.versionRow("v2").getByRole("link", { name: "Download" }).click();
  const file = await download;
  assert.equal(file.suggestedFilename(), "town-v2.dclm");
  const uploaded = readFileSync(join(scene.town.folder, "second.dclm"));
  assert.ok(readFileSync(await file.path()).equals(uploaded));
});

testNothingWentWrong(scene);
