// Daemons that the check begins, and what they say.
import { spawn } from "node:child_process";
import { mkdir, writeFile } from "node:fs/promises";
import { join } from "node:path";

let count = 0;

/**
 * Begins a daemon with an iceoryx2 of its own, which waits for takes.
 * @param {{ enact: string, page: string, folder: string }} of program, acting page, and where its files go
 * @param {string} scene
 * @param {string[]} options further ones
 */
export async function beginDaemon({ enact, page, folder }, scene, options = []) {
  await mkdir(join(folder, "takes"), { recursive: true });
  count += 1;
  const iceoryx2 = join(folder, "iceoryx2.toml");
  const prefix = `enact_acting_${process.pid}_${count}_`;
  await writeFile(iceoryx2, `[global]\nroot-path = "${folder}/iceoryx2/"\nprefix = "${prefix}"\n`);
  const child = spawn(enact, [
    "capture", scene, `--acting=${page}`, "--metrics-port", "0", "-o", join(folder, "takes"),
    "--iceoryx2", iceoryx2, "--format", "ndjson", ...options,
  ], {
    stdio: ["ignore", "pipe", "inherit"],
    // A certificate is made there, and the user's own is left alone.
    env: { ...process.env, XDG_DATA_HOME: join(folder, "data") },
  });
  const said = [];
  const waiting = [];
  let rest = "";
  child.stdout.on("data", (part) => {
    const lines = (rest + part).split("\n");
    rest = lines.pop();
    said.push(...lines.filter((line) => line).map((line) => JSON.parse(line)));
    for (const look of waiting) look();
  });
  /** The first thing said that is so. */
  const wait = (what, isSo = () => true) => new Promise((done, fail) => {
    const timer = setTimeout(() => fail(new Error(
      `nothing said: ${what}, but ${said.slice(-3).map((of) => JSON.stringify(of).slice(0, 400)).join("; ")}`)), 60_000);
    const look = () => {
      const found = said.find((of) => of.what === what && isSo(of));
      if (found) { clearTimeout(timer); done(found); }
    };
    waiting.push(look);
    look();
  });
  /** Ends it; its exit code. */
  const end = () => new Promise((done) => {
    if (child.exitCode !== null) return done(child.exitCode);
    child.on("exit", (code) => done(code));
    child.kill("SIGTERM");
  });
  const ready = await wait("ready");
  return { ready, said, wait, end };
}
