// A pen whose tracker is mounted in a known way, above a table that is known: what calibrations should find, and what
// is performed for them.
import { Quaternion, Vector3 } from "three";

export const SCENE = `# A pen above a table.
name = "pen"
[timing]
stamps = "physical"
[[body]]
name = "pen"
shape = { kind = "cylinder", length_mm = 190, radius_mm = 4 }
mass_g = 6
tracker = { position_mm = [0, 0, 0], orientation_wxyz = [1, 0, 0, 0] } # guessed
features_mm = { tip = [0, 0, -95] }
[[surface]]
name = "table"
point_mm = [0, 0, 0]
normal = [0, 0, 1]
[[event]]
name = "release"
kind = "start"
[[event]]
name = "catch"
kind = "end"
`;

const TIP_M = new Vector3(0, 0, -0.095);

/** A turn by a vector: its axis, and by how much [rad]. */
const by = (x, y, z) => {
  const axis = new Vector3(x, y, z);
  return new Quaternion().setFromAxisAngle(axis.clone().normalize(), axis.length());
};

/** How the tracker is on the pen. */
export const MOUNT = { position: new Vector3(0.02, -0.015, 0.11), turn: by(0.3, -0.5, 0.9) };

/** The table's normal, and its height at the origin [m]. */
export const TABLE = { normal: new Vector3(0.03, -0.05, 1).normalize(), heightM: 0.031 };

const onTable = (x, y) => new Vector3(x, y, TABLE.heightM - (TABLE.normal.x * x + TABLE.normal.y * y) / TABLE.normal.z);

/** A pen turned so, with its tip there. */
const withTip = (turn, tip) => ({ turn, position: tip.clone().sub(TIP_M.clone().applyQuaternion(turn)) });

/** It stands with that axis of its own up. */
export const standing = (axis) => () => ({
  turn: by(0, 0, 0.4).multiply(new Quaternion().setFromUnitVectors(axis, new Vector3(0, 0, 1))),
  position: new Vector3(0.1, 0.2, 0.9),
});

/** It swings about its tip. */
export function swinging(timeS) {
  const turn = by(0.6 * Math.sin(3.1 * timeS) + 1e-9, 0, 0).multiply(by(0, 0.6 * Math.cos(2.3 * timeS) + 1e-9, 0));
  return withTip(turn, new Vector3(0.2, -0.1, 0.04));
}

/** Ten, so that enough of them beyond the three that a plane needs say how exact they are. */
const TOUCHES = [
  [-0.2, -0.15], [0.25, -0.1], [0.05, 0.3], [-0.15, 0.2], [0.2, 0.15],
  [0, -0.2], [0.1, 0.02], [-0.25, 0.05], [0.15, -0.25], [-0.1, 0.3],
];

/** How long it touches, and as long it is lifted over to the next place [s]. */
const STAY_S = 0.6;

export const TOUCHES_S = 2 * STAY_S * TOUCHES.length;

/** When the touches are marked [s]. */
export const MARKS_S = TOUCHES.map((_, number) => (2 * number + 0.5) * STAY_S);

/** It touches the table at each place. */
export function touching(timeS) {
  const number = Math.min(Math.floor(timeS / (2 * STAY_S)), TOUCHES.length - 1);
  const next = Math.min(number + 1, TOUCHES.length - 1);
  const part = Math.min(1, Math.max(0, timeS / STAY_S - 2 * number - 1));
  const [[x, y], [toX, toY]] = [TOUCHES[number], TOUCHES[next]];
  const tip = onTable(x, y).lerp(onTable(toX, toY), part);
  tip.z += 0.05 * Math.sin(Math.PI * part);
  return withTip(by(0.2 + 0.06 * timeS, 0, 0), tip);
}

/** Where the tracker is while the pen is there. */
export const trackerOn = ({ turn, position }) => ({
  position: MOUNT.position.clone().applyQuaternion(turn).add(position),
  turn: turn.clone().multiply(MOUNT.turn),
});

/** Numbers as of a normal distribution, the same each time. @param {number} seed */
export function noise(seed) {
  let state = seed >>> 0;
  const uniform = () => {
    // mulberry32
    state = (state + 0x6d2b79f5) >>> 0;
    let mixed = Math.imul(state ^ (state >>> 15), state | 1);
    mixed ^= mixed + Math.imul(mixed ^ (mixed >>> 7), mixed | 61);
    return ((mixed ^ (mixed >>> 14)) >>> 0) / 2 ** 32;
  };
  return () => Math.sqrt(-2 * Math.log(1 - uniform())) * Math.cos(2 * Math.PI * uniform());
}

/** A tracker is off by so much, each time anew, along each axis [m], and about it [rad]. */
export const NOISE = { m: 1e-4, rad: 1e-3 };

export function disturbed({ position, turn }, draw) {
  const three = (of) => [of * draw(), of * draw(), of * draw()];
  const [off, twist] = [new Vector3(...three(NOISE.m)), by(...three(NOISE.rad))];
  return { position: position.clone().add(off), turn: turn.clone().multiply(twist) };
}
