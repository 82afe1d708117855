import assert from "node:assert/strict";
import { test } from "node:test";
import { UsageError, parseOptions } from "../../../../client/console/bridge/options.ts";

const refusal = (...argv: string[]): string => {
  try {
    parseOptions(argv);
  } catch (error) {
    assert.ok(error instanceof UsageError);
    return error.message;
  }
  return "";
};

test("servers get names and keep their order", () => {
  const { servers } = parseOptions(["--server", "127.0.0.1:1", "--server", "b=localhost:2"]);
  assert.deepEqual(servers, [
    { name: "dcloc", address: "127.0.0.1:1" },
    { name: "b", address: "localhost:2" },
  ]);
});

test("what is wrong is named with its value", () => {
  assert.match(refusal(), /--server is missing/);
  assert.match(refusal("--server", "nowhere"), /"nowhere" is not HOST:PORT/);
  assert.match(refusal("--server", "127.0.0.1:70000"), /70000/);
  assert.match(refusal("--server", "A b=127.0.0.1:1"), /name "A b"/);
  assert.match(refusal("--server", "a=127.0.0.1:1", "--server", "a=127.0.0.1:2"), /same name/);
  assert.match(refusal("--server", "127.0.0.1:1", "--idle-hours", "0"), /within \[1, 720\]/);
  assert.match(refusal("--server", "127.0.0.1:1", "--origin", "https://a.example/x"), /no origin|not an origin/);
  assert.match(refusal("--server", "127.0.0.1:1", "--tls-cert", "x"), /belong together/);
  assert.match(refusal("--frobnicate"), /unknown option --frobnicate/);
  assert.match(refusal("--server"), /needs a value/);
});

test("plaintext stays on this machine unless it is asked for", () => {
  assert.match(refusal("--server", "10.0.0.7:50051"), /TLS only/);
  assert.match(refusal("--server", "127.0.0.1:1", "--listen", "0.0.0.0:80"), /not this machine alone/);
  const allowed = ["--server", "10.0.0.7:1", "--listen", "0.0.0.0:80", "--allow-plaintext-off-loopback"];
  assert.equal(parseOptions(allowed).listen.host, "0.0.0.0");
  assert.equal(parseOptions(["--server", "10.0.0.7:1", "--server-ca", "ca.pem"]).serverCa, "ca.pem");
});
