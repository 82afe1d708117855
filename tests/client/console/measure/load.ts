import { execFile } from "node:child_process";
import { readFileSync, writeFileSync } from "node:fs";
import { join } from "node:path";
import { promisify } from "node:util";
import { type Program, dcloc, serverCommand, startConsole, startServer } from "../browser/harness.ts";
import { Town } from "../browser/town.ts";

const PAGE_COUNT = 20;
const VEHICLE_COUNT = 20;
const DURATION_S = 15;
const PAIR_COUNT = 3;

/** What one drive of the vehicles cost. */
interface Cost {
  p50Ms: number;
  p99Ms: number;
  /** Of the server's process. */
  processorS: number;
}

export interface LoadFigure {
  text: string;
  without: string;
  withPages: string;
}

/** The feeds of so many pages, each with a token of its own, so that the bridge shares nothing. */
async function openPages(address: string, tokens: readonly string[], stop: AbortSignal): Promise<void> {
  for (const token of tokens) {
    const headers = { origin: address };
    const body = JSON.stringify({ token });
    const answer = await fetch(`${address}/api/login`, { method: "POST", headers, body });
    const cookie = answer.headers.get("set-cookie")!.split(";")[0]!;
    const feed = await fetch(`${address}/feed`, { headers: { cookie }, signal: stop });
    void feed.body!.pipeTo(new WritableStream()).catch(() => undefined);
  }
}

/** Processor time of a process so far; a clock tick is 10 ms on Linux. */
function processorS(pid: number): number {
  const fields = readFileSync(`/proc/${pid}/stat`, "utf8").split(") ")[1]!.split(" ");
  return (Number(fields[11]) + Number(fields[12])) / 100;
}

/** Lets vehicles drive, which send at their own rate over the wire. */
async function drive(town: Town, server: Program, tokenFile: string): Promise<Cost> {
  const data = ["--dataset", "nuscenes", "--root", town.drives, "--drive", "live-0"];
  const load = ["--vehicles", String(VEHICLE_COUNT), "--duration-s", String(DURATION_S)];
  const target = ["--server", server.address, "--map", "town", "--token-file", tokenFile];
  const before = processorS(server.pid);
  const args = ["load", ...target, ...data, ...load, "--json"];
  const told = JSON.parse(await standardOutput(args)) as LoadReport;
  const { p50_ms, p99_ms } = told.server_latency;
  for (const shortfall of told.shortfalls) console.error(`load: ${shortfall}`);
  return { p50Ms: p50_ms, p99Ms: p99_ms, processorS: processorS(server.pid) - before };
}

interface LoadReport {
  server_latency: { p50_ms: number; p99_ms: number };
  /** What did not go as it should; the figures are there all the same. */
  shortfalls: string[];
}

/** Of dcloc, also where it fails after it has printed its report, as it does when scans were late. */
async function standardOutput(args: string[]): Promise<string> {
  try {
    return (await promisify(execFile)(process.env["DCLOC"]!, args, { maxBuffer: 1 << 24 })).stdout;
  } catch (error) {
    const { stdout } = error as { stdout?: string };
    if (!stdout?.startsWith("{")) throw error;
    return stdout;
  }
}

/** The server's latency for vehicles and its processor time, with pages that look on and without. */
export async function measureLoad(): Promise<LoadFigure[]> {
  const town = new Town();
  const store = join(town.folder, "store");
  const createToken = (name: string, role: string): string =>
    serverCommand("token", "create", "--data", store, "--name", name, "--role", role).trim();
  const server = await startServer(store);
  const map = town.makeMap("map.dclm", "drive");
  dcloc("map", "upload", "--server", server.address, "--map", "town", "--activate", map);
  const bridge = await startConsole([server.address]);
  const tokens = Array.from({ length: PAGE_COUNT }, (_, i) => createToken(`page-${i}`, "admin"));
  const tokenFile = join(town.folder, "vehicles.token");
  writeFileSync(tokenFile, createToken("vehicles", "operator"), { mode: 0o600 });
  const costs = { without: [] as Cost[], withPages: [] as Cost[] };
  for (let pair = 0; pair < PAIR_COUNT; ++pair) {
    costs.without.push(await drive(town, server, tokenFile));
    const stop = new AbortController();
    await openPages(bridge.address, tokens, stop.signal);
    costs.withPages.push(await drive(town, server, tokenFile));
    stop.abort();
  }
  await bridge.stop();
  await server.stop();
  town.remove();
  const figure = (text: string, value: (cost: Cost) => number, digits: number): LoadFigure => ({
    text,
    without: costs.without.map((cost) => value(cost).toFixed(digits)).join(", "),
    withPages: costs.withPages.map((cost) => value(cost).toFixed(digits)).join(", "),
  });
  return [
    figure(`server's p99 [ms], ${VEHICLE_COUNT} vehicles, ${PAGE_COUNT} pages`, (c) => c.p99Ms, 1),
    figure("server's p50 [ms]", (c) => c.p50Ms, 2),
    figure("server's processor time [s]", (c) => c.processorS, 1),
  ];
}
