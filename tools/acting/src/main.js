// The acting page: pairs, is a tracker, and shows what came back.
import * as THREE from "three";
import { Calibration } from "./calibration.js";
import { Headset, modes } from "./headset.js";
import { Link } from "./link.js";
import { Mouse } from "./mouse.js";
import { View } from "./view.js";

const HELP_MOUSE =
  "Drag the body, wheel: away and near, Q E A D W S: turn, Shift: slowly. Enter begins and ends a take, space marks an event.";

const at = (id) => document.getElementById(id);
const view = new View(at("stage"));
const mouse = new Mouse(view.canvas, view.camera, (isHeld) => {
  if (view.orbit) view.orbit.enabled = !isHeld;
  if (isHeld) watch(false);
});
view.beginOrbit();

/** What was said when it was let in: the scene's streams and events. */
let told = null;
/** Which of the streams is acted by the mouse or the first tracker, and all that this page asked for. */
let stream = 0;
const acted = new Set();
/** The take that runs, or none. */
let take = null;
/** The take that this page has ended last, and when [ms]. */
let ended = null;
/** The motion that is being fetched or shown, and the one that is shown: the take, and the how manieth of it. */
let shown = null;
let played = null;
/** What is known of the last take. */
let latest = null;
/** Whether the motion is looked at, not acted. */
let isWatching = false;
/** What the link asks for. */
const asked = new URLSearchParams(location.hash.slice(1));

const link = new Link((said) => {
  if (said.what === "paired") paired(said);
  else if (said.what === "state") state(said);
  else if (said.what === "calibrated") calibration.found(said);
  else if (said.what === "refused") refused(said.why);
  else gone(said.why);
});
const calibration = new Calibration(link, say, (text) => view.tell(text, "#e8eaee"));

const headset = new Headset(view, {
  readings: (tracked, ms) => {
    for (const { tracker, position, turn, isValid } of tracked) {
      const index = streamOf(tracker);
      if (index === null) continue;
      const reading = { deviceMs: ms, position: position.toArray(), quaternion: turn.toArray(), isValid };
      link.send(index, [reading]);
      put(told.streams[index], position, turn);
    }
  },
  mark: (ms) => (take === null ? watch(false) : mark(ms)),
  take: () => record(),
  over: () => {
    document.body.dataset.room = "";
    placeBodies();
  },
});

function say(text, quality = "") {
  at("said").textContent = text;
  at("said").className = quality;
  view.tell(text, { good: "#57c878", poor: "#e0a144", bad: "#ff7b72" }[quality] ?? "#e8eaee");
}

/** The stream that a tracker is of: the one that was chosen, and for the other hand the next one, if there is one. */
function streamOf(tracker) {
  if (!told || tracker >= told.streams.length) return null;
  const index = (stream + tracker) % told.streams.length;
  if (!acted.has(index)) act(index);
  return index;
}

/** Shows a body where its tracker says. */
function put(of, position, turn) {
  const mount = new THREE.Quaternion(...of.quaternion_xyzw);
  const body = turn.clone().multiply(mount.invert());
  const place = position.clone().sub(new THREE.Vector3(...of.position_m).applyQuaternion(body));
  view.put(of.body, place, body);
}

/** Shows the motion, or what is acted. */
function watch(isWatched) {
  isWatching = isWatched && view.motion !== null;
  view.played.visible = isWatching;
  view.showLive(!isWatching);
  at("replay").hidden = view.motion === null;
  at("help").hidden = isWatching;
}

async function paired(said) {
  at("pairing").hidden = true;
  told = said;
  // Of a connection that broke: this one has asked for none yet.
  acted.clear();
  at("scene").textContent = said.scene;
  at("help").textContent = HELP_MOUSE;
  const bodies = said.streams.map((of) => of.body);
  const answer = await fetch("/act/scene.glb");
  await view.showScene(await answer.arrayBuffer(), bodies);
  at("stream").replaceChildren(...said.streams.map((of, index) => new Option(of.topic, index)));
  at("stream").hidden = said.streams.length < 2;
  choose(Math.min(stream, said.streams.length - 1));
  placeBodies();
  watch(isWatching);
  document.body.dataset.paired = "yes";
  if (asked.has("calibrate")) calibration.show(true);
}

