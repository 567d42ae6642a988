// A mouse as a tracker: a body is dragged, pushed away and pulled near by the wheel, and turned by keys.
import * as THREE from "three";

/** Readings a second, whatever the screen does: the body goes smoothly between what the pointer says. */
const RATE_HZ = 120;

/** After a longer pause, of a page that was hidden, readings begin anew [ms]. */
const PAUSE_MS = 500;

/** How fast the body follows the pointer: the time in which a third of the way is left [s]. */
const FOLLOW_S = 0.045;

/** How fast keys turn [rad/s], and how soon they do [s]. */
const TURN_RAD_S = 2.6;
const TURN_FOLLOW_S = 0.08;

/** Slow motion, with Shift. */
const SLOW = 0.35;

/** Of a step of the wheel [m]. */
const WHEEL_M = 0.0006;

/** How near to the body the pointer takes hold of it [pixels]. */
const GRASP_PX = 60;

/** Keys by the axis they turn about, seen from the viewer: right, up, towards. */
const TURNS = { KeyW: [-1, 0, 0], KeyS: [1, 0, 0], KeyA: [0, -1, 0], KeyD: [0, 1, 0], KeyQ: [0, 0, 1], KeyE: [0, 0, -1] };

export class Mouse {
  /**
   * @param {HTMLCanvasElement} canvas
   * @param {THREE.Camera} camera
   * @param {(isHeld: boolean) => void} held told when the body is taken and let go
   */
  constructor(canvas, camera, held) {
    this.canvas = canvas;
    this.camera = camera;
    this.held = held;
    /** Where the body is, and where it is wanted [m]; its speed [m/s]. */
    this.position = new THREE.Vector3(0, 0, 0.3);
    this.wanted = this.position.clone();
    this.speed = new THREE.Vector3();
    this.turn = new THREE.Quaternion();
    this.spin = new THREE.Vector3();
    this.keys = new Set();
    this.pointer = null;
    this.offset = new THREE.Vector3();
    /** Where the pointer has it, before the body has gone there [m]. */
    this.heldAt = this.wanted.clone();
    /** Until when the body has gone [ms], and what happened since then, with its time. */
    this.atMs = null;
    this.happened = [];
    canvas.addEventListener("pointerdown", (event) => this.#take(event));
    canvas.addEventListener("pointermove", (event) => this.#drag(event));
    for (const end of ["pointerup", "pointercancel"]) canvas.addEventListener(end, (event) => this.#release(event));
    canvas.addEventListener("wheel", (event) => this.#push(event), { passive: false });
    addEventListener("keydown", (event) => this.#later(event, () => this.keys.add(event.code)));
    addEventListener("keyup", (event) => this.#later(event, () => this.keys.delete(event.code)));
    addEventListener("blur", () => this.keys.clear());
  }

  /** Puts the body somewhere, at rest. @param {THREE.Vector3} position @param {THREE.Quaternion} turn */
  place(position, turn) {
    this.position.copy(position);
    this.wanted.copy(position);
    this.speed.set(0, 0, 0);
    this.turn.copy(turn);
    this.spin.set(0, 0, 0);
  }

  /** Happens to the body at its time, in turn. */
  #later(event, what) {
    this.happened.push({ atMs: event.timeStamp, what });
  }

  /** Where the pointer is in the plane through a point that faces the viewer. */
  #under(event, through) {
    const box = this.canvas.getBoundingClientRect();
    const at = new THREE.Vector2(
      (2 * (event.clientX - box.left)) / box.width - 1,
      1 - (2 * (event.clientY - box.top)) / box.height,
    );
    const ray = new THREE.Raycaster();
    ray.setFromCamera(at, this.camera);
    const facing = this.camera.getWorldDirection(new THREE.Vector3());
    const plane = new THREE.Plane().setFromNormalAndCoplanarPoint(facing, through);
    return ray.ray.intersectPlane(plane, new THREE.Vector3());
  }

  /** Where the body is seen [pixels in the window]. */
  seenAt() {
    const box = this.canvas.getBoundingClientRect();
    const at = this.position.clone().project(this.camera);
    return { x: box.left + (box.width * (at.x + 1)) / 2, y: box.top + (box.height * (1 - at.y)) / 2 };
  }

  #take(event) {
    const seen = this.seenAt();
    const isNear = Math.hypot(event.clientX - seen.x, event.clientY - seen.y) < GRASP_PX;
    const under = isNear && event.button === 0 ? this.#under(event, this.wanted) : null;
    if (!under) return;
    this.pointer = event.pointerId;
    this.heldAt = this.wanted.clone();
    this.offset.subVectors(this.wanted, under);
    this.canvas.setPointerCapture(event.pointerId);
    // What is told comes before the view's own use of the pointer.
    event.stopImmediatePropagation();
    this.held(true);
  }

  #drag(event) {
    if (event.pointerId !== this.pointer) return;
    // What came between two frames of the screen has times of its own.
    const between = event.getCoalescedEvents?.() ?? [];
    for (const part of between.length > 0 ? between : [event]) {
      const under = this.#under(part, this.heldAt);
      if (!under) continue;
      const to = under.add(this.offset);
      this.heldAt = to.clone();
      this.#later(part, () => this.wanted.copy(to));
    }
  }

  #release(event) {
    if (event.pointerId !== this.pointer) return;
    this.pointer = null;
    this.held(false);
  }

  #push(event) {
    if (this.pointer === null) return;
    event.preventDefault();
    event.stopImmediatePropagation();
    const away = this.camera.getWorldDirection(new THREE.Vector3()).multiplyScalar(-event.deltaY * WHEEL_M);
    this.heldAt.add(away);
    this.#later(event, () => this.wanted.add(away));
  }

