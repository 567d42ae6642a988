// What is seen: the scene, the body that is acted, and the motion that came back beside the ghost of what was acted.
import * as THREE from "three";
import { OrbitControls } from "three/addons/controls/OrbitControls.js";
import { GLTFLoader } from "three/addons/loaders/GLTFLoader.js";

/** Pause at the end of the motion before it begins again [s]. */
const PAUSE_S = 0.7;

/** How a body looks that is acted. */
const LIVE = new THREE.MeshStandardMaterial({ color: 0x2563c9, roughness: 0.6 });

/** @param {ArrayBuffer} bytes binary glTF */
async function parsed(bytes) {
  const gltf = await new GLTFLoader().parseAsync(bytes, "");
  // The file is y-up by one node over all others; below it is the scene's world.
  const world = gltf.scene.children[0];
  world.quaternion.identity();
  // Its meshes have no normals: faces are flat.
  gltf.scene.traverse((node) => {
    if (node.isMesh) {
      node.material.side = node.material.transparent ? THREE.FrontSide : THREE.DoubleSide;
      node.material.depthWrite = !node.material.transparent;
    }
  });
  return { world, animations: gltf.animations };
}

/** The name of a node as the file has it. */
function nameOf(node) {
  return node.userData.name ?? node.name;
}

export class View {
  /** @param {HTMLElement} stage */
  constructor(stage) {
    this.stage = stage;
    this.renderer = new THREE.WebGLRenderer({ antialias: true, alpha: true });
    this.renderer.setPixelRatio(Math.min(devicePixelRatio, 2));
    stage.prepend(this.renderer.domElement);
    this.canvas = this.renderer.domElement;
    this.canvas.tabIndex = 0;
    this.camera = new THREE.PerspectiveCamera(40, 1, 0.01, 50);
    this.camera.up.set(0, 0, 1);
    this.scene = new THREE.Scene();
    /** The scene's world, z-up, in metres; a headset puts it elsewhere. */
    this.world = new THREE.Group();
    this.scene.add(this.world);
    const above = new THREE.HemisphereLight(0xffffff, 0x8a8f99, 1.6);
    above.position.set(0, 0, 1);
    const sun = new THREE.DirectionalLight(0xffffff, 1.8);
    sun.position.set(0.6, -1, 1.6);
    this.scene.add(above, sun);
    this.grid = new THREE.GridHelper(2, 20);
    this.grid.rotation.x = Math.PI / 2;
    this.grid.position.z = -0.002;
    this.grid.material.transparent = true;
    this.grid.material.opacity = 0.25;
    this.world.add(this.grid);
    this.fixed = new THREE.Group();
    this.played = new THREE.Group();
    this.world.add(this.fixed, this.played);
    const canvas = Object.assign(document.createElement("canvas"), { width: 1024, height: 256 });
    this.said = new THREE.CanvasTexture(canvas);
    this.said.colorSpace = THREE.SRGBColorSpace;
    // It stands upright behind the scene.
    this.panel = new THREE.Mesh(
      new THREE.PlaneGeometry(0.8, 0.2),
      new THREE.MeshBasicMaterial({ map: this.said, transparent: true }),
    );
    this.panel.rotation.x = Math.PI / 2;
    this.live = new Map();
    this.motion = null;
    this.isPlaying = true;
    new ResizeObserver(() => this.#fit()).observe(stage);
  }

  /** Lets the pointer turn the view; what listens before may take it. */
  beginOrbit() {
    this.orbit = new OrbitControls(this.camera, this.canvas);
    this.orbit.zoomSpeed = 0.6;
    this.#look();
  }

  #look() {
    this.camera.position.copy(this.middle).add(new THREE.Vector3(0, -2.6, 0.55).multiplyScalar(this.radius));
    this.orbit?.target.copy(this.middle);
    this.camera.lookAt(this.middle);
    this.orbit?.update();
  }

