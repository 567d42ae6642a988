// The mouse path: a ball is dragged onto the table, bounces and is put into a bowl, by pointer events and keys.
import { accountOf, acting, assert, verdictOf } from "./page.js";
import { SLOW, throwFrom } from "./throws.js";

/** One take; what came of it. */
export async function actByMouse({ browser, daemon }) {
  const { context, page, errors } = await acting(browser, daemon);
  const seen = await page.evaluate(() => window.enactSeenAt());
  const start = await page.evaluate(() => window.enactBody());
  const { fallS, endS, place } = throwFrom(start);
  await page.mouse.move(seen.x, seen.y);
  await page.mouse.down();
  await page.waitForTimeout(200);
  const before = daemon.said.length;
  await page.keyboard.press("Enter");
  const { take } = await daemon.wait("started", (of) => daemon.said.indexOf(of) >= before);
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
  assert.equal(estimated.report.verdict, "physical");
  const came = await verdictOf(page, take);
  assert.deepEqual(errors, []);
  await context.close();
  return { take, closed, estimated, ...came };
}

export const mouseTake = async (how) => accountOf(await actByMouse(how));