/** Puts the bodies where a mouse takes them. */
function placeBodies() {
  for (const [index, of] of told.streams.entries()) {
    const side = 0.25 * index - 0.6 * view.radius;
    const place = view.middle.clone().add(new THREE.Vector3(side, 0, 0.4 * view.radius));
    if (index === stream) mouse.place(place, new THREE.Quaternion());
    view.put(of.body, place, new THREE.Quaternion());
  }
}

/** Becomes the tracker of a stream, too. */
function act(index) {
  acted.add(index);
  link.say({ say: "act", stream: index });
}

/** Chooses the stream that is acted. */
function choose(index) {
  stream = index;
  at("stream").value = String(index);
  calibration.offer(told.streams[index].features, told.surfaces);
  act(index);
}

function gone(why) {
  at("record").disabled = at("mark").disabled = true;
  at("now").textContent = why || "the daemon does not answer";
  delete document.body.dataset.paired;
  if (!sessionStorage.getItem("enact.acting.key")) at("pairing").hidden = false;
}

function refused(why) {
  calibration.refused();
  if (link.isPaired) return say(why, "bad");
  at("pairing").querySelector(".why").textContent = why;
  at("pairing").hidden = false;
}

/** The words of what became of a take, with a class that says how good that is. */
function became(of) {
  if (of.state === "estimating" && of.so_far) return [`take ${of.take}: ${of.so_far} so far, and is being checked`, ""];
  if (of.is_good) return [`take ${of.take}: ${of.state}`, "good"];
  const quality = of.is_good === null ? "" : of.is_good ? "good" : of.state === "broken" ? "bad" : "poor";
  return [of.text ? `take ${of.take}: ${of.state}: ${of.text}` : `take ${of.take}: ${of.state}`, quality];
}

function state(said) {
  const wasRunning = take !== null;
  take = said.take;
  at("record").disabled = false;
  at("mark").disabled = take === null;
  at("record").textContent = take === null ? "Record" : "Stop";
  at("record").className = take === null ? "" : "runs";
  at("now").textContent = take === null
    ? said.troubles[0] ?? "no take runs"
    : `take ${take}: ${said.messages} samples, ${said.marks} marks`;
  if (take !== null && !wasRunning) {
    if (!calibration.isOpen) say("");
    watch(false);
  }
  if (calibration.state(said)) return;
  const last = said.takes[0];
  latest = last ?? null;
  if (!last || take !== null) return;
  const [text, quality] = became(last);
  const isOver = last.is_good !== null;
  if (isOver && ended?.take === last.take && ended.verdictMs === undefined) {
    ended.verdictMs = performance.now() - ended.atMs;
  }
  say(isOver && ended?.take === last.take ? `${text} (${afterEnd()})` : text, quality);
  document.body.dataset.verdict = isOver ? `${last.take} ${last.state}` : "";
  if (last.has_motion && shown !== `${last.take} ${last.motions}`) play(last);
  else tellTimes();
}

/** Says how long they took, once both are there. */
function tellTimes() {
  const of = latest;
  const isThere = of !== null && of.is_good !== null && played === `${of.take} ${of.motions}`;
  if (!isThere || ended?.take !== of.take || ended.verdictMs === undefined) return;
  const [text, quality] = became(of);
  say(`${text} (${afterEnd()})`, quality);
  if (ended.checkedMs === undefined) return;
  const times = [ended.verdictMs, ended.motionMs, ended.checkedMs];
  document.body.dataset.afterEnd = times.map(Math.round).join(" ");
  document.body.dataset.motion = String(of.take);
}

/** How long verdict and motion took. */
function afterEnd() {
  const seconds = (ms) => `${(ms / 1000).toFixed(2)} s`;
  const motion = ended.motionMs === undefined ? "" : `motion ${seconds(ended.motionMs)}, `;
  return `${motion}verdict ${seconds(ended.verdictMs)} after the end`;
}

async function play(of) {
  shown = `${of.take} ${of.motions}`;
  const answer = await fetch(`/motion/${of.take}.glb`);
  if (!answer.ok) return;
  await view.showMotion(await answer.arrayBuffer(), performance.now() / 1000);
  at("motion").href = `/motion/${of.take}.glb`;
  at("motion").download = `take-${of.take}.glb`;
  at("time").max = String(view.motion.duration);
  watch(true);
  view.render();
  if (ended?.take === of.take) {
    // The first motion, so far or checked.
    ended.motionMs ??= performance.now() - ended.atMs;
    if (of.is_checked) ended.checkedMs ??= performance.now() - ended.atMs;
  }
  played = `${of.take} ${of.motions}`;
  tellTimes();
}

