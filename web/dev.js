// Runs `nao-kin view`, and after each change of src writes the bundle and starts it again: an open page, which finds that its
// program has another version, reloads by itself. Options after -- are passed on: npm run dev -- --nao v5 --posture Sit
import { spawn, spawnSync } from "node:child_process";
import { existsSync, watch } from "node:fs";
import path from "node:path";
import { fileURLToPath } from "node:url";

const HERE = path.dirname(fileURLToPath(import.meta.url));
const ROOT = path.join(HERE, "..");
const own = path.join(ROOT, ".venv", "bin", "python");
const python = existsSync(own) ? own : "python3";
// The page finds the program again by its port.
const call = ["-m", "nao_kin", "view", "--port", "7020", ...process.argv.slice(2)];

const bundle = () => spawnSync("node", ["build.js"], { cwd: HERE, stdio: "inherit" }).status === 0;
const start = () => spawn(python, call, { cwd: ROOT, stdio: "inherit" });

bundle();
let program = start();
let waiting;
watch(path.join(HERE, "src"), { recursive: true }, () => {
  clearTimeout(waiting);
  // An editor writes a file in several steps. After an error the program goes on as it is.
  waiting = setTimeout(() => {
    if (!bundle()) return;
    const old = program;
    old.once("exit", () => (program = start()));
    old.kill();
  }, 100);
});
process.on("SIGINT", () => process.exit());
process.on("exit", () => program.kill());
