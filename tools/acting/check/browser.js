// Acts in a browser as a person would, and looks at what comes of it: pages, WebSocket, daemon, recording, estimate and
// back. Says what was measured, and fails where something is not as it should be.
//
//     node check/browser.js ENACT CHROMIUM FOLDER [PART...]
//
// ENACT is the program with live takes, FOLDER gets recordings and pictures.
import { spawn } from "node:child_process";
import { mkdir, writeFile } from "node:fs/promises";
import { dirname, join } from "node:path";
import { fileURLToPath } from "node:url";
import { chromium } from "playwright-core";
import { calibration } from "./calibration.js";
import { headsetTake } from "./headset.js";
import { mouseTake } from "./mouse.js";
import { pictures } from "./pictures.js";
import { times } from "./times.js";

const home = dirname(dirname(fileURLToPath(import.meta.url)));
const root = dirname(dirname(home));
const [enact, executablePath, folder, ...wanted] = process.argv.slice(2);
const PARTS = { mouse: mouseTake, headset: headsetTake, pictures, calibration, times };
/** Those that run where none is asked for. */
const USUAL = ["mouse", "headset", "pictures", "calibration"];

/** A daemon with an iceoryx2 of its own, and what it says. */
async function daemon() {
  await mkdir(join(folder, "takes"), { recursive: true });
  const iceoryx2 = join(folder, "iceoryx2.toml");
  const prefix = `enact_acting_${process.pid}_`;
  await writeFile(iceoryx2, `[global]\nroot-path = "${folder}/iceoryx2/"\nprefix = "${prefix}"\n`);
  const child = spawn(enact, [
    "capture", join(root, "config/ball.toml"), `--acting=${join(home, "dist/acting.html")}`, "--metrics-port", "0",
    "-o", join(folder, "takes"), "--iceoryx2", iceoryx2, "--format", "ndjson",
  ], { stdio: ["ignore", "pipe", "inherit"] });
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
    const timer = setTimeout(() => fail(new Error(`nothing said: ${what}`)), 60_000);
    const look = () => {
      const found = said.find((of) => of.what === what && isSo(of));
      if (found) { clearTimeout(timer); done(found); }
    };
    waiting.push(look);
    look();
  });
  const ready = await wait("ready");
  const end = () => new Promise((done) => {
    child.on("exit", (code) => done(code));
    child.kill("SIGTERM");
  });
  return { ready, said, wait, end };
}

const begun = await daemon();
const browser = await chromium.launch({
  executablePath,
  args: ["--headless", "--no-sandbox", "--disable-quic", "--no-first-run", "--disable-background-networking",
    "--disable-component-update", "--disable-sync", "--use-gl=angle", "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader"],
});
let failed = 0;
try {
  for (const [name, part] of Object.entries(PARTS)) {
    if (!(wanted.length > 0 ? wanted : USUAL).includes(name)) continue;
    try {
      for (const line of await part({ browser, daemon: begun, folder, home, enact })) console.log(`${name}: ${line}`);
    } catch (error) {
      failed += 1;
      console.log(`${name}: FAILED: ${error.stack}`);
    }
  }
} finally {
  await browser.close();
  const code = await begun.end();
  if (code !== 0) {
    failed += 1;
    console.log(`the daemon ended with ${code}`);
  }
}
process.exit(failed === 0 ? 0 : 1);
