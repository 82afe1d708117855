import { type ChildProcess, spawn } from "node:child_process";
import { existsSync, mkdtempSync, renameSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { DCLOC, dcloc, until } from "./harness.ts";

/** Drives through a simulated town, of which one lasts for three minutes. */
function simulate(drives: string): void {
  const speeds = ["--map-speed-kmh", "72", "--live-speed-kmh", "7.5"];
  const unfinished = `${drives}.${process.pid}`;
  dcloc("simulate", "--out", unfinished, "--length-m", "400", "--seed", "5", ...speeds);
  try {
    renameSync(unfinished, drives);
  } catch (error) {
    // Another test was first: its drives are the same.
    rmSync(unfinished, { recursive: true });
    if (!existsSync(drives)) throw error;
  }
}

/** A folder for the test's data, with a simulated town: a map and a drive in it. */
export class Town {
  readonly folder = mkdtempSync(join(tmpdir(), "dcloc-console-"));
  /** Where the caller names a place, the first test makes the drives for all. */
  readonly drives = process.env["DCLOC_CONSOLE_DRIVES"] ?? join(this.folder, "drives");

  constructor() {
    if (!existsSync(this.drives)) simulate(this.drives);
  }

  /** Makes a map file of the town; the name tells whose drive it was. */
  makeMap(file: string, name: string): string {
    const path = join(this.folder, file);
    const data = ["--dataset", "nuscenes", "--root", this.drives, "--drive", "map"];
    dcloc("map", "build", ...data, "--name", name, "--out", path);
    return path;
  }

  /** A copy of a map file that tells how well vehicles can know where they are. */
  withAccuracy(path: string): string {
    const graded = `${path}.graded`;
    dcloc("map", "report", path, "--out", join(this.folder, "report.html"), "--map-out", graded);
    return graded;
  }

  /** Vehicles that drive through the town until they are stopped; their first sessions last for two and a half minutes. */
  drive(address: string, map: string, count: number, more: string[] = []): ChildProcess {
    const data = ["--dataset", "nuscenes", "--root", this.drives, "--drive", "live-0"];
    const load = ["--vehicles", String(count), "--duration-s", "3600", "--ramp-s", "0.5", "--begin-within", "0.2"];
    const args = ["load", "--server", address, "--map", map, ...data, ...load, ...more];
    return spawn(DCLOC, args, { stdio: "ignore" });
  }

  remove(): void {
    rmSync(this.folder, { recursive: true, force: true });
  }
}

/** Ends vehicles, and waits until they have. */
export async function stopVehicles(vehicles: ChildProcess | undefined): Promise<void> {
  vehicles?.kill();
  await until(() => !vehicles || vehicles.exitCode !== null || vehicles.signalCode !== null, "vehicles end");
}
