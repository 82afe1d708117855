import type { IncomingMessage, ServerResponse } from "node:http";

/** What each answer says to the browser: nothing from elsewhere, in nobody's frame, never guessed. */
const HEADERS: Record<string, string> = {
  "Content-Security-Policy":
    "default-src 'none'; script-src 'self'; style-src 'self'; font-src 'self'; img-src 'self' " +
    "data: blob:; connect-src 'self'; manifest-src 'self'; base-uri 'none'; form-action 'self'; " +
    "frame-ancestors 'none'",
  "X-Content-Type-Options": "nosniff",
  "Referrer-Policy": "no-referrer",
  "Cross-Origin-Opener-Policy": "same-origin",
  "Cross-Origin-Resource-Policy": "same-origin",
  "Permissions-Policy": "camera=(), geolocation=(), microphone=()",
};

/** Refuses what no page of ours sends: other hosts (DNS rebinding) and other origins. */
export class Guard {
  private readonly hosts: Set<string>;

  /** `origins` are all under which the page may be reached. */
  constructor(
    private readonly origins: readonly string[],
    private readonly tls: boolean,
  ) {
    this.hosts = new Set(origins.map((origin) => new URL(origin).host));
  }

  /** Sets the answer's headers. */
  protect(response: ServerResponse): void {
    for (const [name, value] of Object.entries(HEADERS)) response.setHeader(name, value);
    if (this.tls) response.setHeader("Strict-Transport-Security", "max-age=31536000");
  }

  /** Why the request is refused; undefined: it is not. */
  refusal(request: IncomingMessage): string | undefined {
    const host = request.headers.host ?? "";
    if (!this.hosts.has(host)) {
      return `this page is not called ${JSON.stringify(host.slice(0, 100))}; see --origin`;
    }
    const { origin } = request.headers;
    if (origin !== undefined && !this.origins.includes(origin)) return "another page asked";
    const site = request.headers["sec-fetch-site"];
    const isPage = request.headers["sec-fetch-mode"] === "navigate";
    if (site === "cross-site" && !isPage) return "another site asked";
    const isSafe = request.method === "GET" || request.method === "HEAD";
    // Every browser names the origin with what changes something.
    if (!isSafe && origin === undefined) return "the request names no origin";
    return undefined;
  }
}

/** The origins under which the page answers at this address. */
export function ownOrigins(host: string, port: number, tls: boolean): string[] {
  const scheme = tls ? "https" : "http";
  const names = new Set([host.includes(":") ? `[${host}]` : host, "localhost", "127.0.0.1"]);
  return [...names].map((name) => new URL(`${scheme}://${name}:${port}`).origin);
}
