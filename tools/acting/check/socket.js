// Takes by a WebSocket without a page: what the daemon alone takes.
import { request } from "node:http";
import { message } from "../src/reading.js";
import { SLOW, throwFrom } from "./throws.js";

const START = { x: -0.2, z: 0.45 };
const RATE_HZ = 90;

/** A WebSocket of a page of the daemon's own, as far as this needs one: RFC 6455 without fragments. */
class Socket {
  /** @param {import("node:net").Socket} stream */
  constructor(stream, head) {
    this.stream = stream;
    this.rest = head;
    this.heard = [];
    this.waiting = [];
    stream.on("data", (part) => this.#take(part));
  }

  static open(url, path) {
    const { host, hostname, port } = new URL(url);
    const headers = {
      Host: host, Origin: url, Upgrade: "websocket", Connection: "Upgrade",
      "Sec-WebSocket-Key": "dGhlIHNhbXBsZSBub25jZQ==", "Sec-WebSocket-Version": "13",
    };
    return new Promise((done, fail) => {
      const asked = request({ hostname, port, path, headers });
      asked.on("upgrade", (_, stream, head) => {
        const socket = new Socket(stream, Buffer.alloc(0));
        if (head.length > 0) socket.#take(head);
        done(socket);
      });
      asked.on("response", (answer) => fail(new Error(`${answer.statusCode}`)));
      asked.on("error", fail);
      asked.end();
    });
  }

  #take(part) {
    this.rest = Buffer.concat([this.rest, part]);
    for (;;) {
      if (this.rest.length < 2) return;
      const short = this.rest[1] & 127;
      const begin = short === 126 ? 4 : short === 127 ? 10 : 2;
      if (this.rest.length < begin) return;
      const length = short === 126 ? this.rest.readUInt16BE(2) : short === 127 ? Number(this.rest.readBigUInt64BE(2)) : short;
      if (this.rest.length < begin + length) return;
      const data = this.rest.subarray(begin, begin + length);
      const opcode = this.rest[0] & 15;
      this.rest = this.rest.subarray(begin + length);
      if (opcode === 9) this.send(data, 10);
      if (opcode !== 1) continue;
      this.heard.push({ atMs: performance.now(), said: JSON.parse(data.toString()) });
      for (const look of [...this.waiting]) look();
    }
  }

  send(data, opcode) {
    const head = Buffer.from([128 | opcode, 128 | 126, 0, 0, 0, 0, 0, 0]);
    head.writeUInt16BE(data.length, 2);
    this.stream.write(Buffer.concat([head, data]));
  }

  say(what) {
    this.send(Buffer.from(JSON.stringify(what)), 1);
  }

  /** The first message from now on, or of those heard, that is so, and when it came. */
  hear(isSo) {
    return new Promise((done, fail) => {
      const timer = setTimeout(() => fail(new Error("nothing heard")), 60_000);
      const look = () => {
        const found = this.heard.find((of) => isSo(of.said));
        if (!found) return;
        clearTimeout(timer);
        this.waiting = this.waiting.filter((of) => of !== look);
        done(found);
      };
      this.waiting.push(look);
      look();
    });
  }
}

const pause = (ms) => new Promise((done) => setTimeout(done, ms));

/** Takes, one after the other; how long each took after its end [ms]. */
export async function socketTakes({ daemon }, count) {
  const link = new URL(daemon.ready.acting);
  const socket = await Socket.open(link.origin, "/act/socket");
  socket.say({ say: "pair", code: link.hash.slice("#code=".length) });
  await socket.hear((of) => of.what === "paired");
  socket.say({ say: "act", stream: 0 });
  const { fallS, endS, place } = throwFrom(START);
  const takes = [];
  let sequence = 0;
  while (takes.length < count) {
    socket.heard = [];
    socket.say({ say: "start" });
    const { said: { take } } = await socket.hear((of) => of.what === "state" && of.take !== null);
    const begun = performance.now();
    let [sent, marks] = [0, 0];
    const marksS = [SLOW * fallS, SLOW * endS];
    while (marks < 2) {
      const nowS = (performance.now() - begun) / 1000;
      for (; sent / RATE_HZ <= nowS; sent += 1) {
        const { x, z } = place(Math.min(endS, sent / RATE_HZ / SLOW));
        const wave = 0.002 * Math.sin(5.7 * (sent / RATE_HZ) + takes.length);
        const reading = { sequence: sequence++, deviceMs: begun + (1000 * sent) / RATE_HZ, position: [x + wave, wave, z + wave],
          quaternion: [0, 0, 0, 1], isValid: true };
        socket.send(Buffer.from(message(0, [reading])), 2);
      }
      if (nowS >= marksS[marks]) {
        socket.say({ say: "mark", event: "", device_ns: Math.round(1e6 * (begun + 1000 * marksS[marks])) });
        marks += 1;
      }
      await pause(2);
    }
    await pause(100);
    const endedMs = performance.now();
    socket.say({ say: "stop" });
    const of = (said) => said.what === "state" && said.take === null && said.takes.find((line) => line.take === take);
    const motion = await socket.hear((said) => of(said) && of(said).has_motion);
    const verdict = await socket.hear((said) => of(said) && of(said).is_good !== null);
    const checked = await socket.hear((said) => of(said) && of(said).is_checked);
    const after = ({ atMs }) => atMs - endedMs;
    takes.push({ motionMs: after(motion), verdictMs: after(verdict), checkedMs: after(checked), state: of(checked.said).state });
    await pause(300);
  }
  socket.stream.destroy();
  return takes;
}
