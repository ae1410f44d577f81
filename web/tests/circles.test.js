import assert from "node:assert/strict";
import path from "node:path";
import test from "node:test";
import { build } from "esbuild";

/** The modules that each module of the page imports at run time; type imports are not in the bundle. */
async function importsOf(...entryPoints) {
  const bundled = {
    entryPoints,
    bundle: true,
    write: false,
    metafile: true,
    outdir: "build",
    logLevel: "silent",
  };
  const { metafile } = await build(bundled);
  const modules = Object.entries(metafile.inputs);
  return new Map(modules.map(([file, { imports }]) => [file, imports.map((one) => one.path)]));
}

/** The modules that import themselves through others, each with the modules of the shortest way round. */
function circles(imports) {
  return [...imports.keys()].flatMap((module) => {
    const ways = [[module]];
    const seen = new Set();
    for (const way of ways) {
      for (const next of imports.get(way.at(-1)) ?? []) {
        if (next === module) return [[...way, module].map((file) => path.basename(file)).join(" → ")];
        if (!seen.has(next)) ways.push([...way, next]);
        seen.add(next);
      }
    }
    return [];
  });
}

test("no module of the page imports itself at run time, directly or through others", async () => {
  const imports = await importsOf("src/main.ts", "src/notebook/bridge.ts");
  assert.ok(imports.has("src/app.ts"));
  assert.deepEqual(circles(imports), []);
});
