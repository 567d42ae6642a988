// All steps of a calibration by a controller that iwer emulates, on a pen whose mount and whose table are known:
// through page, WebSocket and daemon to the scene with what was found.
import { readFile, writeFile } from "node:fs/promises";
import { join } from "node:path";
import { Quaternion, Vector3 } from "three";
import { emulates, enter, leave, onFloor, play } from "./emulated.js";
import { SMALL, acting, assert } from "./page.js";
import {
  MARKS_S, MOUNT, SCENE, TABLE, TOUCHES_S, disturbed, noise, standing, swinging, touching, trackerOn,
} from "./pen.js";

const RATE_HZ = 250;

/** How long it is performed before the take begins and after it ends [s]. */
const ABOUT_S = 0.5;

/** How far what is found may be off. */
const MOST = { mountDeg: 0.05, mountMm: 0.15, tableDeg: 0.05, tableMm: 0.15 };

/** From the scene's world, z up, to that of the room, y up. */
const Y_UP = new Quaternion().setFromAxisAngle(new Vector3(1, 0, 0), -Math.PI / 2);

/** A controller that performs a motion of the pen, with a take about it. */
function scripted(motion, spanS, marksS, draw) {
  const poses = [];
  for (let timeS = -ABOUT_S; timeS < spanS + ABOUT_S; timeS += 1 / RATE_HZ) {
    const { position, turn } = disturbed(trackerOn(motion(Math.min(spanS, Math.max(0, timeS)))), draw);
    const inRoom = Y_UP.clone().multiply(turn);
    poses.push([1000 * (timeS + ABOUT_S), ...onFloor(position), ...inRoom.toArray()]);
  }
  const ms = (timeS) => 1000 * (timeS + ABOUT_S);
  return { poses, select: marksS.map(ms), squeeze: [ms(0), ms(spanS)] };
}

/** The numbers of a key. */
function numbers(toml, key) {
  const [, list] = toml.match(new RegExp(`${key} = \\[([^\\]]*)\\]`)) ?? assert.fail(`no ${key} in ${toml}`);
  return list.split(",").map(Number);
}

const degrees = (rad) => (180 / Math.PI) * rad;

export async function calibrating({ browser, begin, folder, home }) {
  const scene = join(folder, "pen.toml");
  await writeFile(scene, SCENE);
  const daemon = await begin("calibrating", scene);
  const { context, page, errors } = await acting(browser, daemon, SMALL, emulates(home));
  const draw = noise(7301);
  await page.evaluate(() => { window.emulated.controllers.left.connected = false; });
  await page.click("#calibrate");
  await page.selectOption("#place", "room");
  await enter(page, "immersive-vr");

  const step = async (name, motion, spanS, { stands, marksS = [] }) => {
    await page.selectOption("#step", name);
    if (stands) await page.selectOption("#stands", stands);
    await page.evaluate(() => delete document.body.dataset.calibrated);
    const before = daemon.said.length;
    await play(page, { with: "controller", right: scripted(motion, spanS, marksS, draw) });
    const { take } = await daemon.wait("started", (of) => daemon.said.indexOf(of) >= before);
    await daemon.wait("discarded", (of) => of.take === take);
    await page.waitForSelector(`body[data-calibrated=${name}]`, { state: "attached" });
    assert.deepEqual(await page.$$eval("#found .against", (all) => all.map((line) => line.textContent)), []);
    const [, made] = (await page.textContent("#files")).match(/the whole scene with it: (.*)$/) ?? [];
    assert.ok(made, "no scene with what was found");
    return { keys: await page.inputValue("#keys"), made };
  };
  await step("rest", standing(new Vector3(0, 0, 1)), 8, { stands: "+z" });
  await step("rest", standing(new Vector3(1, 0, 0)), 8, { stands: "+x" });
  await step("pivot", swinging, 12, {});
  const { keys, made } = await step("plane", touching, TOUCHES_S, { marksS: MARKS_S });
  const toml = await readFile(made, "utf8");
  await leave(page);
  assert.deepEqual(errors, []);
  await context.close();
  assert.equal(await readFile(scene, "utf8"), SCENE);

  const [w, x, y, z] = numbers(toml, "orientation_wxyz");
  const mountDeg = degrees(new Quaternion(x, y, z, w).angleTo(MOUNT.turn));
  const mountMm = 1000 * MOUNT.position.distanceTo(new Vector3(...numbers(toml, "position_mm")).divideScalar(1000));
  const normal = new Vector3(...numbers(keys, "normal"));
  const tableDeg = degrees(normal.angleTo(TABLE.normal));
  const point = new Vector3(...numbers(keys, "point_mm")).divideScalar(1000);
  const tableMm = 1000 * Math.abs(point.sub(new Vector3(0, 0, TABLE.heightM)).dot(TABLE.normal));
  for (const [name, off] of Object.entries({ mountDeg, mountMm, tableDeg, tableMm })) {
    assert.ok(off < MOST[name], `${name} is off by ${off}`);
  }
  // A daemon takes it.
  await begin("calibrated", made);
  const short = (number) => number.toPrecision(2);
  return [
    `the mount is off by ${short(mountDeg)}° and ${short(mountMm)} mm`,
    `the table is off by ${short(tableDeg)}° and ${short(tableMm)} mm`,
  ];
}
