// How long verdict and motion take after the end of a take: many takes by mouse, by headset, and by a WebSocket alone.
import { actByHeadset } from "./headset.js";
import { actByMouse } from "./mouse.js";
import { assert, isPhysical } from "./page.js";
import { socketTakes } from "./socket.js";

const TAKES = 20;

/** So many of them may be acted badly, by pointer events that came late on a machine that does much else. */
const BAD = 2;

/** Median and greatest of numbers [ms]. */
function spread(all) {
  const sorted = [...all].sort((one, other) => one - other);
  const middle = sorted.length / 2;
  const median = (sorted[Math.floor(middle - 0.5)] + sorted[Math.floor(middle)]) / 2;
  return `median ${median.toFixed(0)} ms, longest ${sorted.at(-1).toFixed(0)} ms`;
}

function account(name, takes) {
  const of = (what) => spread(takes.map((take) => take[what]));
  return [
    `${takes.length} takes by ${name}: first motion ${of("motionMs")}`,
    `${takes.length} takes by ${name}: verdict ${of("verdictMs")}`,
    `${takes.length} takes by ${name}: checked motion ${of("checkedMs")}`,
  ];
}

export async function times(how) {
  const lines = account("a WebSocket alone", await socketTakes(how, TAKES));
  for (const [name, act] of [["mouse", actByMouse], ["headset", actByHeadset]]) {
    const takes = [];
    while (takes.length < TAKES) takes.push(await act(how));
    const physical = takes.filter(isPhysical).length;
    lines.push(...account(name, takes), `${physical} of ${takes.length} takes by ${name} are physical`);
    assert.ok(physical >= TAKES - BAD, lines.join("\n"));
  }
  return lines;
}
