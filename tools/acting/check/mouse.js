// The mouse path: a pencil is dragged onto its tip, bounces, tumbles and is put into the mug, by pointer events and keys.
import { acting, assert, verdictOf } from "./page.js";

/** Where the pointer goes in the plane that it drags in, in radii of the view from the body's first place, over time [s]. */
const PATH = [
  // The pencil falls on its tip.
  { untilS: 0.9, toX: 0.02, toY: -0.2 },
  // It bounces up, over and into the mug.
  { untilS: 1.6, toX: 0.1, toY: 0.14 },
  { untilS: 2.5, toX: 0.16, toY: -0.1 },
];

export async function mouseTake({ browser, daemon }) {
  const { context, page, errors } = await acting(browser, daemon);
  const seen = await page.evaluate(() => window.enactSeenAt());
  const scale = await page.evaluate(() => window.enactPixelsPerRadius());
  await page.mouse.move(seen.x, seen.y);
  await page.mouse.down();
  await page.waitForTimeout(300);
  await page.keyboard.press("Enter");
  const { take } = await daemon.wait("started");
  await page.waitForFunction(() => document.querySelector("#record").textContent === "Stop");
  const begun = Date.now();
  let [from, fromX, fromY] = [0, 0, 0];
  for (const [index, { untilS, toX, toY }] of PATH.entries()) {
    for (;;) {
      const time = (Date.now() - begun) / 1000;
      const share = Math.min(1, (time - from) / (untilS - from));
      // A fall is fast at its end, a rise at its beginning.
      const along = index === 0 || index === 2 ? share * share : 1 - (1 - share) * (1 - share);
      await page.mouse.move(seen.x + scale * (fromX + share * (toX - fromX)), seen.y - scale * (fromY + along * (toY - fromY)));
      if (share >= 1) break;
      await page.waitForTimeout(8);
    }
    [from, fromX, fromY] = [untilS, toX, toY];
    if (index === 0) {
      await page.keyboard.press("Space");
      await page.keyboard.down("KeyE");
    }
  }
  await page.keyboard.up("KeyE");
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
