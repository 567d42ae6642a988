// A headset or a phone that iwer emulates on a page: what is in its hands goes where a script says.
import { join } from "node:path";

/** Eyes of who stands there, at first [m]. */
export const EYES = [0, 1.6, 0];

/** Where the page puts a place of the scene before a viewer who looks ahead [m]: see src/headset.js. */
export const ahead = ({ x, y, z }) => [x, EYES[1] - 0.5 + z, -0.55 - y];

/** Where a place of the scene is in a room whose floor it stands on [m]. */
export const onFloor = ({ x, y, z }) => [x, z, -y];

/** Gives a page an emulated headset before it begins. */
export const emulates = (home) => async (page) => {
  await page.addInitScript({ path: join(home, "node_modules/iwer/build/iwer.min.js") });
  await page.addInitScript(() => {
    // The browser's own layers know nothing of an emulated session.
    delete window.XRWebGLBinding;
    window.emulated = new IWER.XRDevice(IWER.metaQuest3);
    window.emulated.installRuntime({ polyfillLayers: false, forceInstall: true });
    // It says of all controllers that nobody sees them.
    Object.defineProperty(XRPose.prototype, "emulatedPosition", { get: () => false });
  });
};

/** Enters a room, and waits until the scene is put there. @param {"immersive-vr" | "immersive-ar"} mode */
export async function enter(page, mode) {
  const button = mode === "immersive-ar" ? "#enter-ar" : "#enter-vr";
  await page.waitForSelector(`${button}:not([hidden])`);
  await page.click(button);
  await page.waitForSelector(`body[data-room=${mode}]`);
  await page.waitForFunction(() => window.enactRoom().headset.isPlaced);
}

export async function leave(page) {
  await page.evaluate(() => window.enactRoom().headset.leave());
  await page.waitForSelector("body[data-room='']");
}

/**
 * What an input does: poses as [time in ms, x, y, z, qx, qy, qz, qw] in the room, straight between them, and when its
 * buttons are pressed [ms]. Of a hand, that is where its wrist is, and `select` is a pinch; of a controller, its grip.
 * @typedef {{ poses: number[][], select?: number[], squeeze?: number[] }} Part
 */

/**
 * Begins to play a script from now on: what is in the hands, or where the phone itself is and when it is tapped. Says
 * when that was on the page's clock [ms].
 * @param {import("playwright-core").Page} page
 * @param {{ with: "hand" | "controller" | "phone", left?: Part, right?: Part, phone?: Part }} script
 */
export async function play(page, script) {
  return page.evaluate((script) => {
    const PRESSED_MS = 120;
    const { headset } = window.enactRoom();
    const device = window.emulated;
    const begunMs = performance.now();
    const unit = (q) => q.map((value) => value / Math.hypot(...q));
    /** Where it is then: straight between two poses. */
    const poseAt = (poses, ms) => {
      const next = Math.max(1, poses.findIndex(([at]) => at > ms));
      const [one, other] = ms >= poses.at(-1)[0] ? [poses.at(-1), poses.at(-1)] : [poses[next - 1], poses[next]];
      const span = other[0] - one[0];
      const part = span > 0 ? Math.min(1, Math.max(0, (ms - one[0]) / span)) : 0;
      const of = one.map((value, index) => value + part * (other[index] - value));
      return { p: of.slice(1, 4), q: unit(of.slice(4)) };
    };
    const times = ([ax, ay, az, aw], [bx, by, bz, bw]) => [
      aw * bx + ax * bw + ay * bz - az * by, aw * by - ax * bz + ay * bw + az * bx,
      aw * bz + ax * by - ay * bx + az * bw, aw * bw - ax * bx - ay * by - az * bz];
    const back = ([x, y, z, w]) => [-x, -y, -z, w];
    const turned = (q, [x, y, z]) => times(times(q, [x, y, z, 0]), back(q)).slice(0, 3);
    /** A button that is pressed then, for a while and for a frame at least; its value in every frame. */
    const button = (pressed = []) => {
      let [number, sinceMs] = [0, null];
      return (ms) => {
        if (sinceMs === null && ms >= pressed[number]) sinceMs = ms;
        else if (sinceMs !== null && ms >= sinceMs + PRESSED_MS) [number, sinceMs] = [number + 1, null];
        return Number(sinceMs !== null);
      };
    };

    if (script.with === "phone") {
      const { poses, select } = script.phone;
      let tapped = 0;
      const step = (_, frame) => {
        const ms = frame.predictedDisplayTime - begunMs;
        // It is there in the next frame.
        const { p, q } = poseAt(poses, ms);
        device.position.set(...p);
        device.quaternion.set(...q);
        // As a browser says that a screen was tapped.
        const inputSource = { targetRayMode: "screen", handedness: "none" };
        for (; select[tapped] <= ms; tapped += 1) {
          headset.session.dispatchEvent(new XRInputSourceEvent("selectstart", { frame, inputSource }));
        }
        headset.session.requestAnimationFrame(step);
      };
      headset.session.requestAnimationFrame(step);
      return begunMs;
    }
    const isHand = script.with === "hand";
    for (const side of ["left", "right"]) {
      if (!script[side]) continue;
      const { poses, select, squeeze } = script[side];
      const input = (isHand ? device.hands : device.controllers)[side];
      const { inputSource } = input;
      const held = isHand ? inputSource.hand.get("wrist") : inputSource.gripSpace;
      const [first, second] = [button(select), button(squeeze)];
      const usual = Object.getPrototypeOf(input).onFrameStart;
      input.onFrameStart = (frame) => {
        const ms = frame.predictedDisplayTime - begunMs;
        if (isHand) input.updatePinchValue(first(ms));
        else {
          input.updateButtonValue("trigger", first(ms));
          input.updateButtonValue("squeeze", second(ms));
        }
        usual.call(input, frame);
        // Its ray is put where what is held comes to be where it should: a hand that pinches has it elsewhere.
        const { position, orientation } = frame.getPose(held, inputSource.targetRaySpace).transform;
        const { p, q } = poseAt(poses, ms);
        const ray = times(q, back([orientation.x, orientation.y, orientation.z, orientation.w]));
        const off = turned(ray, [position.x, position.y, position.z]);
        input.position.set(...p.map((value, index) => value - off[index]));
        input.quaternion.set(...ray);
        input.updateTargetRaySpace();
      };
    }
    return begunMs;
  }, script);
}

/**
 * What is drawn in the room, of one frame: shares of pixels that let the room through, and that do not.
 * @returns {Promise<{ through: number, opaque: number }>}
 */
export const drawn = (page) => page.evaluate(() => new Promise((done) => {
  const { session } = window.enactRoom().headset;
  const gl = document.querySelector("canvas[data-engine]").getContext("webgl2");
  let frames = 0;
  const look = () => {
    frames += 1;
    if (frames < 5) return session.requestAnimationFrame(look);
    // After the page has drawn: it asked for this frame before.
    const before = gl.getParameter(gl.FRAMEBUFFER_BINDING);
    gl.bindFramebuffer(gl.FRAMEBUFFER, null);
    const { drawingBufferWidth: width, drawingBufferHeight: height } = gl;
    const pixels = new Uint8Array(4 * width * height);
    gl.readPixels(0, 0, width, height, gl.RGBA, gl.UNSIGNED_BYTE, pixels);
    gl.bindFramebuffer(gl.FRAMEBUFFER, before);
    const alphas = pixels.filter((_, index) => index % 4 === 3);
    const share = (alpha) => alphas.filter((value) => value === alpha).length / alphas.length;
    done({ through: share(0), opaque: share(255) });
  };
  session.requestAnimationFrame(look);
}));
