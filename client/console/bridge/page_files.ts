import { readFileSync, readdirSync } from "node:fs";
import type { IncomingMessage, ServerResponse } from "node:http";
import { extname, join } from "node:path";
import { brotliDecompressSync } from "node:zlib";

const TYPES: Record<string, string> = {
  ".html": "text/html; charset=utf-8",
  ".js": "text/javascript; charset=utf-8",
  ".css": "text/css; charset=utf-8",
  ".svg": "image/svg+xml",
  ".woff2": "font/woff2",
};

interface PageFile {
  type: string;
  plain: Buffer;
  brotli: Buffer | undefined;
}

/** The built page, held in memory: no request ever names a file of the disk. */
export class PageFiles {
  private readonly files = new Map<string, PageFile>();

  /** Throws if `folder` has no built page. */
  constructor(folder: string) {
    const names = readdirSync(folder);
    for (const name of names.filter((n) => !n.endsWith(".br"))) {
      const compressed = names.includes(`${name}.br`);
      const brotli = compressed ? readFileSync(join(folder, `${name}.br`)) : undefined;
      const plain = brotli ? brotliDecompressSync(brotli) : readFileSync(join(folder, name));
      const type = TYPES[extname(name)] ?? "application/octet-stream";
      this.files.set(`/${name}`, { type, plain, brotli });
    }
    if (!this.files.has("/index.html")) throw new Error(`${folder} has no index.html`);
  }

  /** Answers with a file, or, for the address of a view, with the page itself. */
  answer(path: string, request: IncomingMessage, response: ServerResponse): void {
    let file = this.files.get(path);
    const isAsset = file !== undefined && path !== "/index.html";
    if (file === undefined && extname(path) === "") file = this.files.get("/index.html");
    if (file === undefined) {
      response.writeHead(404, { "Content-Type": "text/plain" }).end("there is no such file\n");
      return;
    }
    // Names of assets change with their content; the page itself is asked for each time.
    const caching = isAsset && path.includes("-") ? "public, max-age=31536000, immutable" : "no-cache";
    const takesBrotli = /\bbr\b/.test(String(request.headers["accept-encoding"] ?? ""));
    const body = takesBrotli && file.brotli ? file.brotli : file.plain;
    response.writeHead(200, {
      "Content-Type": file.type,
      "Content-Length": body.length,
      "Cache-Control": caching,
      Vary: "Accept-Encoding",
      ...(body === file.brotli ? { "Content-Encoding": "br" } : {}),
    });
    response.end(request.method === "HEAD" ? undefined : body);
  }
}
