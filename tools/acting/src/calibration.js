// Calibrations step by step: each step is a take, which goes aside and is then given to the daemon's calibrations.

const at = (id) => document.getElementById(id);

/** What is done in each step, and what the page asks for with it. */
const STEPS = {
  rest: {
    todo: "Put the object down on one side, say which way is up, and let it stand for ten seconds. Then on another side.",
    fields: ["stands"],
  },
  pivot: {
    todo: "Hold the tip in one place, a dimple if there is one, and swing the object about two axes for twenty seconds.",
    fields: ["feature"],
  },
  plane: {
    todo: "Touch the table with the tip at three places or more, not in a line; stay for a moment, and mark each touch.",
    fields: ["feature", "surface"],
  },
};

/** Digits after the point that say something, of a number in its unit. */
const short = (number) => Number(number.toPrecision(4)).toString();

/** What was found, in a line. */
function lineOf({ name, unit, value, lower = [], upper = [] }) {
  const halves = upper.map((end, index) => short((end - lower[index]) / 2));
  const within = halves.length > 0 ? ` ± ${halves.join(", ")}` : "";
  return `${name}: ${value.map(short).join(", ")}${within} ${unit}`.trim();
}

export class Calibration {
  /**
   * @param {import("./link.js").Link} link
   * @param {(text: string, quality?: string) => void} say
   * @param {(text: string) => void} tell where the page is not seen
   */
  constructor(link, say, tell) {
    this.link = link;
    this.say = say;
    this.tell = tell;
    /** The take that is one of its own, once it has ended, until the daemon has put it aside. */
    this.ending = null;
    /** Whether the daemon has been asked, and has not answered. */
    this.isAsked = false;
    /** Takes of an object at rest, with what was up. */
    this.rests = [];
    at("calibrate").onclick = () => this.show(at("calibration").hidden);
    at("step").onchange = () => this.#choose();
    // Keys are for takes and marks again.
    at("calibration").onchange = (event) => event.target.blur();
    at("copy").onclick = async () => {
      at("keys").select();
      await navigator.clipboard?.writeText(at("keys").value).catch(() => {});
    };
  }

  /** Whether takes are its own. */
  get isOpen() {
    return !at("calibration").hidden;
  }

  /** @param {boolean} isShown */
  show(isShown) {
    at("calibration").hidden = !isShown;
    at("calibrate").setAttribute("aria-expanded", String(isShown));
    this.say("");
    if (isShown) this.#choose();
  }

  /** Takes in what the daemon has: features of the body that is acted, and surfaces. */
  offer(features, surfaces) {
    at("feature").replaceChildren(...features.map((name) => new Option(name)));
    at("surface").replaceChildren(...(surfaces.length > 0 ? surfaces : ["table"]).map((name) => new Option(name)));
    this.#choose();
  }

  #choose() {
    const { todo, fields } = STEPS[at("step").value];
    at("todo").textContent = todo;
    for (const name of ["stands", "feature", "surface"]) {
      const field = at(name);
      field.parentElement.hidden = !fields.includes(name) || field.options.length === 0;
    }
    if (this.isOpen) this.tell(todo);
  }

  /** Ends its take. @param {number} take @param {number} stream */
  end(take, stream) {
    this.ending = { take, stream };
    this.link.say({ say: "discard" });
  }

  /** Takes in how everything stands; whether that is of a take of its own. */
  state({ take, takes }) {
    if (this.ending === null || take !== null || takes[0]?.take !== this.ending.take) return this.isOpen;
    if (takes[0].state !== "discarded") return true;
    const { take: number, stream } = this.ending;
    this.ending = null;
    const step = at("step").value;
    const asked = { say: "calibrate", step, stream, takes: [number] };
    const feature = at("feature").value;
    if (step === "rest") {
      this.rests = this.rests.filter((rest) => rest.stands !== at("stands").value);
      this.rests.push({ take: number, stands: at("stands").value });
      asked.takes = this.rests.map((rest) => rest.take);
      asked.stands = this.rests.map((rest) => rest.stands);
    } else if (feature) {
      asked.feature = feature;
    }
    if (step === "plane") asked.surface = at("surface").value;
    this.say("calibrating");
    this.isAsked = true;
    this.link.say(asked);
    return true;
  }

  /** Shows what was found. */
  found({ step, is_good, quantity, against, keys, file, scene }) {
    this.isAsked = false;
    document.body.dataset.calibrated = step;
    this.say(against[0] ?? `${step}: found`, is_good ? "good" : "poor");
    at("found").replaceChildren(...[...against, ...quantity.map(lineOf)].map((text, index) => {
      const line = document.createElement("li");
      line.textContent = text;
      line.className = index < against.length ? "against" : "";
      return line;
    }));
    at("keys").value = keys;
    at("keys").rows = Math.max(2, keys.split("\n").length);
    at("pasted").hidden = keys === "";
    at("files").textContent = scene ? `${file}; the whole scene with it: ${scene}` : file;
  }

  /** What is refused: of an object at rest the last side is made anew. */
  refused() {
    if (this.isAsked && at("step").value === "rest") this.rests.pop();
    this.isAsked = false;
    this.ending = null;
  }
}
