// Bundles the page's modules and styles into nao_kin/viewer/page; with --check, only compares them with the committed ones.
// With --node, a file and modules, bundles the modules (the tests) into the file for Node.js, which may not run TypeScript. One
// file for all, because Node.js starts a process for each.
import { readFile, writeFile } from "node:fs/promises";
import path from "node:path";
import { fileURLToPath } from "node:url";

import { build } from "esbuild";

const HERE = path.dirname(fileURLToPath(import.meta.url));
const TARGET = path.join(HERE, "..", "nao_kin", "viewer", "page");

async function buildPage() {
  const common = {
    absWorkingDir: HERE,
    outdir: TARGET,
    bundle: true,
    charset: "utf8",
    legalComments: "inline",
    minify: true,
    target: "es2022",
    write: false,
  };
  const built = await Promise.all([
    build({ ...common, entryPoints: { page: "src/main.ts", loader: "src/loader.ts" }, format: "iife" }),
    build({ ...common, entryPoints: { bridge: "src/notebook/bridge.ts" }, format: "esm" }),
  ]);
  const stale = [];
  for (const { path: file, text } of built.flatMap(({ outputFiles }) => outputFiles)) {
    if (!process.argv.includes("--check")) await writeFile(file, text);
    else if ((await readFile(file, "utf8").catch(() => "")) !== text) stale.push(path.basename(file));
  }
  if (stale.length > 0) {
    console.error(`out of step with web/src: ${stale.join(", ")}; run npm run build in web/`);
    process.exitCode = 1;
  }
}

const [option, outfile, ...modules] = process.argv.slice(2);
if (option === "--node") {
  const contents = modules.map((file) => `import ${JSON.stringify(path.resolve(file))};`).join("\n");
  const stdin = { contents, resolveDir: HERE };
  await build({ stdin, outfile, bundle: true, platform: "node", format: "esm", external: ["esbuild"] });
} else await buildPage();
