// Opens a page with three.js and applyC1 in a browser without a window. CHROMIUM is the browser.

import { fileURLToPath } from "node:url";
import { chromium } from "playwright-core";

const PAGE = `<!doctype html>
<link rel="icon" href="data:,">
<script type="importmap">{ "imports": { "three": "/node_modules/three/build/three.module.js" } }</script>
<script type="module">
  import * as THREE from "three";
  import { applyC1 } from "/index.js";
  Object.assign(window, { THREE, applyC1 });
</script>`;

// Returns the page and what it complained about; close page.context().browser() at the end.
export async function open() {
  const browser = await chromium.launch({
    executablePath: process.env.CHROMIUM ?? "/usr/bin/chromium",
    args: ["--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--ignore-gpu-blocklist", "--no-first-run",
           "--disable-background-networking", "--disable-component-update", "--disable-sync", "--disable-quic"],
  });
  const page = await browser.newPage(), faults = [];
  page.on("pageerror", (error) => faults.push(error.message));
  // Drivers tell how long they take to give pixels back.
  const matters = (message) => ["error", "warning"].includes(message.type()) && !message.text().includes("GPU stall");
  page.on("console", (message) => matters(message) && faults.push(message.text()));
  await page.route("http://c1.test/**", (route) => {
    const { pathname } = new URL(route.request().url());
    const file = () => ({ path: fileURLToPath(new URL(`.${pathname}`, import.meta.url)) });
    return route.fulfill(pathname === "/" ? { contentType: "text/html", body: PAGE } : file());
  });
  await page.goto("http://c1.test/");
  await page.waitForFunction("window.applyC1", null, { timeout: 60_000 });
  return { page, faults };
}
