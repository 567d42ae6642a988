// A page acts and is closed, and another one is opened at once: its readings are taken, and nobody takes the first
// page's for another tracker's.
import { acting, assert, wellTaken } from "./page.js";

/** How long the first one acts [ms]: as long as it takes until the daemon knows that a tracker sends. */
const FIRST_MS = 700;

export async function handover({ browser, daemon }) {
  const first = await acting(browser, daemon);
  await first.page.waitForTimeout(FIRST_MS);
  // It goes while the second one is let in and has not yet asked for its stream.
  const prepare = (page) => page.route("**/act/scene.glb", async (route) => {
    await first.context.close();
    await route.continue();
  });
  const { context, page, errors } = await acting(browser, daemon, {}, prepare);
  const before = daemon.said.length;
  await page.keyboard.press("Enter");
  const { take } = await daemon.wait("started", (of) => daemon.said.indexOf(of) >= before);
  await page.waitForFunction(() => document.querySelector("#record").textContent === "Stop");
  for (let mark = 0; mark < 2; mark += 1) {
    await page.waitForTimeout(300);
    await page.keyboard.press("Space");
  }
  await page.waitForTimeout(100);
  await page.keyboard.press("Enter");
  const closed = await daemon.wait("closed", (of) => of.take === take);
  const { received } = wellTaken(closed);
  assert.deepEqual(first.errors, []);
  assert.deepEqual(errors, []);
  await context.close();
  return [`take ${take}: ${received} samples of the second page, none missing, nothing refused`];
}
