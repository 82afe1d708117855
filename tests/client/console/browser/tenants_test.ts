import assert from "node:assert/strict";
import { writeFileSync } from "node:fs";
import { join } from "node:path";
import { test } from "node:test";
import { dcloc } from "./harness.ts";
import { TownScene, staged } from "./scene.ts";

/** The default tenant has a map, "town", and no vehicle; "acme" has both, on "harbour". */
const scene = staged(new TownScene(), (scene) => {
  const file = join(scene.town.folder, "acme.token");
  writeFileSync(file, scene.token("ops", "operator", "--tenant", "acme"), { mode: 0o600 });
  const { address } = scene.server;
  const as = ["--token-file", file];
  const map = join(scene.town.folder, "v1.dclm");
  dcloc("map", "upload", "--server", address, "--map", "harbour", "--activate", map, ...as);
  scene.vehicles = scene.town.drive(address, "harbour", 2, as);
});

test("an admin of the server looks at one tenant after the other", async () => {
  await scene.visit(async (page) => {
    const tenant = page.getByLabel("Tenant");
    await page.getByText("A vehicle appears here").first().waitFor();
    await tenant.selectOption("acme");
    await page.getByRole("button", { name: "2 Tracking" }).waitFor();
    await page.locator(".row").first().getByRole("button").first().click();
    await page.getByRole("link", { name: "Details" }).click();
    await page.getByText("The scans agree with the map").waitFor();
    await page.getByRole("link", { name: "Maps" }).click();
    await page.getByRole("link", { name: "harbour" }).waitFor();
    assert.equal(await page.getByRole("link", { name: "town" }).count(), 0);
    await page.reload();
    await page.getByRole("link", { name: "harbour" }).waitFor();
    await tenant.selectOption("Default tenant");
    await page.getByRole("link", { name: "town" }).waitFor();
    assert.equal(await page.getByRole("link", { name: "harbour" }).count(), 0);
  }, scene.token("alice", "admin"));
});

test("others see their own tenant alone, whatever they ask for", async () => {
  await scene.visit(async (page) => {
    await page.getByRole("button", { name: "2 Tracking" }).waitFor();
    assert.equal(await page.getByLabel("Tenant").count(), 0);
    const list = "/dcloc.v1.MapService/ListMaps";
    const statusIn = (tenant: string): Promise<number> =>
      page.evaluate(
        async ([path, name]) => {
          const server = (await (await fetch("/api/session")).json()).servers[0].name;
          return (await fetch(`/rpc/${server}${path}?tenant=${name}`, { method: "POST" })).status;
        },
        [list, tenant] as const,
      );
    assert.equal(await statusIn("acme"), 200);
    assert.equal(await statusIn("other"), 403);
    assert.equal(await statusIn("a%0d%0ab"), 400);
  }, scene.token("carla", "admin", "--tenant", "acme"));
});
