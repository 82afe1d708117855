import { createHash, randomBytes } from "node:crypto";
import { status } from "@grpc/grpc-js";
import { RequestError } from "./http.ts";

/** Somebody who signed in: the token that the servers know, kept in memory alone. */
export interface Login {
  /** Empty where servers need none. */
  readonly token: string;
  /** Equal for equal tokens, and tells nothing of them: for sharing and for logs. */
  readonly tokenKey: string;
  lastUsedMs: number;
}

/** In whose name a page calls, and in which tenant. */
export interface Caller {
  readonly token: string;
  /** Empty: the token's own. */
  readonly tenant: string;
  /** Equal for equal callers, as `tokenKey`. */
  readonly key: string;
}

/** `tenant` as the page names it; the server decides whether the token may enter it. */
export function callerOf({ token, tokenKey }: Login, tenant: string): Caller {
  if (!TENANT.test(tenant)) {
    throw new RequestError(status.INVALID_ARGUMENT, "a tenant has a-z, 0-9, '-' and '_'");
  }
  return { token, tenant, key: `${tokenKey}/${tenant}` };
}

/** What a header may carry of the names that servers take. */
const TENANT = /^[a-z0-9_-]{0,200}$/;
const MAX_LOGIN_COUNT = 1_000;

const sha256 = (text: string): string => createHash("sha256").update(text).digest("hex");

/**
 * The sign-ins. A browser holds 256 random bits in a cookie that scripts cannot read; here only the
 * hash of them is kept. When there are too many, the one that was idle for longest is forgotten.
 */
export class Logins {
  private readonly logins = new Map<string, Login>();

  constructor(
    private readonly idleMs: number,
    private readonly now: () => number = Date.now,
  ) {}

  /** The cookie's value. */
  add(token: string): string {
    this.forgetIdle();
    if (this.logins.size >= MAX_LOGIN_COUNT) this.forgetLeastUsed();
    const secret = randomBytes(32).toString("base64url");
    const tokenKey = sha256(token).slice(0, 16);
    this.logins.set(sha256(secret), { token, tokenKey, lastUsedMs: this.now() });
    return secret;
  }

  find(secret: string | undefined): Login | undefined {
    if (secret === undefined || secret.length > 100) return undefined;
    const key = sha256(secret);
    const login = this.logins.get(key);
    if (login === undefined) return undefined;
    if (this.now() - login.lastUsedMs > this.idleMs) {
      this.logins.delete(key);
      return undefined;
    }
    login.lastUsedMs = this.now();
    return login;
  }

  remove(secret: string | undefined): void {
    if (secret !== undefined) this.logins.delete(sha256(secret));
  }

  get size(): number {
    return this.logins.size;
  }

  private forgetIdle(): void {
    for (const [key, login] of this.logins) {
      if (this.now() - login.lastUsedMs > this.idleMs) this.logins.delete(key);
    }
  }

  private forgetLeastUsed(): void {
    let oldest: [string, Login] | undefined;
    for (const entry of this.logins) {
      if (oldest === undefined || entry[1].lastUsedMs < oldest[1].lastUsedMs) oldest = entry;
    }
    if (oldest) this.logins.delete(oldest[0]);
  }
}
