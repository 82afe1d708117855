/** How browser tests begin and end: said here once. */
import assert from "node:assert/strict";
import type { ChildProcess } from "node:child_process";
import { join } from "node:path";
import { after, before, test } from "node:test";
import type { Browser, Locator, Page } from "playwright-core";
import { FakeServer } from "./fake_server.ts";
import {
  type Program,
  dcloc,
  launch,
  openPage,
  serverCommand,
  signIn,
  startConsole,
  startServer,
} from "./harness.ts";
import { Town, stopVehicles } from "./town.ts";

/** A browser, and a console in front of a server. */
abstract class Scene {
  bridge!: Program;
  browser!: Browser;

  /** Starts the server; its address. */
  protected abstract begin(): Promise<string>;
  protected abstract end(): Promise<void>;

  async open(): Promise<void> {
    const startBridge = async (): Promise<Program> => startConsole([await this.begin()]);
    await Promise.all([
      launch().then((browser) => (this.browser = browser)),
      startBridge().then((bridge) => (this.bridge = bridge)),
    ]);
  }

  async close(): Promise<void> {
    await this.browser?.close();
    await this.bridge?.stop();
    await this.end();
  }

  /** Somebody opens a page of his own and signs in; nothing may go wrong in it that it does not show. */
  async visit(look: (page: Page) => Promise<void>, token?: string): Promise<void> {
    const { page, faults } = await openPage(this.browser, this.bridge.address);
    await signIn(page, token);
    await look(page);
    assert.deepEqual(faults, []);
    await page.close();
  }
}

/** A scene with a server that says what a test wants. */
export class FakeScene extends Scene {
  readonly fake = new FakeServer();

  protected begin(): Promise<string> {
    return this.fake.start();
  }

  protected async end(): Promise<void> {
    this.fake.stop();
  }
}

export interface TownOptions {
  /** Names of the drives that the versions of the map were made of; the first one is active. */
  versions?: readonly string[];
  vehicles?: number;
  /** A further version, of the first drive, tells how well vehicles can know where they are. */
  isGraded?: boolean;
}

/** A scene with a real server, a map named "town", and vehicles. */
export class TownScene extends Scene {
  readonly town = new Town();
  readonly store = join(this.town.folder, "store");
  server!: Program;
  vehicles: ChildProcess | undefined;
  /** One page for tests that go on from one another. */
  page!: Page;
  faults: string[] = [];

  constructor(private readonly options: TownOptions = {}) {
    super();
  }

  protected async begin(): Promise<string> {
    this.server = await startServer(this.store);
    const { versions = ["drive"], vehicles = 0, isGraded } = this.options;
    const files = versions.map((name, i) => this.town.makeMap(`v${i + 1}.dclm`, name));
    if (isGraded) files.push(this.town.withAccuracy(files[0]!));
    files.forEach((file, i) => {
      const activate = i === 0 ? ["--activate"] : [];
      dcloc("map", "upload", "--server", this.server.address, "--map", "town", ...activate, file);
    });
    if (vehicles > 0) this.drive(vehicles);
    return this.server.address;
  }

  override async open(): Promise<void> {
    await super.open();
    Object.assign(this, await openPage(this.browser, this.bridge.address));
  }

  protected async end(): Promise<void> {
    await stopVehicles(this.vehicles);
    await this.server?.stop();
    this.town.remove();
  }

  drive(count: number, more: string[] = []): void {
    this.vehicles = this.town.drive(this.server.address, "town", count, more);
  }

  token(name: string, role: string, ...more: string[]): string {
    const args = ["token", "create", "--data", this.store, "--name", name, "--role", role, ...more];
    return serverCommand(...args).trim();
  }

  goto(view: string): Promise<unknown> {
    return this.page.goto(this.bridge.address + view);
  }

  get dialog(): Locator {
    return this.page.getByRole("dialog");
  }

  /** The row of a version in the view of a map; other rows may name it, too. */
  versionRow(name: string): Locator {
    const { page } = this;
    const heading = page.locator("strong", { hasText: new RegExp(`^${name}\\b`) });
    return page.locator(".row").filter({ has: heading });
  }

  async choose(version: string): Promise<void> {
    await this.versionRow(version).getByRole("button").first().click();
  }

  /** Opens the view of the first vehicle's session. */
  async openSession(): Promise<void> {
    await this.goto("/live");
    await this.page.locator(".row").first().getByRole("button").first().click();
    await this.page.getByRole("link", { name: "Details" }).click();
    await this.page.getByText("The scans agree with the map").waitFor();
  }
}

/** Opens a scene before the tests of a file, and then calls `begin`; closes it behind them. */
export function staged<S extends Scene>(scene: S, begin?: (scene: S) => unknown): S {
  before(async () => {
    await scene.open();
    await begin?.(scene);
  });
  after(() => scene.close());
  return scene;
}

/** The last test of a file whose tests share a page. */
export function testNothingWentWrong(scene: TownScene): void {
  test("in all of this nothing was uncaught, and no other host was asked", () => {
    assert.deepEqual(scene.faults, []);
  });
}