/** Begins a take, or ends the one that runs. */
export function record() {
  if (take === null) return link.say({ say: "start" });
  if (calibration.isOpen) return calibration.end(take, stream);
  // Until now, in a frame that is late too: of the last mark there are readings.
  if (!headset.session && acted.has(stream)) readMouse(performance.now());
  ended = { take, atMs: performance.now() };
  link.say({ say: "stop" });
}

/** An event happens. @param {number} ms */
export function mark(ms) {
  if (take === null) return;
  link.mark(ms);
}

at("record").onclick = () => record();
at("calibrate").addEventListener("click", () => watch(false));
at("mark").onclick = (event) => mark(event.timeStamp);
at("enter-ar").title = at("enter-vr").title = "begins a session, and ends it";
at("stream").onchange = () => choose(Number(at("stream").value));
at("play").onclick = () => {
  view.isPlaying = !view.isPlaying;
  watch(true);
};
at("time").oninput = () => {
  view.isPlaying = false;
  watch(true);
  view.setTime(Number(at("time").value));
};
addEventListener("keydown", (event) => {
  if (event.target.matches?.("input, select, textarea") || event.repeat) return;
  if (event.code === "Space") mark(event.timeStamp);
  else if (event.code === "Enter") record();
  else return;
  event.preventDefault();
  document.activeElement?.blur();
});
at("pairing").querySelector("form").onsubmit = (event) => {
  event.preventDefault();
  at("pairing").querySelector(".why").textContent = "";
  link.pair(at("code").value);
};

/** The tracker is where its body is and how it is mounted there. */
function reading(of, position, turn, deviceMs) {
  const mount = new THREE.Quaternion(...of.quaternion_xyzw);
  const tracker = new THREE.Vector3(...of.position_m).applyQuaternion(turn).add(position);
  return { deviceMs, position: tracker.toArray(), quaternion: turn.clone().multiply(mount).toArray(), isValid: true };
}

/** Sends where the mouse has the body, until then. @param {number} ms */
function readMouse(ms) {
  const of = told.streams[stream];
  const readings = [];
  mouse.advanceTo(ms, (atMs) => readings.push(reading(of, mouse.position, mouse.turn, atMs)));
  view.put(of.body, mouse.position, mouse.turn);
  link.send(stream, readings);
}

view.renderer.setAnimationLoop((ms, frame) => {
  if (told && frame) headset.read(frame, ms);
  else if (acted.has(stream)) readMouse(ms);
  if (isWatching) {
    view.advance(ms / 1000);
    at("time").value = String(view.motion.time);
    at("clock").textContent = `${view.motion.time.toFixed(2)} s`;
    at("play").textContent = view.isPlaying ? "Pause" : "Play";
  }
  view.render();
});

for (const [mode, button] of [["immersive-vr", at("enter-vr")], ["immersive-ar", at("enter-ar")]]) {
  button.onclick = async () => {
    if (headset.session) return headset.leave();
    try {
      headset.isOfRoom = at("place").value === "room";
      await headset.enter(mode);
      document.body.dataset.room = mode;
    } catch (error) {
      say(`no session: ${error.message}`, "bad");
    }
  };
}
modes().then((known) => {
  at("enter-vr").hidden = !known.includes("immersive-vr");
  at("enter-ar").hidden = !known.includes("immersive-ar");
  at("place").hidden = known.length === 0;
});

// For who looks from outside, as the browser's check does.
window.enactSeenAt = () => mouse.seenAt();
window.enactRoom = () => ({ headset, space: view.renderer.xr.getReferenceSpace() });
window.enactBody = () => ({ ...mouse.position, pixelsPerMetre: view.pixelsPer(mouse.position) });

// The link that the daemon prints has the code after #, where browsers keep it to themselves.
const code = asked.get("code");
if (code) {
  history.replaceState(null, "", location.pathname);
  at("code").value = code;
  link.pair(code);
} else {
  link.resume();
}
