// The mouse path: a ball is dragged onto the table, bounces and is put into a bowl, by pointer events and keys.
import { acting, assert, verdictOf } from "./page.js";

/** How much slower than it would happen it is acted. */
const SLOW = 3;

const GRAVITY_M_S2 = 9.81;
const RADIUS_M = 0.03;
const RESTITUTION = 0.8;
const BOWL = { x: 0.15, z: 0.05 };

/** Where a ball that is let go there is after so long: the throw that ends in the bowl. */
function ballistic(start) {
  const fallS = Math.sqrt((2 * (start.z - RADIUS_M)) / GRAVITY_M_S2);
  const up = RESTITUTION * GRAVITY_M_S2 * fallS;
  const flyS = (up + Math.sqrt(up * up - 2 * GRAVITY_M_S2 * (BOWL.z - RADIUS_M))) / GRAVITY_M_S2;
  const across = (BOWL.x - start.x) / (fallS + flyS);
  const place = (time) => {
    const after = time - fallS;
    const z = after < 0
      ? start.z - 0.5 * GRAVITY_M_S2 * time * time
      : RADIUS_M + up * after - 0.5 * GRAVITY_M_S2 * after * after;
    return { x: start.x + across * time, z };
  };
  return { fallS, endS: fallS + flyS, place };
}

export async function mouseTake({ browser, daemon }) {
  const { context, page, errors } = await acting(browser, daemon);
  const seen = await page.evaluate(() => window.enactSeenAt());
  const start = await page.evaluate(() => window.enactBody());
  const { fallS, endS, place } = ballistic(start);
  await page.mouse.move(seen.x, seen.y);
  await page.mouse.down();
  await page.waitForTimeout(200);
  await page.keyboard.press("Enter");
  const { take } = await daemon.wait("started");
  await page.waitForFunction(() => document.querySelector("#record").textContent === "Stop");
  const begun = Date.now();
  let isMarked = false;
  for (let time = 0; time < endS; ) {
    time = Math.min(endS, (Date.now() - begun) / 1000 / SLOW);
    const { x, z } = place(time);
    await page.mouse.move(seen.x + start.pixelsPerMetre * (x - start.x), seen.y - start.pixelsPerMetre * (z - start.z));
    if (!isMarked && time > fallS + 0.01) {
      isMarked = true;
      await page.keyboard.press("Space");
    }
    await page.waitForTimeout(4);
  }
  await page.waitForTimeout(60);
  await page.keyboard.press("Space");
  await page.waitForTimeout(60);
  await page.keyboard.press("Enter");
  const closed = await daemon.wait("closed", (of) => of.take === take);
  await page.mouse.up();
  const tracker = closed.counts.trackers[0];
  assert.equal(closed.counts.marks.received, 2);
  assert.equal(tracker.counts.missing, 0);
  assert.equal(tracker.clock.source, "device");
  const estimated = await daemon.wait("estimated", (of) => of.take === take);
  const { said, verdictMs, motionMs } = await verdictOf(page, take);
  assert.deepEqual(errors, []);
  await context.close();
  return [
    `take ${take}: ${tracker.counts.received} samples, ${closed.counts.marks.received} marks, none missing`,
    `the daemon says ${estimated.report.verdict ?? estimated.report.estimate?.verdict}; the page says: ${said}`,
    `verdict ${verdictMs} ms, motion ${motionMs} ms after the end`,
  ];
}
