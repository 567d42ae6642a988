// The headset path: iwer plays a recorded controller session, a throw with its buttons, through the page.
import { join } from "node:path";
import { EYES, ahead, emulates, enter, leave } from "./emulated.js";
import { SMALL, accountOf, acting, assert, isPhysical, verdictOf, wellTaken } from "./page.js";
import { SLOW, throwFrom } from "./throws.js";

/** Frames a second of the recording, and what its numbers are rounded to, as iwer's recorder does. */
const RATE_HZ = 90;
const rounded = (value) => Math.round(value * 1000) / 1000;

const START = { x: -0.2, z: 0.45 };

/** Time before the motion, between its end and the grip, and after that [s]. */
const BEFORE_S = 1;
const AFTER_S = 0.25;
const REST_S = 30;

/** A session as iwer's recorder writes it: a controller in the right hand with trigger and grip. */
function recorded() {
  const { fallS, endS, place } = throwFrom(START);
  const overS = BEFORE_S + SLOW * endS;
  const pressed = { grip: [0.5, overS + AFTER_S], trigger: [BEFORE_S + SLOW * fallS, overS] };
  const frames = [];
  const count = Math.ceil((overS + AFTER_S + 1) * RATE_HZ);
  for (let frame = 0; frame <= count; frame += 1) {
    // The last one stays.
    const time = frame === count ? overS + REST_S : frame / RATE_HZ;
    const { x, z } = place(Math.min(endS, Math.max(0, (time - BEFORE_S) / SLOW)));
    // A hand wavers by a few millimetres.
    const waver = 0.003 * Math.sin(2 * Math.PI * 0.9 * time + 1);
    const pose = [...ahead({ x: x + waver, y: 0.4 * waver, z: z + 0.7 * waver }), 0, 0.0349, 0, 0.9994].map(rounded);
    const button = (times) => (times.some((at) => time >= at && time < at + 0.12) ? [1, 1, 1] : [0, 0, 0]);
    frames.push([
      rounded(1000 * time), ...EYES, 0, 0, 0, 1,
      [0, ...pose, pose, [button(pressed.trigger), button(pressed.grip), 0, 0]],
    ]);
  }
  const schema = {
    handedness: "right", targetRayMode: "tracked-pointer", profiles: ["oculus-touch-v3"],
    hasGrip: true, hasHand: false, hasGamepad: true, mapping: "xr-standard", numButtons: 2, numAxes: 2,
  };
  return { schema: [[0, schema]], frames };
}

/** One take; what came of it. */
export async function actByHeadset({ browser, daemon, folder, home }) {
  const { context, page, errors } = await acting(browser, daemon, SMALL, emulates(home));
  await enter(page, "immersive-vr");
  const before = daemon.said.length;
  await page.evaluate((recording) => {
    const { headset, space } = window.enactRoom();
    const player = window.emulated.createActionPlayer(space, recording);
    player.setEventContext({ session: headset.session, getFrame: () => window.enactRoom().headset.frame });
    player.play();
  }, recorded());
  const { take } = await daemon.wait("started", (of) => daemon.said.indexOf(of) >= before);
  const closed = await daemon.wait("closed", (of) => of.take === take);
  wellTaken(closed);
  const estimated = await daemon.wait("estimated", (of) => of.take === take);
  const came = await verdictOf(page, take);
  await page.waitForTimeout(300);
  const path = join(folder, "headset.png");
  await page.screenshot({ path });
  await leave(page);
  assert.deepEqual(errors, []);
  await context.close();
  return { take, closed, estimated, ...came, path };
}

export async function headsetTake(how) {
  const came = await actByHeadset(how);
  assert.ok(isPhysical(came), came.said);
  return [...accountOf(came), came.path];
}
