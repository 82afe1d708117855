import type { Browser, Page } from "playwright-core";
import { type Notes, note, readNotes } from "./notes.ts";

const ROUND_COUNT = 8;

/** A page that does nothing: what its interactions take is the browser's and the machine's own. */
export class EmptyPage {
  private constructor(private readonly page: Page) {}

  static async open(browser: Browser): Promise<EmptyPage> {
    const page = await browser.newPage({ viewport: { width: 1280, height: 800 } });
    page.setDefaultTimeout(120_000);
    await page.addInitScript(note);
    await page.goto("data:text/html,<button>press</button><input>");
    return new EmptyPage(page);
  }

  async interact(): Promise<void> {
    for (let i = 0; i < ROUND_COUNT; ++i) {
      await this.page.locator("button").click();
      await this.page.locator("input").press("a");
    }
  }

  notes(): Promise<Notes> {
    return readNotes(this.page);
  }

  close(): Promise<void> {
    return this.page.close();
  }
}
