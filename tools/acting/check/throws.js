// A ball that is let go, bounces once on the table and falls into the bowl of config/ball.toml, as physics has it: what
// the check acts, slowly.

const GRAVITY_M_S2 = 9.81;
const RADIUS_M = 0.03;
const RESTITUTION = 0.8;
const BOWL = { x: 0.15, z: 0.05 };

/** How much slower than it would happen it is acted. */
export const SLOW = 3;

/**
 * The throw from there: when it bounces and lands [s], and where the ball is at a time between.
 * @param {{ x: number, z: number }} start [m]
 */
export function throwFrom(start) {
  const fallS = Math.sqrt((2 * (start.z - RADIUS_M)) / GRAVITY_M_S2);
  const up = RESTITUTION * GRAVITY_M_S2 * fallS;
  const flyS = (up + Math.sqrt(up * up - 2 * GRAVITY_M_S2 * (BOWL.z - RADIUS_M))) / GRAVITY_M_S2;
  const across = (BOWL.x - start.x) / (fallS + flyS);
  const place = (time) => {
    const after = time - fallS;
    const z = after < 0
      ? start.z - 0.5 * GRAVITY_M_S2 * time * time
      : RADIUS_M + up * after - 0.5 * GRAVITY_M_S2 * after * after;
    return { x: start.x + across * time, z };
  };
  return { fallS, endS: fallS + flyS, place };
}
