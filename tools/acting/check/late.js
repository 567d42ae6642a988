// A frame of the page is late as a take ends: of the last mark there are readings all the same.
import { wellActed } from "./mouse.js";
import { accountOf, acting } from "./page.js";

/** How late it is, and how long after it was due the last mark is made [ms]; the take ends a moment later. */
const LATE_MS = 450;
const MARK_MS = 200;

export async function late(how) {
  const prepare = (page) => page.addInitScript(() => {
    const usual = window.requestAnimationFrame.bind(window);
    const held = [];
    let isHeld = false;
    window.requestAnimationFrame = (callback) => usual((ms) => (isHeld ? held.push(callback) : callback(ms)));
    window.holdFrames = (ms) => {
      isHeld = true;
      setTimeout(() => {
        isHeld = false;
        for (const callback of held.splice(0)) usual(callback);
      }, ms);
    };
  });
  const open = () => acting(how.browser, how.daemon, {}, prepare);
  const beforeEnd = async (page) => {
    await page.evaluate((ms) => window.holdFrames(ms), LATE_MS);
    await page.waitForTimeout(MARK_MS);
  };
  const came = await wellActed({ ...how, open, beforeEnd });
  return [`the last frame comes ${LATE_MS} ms late`, ...came.tried, ...accountOf(came)];
}
