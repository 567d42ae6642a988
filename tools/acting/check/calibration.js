// A step of a calibration on the page: a ball that nobody moves, by a tracker that repeats its poses, which is said.
import { join } from "node:path";
import { acting, assert } from "./page.js";

export async function calibration({ browser, daemon, folder }) {
  const { context, page, errors } = await acting(browser, daemon);
  await page.click("#calibrate");
  const before = daemon.said.length;
  await page.click("#record");
  const { take } = await daemon.wait("started", (of) => daemon.said.indexOf(of) >= before);
  await page.waitForFunction(() => document.querySelector("#record").textContent === "Stop");
  await page.waitForTimeout(1500);
  await page.click("#record");
  await daemon.wait("discarded", (of) => of.take === take);
  await page.waitForSelector("body[data-calibrated=rest]");
  const against = await page.$$eval("#found .against", (all) => all.map((line) => line.textContent).join("; "));
  assert.match(against, /the very same as the one before/);
  assert.match(await page.inputValue("#keys"), /orientation_wxyz/);
  // What something speaks against is in no scene.
  assert.doesNotMatch(await page.textContent("#files"), /scene/);
  const path = join(folder, "calibration-found.png");
  await page.screenshot({ path });
  assert.deepEqual(errors, []);
  await context.close();
  return [`take ${take}: ${against}`, path];
}
