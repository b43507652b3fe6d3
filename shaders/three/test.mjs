// Joins the seams of shapes; opens the page in a browser without a window and holds its pixels against the pictures of `machband shade`: at most 2
// codes apart inside the outline, apart from one pixel in ten thousand, where one part may hide another. `node
// test.mjs`; MACHBAND is the program, CHROMIUM the browser.

import { execFileSync } from "node:child_process";
import { mkdtempSync, readFileSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { fileURLToPath } from "node:url";
import { chromium } from "playwright-core";
import { PNG } from "pngjs";
import * as THREE from "three";
import { shared } from "../ordinates.js";
import { serve } from "./serve.mjs";

const SIDE = 512, FILL = 0.9, ROTATE = [25, -35, 10], MOST = 2;
const MACHBAND = process.env.MACHBAND ?? fileURLToPath(new URL("../../target/debug/machband", import.meta.url));
const CHROMIUM = process.env.CHROMIUM ?? "/usr/bin/chromium";

const folder = mkdtempSync(join(tmpdir(), "c1-"));
const { server, address } = await serve();
const browser = await chromium.launch({
  executablePath: CHROMIUM,
  args: ["--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--ignore-gpu-blocklist", "--no-first-run",
         "--disable-background-networking", "--disable-component-update", "--disable-sync", "--disable-quic"],
});
let failed = false;
// The seams of three.js's own shapes, where positions differ by rounding errors, are joined.
for (const [shape, joined] of [[new THREE.TorusGeometry(1, 0.4, 8, 16), 8 * 16], [new THREE.SphereGeometry(1, 16, 10), 9 * 16 + 2]]) {
  const { position, normal } = shape.attributes, found = shared(position.array, normal.array, shape.index.array).positions.length / 3;
  console.log(`${shape.type}: ${position.count} vertices become ${found}; expected ${joined}`);
  failed ||= found !== joined;
}
try {
  const mesh = fileURLToPath(new URL("mesh.glb", import.meta.url));
  const page = await browser.newPage({ viewport: { width: 1200, height: 560 } });
  const faults = [];
  page.on("pageerror", (error) => faults.push(error.message));
  page.on("console", (message) => ["error", "warning"].includes(message.type()) && faults.push(message.text()));
  await page.goto(address);
  await page.waitForFunction("window.ready", null, { timeout: 60_000 });
  if (process.env.SCREENSHOT) await page.screenshot({ path: process.env.SCREENSHOT });
  for (const [shader, distance] of [["gouraud", 0], ["phong", 0], ["c1-phong", 0], ["c1-phong", 3], ["matt", 0], ["matt", 3]]) {
    const out = join(folder, "picture.png");
    execFileSync(MACHBAND, [
      "shade", "--mesh", mesh, "--shader", shader === "matt" ? "c1-phong" : shader, "--rotate", ROTATE.join(), "--size", `${SIDE}`, "--background", "0",
      "--force", "--ambient", "0.1", "--diffuse", "0.6", "--specular", shader === "matt" ? "0" : "0.3", "--shininess", "20", "--out", out,
      "--distance", distance ? `${distance}` : "inf",
    ]);
    const { data } = PNG.sync.read(readFileSync(out));
    const page_codes = await page.evaluate(
      ([shader, view]) => window.codes(shader, view), [shader, { side: SIDE, rotate: ROTATE, fill: FILL, distance }],
    );
    // The page's rows begin at the bottom.
    const of = [(x, y) => page_codes[4 * ((SIDE - 1 - y) * SIDE + x)], (x, y) => data[4 * (y * SIDE + x)]];
    let worst = 0, compared = 0, above = 0;
    for (let y = 2; y < SIDE - 2; y++) {
      for (let x = 2; x < SIDE - 2; x++) {
        // Inside the outline: both show the surface everywhere around, without steps.
        const around = of.map((code) => [-2, -1, 0, 1, 2].flatMap((dy) => [-2, -1, 0, 1, 2].map((dx) => code(x + dx, y + dy))));
        if (around.some((codes) => Math.min(...codes) === 0 || Math.max(...codes) - Math.min(...codes) > 20)) continue;
        const difference = Math.abs(of[0](x, y) - of[1](x, y));
        worst = Math.max(worst, difference);
        above += difference > MOST;
        compared++;
      }
    }
    const view = distance ? `perspective from ${distance} radii` : "parallel projection";
    console.log(`${shader}, ${view}: at most ${worst} codes apart over ${compared} pixels${above ? `, ${above} above ${MOST}` : ""}`);
    failed ||= above > compared / 10_000 || compared < 30_000;
  }
  if (faults.length > 0) {
    console.error(faults.join("\n"));
    failed = true;
  }
} finally {
  await browser.close();
  server.close();
  rmSync(folder, { recursive: true });
}
process.exit(failed ? 1 : 0);
