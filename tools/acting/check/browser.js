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
import { beginDaemon } from "./daemon.js";
import { handover } from "./handover.js";
import { headsetTake } from "./headset.js";
import { https } from "./https.js";
import { mouseTake } from "./mouse.js";
import { pictures } from "./pictures.js";
import { rooms } from "./rooms.js";
import { times } from "./times.js";

const home = dirname(dirname(fileURLToPath(import.meta.url)));
const root = dirname(dirname(home));
const [enact, executablePath, folder, ...wanted] = process.argv.slice(2);
const PARTS = { mouse: mouseTake, headset: headsetTake, rooms, handover, https, pictures, calibration, times };
/** Those that run where none is asked for. */
const USUAL = ["mouse", "headset", "rooms", "handover", "https", "pictures", "calibration"];

const BALL = join(root, "config/ball.toml");
/** Begins a daemon whose files go into a folder of that name. */
const begin = (name, scene = BALL, options = []) =>
  beginDaemon({ enact, page: join(home, "dist/acting.html"), folder: join(folder, name) }, scene, options);

const begun = await begin("");
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
      for (const line of await part({ browser, daemon: begun, folder, home, enact, begin })) console.log(`${name}: ${line}`);
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
