// Acts in a browser as a person would, and looks at what comes of it: pages, WebSocket, daemon, recording, estimate and
// back. Says what was measured, and fails where something is not as it should be.
//
//     node check/browser.js ENACT CHROMIUM FOLDER [PART...]
//
// ENACT is the program with live takes, FOLDER gets recordings and pictures.
import { dirname, join } from "node:path";
import { fileURLToPath } from "node:url";
import { chromium } from "playwright-core";
import { calibration } from "./calibration.js";
import { calibrating } from "./calibrating.js";
import { beginDaemon } from "./daemon.js";
import { handover } from "./handover.js";
import { headsetTake } from "./headset.js";
import { https } from "./https.js";
import { late } from "./late.js";
import { mouseTake } from "./mouse.js";
import { pictures } from "./pictures.js";
import { rooms } from "./rooms.js";
import { times } from "./times.js";

const home = dirname(dirname(fileURLToPath(import.meta.url)));
const root = dirname(dirname(home));
const [enact, executablePath, folder, ...wanted] = process.argv.slice(2);
const PARTS = {
  mouse: mouseTake, headset: headsetTake, late, rooms, handover, https, pictures, calibration, calibrating, times,
};
/** Those that run where none is asked for. */
const USUAL = Object.keys(PARTS).filter((name) => name !== "times");

const BALL = join(root, "config/ball.toml");
const daemons = [];
/** Begins a daemon whose files go into a folder of that name; it is ended in the end. */
async function begin(name, scene = BALL, options = []) {
  const daemon = await beginDaemon(
    { enact, page: join(home, "dist/acting.html"), folder: join(folder, name) }, scene, options);
  daemons.push(daemon);
  return daemon;
}

const daemon = await begin("");
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
      for (const line of await part({ browser, daemon, folder, home, enact, begin })) console.log(`${name}: ${line}`);
    } catch (error) {
      failed += 1;
      console.log(`${name}: FAILED: ${error.stack}`);
    }
  }
} finally {
  await browser.close();
  for (const { end } of daemons) {
    const code = await end();
    if (code === 0) continue;
    failed += 1;
    console.log(`a daemon ended with ${code}`);
  }
}
process.exit(failed === 0 ? 0 : 1);
