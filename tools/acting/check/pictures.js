// Pictures of the page, to be looked at: light and dark, phone and desktop, acting and with a motion that came back.
import { join } from "node:path";
import { acting, assert } from "./page.js";

const PHONE = { viewport: { width: 390, height: 780 }, deviceScaleFactor: 2, hasTouch: true, isMobile: true };

export async function pictures({ browser, daemon, folder }) {
  const made = [];
  for (const [size, options] of [["desktop", {}], ["phone", PHONE]]) {
    for (const colorScheme of ["light", "dark"]) {
      const { context, page, errors } = await acting(browser, daemon, { ...options, colorScheme });
      await page.waitForTimeout(700);
      const wide = await page.evaluate(() => document.documentElement.scrollWidth - innerWidth);
      assert.ok(wide <= 0, `the page is ${wide} pixels too wide`);
      const path = join(folder, `${size}-${colorScheme}.png`);
      await page.screenshot({ path });
      assert.deepEqual(errors, []);
      await context.close();
      made.push(path);
    }
  }
  return made;
}
