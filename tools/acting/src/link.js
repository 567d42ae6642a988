// The page's connection to the daemon: the code first, then readings out and takes in.
import { READINGS, message, nanoseconds } from "./reading.js";

/** Between two tries to come back [ms]. */
const AGAIN_MS = 1000;

/** What may wait to be sent before readings are left out [bytes]. */
const WAITING_BYTES = 64 * 1024;

/** Where the key is kept until the tab is closed. */
const KEY = "enact.acting.key";

/** @typedef {import("./reading.js").Reading} Reading */

/**
 * What the daemon says, in turn: `paired`, `state`, `refused`, and of the page itself `gone`.
 * @callback Said
 * @param {any} said
 */

export class Link {
  /** @param {Said} said */
  constructor(said) {
    this.said = said;
    this.socket = null;
    this.isPaired = false;
    /** Numbers of the next readings, by their streams. */
    this.sequences = new Map();
    this.leftOut = 0;
  }

  /** Comes back with the key of before, if there is one; whether there is. */
  resume() {
    const key = sessionStorage.getItem(KEY);
    if (key) this.#open({ say: "resume", key });
    return key !== null;
  }

  /** @param {string} code the six digits */
  pair(code) {
    this.#open({ say: "pair", code });
  }

  /** @param {object} first what is said first */
  #open(first) {
    this.socket?.close();
    const scheme = location.protocol === "https:" ? "wss" : "ws";
    const socket = new WebSocket(`${scheme}://${location.host}/act/socket`);
    this.socket = socket;
    socket.binaryType = "arraybuffer";
    socket.onopen = () => socket.send(JSON.stringify(first));
    socket.onmessage = (event) => {
      const said = JSON.parse(event.data);
      if (said.what === "paired") {
        this.isPaired = true;
        this.sequences.clear();
        sessionStorage.setItem(KEY, said.key);
      } else if (said.what === "refused" && !this.isPaired) {
        sessionStorage.removeItem(KEY);
      }
      this.said(said);
    };
    socket.onclose = (event) => {
      if (this.socket !== socket) return;
      const wasPaired = this.isPaired;
      this.isPaired = false;
      this.said({ what: "gone", why: event.reason });
      // Who was let in comes back; who was not types the code again.
      if (wasPaired || (first.say === "resume" && sessionStorage.getItem(KEY))) {
        setTimeout(() => this.socket === socket && this.resume(), AGAIN_MS);
      }
    };
  }

  /** @param {object} what */
  say(what) {
    if (this.isPaired) this.socket.send(JSON.stringify(what));
  }

  /** An event happens, then on the page's clock. @param {number} deviceMs */
  mark(deviceMs) {
    this.say({ say: "mark", event: "", device_ns: nanoseconds(deviceMs) });
  }

  /**
   * Sends readings of a stream, numbered; leaves them out where the network does not keep up: their numbers are
   * missing then.
   * @param {number} stream
   * @param {Omit<Reading, "sequence">[]} readings
   */
  send(stream, readings) {
    if (!this.isPaired || readings.length === 0) return;
    let sequence = this.sequences.get(stream) ?? 0;
    const numbered = readings.map((reading) => ({ ...reading, sequence: sequence++ }));
    this.sequences.set(stream, sequence);
    if (this.socket.bufferedAmount > WAITING_BYTES) {
      this.leftOut += numbered.length;
      return;
    }
    for (let at = 0; at < numbered.length; at += READINGS) {
      this.socket.send(message(stream, numbered.slice(at, at + READINGS)));
    }
  }
}
