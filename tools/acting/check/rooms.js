// Hands in virtual reality and a phone in augmented reality, as iwer emulates them: a throw by a wrist with pinches,
// and by a phone with taps, through the page and back.
import { join } from "node:path";
import { ahead, drawn, emulates, enter, leave, play } from "./emulated.js";
import { SMALL, accountOf, acting, assert, isPhysical, readingsOf, verdictOf, wellTaken } from "./page.js";
import { SLOW, throwFrom } from "./throws.js";

const START = { x: -0.2, z: 0.45 };
const RATE_HZ = 250;

/** When the take begins, the motion begins, and how long after its end the take ends [ms]. */
const BEGIN_MS = 500;
const BEFORE_MS = 1000;
const AFTER_MS = 250;

/** How far a reading may be from where it was put, between poses that are given every few milliseconds [m]. */
const NEAR_M = 0.005;

/** The throw, slowly, with the take about it. */
function scripted() {
  const { fallS, endS, place } = throwFrom(START);
  const overMs = BEFORE_MS + 1000 * SLOW * endS;
  /** Where it is in the scene. */
  const placeAt = (ms) => {
    const { x, z } = place(Math.min(endS, Math.max(0, (ms - BEFORE_MS) / 1000 / SLOW)));
    // A hand wavers by a few millimetres.
    const waver = 0.003 * Math.sin((2 * Math.PI * 0.9 * ms) / 1000 + 1);
    return { x: x + waver, y: 0.4 * waver, z: z + 0.7 * waver };
  };
  const poses = [];
  for (let ms = 0; ms <= overMs + 1000; ms += 1000 / RATE_HZ) {
    poses.push([ms, ...ahead(placeAt(ms)), 0, 0.0349, 0, 0.9994]);
  }
  return { placeAt, poses, marks: [BEFORE_MS + 1000 * SLOW * fallS, overMs], endMs: overMs + AFTER_MS };
}

/** Looks whether what was sent was where it had been put so many frames before. */
function isWhereItWasPut(readings, { placeAt, endMs }, begunMs, frames) {
  const during = readings.map(({ atMs, place }) => ({ ms: atMs - begunMs, place }))
    .filter(({ ms }) => ms > 0 && ms < endMs);
  assert.ok(during.length > 50, `${during.length} readings`);
  for (let number = frames + 1; number < during.length; number += 1) {
    const { x, y, z } = placeAt(during[number - frames].ms);
    const [atX, atY, atZ] = during[number].place;
    const off = Math.hypot(atX - x, atY - y, atZ - z);
    assert.ok(off < NEAR_M, `at ${during[number].ms} ms a reading is off by ${off} m`);
  }
}

/** Looks at a take that goes on, until its motion is shown. */
async function came({ daemon }, page, before, name) {
  const { take } = await daemon.wait("started", (of) => daemon.said.indexOf(of) >= before);
  const closed = await daemon.wait("closed", (of) => of.take === take);
  const { received, invalid } = wellTaken(closed);
  assert.ok(received > 50, `${received} samples`);
  assert.equal(invalid, 0);
  const estimated = await daemon.wait("estimated", (of) => of.take === take);
  const all = { take, closed, estimated, ...(await verdictOf(page, take)) };
  assert.ok(isPhysical(all), all.said);
  return accountOf(all).map((line) => `${name}: ${line}`);
}

/** A page with an emulated headset, and what it sends. */
async function emulated({ browser, daemon, home }) {
  let readings;
  const prepare = async (page) => {
    readings = readingsOf(page);
    await emulates(home)(page);
  };
  return { ...(await acting(browser, daemon, SMALL, prepare)), readings };
}

async function byHands(how) {
  const { context, page, errors, readings } = await emulated(how);
  await page.evaluate(() => { window.emulated.primaryInputMode = "hand"; });
  await enter(page, "immersive-vr");
  const { through } = await drawn(page);
  assert.equal(through, 0, "the room is seen in virtual reality");
  const script = scripted();
  const { poses, marks, endMs } = script;
  const before = how.daemon.said.length;
  // The right hand acts and marks, the left one begins and ends the take.
  const left = { poses: [[0, -0.3, 1.2, -0.4, 0, 0, 0, 1]], select: [BEGIN_MS, endMs] };
  const begunMs = await play(page, { with: "hand", left, right: { poses, select: marks } });
  const lines = await came(how, page, before, "hands");
  isWhereItWasPut(readings, script, begunMs, 0);
  await leave(page);
  assert.deepEqual(errors, []);
  await context.close();
  return lines;
}

async function byPhone(how) {
  const { context, page, errors, readings } = await emulated(how);
  await page.evaluate(() => {
    for (const controller of Object.values(window.emulated.controllers)) controller.connected = false;
  });
  await enter(page, "immersive-ar");
  const { through, opaque } = await drawn(page);
  assert.ok(through > 0.3, `the room is seen in ${through} of the picture`);
  assert.ok(opaque > 0.01, `the scene is drawn in ${opaque} of the picture`);
  const script = scripted();
  const { poses, marks, endMs } = script;
  const before = how.daemon.said.length;
  const begunMs = await play(page, { with: "phone", phone: { poses, select: marks } });
  const begun = Date.now();
  await page.waitForTimeout(BEGIN_MS);
  // The page's buttons lie over the room on a phone, which iwer does not emulate.
  await page.dispatchEvent("#record", "click");
  await page.waitForTimeout(begun + endMs - Date.now());
  await page.dispatchEvent("#record", "click");
  const lines = await came(how, page, before, "phone");
  isWhereItWasPut(readings, script, begunMs, 1);
  const path = join(how.folder, "phone.png");
  await page.screenshot({ path });
  await leave(page);
  assert.deepEqual(errors, []);
  await context.close();
  return [...lines, `phone: the room is seen in ${Math.round(100 * through)} % of the picture`, path];
}

export async function rooms(how) {
  return [...(await byHands(how)), ...(await byPhone(how))];
}
