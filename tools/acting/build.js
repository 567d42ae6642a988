// Makes the acting page of its sources: one file that needs nothing else, dist/acting.html.
import { mkdir, readFile, writeFile } from "node:fs/promises";
import { dirname, join } from "node:path";
import { fileURLToPath } from "node:url";
import { build } from "esbuild";

const home = dirname(fileURLToPath(import.meta.url));

const made = await build({
  entryPoints: [join(home, "src/main.js")],
  bundle: true,
  minify: true,
  format: "iife",
  target: "es2022",
  // Licences of what is bundled go along.
  legalComments: "inline",
  write: false,
});
// What ends a script must not be in it.
const script = made.outputFiles[0].text.replaceAll("</script", "<\\/script");
const page = await readFile(join(home, "src/acting.html"), "utf8");
const licence = await readFile(join(home, "node_modules/three/LICENSE"), "utf8");
const html = page
  .replace("<!-- licences -->", () => `<!--\nWith three.js:\n\n${licence.trim()}\n-->`)
  .replace("<!-- script -->", () => `<script>${script}</script>`);
await mkdir(join(home, "dist"), { recursive: true });
await writeFile(join(home, "dist/acting.html"), html);
console.log(`dist/acting.html: ${Math.round(html.length / 1024)} KiB`);
