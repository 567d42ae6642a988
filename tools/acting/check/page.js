// What the parts of the check share: pages that are open, and what they say.
import assert from "node:assert/strict";

/** A window in which a room is drawn soon enough without a graphics processor. */
export const SMALL = { viewport: { width: 480, height: 320 } };

/** Opens a page. Any error of the page, and all that the daemon refuses it, is kept, and said. */
export async function opened(browser, link, options = {}, prepare = async () => {}) {
  const context = await browser.newContext({ viewport: { width: 1280, height: 800 }, ...options });
  const page = await context.newPage();
  const errors = [];
  const fails = (text) => {
    if (errors.includes(text)) return;
    errors.push(text);
    console.log(`the page: ${text}`);
  };
  page.on("pageerror", (error) => fails(error.stack));
  page.on("console", (said) => said.type() === "error" && fails(said.text()));
  page.on("websocket", (socket) => socket.on("framereceived", ({ payload }) => {
    const { what, why } = JSON.parse(payload);
    if (what === "refused") fails(`refused: ${why}`);
  }));
  await prepare(page);
  await page.goto(link);
  return { context, page, errors };
}

/** Opens the acting page as the link says it, and waits until it is paired. */
export async function acting(browser, daemon, options = {}, prepare = async () => {}) {
  const all = await opened(browser, daemon.ready.acting, options, prepare);
  await all.page.waitForSelector("body[data-paired=yes]");
  return all;
}

/** All readings that a page sends from now on: when on its own clock [ms], and where [m]. */
export function readingsOf(page) {
  const readings = [];
  page.on("websocket", (socket) => socket.on("framesent", ({ payload }) => {
    if (typeof payload === "string") return;
    for (let at = 8; at < payload.length; at += 96) {
      const place = [32, 40, 48].map((of) => payload.readDoubleLE(at + of));
      readings.push({ atMs: Number(payload.readBigInt64LE(at + 24)) / 1e6, place });
    }
  }));
  return readings;
}

/** Looks whether a take has all that was sent in it, by the page's clock; the counts of its tracker. */
export function wellTaken(closed, tracker = 0) {
  const { counts, clock } = closed.counts.trackers[tracker];
  assert.ok(counts.received > 0, `nothing was received: ${JSON.stringify(closed.counts)}`);
  assert.equal(counts.missing, 0);
  assert.equal(clock.source, "device");
  assert.equal(closed.counts.marks.received, 2);
  assert.equal(closed.counts.marks.refused, 0);
  return counts;
}

/** Whether the daemon says that a take became a motion as physics has it. */
export const isPhysical = ({ estimated }) => estimated.report.verdict === "physical";

/** What came of a take, in lines. */
export function accountOf({ take, closed, estimated, said, verdictMs, motionMs, checkedMs }) {
  return [
    `take ${take}: ${closed.counts.trackers[0].counts.received} samples, ${closed.counts.marks.received} marks, none missing`,
    `the daemon says ${estimated.report.verdict}; the page says: ${said}`,
    `first motion ${motionMs} ms, verdict ${verdictMs} ms, checked motion ${checkedMs} ms after the end`,
  ];
}

/** Waits for the verdict on a take and until its motion is shown; what the page says, and how long it took [ms]. */
export async function verdictOf(page, take) {
  await page.waitForFunction((take) => document.body.dataset.motion === String(take), take, { timeout: 30_000 });
  const said = await page.textContent("#said");
  const [verdictMs, motionMs, checkedMs] = (await page.evaluate(() => document.body.dataset.afterEnd)).split(" ").map(Number);
  return { said, verdictMs, motionMs, checkedMs };
}

export { assert };
