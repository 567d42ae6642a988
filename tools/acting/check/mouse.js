// The mouse path: a ball is dragged onto the table, bounces and is put into a bowl, by pointer events and keys.
import { accountOf, acting, assert, isPhysical, verdictOf, wellTaken } from "./page.js";
import { SLOW, throwFrom } from "./throws.js";

/** Where the pointer stood still for longer than that it was acted badly, by a machine that did something else [ms]. */
const LATE_MS = 100;
const TRIES = 3;

/** So much later than the pointer the ball is there [s]: see src/mouse.js. */
const BEHIND_S = 0.09;

/** One take on a page that is opened so, with what is done before the last mark; what came of it. */
export async function actByMouse({ browser, daemon, open = () => acting(browser, daemon), beforeEnd = () => {} }) {
  const { context, page, errors } = await open();
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
  let [lateMs, movedAt] = [0, begun];
  for (let time = 0; time < endS; ) {
    time = Math.min(endS, (Date.now() - begun) / 1000 / SLOW);
    const { x, z } = place(time);
    // Before the ball is moved on: a slow machine takes a while for each.
    if (!isMarked && time > fallS + BEHIND_S / SLOW) {
      isMarked = true;
      await page.keyboard.press("Space");
    }
    await page.mouse.move(seen.x + start.pixelsPerMetre * (x - start.x), seen.y - start.pixelsPerMetre * (z - start.z));
    lateMs = Math.max(lateMs, Date.now() - movedAt);
    movedAt = Date.now();
    await page.waitForTimeout(4);
  }
  await page.waitForTimeout(60);
  await beforeEnd(page);
  await page.keyboard.press("Space");
  await page.waitForTimeout(60);
  await page.keyboard.press("Enter");
  const closed = await daemon.wait("closed", (of) => of.take === take);
  await page.mouse.up();
  wellTaken(closed);
  const estimated = await daemon.wait("estimated", (of) => of.take === take);
  const came = await verdictOf(page, take);
  assert.deepEqual(errors, []);
  await context.close();
  return { take, closed, estimated, lateMs, ...came };
}

/** A take that is as physics has it; it is acted again where the pointer stood still. */
export async function wellActed(how) {
  const tried = [];
  for (;;) {
    const came = await actByMouse(how);
    if (isPhysical(came)) return { ...came, tried };
    tried.push(`acted again: ${came.said}; the pointer stood still for ${came.lateMs} ms`);
    assert.ok(came.lateMs > LATE_MS && tried.length < TRIES, tried.join("\n"));
  }
}

export async function mouseTake(how) {
  const came = await wellActed(how);
  return [...came.tried, ...accountOf(came)];
}
