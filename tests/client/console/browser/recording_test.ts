import assert from "node:assert/strict";
import { readFileSync, writeFileSync } from "node:fs";
import { join } from "node:path";
import { test } from "node:test";
import type { Page } from "playwright-core";
import { seriousFindings } from "./accessibility.ts";
import { dcloc, signIn } from "./harness.ts";
import { TownScene, staged, testNothingWentWrong } from "./scene.ts";

const VEHICLE = "load-00000";

let page: Page;
const scene = staged(new TownScene(), async (scene) => {
  ({ page } = scene);
  await signIn(page);
});
const file = join(scene.town.folder, "session.dclocrec");

const item = () => page.locator(".item");
const positionS = async (): Promise<number> =>
  Number(await page.getByRole("slider").getAttribute("aria-valuenow"));

test("a vehicle that is not there yet is waited for, and recorded from its opening on", async () => {
  await page.getByRole("navigation").getByRole("link", { name: "Recordings" }).click();
  await page.getByText("Record a vehicle’s next session, or open a file.").waitFor();
  assert.deepEqual(await seriousFindings(page), []);
  await page.getByRole("button", { name: "Record a vehicle" }).click();
  await page.getByRole("dialog").getByLabel("Vehicle").fill(VEHICLE);
  await page.getByRole("dialog").getByRole("button", { name: "Record", exact: true }).click();
  await item().getByText("Waiting for the vehicle to open its next session").waitFor();
  scene.drive(2);
  await item().getByText(/^Recording · \d+ scans/).waitFor();
});

test("it is watched as it comes: the scan on the map, states, innovations beside their gate", async () => {
  await item().getByRole("link", { name: "Watch" }).click();
  await page.getByRole("heading", { name: VEHICLE }).waitFor();
  await page.getByText("The scans agree with the map").waitFor();
  await page.getByText("Target with a landmark within 1 m").waitFor();
  await page.getByText("gate 7.8").waitFor();
  await page.getByText(/Tracking \d+\.\d %/).waitFor();
  const begin = await positionS();
  await page.waitForFunction(
    (s) => Number(document.querySelector("[role=slider]")!.getAttribute("aria-valuenow")) >= s + 2,
    begin,
  );
  assert.deepEqual(await seriousFindings(page), []);
});

test("what is downloaded is replayed by dcloc, answer for answer", async () => {
  await page.getByRole("button", { name: "Stop" }).click();
  await page.getByRole("button", { name: "Stop" }).waitFor({ state: "hidden" });
  const download = page.waitForEvent("download");
  await page.getByRole("button", { name: "Download" }).click();
  const saved = await download;
  assert.match(saved.suggestedFilename(), /^load-00000-\d+\.dclocrec$/);
  await saved.saveAs(file);
  const told = dcloc("session", "replay", file, "--map", join(scene.town.folder, "v1.dclm"), "--json");
  const figures = JSON.parse(told) as { different_count?: number; equal_count?: number };
  assert.ok((figures.equal_count ?? 0) > 10, told);
  assert.equal(figures.different_count, 0, told);
});

test("a file is opened and played with keys: to and fro, scan by scan, at another speed", async () => {
  await page.getByRole("link", { name: "Recordings" }).first().click();
  await page.getByLabel("Open a recording").setInputFiles(file);
  await page.getByRole("heading", { name: VEHICLE }).waitFor();
  const output = page.locator(".transport output");
  await page.getByRole("slider").focus();
  await page.keyboard.press("Home");
  assert.equal(await positionS(), 0);
  await page.keyboard.press(".");
  const afterOne = await output.innerText();
  // Scans follow one another by less than a tenth of a second, which is what is shown.
  for (const key of [".", ".", "."]) await page.keyboard.press(key);
  assert.notEqual(await output.innerText(), afterOne);
  for (const key of [",", ",", ","]) await page.keyboard.press(key);
  assert.equal(await output.innerText(), afterOne);
  await page.keyboard.press("Home");
  await page.getByLabel("Speed").selectOption("100");
  await page.getByRole("button", { name: "Play" }).click();
  // At its end it stops by itself.
  await page.getByRole("button", { name: "Play" }).waitFor();
  const [at, duration] = (await output.innerText()).split(" / ");
  assert.equal(at, duration);
  const { x, y } = (await page.getByRole("slider").boundingBox())!;
  await page.mouse.click(x + 2, y + 8);
  assert.equal(await positionS(), 0);
  await page.getByText("Changes of state").click();
  await page.locator(".changes li").first().waitFor();
});

test("hostile and truncated files get a clear word, and do nothing", async () => {
  const whole = readFileSync(file);
  const open = async (name: string, bytes: Uint8Array): Promise<void> => {
    const path = join(scene.town.folder, name);
    writeFileSync(path, bytes);
    await page.goto(`${scene.bridge.address}/recordings`);
    await page.getByLabel("Open a recording").setInputFiles(path);
  };
  await open("<img src=x onerror=alert(1)>.txt", Buffer.from("<script>alert(1)</script>"));
  await page.getByText("This is no recording of dcloc.").waitFor();
  assert.equal(await page.locator("img").count(), 0);
  await open("cut.dclocrec", whole.subarray(0, whole.length / 2));
  await page.getByText("The file is cut off. What was whole is shown.").waitFor();
  await page.getByRole("button", { name: "Play" }).waitFor();
  const changed = Buffer.from(whole);
  changed[changed.length - 200] = changed[changed.length - 200]! ^ 0xff;
  await open("changed.dclocrec", changed);
  await page.getByText("The file is damaged").waitFor();
  await open("newer.dclocrec", Buffer.from([...Buffer.from("DCLOCREC"), 2, 8, 9]));
  await page.getByText("The file has format version 9").waitFor();
});

test("a file can be dropped", async () => {
  await page.goto(`${scene.bridge.address}/recordings`);
  const transfer = await page.evaluateHandle(
    (bytes) => {
      const made = new DataTransfer();
      made.items.add(new File([Uint8Array.from(bytes)], "dropped.dclocrec"));
      return made;
    },
    [...readFileSync(file)],
  );
  await page.dispatchEvent(".drop-zone", "drop", { dataTransfer: transfer });
  await page.getByRole("button", { name: "Play" }).waitFor();
});

test("who may not record is told so by the server", async () => {
  // From the first one on, servers want a token.
  scene.token("root", "admin");
  const token = scene.token("eve", "viewer");
  await page.getByText("The servers no longer know your token").waitFor();
  await signIn(page, token);
  await page.getByRole("navigation").getByRole("link", { name: "Recordings" }).click();
  await page.getByRole("button", { name: "Record a vehicle" }).click();
  await page.getByRole("dialog").getByLabel("Vehicle").fill(VEHICLE);
  await page.getByRole("dialog").getByRole("button", { name: "Record", exact: true }).click();
  await item().getByText("Your token does not permit this").waitFor();
});

testNothingWentWrong(scene);
