import { readFileSync } from "node:fs";
import { createServer } from "node:http";
import { createServer as createTlsServer } from "node:https";
import type { AddressInfo } from "node:net";
import { join } from "node:path";
import { App } from "./app.ts";
import { Guard, ownOrigins } from "./guard.ts";
import { Logins } from "./logins.ts";
import { type Options, USAGE, UsageError, parseOptions } from "./options.ts";
import { PageFiles } from "./page_files.ts";
import { Upstream } from "./upstream.ts";

const MS_PER_HOUR = 3_600_000;

function log(text: string): void {
  process.stderr.write(`dcloc-console: ${text}\n`);
}

function start(options: Options): void {
  const ca = options.serverCa === undefined ? undefined : readFileSync(options.serverCa);
  const upstreams = options.servers.map(({ name, address }) => new Upstream(name, address, ca));
  const tls = options.tls !== undefined;
  const server = options.tls
    ? createTlsServer({
        cert: readFileSync(options.tls.certificate),
        key: readFileSync(options.tls.key),
        minVersion: "TLSv1.2",
      })
    : createServer();
  // A slow reader of a stream is no idle one; a request must come within half a minute.
  server.headersTimeout = 30_000;
  server.requestTimeout = 0;
  server.maxHeadersCount = 100;

  const page = new PageFiles(join(__dirname, "page"));
  const { host, port } = options.listen;
  server.listen(port, host, () => {
    const taken = (server.address() as AddressInfo).port;
    const origins = [...ownOrigins(host, taken, tls), ...options.origins];
    // Behind a proxy that speaks TLS the cookie is for TLS alone as well.
    const secure = origins.every((o) => o.startsWith("https:")) || isBehindTls(options);
    const app = new App({
      upstreams,
      logins: new Logins(options.idleHours * MS_PER_HOUR),
      guard: new Guard(origins, tls),
      page,
      tls: secure,
      maxWatchCount: options.maxWatchCount,
      maxRecordingCount: options.maxRecordingCount,
      log,
    });
    server.on("request", (request, response) => void app.answer(request, response));
    process.stdout.write(`listening on ${origins[0]}\n`);
  });
  server.on("error", (error) => fail(`cannot listen on ${host}:${port}: ${error.message}`));
  for (const signal of ["SIGTERM", "SIGINT"] as const) {
    process.on(signal, () => {
      server.close();
      server.closeAllConnections();
      for (const upstream of upstreams) upstream.close();
      process.exit(0);
    });
  }
}

/** Whether browsers come through a proxy only, by https. */
function isBehindTls(options: Options): boolean {
  const { origins } = options;
  return origins.length > 0 && origins.every((origin) => origin.startsWith("https:"));
}

function fail(text: string): never {
  log(text);
  process.exit(1);
}

if (process.argv.includes("--help")) {
  process.stdout.write(USAGE);
} else {
  try {
    start(parseOptions(process.argv.slice(2)));
  } catch (error) {
    if (error instanceof UsageError) {
      log(`${error.message}\n\n${USAGE}`);
      process.exit(2);
    }
    fail(error instanceof Error ? error.message : String(error));
  }
}
