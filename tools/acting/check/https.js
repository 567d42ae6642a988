// By HTTPS, as from another device: the certificate that nobody has signed is refused unless somebody accepts it, the
// code is typed, and a take goes out and comes back over wss.
import { connect } from "node:tls";
import { wellActed } from "./mouse.js";
import { accountOf, assert, opened } from "./page.js";

/** SHA-256 of the certificate that a server shows. */
function fingerprintOf({ hostname, port }) {
  return new Promise((done, fail) => {
    const socket = connect({ host: hostname, port, rejectUnauthorized: false }, () => {
      done(socket.getPeerCertificate().fingerprint256);
      socket.destroy();
    });
    socket.on("error", fail);
  });
}

/** Why a browser that accepts nothing does not open it, or null. */
async function whyNot(browser, link) {
  const context = await browser.newContext();
  const page = await context.newPage();
  const why = await page.goto(link).then(() => null, (error) => error.message);
  await context.close();
  return why;
}

export async function https({ browser, begin }) {
  const daemon = await begin("https", undefined, ["--https=0"]);
  const { link, fingerprint } = daemon.ready.https;
  const of = new URL(link);
  assert.equal(of.protocol, "https:");
  assert.equal(await fingerprintOf(of), fingerprint);
  assert.match(await whyNot(browser, link), /ERR_CERT_AUTHORITY_INVALID/);

  const sockets = [];
  const open = async () => {
    const prepare = (page) => page.on("websocket", (socket) => sockets.push(socket.url()));
    // Without the code, which is typed.
    const bare = new URL(of.pathname, of).href;
    const all = await opened(browser, bare, { ignoreHTTPSErrors: true }, prepare);
    const { page } = all;
    assert.ok(await page.evaluate(() => isSecureContext && "xr" in navigator));
    assert.equal(await page.getAttribute("body", "data-paired"), null);
    await page.fill("#code", of.hash.slice("#code=".length));
    await page.click("#pairing button");
    await page.waitForSelector("body[data-paired=yes]");
    for (const elsewhere of ["/", "/metrics", "/health"]) {
      const answer = await page.request.get(new URL(elsewhere, of).href);
      assert.equal(answer.status(), 404, elsewhere);
    }
    return all;
  };
  const came = await wellActed({ browser, daemon, open });
  assert.deepEqual([...new Set(sockets)], [`wss://${of.host}/act/socket`]);
  const way = sockets[0].replace(of.host, "…");
  return [`${way}, the certificate is the one that was said`, ...came.tried, ...accountOf(came)];
}