  /**
   * Goes on until that time, in even steps.
   * @param {number} ms
   * @param {(atMs: number) => void} step told of each
   */
  advanceTo(ms, step) {
    const stepMs = 1000 / RATE_HZ;
    if (this.atMs === null || ms - this.atMs > PAUSE_MS) this.atMs = ms - stepMs;
    this.happened.sort((one, other) => one.atMs - other.atMs);
    while (this.atMs + stepMs <= ms) {
      this.atMs += stepMs;
      while (this.happened.length > 0 && this.happened[0].atMs <= this.atMs) this.happened.shift().what();
      this.#advance(stepMs / 1000);
      step(this.atMs);
    }
  }

  /** Follows the pointer and the keys for a while [s]. */
  #advance(span) {
    // Critically damped, exactly: of any step the same path.
    const rate = 1 / FOLLOW_S;
    const decay = Math.exp(-rate * span);
    const off = this.position.clone().sub(this.wanted);
    const lead = this.speed.clone().addScaledVector(off, rate).multiplyScalar(span);
    const speed = this.speed.clone().addScaledVector(lead, -rate).multiplyScalar(decay);
    this.position.copy(off.add(lead).multiplyScalar(decay).add(this.wanted));
    this.speed.copy(speed);

    const wanted = new THREE.Vector3();
    for (const key of this.keys) if (TURNS[key]) wanted.add(new THREE.Vector3(...TURNS[key]));
    const isSlow = this.keys.has("ShiftLeft") || this.keys.has("ShiftRight");
    wanted.multiplyScalar(isSlow ? SLOW * TURN_RAD_S : TURN_RAD_S);
    wanted.applyQuaternion(this.camera.getWorldQuaternion(new THREE.Quaternion()));
    this.spin.lerp(wanted, 1 - Math.exp(-span / TURN_FOLLOW_S));
    const angle = this.spin.length() * span;
    if (angle > 1e-12) {
      const step = new THREE.Quaternion().setFromAxisAngle(this.spin.clone().normalize(), angle);
      this.turn.premultiply(step).normalize();
    }
  }
}
