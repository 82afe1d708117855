/** What the bridge is told on its command line. */

export interface ServerAddress {
  /** How people and addresses of the page call it: 1 to 32 of a-z, 0-9 and "-". */
  name: string;
  /** HOST:PORT. */
  address: string;
}

export interface Options {
  listen: { host: string; port: number };
  servers: ServerAddress[];
  /** Files of the certificate authority of the servers; undefined: plaintext to this machine. */
  serverCa: string | undefined;
  tls: { certificate: string; key: string } | undefined;
  /** Origins under which browsers reach the page, where a proxy is in front. */
  origins: string[];
  allowPlaintextOffLoopback: boolean;
  /** How long a sign-in is kept without a request. */
  idleHours: number;
  /** Most sessions that are watched at once, over all servers. */
  maxWatchCount: number;
  /** Most sessions that are recorded, or waited for, at once, over all servers. */
  maxRecordingCount: number;
}

export const USAGE = `Usage: dcloc-console --server [NAME=]HOST:PORT [...]
Serves the console's page and speaks to dcloc servers with each visitor's own token.

  --server [NAME=]HOST:PORT  a server; may be given several times, up to 32
  --server-ca FILE           speak TLS to the servers; FILE has their certificate authority
  --listen HOST:PORT         127.0.0.1:8080 by default; port 0 takes a free one
  --tls-cert FILE            speak TLS to browsers, with this certificate ...
  --tls-key FILE             ... and this key
  --origin URL               as browsers name this page, where a proxy is in front (may repeat)
  --idle-hours N             forget a sign-in after N hours without a request, 12 by default
  --max-watch-count N        sessions watched at once, 64 by default
  --max-recording-count N    sessions recorded at once, 8 by default
  --allow-plaintext-off-loopback
                             allow plaintext to other machines: tokens and maps can then be read
                             by the network between
  --help                     this text
`;

export class UsageError extends Error {}

const SERVER_NAME = /^[a-z0-9][a-z0-9-]{0,31}$/;
const MAX_SERVER_COUNT = 32;

export function splitAddress(option: string, text: string): { host: string; port: number } {
  const match = /^(?:\[([0-9A-Fa-f:.]+)\]|([^:[\]]+)):(\d{1,5})$/.exec(text);
  const port = Number(match?.[3]);
  if (!match || port > 65535) throw new UsageError(`${option} "${text}" is not HOST:PORT`);
  return { host: (match[1] ?? match[2])!, port };
}

export function isLoopback(host: string): boolean {
  return host === "localhost" || host === "::1" || /^127\.\d+\.\d+\.\d+$/.test(host);
}

function takeServer(text: string, count: number): ServerAddress {
  const [name, address] = text.includes("=")
    ? (text.split("=", 2) as [string, string])
    : [count === 0 ? "dcloc" : `dcloc-${count + 1}`, text];
  if (!SERVER_NAME.test(name)) {
    throw new UsageError(`--server name "${name}" must be 1 to 32 of a-z, 0-9 and "-"`);
  }
  splitAddress("--server", address);
  return { name, address };
}

function takeInteger(option: string, text: string, least: number, greatest: number): number {
  const value = Number(text);
  if (!/^\d+$/.test(text) || value < least || value > greatest) {
    throw new UsageError(`${option} is ${text}; it must be within [${least}, ${greatest}]`);
  }
  return value;
}

function takeOrigin(text: string): string {
  try {
    const url = new URL(text);
    if (url.origin === text.replace(/\/$/, "") && /^https?:$/.test(url.protocol)) return url.origin;
  } catch {
    // Said below.
  }
  throw new UsageError(`--origin "${text}" is not an origin, as https://console.example is one`);
}

/** Throws UsageError that names the option, the value and the bound. */
export function parseOptions(argv: string[]): Options {
  const options: Options = {
    listen: { host: "127.0.0.1", port: 8080 },
    servers: [],
    serverCa: undefined,
    tls: undefined,
    origins: [],
    allowPlaintextOffLoopback: false,
    idleHours: 12,
    maxWatchCount: 64,
    maxRecordingCount: 8,
  };
  let certificate: string | undefined;
  let key: string | undefined;
  const takers: Record<string, (value: string) => void> = {
    "--server": (v) => options.servers.push(takeServer(v, options.servers.length)),
    "--server-ca": (v) => (options.serverCa = v),
    "--listen": (v) => (options.listen = splitAddress("--listen", v)),
    "--tls-cert": (v) => (certificate = v),
    "--tls-key": (v) => (key = v),
    "--origin": (v) => options.origins.push(takeOrigin(v)),
    "--idle-hours": (v) => (options.idleHours = takeInteger("--idle-hours", v, 1, 720)),
    "--max-watch-count": (v) =>
      (options.maxWatchCount = takeInteger("--max-watch-count", v, 1, 10_000)),
    "--max-recording-count": (v) =>
      (options.maxRecordingCount = takeInteger("--max-recording-count", v, 1, 1_000)),
  };
  for (let i = 0; i < argv.length; ++i) {
    const option = argv[i]!;
    if (option === "--allow-plaintext-off-loopback") {
      options.allowPlaintextOffLoopback = true;
      continue;
    }
    const take = takers[option];
    if (!take) throw new UsageError(`unknown option ${option}`);
    const value = argv[++i];
    if (value === undefined) throw new UsageError(`${option} needs a value`);
    take(value);
  }
  if ((certificate === undefined) !== (key === undefined)) {
    throw new UsageError("--tls-cert and --tls-key belong together");
  }
  if (certificate !== undefined && key !== undefined) options.tls = { certificate, key };
  check(options);
  return options;
}

function check(options: Options): void {
  const { servers, listen } = options;
  if (servers.length === 0) throw new UsageError("--server is missing: which server to show?");
  if (servers.length > MAX_SERVER_COUNT) {
    throw new UsageError(`--server is given ${servers.length} times; at most ${MAX_SERVER_COUNT}`);
  }
  const names = new Set(servers.map((server) => server.name));
  if (names.size < servers.length) throw new UsageError("--server: two have the same name");
  if (options.allowPlaintextOffLoopback) return;
  if (!options.tls && !isLoopback(listen.host)) {
    throw new UsageError(
      `--listen ${listen.host} is not this machine alone: give --tls-cert and --tls-key, or ` +
        "--allow-plaintext-off-loopback where a proxy speaks TLS in front",
    );
  }
  const remote = servers.find((s) => !isLoopback(splitAddress("--server", s.address).host));
  if (remote && options.serverCa === undefined) {
    throw new UsageError(
      `--server ${remote.address} is another machine: a token goes there over TLS only. Give ` +
        "--server-ca, or --allow-plaintext-off-loopback",
    );
  }
}
