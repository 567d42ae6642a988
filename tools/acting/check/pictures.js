// Pictures of the pages, to be looked at: light and dark, phone and desktop, with a motion that plays.
import { execFileSync } from "node:child_process";
import { join } from "node:path";
import { pathToFileURL } from "node:url";
import { acting, assert, opened } from "./page.js";

const PHONE = { viewport: { width: 390, height: 780 }, deviceScaleFactor: 2, hasTouch: true, isMobile: true };

/** Plays a motion in a page's picture, and looks whether it moves and whether the page fits. */
async function plays(page, within) {
  await page.waitForSelector(`${within} .controls:not([hidden]) button`);
  await page.click(`${within} .controls button`);
  const path = () => page.$eval(`${within} .played path[data-d]`, (of) => of.getAttribute("d"));
  const before = await path();
  await page.waitForFunction(
    ([within, before]) => document.querySelector(`${within} .played path[data-d]`).getAttribute("d") !== before,
    [within, before], { timeout: 10_000 });
  await page.waitForTimeout(250);
}

/** The report page of the last estimate. */
function report(enact, folder, estimate) {
  const page = join(folder, "report.html");
  execFileSync(enact, ["report", estimate, "-o", page]);
  return pathToFileURL(page).href;
}

export async function pictures({ browser, daemon, folder, enact }) {
  const estimated = daemon.said.findLast((of) => of.what === "estimated");
  assert.ok(estimated, "nothing was acted");
  const ofReport = report(enact, folder, estimated.report.output);
  const made = [];
  for (const [size, options] of [["desktop", {}], ["phone", PHONE]]) {
    for (const colorScheme of ["light", "dark"]) {
      const how = { ...options, colorScheme };
      const shoot = async ({ context, page, errors }, name) => {
        const wide = await page.evaluate(() => document.documentElement.scrollWidth - innerWidth);
        assert.ok(wide <= 0, `${name} is ${wide} pixels too wide`);
        const path = join(folder, `${name}-${size}-${colorScheme}.png`);
        await page.screenshot({ path });
        assert.deepEqual(errors, []);
        await context.close();
        made.push(path);
      };
      const act = await acting(browser, daemon, how);
      await act.page.waitForTimeout(700);
      await shoot(act, "acting");
      const calibration = await acting(browser, daemon, how);
      await calibration.page.click("#calibrate");
      await calibration.page.selectOption("#step", "plane");
      await calibration.page.waitForTimeout(200);
      const [panel, help] = await Promise.all(
        ["#calibration", "#help"].map((of) => calibration.page.locator(of).boundingBox()));
      assert.ok(help === null || help.x + help.width <= panel.x, `the panel is over the help (${size})`);
      assert.equal(help === null, size === "phone");
      await shoot(calibration, "calibration");
      const operator = await opened(browser, daemon.ready.page, how);
      await operator.page.waitForSelector("#last:not([hidden])");
      const top = join(folder, `operator-top-${size}-${colorScheme}.png`);
      await operator.page.screenshot({ path: top });
      made.push(top);
      await plays(operator.page, "#last");
      await shoot(operator, "operator");
      const page = await opened(browser, ofReport, how);
      await plays(page.page, "figure.plays");
      await page.page.$eval("figure.plays", (figure) => figure.scrollIntoView({ block: "start" }));
      await shoot(page, "report");
    }
  }
  return made;
}
