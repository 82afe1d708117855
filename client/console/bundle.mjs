// Bundles the bridge, the page and, with --tests, the tests. Called by build.
import { createHash } from "node:crypto";
import { mkdirSync, readFileSync, readdirSync, rmSync, writeFileSync } from "node:fs";
import { createRequire } from "node:module";
import { basename, extname, join } from "node:path";
import { brotliCompressSync } from "node:zlib";

const [root, out, ...flags] = process.argv.slice(2);
const { build } = createRequire(join(out, "package.json"))("esbuild");
const here = join(root, "client/console");

const shared = {
  bundle: true,
  preserveSymlinks: true,
  nodePaths: [join(out, "node_modules")],
  alias: { proto: join(out, "proto") },
  tsconfigRaw: { compilerOptions: { jsx: "react-jsx", jsxImportSource: "preact" } },
  legalComments: "none",
  logLevel: "warning",
};
const node = { ...shared, platform: "node", target: "node18", format: "cjs" };

async function buildBridge(folder) {
  await build({
    ...node,
    entryPoints: [join(here, "bridge/main.ts")],
    outfile: join(folder, "dcloc-console.cjs"),
    banner: { js: "#!/usr/bin/env node" },
    minifySyntax: true,
  });
}

/** Names files by their content, so that browsers may keep them for ever, and compresses them. */
async function buildPage(folder) {
  rmSync(folder, { recursive: true, force: true });
  mkdirSync(folder, { recursive: true });
  const browser = {
    ...shared,
    outdir: folder,
    assetNames: "[name]-[hash]",
    loader: { ".woff2": "file" },
    platform: "browser",
    target: ["chrome110", "firefox115", "safari16.4"],
    format: "esm",
    minify: true,
    metafile: true,
  };
  const outputsOf = ({ metafile }) => Object.keys(metafile.outputs).map((path) => basename(path));
  const worker = await build({
    ...browser,
    entryPoints: [join(here, "page/map/tile_worker.ts")],
    entryNames: "tile_worker-[hash]",
  });
  const outputs = outputsOf(
    await build({
      ...browser,
      entryPoints: [join(here, "page/main.tsx")],
      entryNames: "console-[hash]",
      define: { TILE_WORKER: JSON.stringify(`/${outputsOf(worker)[0]}`) },
    }),
  );
  const named = (extension) => outputs.find((name) => extname(name) === extension);
  const icon = readFileSync(join(here, "page/icon.svg"));
  const iconName = `icon-${createHash("sha256").update(icon).digest("hex").slice(0, 8)}.svg`;
  writeFileSync(join(folder, iconName), icon);
  const html = readFileSync(join(here, "page/index.html"), "utf8")
    .replace("CONSOLE.css", `/${named(".css")}`)
    .replace("CONSOLE.js", `/${named(".js")}`)
    .replace("ICON.svg", `/${iconName}`);
  writeFileSync(join(folder, "index.html"), html);
  let size = 0;
  for (const name of readdirSync(folder)) {
    const plain = readFileSync(join(folder, name));
    if (extname(name) !== ".woff2") {
      const small = brotliCompressSync(plain);
      writeFileSync(join(folder, `${name}.br`), small);
      size += small.length;
    } else {
      size += plain.length;
    }
  }
  console.log(`page: ${Math.round(size / 1000)} kB compressed`);
}

async function buildTests(folder) {
  const source = join(root, "tests/client/console");
  rmSync(folder, { recursive: true, force: true });
  const tests = readdirSync(source, { recursive: true }).filter((name) => /(_test|measure\/(goals|fleet_server)|pictures\/pictures)\.ts$/.test(name));
  await build({
    ...node,
    entryPoints: tests.filter((n) => !n.startsWith("node_modules")).map((n) => join(source, n)),
    outdir: folder,
    outbase: source,
    outExtension: { ".js": ".cjs" },
    external: ["playwright-core", "axe-core"],
    sourcemap: "inline",
  });
}

await buildBridge(join(out, "dist"));
await buildPage(join(out, "dist/page"));
if (flags.includes("--tests")) await buildTests(join(out, "tests"));
