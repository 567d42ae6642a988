// Readings in the layout that iceoryx2 carries: `enact.Pose.1`, 96 bytes, little-endian.

const HEAD_BYTES = 8;
const POSE_BYTES = 96;

/** Most readings that one message carries. */
export const READINGS = 64;

/** Stands for a time that is not known. */
const NO_TIME = -(2n ** 63n);

/**
 * A reading of a tracker, in the scene's world.
 * @typedef {object} Reading
 * @property {number} sequence counts the readings by one
 * @property {number} deviceMs when it was measured, on the page's clock
 * @property {number[]} position [m]
 * @property {number[]} quaternion x, y, z, w
 * @property {boolean} isValid whether the tracker vouches for it
 */

/** A time of the page's clock in nanoseconds. @param {number} ms */
export function nanoseconds(ms) {
  return Math.round(ms * 1e6);
}

/**
 * The message with these readings.
 * @param {number} stream index of the stream
 * @param {Reading[]} readings at most READINGS
 */
export function message(stream, readings) {
  const view = new DataView(new ArrayBuffer(HEAD_BYTES + POSE_BYTES * readings.length));
  view.setUint32(0, stream, true);
  readings.forEach((reading, index) => {
    const at = HEAD_BYTES + POSE_BYTES * index;
    view.setBigUint64(at, BigInt(reading.sequence), true);
    // When it arrives, and when that was on its own clock, the daemon knows.
    view.setBigInt64(at + 8, NO_TIME, true);
    view.setBigInt64(at + 16, NO_TIME, true);
    view.setBigInt64(at + 24, BigInt(nanoseconds(reading.deviceMs)), true);
    [...reading.position, ...reading.quaternion].forEach((value, number) => {
      view.setFloat64(at + 32 + 8 * number, value, true);
    });
    view.setUint32(at + 88, reading.isValid ? 1 : 0, true);
  });
  return view.buffer;
}
