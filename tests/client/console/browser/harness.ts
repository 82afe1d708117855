import { type ChildProcess, execFileSync, spawn } from "node:child_process";
import { type Browser, type Page, chromium } from "playwright-core";

/** Where the programs are: the test's caller says so. */
function environment(name: string): string {
  const value = process.env[name];
  if (!value) throw new Error(`${name} is not set; see tests/client/console/run`);
  return value;
}

export const DCLOC = environment("DCLOC");
const DCLOC_SERVER = environment("DCLOC_SERVER");
const CONSOLE = environment("DCLOC_CONSOLE");
const CHROMIUM_FLAGS = [
  "--no-sandbox",
  "--disable-gpu",
  "--disable-quic",
  "--no-first-run",
  "--disable-background-networking",
  "--disable-component-update",
  "--disable-sync",
];

/** For a page on a machine that does much else. */
const PATIENCE_MS = 60_000;

/** A process that tells its address on its standard output. */
export class Program {
  private constructor(
    private readonly child: ChildProcess,
    readonly address: string,
    /** What it has written to standard error. */
    readonly log: string[],
  ) {}

  static start(command: string, args: string[]): Promise<Program> {
    const child = spawn(command, args, { stdio: ["ignore", "pipe", "pipe"] });
    const log: string[] = [];
    child.stderr!.on("data", (bytes: Buffer) => log.push(bytes.toString()));
    return new Promise((resolve, reject) => {
      let told = "";
      child.stdout!.on("data", (bytes: Buffer) => {
        told += bytes.toString();
        const address = /listening on (\S+)/.exec(told)?.[1];
        if (address) resolve(new Program(child, address, log));
      });
      child.on("exit", (code) => reject(new Error(`${command} ended with ${code}: ${log.join("")}`)));
    });
  }

  get pid(): number {
    return this.child.pid!;
  }

  async stop(signal: NodeJS.Signals = "SIGTERM"): Promise<void> {
    if (this.child.exitCode !== null || this.child.signalCode !== null) return;
    const ended = new Promise((resolve) => this.child.once("exit", resolve));
    this.child.kill(signal);
    await ended;
  }
}

export function dcloc(...args: string[]): string {
  return execFileSync(DCLOC, args, { encoding: "utf8", stdio: ["ignore", "pipe", "pipe"] });
}

export function serverCommand(...args: string[]): string {
  return execFileSync(DCLOC_SERVER, args, { encoding: "utf8", stdio: ["ignore", "pipe", "pipe"] });
}

export const startServer = (
  store: string,
  address = "127.0.0.1:0",
  more: string[] = [],
): Promise<Program> => Program.start(DCLOC_SERVER, ["--data", store, "--listen", address, ...more]);

export const startConsole = (
  servers: string[],
  listen = "127.0.0.1:0",
  more: string[] = [],
): Promise<Program> =>
  Program.start(process.execPath, [
    CONSOLE,
    "--listen",
    listen,
    ...servers.flatMap((server) => ["--server", server]),
    ...more,
  ]);

export const launch = (): Promise<Browser> =>
  chromium.launch({ executablePath: environment("CHROMIUM"), args: CHROMIUM_FLAGS });

/** A page, and what went wrong in it: errors that nothing caught, and calls to other hosts. */
export async function openPage(
  browser: Browser,
  address: string,
): Promise<{ page: Page; faults: string[] }> {
  const page = await browser.newPage({
    viewport: { width: 1280, height: 800 },
    locale: "en-GB",
    // Tests make certificates of their own; that the bridge's is checked is the browser's affair.
    ignoreHTTPSErrors: true,
  });
  const faults: string[] = [];
  page.setDefaultTimeout(PATIENCE_MS);
  page.on("pageerror", (error) => faults.push(`uncaught: ${error.message}`));
  page.on("console", (message) => {
    const text = message.text();
    // A failed request is told here by the browser; the page has to show it, which tests look at.
    if (message.type() === "error" && !text.startsWith("Failed to load resource")) faults.push(text);
  });
  page.on("request", (request) => {
    if (!/^(https?:\/\/127\.0\.0\.1:|blob:|data:)/.test(request.url())) faults.push(request.url());
  });
  await page.goto(address);
  return { page, faults };
}

/** Signs in, and waits until the console is there or says why not. */
export async function signIn(page: Page, token?: string): Promise<void> {
  if (token === undefined) {
    await page.getByRole("button", { name: "Continue without a token" }).click();
  } else {
    await page.getByLabel("Token").fill(token);
    await page.getByRole("button", { name: "Sign in" }).click();
  }
  // Whoever goes on before the bridge has answered calls the sign-in off.
  await page.getByRole("navigation").or(page.getByRole("alert")).first().waitFor();
}

/** Waits until something holds, as long as a page is waited for. */
export async function until(holds: () => boolean | Promise<boolean>, what: string): Promise<void> {
  const end = Date.now() + PATIENCE_MS;
  while (!(await holds())) {
    if (Date.now() > end) throw new Error(`not so after ${PATIENCE_MS / 1000} s: ${what}`);
    await new Promise((resolve) => setTimeout(resolve, 50));
  }
}
