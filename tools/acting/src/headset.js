// A headset or a phone as a tracker, by WebXR: poses of controllers, of hands, or of the phone itself.
import * as THREE from "three";

/** Where the scene's world is put before anybody has said so: so far ahead, and so far below the eyes [m]. */
const AHEAD_M = 0.55;
const BELOW_M = 0.5;

/** From the scene's world, z up, to that of a headset, y up. */
const Y_UP = new THREE.Quaternion().setFromAxisAngle(new THREE.Vector3(1, 0, 0), -Math.PI / 2);

/** The joint of a hand that is its tracker. */
const JOINT = "wrist";

/** The ways into a room, the better one first. */
export const MODES = ["immersive-vr", "immersive-ar"];

/** Which of them this browser has. */
export async function modes() {
  const { xr } = navigator;
  if (!xr) return [];
  const are = await Promise.all(MODES.map((mode) => xr.isSessionSupported(mode).catch(() => false)));
  return MODES.filter((_, index) => are[index]);
}

/**
 * A reading of a tracker in the scene's world.
 * @typedef {object} Tracked
 * @property {number} tracker 0 for the one that acts, 1 for the other hand's
 * @property {THREE.Vector3} position [m]
 * @property {THREE.Quaternion} turn
 * @property {boolean} isValid
 */

/**
 * What is told of a session.
 * @typedef {object} Hears
 * @property {(tracked: Tracked[], deviceMs: number) => void} readings of every frame
 * @property {(deviceMs: number) => void} mark an event happens
 * @property {() => void} take a take begins or ends
 * @property {() => void} over the session is over
 */

export class Headset {
  /** @param {import("./view.js").View} view @param {Hears} hears */
  constructor(view, hears) {
    this.view = view;
    this.hears = hears;
    this.session = null;
    /** Which hand acts: the one that pressed something last. */
    this.hand = "right";
    this.isPlaced = false;
    /** Whether the scene's world is the room's, as a calibration has it, not put ahead of the viewer. */
    this.isOfRoom = false;
    /** Whether this session ever had anything in a hand. */
    this.hadSources = false;
    this.last = new Map();
  }

  /** Begins a session. @param {string} mode */
  async enter(mode) {
    const { xr } = this.view.renderer;
    const session = await navigator.xr.requestSession(mode, {
      requiredFeatures: ["local-floor"],
      optionalFeatures: ["hand-tracking", "dom-overlay"],
      domOverlay: { root: document.body },
    });
    this.session = session;
    this.isPlaced = false;
    this.hadSources = false;
    this.last.clear();
    session.addEventListener("selectstart", (event) => this.#select(event));
    session.addEventListener("squeezestart", (event) => this.#squeeze(event));
    session.addEventListener("end", () => {
      this.session = null;
      this.view.leaveRoom();
      this.hears.over();
    });
    xr.enabled = true;
    xr.setReferenceSpaceType("local-floor");
    await xr.setSession(session);
    this.view.enterRoom(mode === "immersive-ar");
  }

  leave() {
    this.session?.end();
  }

  /** When something happened, on the clock of the readings [ms]. */
  #time(event) {
    return event.frame?.predictedDisplayTime ?? event.timeStamp;
  }

  /** A trigger or a tap marks. A hand that pinches has no grip: the one that does not act begins and ends takes. */
  #select(event) {
    const { inputSource: source } = event;
    if (source.hand && source.handedness !== this.hand) return this.hears.take();
    if (!source.hand && source.targetRayMode === "tracked-pointer") this.hand = source.handedness;
    this.hears.mark(this.#time(event));
  }

  #squeeze(event) {
    this.hand = event.inputSource.handedness;
    this.hears.take();
  }

  /**
   * Reads all trackers of a frame.
   * @param {XRFrame} frame
   * @param {number} ms
   */
  read(frame, ms) {
    this.frame = frame;
    const space = this.view.renderer.xr.getReferenceSpace();
    const viewer = frame.getViewerPose(space);
    if (viewer && !this.isPlaced) this.#place(viewer.transform);
    const sources = [...frame.session.inputSources].filter((source) => source.gripSpace || source.hand);
    const ofHand = (source) => (source.handedness === this.hand ? 0 : 1);
    sources.sort((one, other) => ofHand(one) - ofHand(other));
    const poses = sources.map((source) =>
      source.hand ? frame.getJointPose?.(source.hand.get(JOINT), space) : frame.getPose(source.gripSpace, space));
    // Without anything in a hand the phone itself is the tracker.
    if (sources.length === 0 && viewer && !this.hadSources) poses.push(viewer);
    this.hadSources ||= sources.length > 0;
    const tracked = poses.map((pose, tracker) => this.#tracked(pose ?? null, tracker));
    const known = tracked.filter((of) => of !== null);
    if (known.length > 0) this.hears.readings(known, frame.predictedDisplayTime ?? ms);
  }

  /** A pose in the scene's world; while there is none, the last one, for which nobody vouches. */
  #tracked(pose, tracker) {
    if (pose) {
      const { position, orientation } = pose.transform;
      const { world } = this.view;
      const back = world.quaternion.clone().invert();
      const place = new THREE.Vector3(position.x, position.y, position.z).sub(world.position).applyQuaternion(back);
      const turn = new THREE.Quaternion(orientation.x, orientation.y, orientation.z, orientation.w).premultiply(back);
      // A position that is only thought of, of a controller that is not seen, is none.
      const isValid = !pose.emulatedPosition;
      this.last.set(tracker, { tracker, position: place, turn, isValid });
      return this.last.get(tracker);
    }
    const last = this.last.get(tracker);
    return last ? { ...last, isValid: false } : null;
  }

  /** Puts the scene's world ahead of the viewer, its y away from them. */
  #place({ position, orientation }) {
    this.isPlaced = true;
    if (this.isOfRoom) return this.view.placeWorld(new THREE.Vector3(), Y_UP.clone());
    const look = new THREE.Vector3(0, 0, -1).applyQuaternion(
      new THREE.Quaternion(orientation.x, orientation.y, orientation.z, orientation.w));
    const heading = Math.atan2(-look.x, -look.z);
    const turn = new THREE.Quaternion().setFromAxisAngle(new THREE.Vector3(0, 1, 0), heading);
    const ahead = new THREE.Vector3(0, -BELOW_M, -AHEAD_M).applyQuaternion(turn);
    this.view.placeWorld(new THREE.Vector3(position.x, position.y, position.z).add(ahead), turn.multiply(Y_UP));
  }
}