  #fit() {
    const { clientWidth: width, clientHeight: height } = this.stage;
    if (this.renderer.xr.isPresenting || width === 0 || height === 0) return;
    this.renderer.setSize(width, height, false);
    this.camera.aspect = width / height;
    // As much is seen across on a phone held upright.
    this.camera.fov = Math.min(75, Math.max(40, 40 / Math.min(1, this.camera.aspect / 0.9)));
    this.camera.updateProjectionMatrix();
  }

  middle = new THREE.Vector3(0, 0, 0.2);
  radius = 0.5;

  /**
   * Shows a scene; bodies that are acted are shown where they are put.
   * @param {ArrayBuffer} bytes
   * @param {string[]} bodies
   */
  async showScene(bytes, bodies) {
    const { world } = await parsed(bytes);
    this.fixed.clear();
    this.live.clear();
    for (const node of [...world.children]) {
      const isBody = bodies.includes(nameOf(node));
      this.fixed.add(node);
      if (!isBody) continue;
      node.traverse((part) => { if (part.isMesh) part.material = LIVE; });
      this.live.set(nameOf(node), node);
    }
    const fixed = new THREE.Box3();
    for (const node of this.fixed.children) if (![...this.live.values()].includes(node)) fixed.expandByObject(node);
    const size = fixed.isEmpty() ? new THREE.Vector3(0.4, 0.4, 0.4) : fixed.getSize(new THREE.Vector3());
    this.radius = Math.min(2, Math.max(0.4, 0.5 * size.length()));
    if (!fixed.isEmpty()) fixed.getCenter(this.middle);
    this.middle.z += 0.45 * this.radius;
    this.#look();
    this.#fit();
  }

  /** The world goes into a room, whose up is y. @param {boolean} isSeenThrough whether the room itself is seen */
  enterRoom(isSeenThrough) {
    if (this.orbit) this.orbit.enabled = false;
    this.grid.visible = !isSeenThrough;
    this.camera.up.set(0, 1, 0);
    const paper = getComputedStyle(document.body).backgroundColor;
    this.scene.background = isSeenThrough ? null : new THREE.Color(paper);
    this.world.add(this.panel);
  }

  /** Puts the world somewhere in the room. @param {THREE.Vector3} position @param {THREE.Quaternion} turn */
  placeWorld(position, turn) {
    this.world.position.copy(position);
    this.world.quaternion.copy(turn);
    this.panel.position.set(0, 0.35, 0.55);
  }

  leaveRoom() {
    this.renderer.xr.enabled = false;
    this.world.position.set(0, 0, 0);
    this.world.quaternion.identity();
    this.scene.background = null;
    this.grid.visible = true;
    this.world.remove(this.panel);
    this.camera.up.set(0, 0, 1);
    if (this.orbit) this.orbit.enabled = true;
    this.#look();
    this.#fit();
  }

  /** Says something in the room, where the page is not seen. @param {string} text @param {string} colour */
  tell(text, colour) {
    const canvas = this.said.image;
    const draw = canvas.getContext("2d");
    draw.fillStyle = "#15181de0";
    draw.fillRect(0, 0, canvas.width, canvas.height);
    draw.fillStyle = colour;
    draw.font = "52px system-ui, sans-serif";
    let line = "";
    let at = 70;
    for (const word of text.split(" ")) {
      if (line && draw.measureText(`${line} ${word}`).width > canvas.width - 48) {
        draw.fillText(line, 24, at);
        [line, at] = ["", at + 62];
      }
      line = line ? `${line} ${word}` : word;
    }
    draw.fillText(line, 24, at);
    this.said.needsUpdate = true;
  }

  /** Pixels of the window that a metre takes there. @param {THREE.Vector3} at */
  pixelsPer(at) {
    const away = at.clone().applyMatrix4(this.camera.matrixWorldInverse).z;
    return this.canvas.clientHeight / (2 * -away * Math.tan((this.camera.fov * Math.PI) / 360));
  }

  /** Puts a body that is acted somewhere. */
  put(body, position, turn) {
    const node = this.live.get(body);
    node?.position.copy(position);
    node?.quaternion.copy(turn);
  }

  /** Plays a motion beside the ghost of what was acted. @param {ArrayBuffer} bytes @param {number} now [s] */
  async showMotion(bytes, now) {
    const { world, animations } = await parsed(bytes);
    const tracks = animations.flatMap((clip) => clip.tracks);
    const parts = tracks.map((track) => {
      const { nodeName, propertyName } = THREE.PropertyBinding.parseTrackName(track.name);
      const node = world.children.find((child) => child.name === nodeName);
      return { node, propertyName, values: track.createInterpolant(), end: track.times.at(-1) };
    });
    this.played.clear();
    for (const node of new Set(parts.map((part) => part.node))) this.played.add(node);
    this.motion = { parts, duration: Math.max(0, ...parts.map((part) => part.end)), begun: now, time: 0 };
    this.isPlaying = true;
    this.setTime(0);
  }

  hideMotion() {
    this.played.clear();
    this.motion = null;
  }

  /** Whether what is acted is shown: beside a motion it is in the way. @param {boolean} isShown */
  showLive(isShown) {
    for (const node of this.live.values()) node.visible = isShown;
  }

  /** Shows the motion at a time from its beginning on [s]. */
  setTime(time) {
    const { motion } = this;
    if (!motion) return;
    motion.time = Math.min(Math.max(time, 0), motion.duration);
    for (const { node, propertyName, values } of motion.parts) node[propertyName].fromArray(values.evaluate(motion.time));
  }

  /** Goes on. @param {number} now [s] */
  advance(now) {
    const { motion } = this;
    if (!motion) return;
    if (this.isPlaying) this.setTime((now - motion.begun) % (motion.duration + PAUSE_S));
    else motion.begun = now - motion.time;
  }

  render() {
    if (!this.renderer.xr.isPresenting) this.orbit?.update();
    this.renderer.render(this.scene, this.camera);
  }
}
