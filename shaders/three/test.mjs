// Joins the seams of shapes; draws in a browser without a window and holds the pixels against the pictures of `machband
// shade`: at most 2 codes apart inside the outline, apart from one pixel in ten thousand, where one part may hide another;
// and uses applyC1 as programs do. `npm test`; MACHBAND is the program and CHROMIUM the browser.
//
// `npm test -- --speed [rounds]` measures the cost instead, with SwiftShader, in one page whose draws alternate: C1 normals
// over the material alone, with medians of frames that the page waits for; and, for 100,352 triangles, the time of JavaScript
// for preparing them and for a frame in which they turn.

import { execFileSync } from "node:child_process";
import { mkdtempSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { fileURLToPath } from "node:url";
import { chromium } from "playwright-core";
import { PNG } from "pngjs";
import * as THREE from "three";
import { RoundedBoxGeometry } from "three/addons/geometries/RoundedBoxGeometry.js";
import { applyC1 } from "./index.js";
import { welded } from "./ordinates.js";

// A page with three.js and applyC1.
const PAGE = `<!doctype html>
<link rel="icon" href="data:,">
<script type="importmap">{ "imports": { "three": "/node_modules/three/build/three.module.js" } }</script>
<script type="module">
  import * as THREE from "three";
  import { applyC1 } from "/index.js";
  Object.assign(window, { THREE, applyC1 });
</script>`;

// Returns the page and what it complained about; close page.context().browser() at the end.
async function open() {
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

const SIDE = 512, MOST = 2;
const MACHBAND = process.env.MACHBAND ?? fileURLToPath(new URL("../../target/debug/machband", import.meta.url));

let failed = false;
const expect = (is, text) => {
  console.log(`${is ? "" : "FAILED: "}${text}`);
  failed ||= !is;
};

// The seams of three.js's own shapes, where positions differ by rounding errors, are joined, whatever their size.
const seams = [[new THREE.TorusGeometry(1, 0.4, 8, 16), 8 * 16], [new THREE.SphereGeometry(1, 16, 10), 9 * 16 + 2]];
for (const [shape, joined] of seams) {
  for (const size of [1, 1e-6, 1e6]) {
    const { position, normal } = shape.clone().scale(size, size, size).attributes;
    const found = welded(position.array, normal.array, shape.index.array).positions.length / 3;
    expect(found === joined, `${shape.type} of size ${size}: ${position.count} vertices become ${found}; expected ${joined}`);
  }
}

// A vertex may be anywhere, but nowhere else; and only meshes that get C1 normals are listed as such.
const sphere = (x, material) => {
  const geometry = new THREE.SphereGeometry(1, 8, 6);
  geometry.attributes.position.setX(0, x);
  return new THREE.Mesh(geometry, material);
};
for (const x of [1e13, 3e38]) {
  const { position, normal } = sphere(x).geometry.attributes;
  const found = welded(position.array, normal.array).positions.length / 3;
  expect(found > 5 * 8, `a vertex at ${x}: ${position.count} vertices become ${found}`);
}
const thrown = (by) => {
  try {
    by();
  } catch (error) {
    return error;
  }
};
const { position: places, normal: normals } = sphere(0).geometry.attributes;
for (const [short, index, word] of [[3, undefined, "the same number"], [0, [0, 1, 1e6], "index 1000000"], [0, [0, 1, -1], "index -1"]]) {
  const error = thrown(() => welded(places.array, normals.array.slice(short), index));
  expect(error instanceof RangeError && error.message.includes(word), `a mesh that is not one: ${error}`);
}
const smooth = sphere(0, new THREE.MeshStandardMaterial()), others = [
  sphere(Infinity, new THREE.MeshStandardMaterial()), sphere(0, new THREE.MeshStandardMaterial({ flatShading: true })),
  sphere(0, new THREE.MeshBasicMaterial()), sphere(0, new THREE.ShaderMaterial()), sphere(0, []),
];
const outside = sphere(0, new THREE.MeshStandardMaterial());
outside.geometry.index.setX(0, 1e4);
others.push(outside);
const refusal = thrown(() => applyC1({ scene: smooth }));
expect(refusal instanceof TypeError && refusal.message.endsWith("expected one, such as gltf.scene"), `a glTF: ${refusal}`);
const { meshes, skipped } = applyC1(new THREE.Group().add(smooth, ...others));
expect(meshes.length === 1 && meshes[0] === smooth, `applied to ${meshes.length} mesh; expected 1`);
const reasons = skipped.map(({ reason }) => reason).join();
const wanted = ["a position is not finite", "it is flat-shaded", "its material uses no normals",
  "its shader does not have #include <normal_pars_fragment>, where C1 normals belong", "it lacks a material",
  "an index is not that of a position"];
expect(reasons === wanted.join(), `skipped: ${reasons}`);

// Shapes whose curvature jumps: planes and cylinders that continue into roundings.
function lathe() {
  const half = [-90, -90, -67.5, -45, -22.5, 0], sides = 24;
  const angles = [...half, ...half.map((angle) => -angle).reverse()].map(THREE.MathUtils.degToRad), last = angles.length - 1;
  const geometry = new THREE.LatheGeometry(angles.map((angle, i) => new THREE.Vector2(
    i === 0 || i === last ? 0 : 0.5 + 0.1 * Math.cos(angle), (i < half.length ? -0.7 : 0.7) + 0.1 * Math.sin(angle),
  )), sides);
  // Normals of the surface, as modeling programs write them.
  const { normal } = geometry.attributes, place = new THREE.Vector3();
  for (let v = 0; v < normal.count; v++) {
    const angle = angles[v % angles.length], turn = (2 * Math.PI * Math.floor(v / angles.length)) / sides;
    normal.setXYZ(v, ...place.setFromSphericalCoords(1, Math.PI / 2 - angle, turn));
  }
  return geometry;
}
const shapes = {
  knot: new THREE.TorusKnotGeometry(0.7, 0.25, 96, 12), lathe: lathe(), capsule: new THREE.CapsuleGeometry(0.5, 1, 8, 20),
  "rounded box": new RoundedBoxGeometry(1.6, 1.2, 1, 4, 0.1),
};
const plain = (geometry) => {
  const { position, normal } = geometry.attributes;
  // Joined, so that the program sees the same seams.
  const joined = welded(position.array, normal.array, geometry.index?.array);
  // Shapes that are turned around an axis have triangles without area there.
  const isFace = (t) => new Set(t).size === 3, triples = [];
  for (let i = 0; i < joined.triangles.length; i += 3) triples.push(Array.from(joined.triangles.slice(i, i + 3)));
  return { positions: Array.from(joined.positions), normals: Array.from(joined.normals), index: triples.filter(isFace).flat() };
};

const folder = mkdtempSync(join(tmpdir(), "c1-"));
function picture({ file, shader, shine, distance }) {
  const out = join(folder, "picture.png");
  execFileSync(MACHBAND, [
    "shade", "--mesh", file, "--shader", shader, "--rotate", "25,-35,10", "--size", `${SIDE}`, "--background", "0", "--force",
    "--ambient", "0.1", "--diffuse", "0.6", "--specular", shine ? "0.3" : "0", "--shininess", "20",
    "--distance", distance ? `${distance}` : "inf", "--out", out,
  ], { stdio: "pipe" });
  return PNG.sync.read(readFileSync(out)).data;
}

// Runs in the page: what users do with applyC1.
async function usage() {
  const { THREE, applyC1 } = window, side = 128, results = {}, told = [];
  const renderer = new THREE.WebGLRenderer(), camera = new THREE.PerspectiveCamera(40, 1, 0.1, 100);
  camera.position.z = 5;
  const target = new THREE.WebGLRenderTarget(side, side), light = new THREE.DirectionalLight(0xffffff, 3);
  const seen = (scene, eye = camera, by = renderer) => {
    const pixels = new Uint8Array(4 * side * side);
    by.setRenderTarget(target);
    by.render(scene, eye);
    by.readRenderTargetPixels(target, 0, 0, side, side, pixels);
    by.setRenderTarget(null);
    return pixels;
  };
  const apart = (a, b) => a.reduce((most, code, i) => Math.max(most, Math.abs(code - b[i])), 0);
  const says = (how) => (text) => told.push(`${how} ${text}`), { warn, info } = console;
  Object.assign(console, { warn: says("warn"), info: says("info") });
  const knot = new THREE.TorusKnotGeometry(0.5, 0.2, 48, 10), material = new THREE.MeshStandardMaterial({ roughness: 0.3 });
  const parts = [knot, knot, new THREE.CylinderGeometry(0.4, 0.4, 0.8, 16)].map((geometry, i) =>
    new THREE.Mesh(geometry, i < 2 ? material : [material, new THREE.MeshToonMaterial(), new THREE.MeshNormalMaterial()]));
  parts.forEach((mesh, i) => mesh.position.set(i - 1, i - 1, 0));
  const scene = new THREE.Scene().add(light, ...parts), second = new THREE.OrthographicCamera(-2, 2, 2, -2, 0.1, 10);
  second.position.set(1, 2, 4);
  second.lookAt(0, 0, 0);
  const before = seen(scene), { textures } = renderer.info.memory;
  let applied = applyC1(scene, { gpu: false });
  const own = seen(scene), other = seen(scene, second);
  results["a shared material, and three materials in one mesh"] = applied.meshes.length === 3 && apart(before, own) > 10;
  results["a second camera does not disturb the first"] = apart(own, seen(scene)) === 0;
  const copy = parts[0].clone();
  copy.position.set(1, -1, 0);
  scene.add(copy);
  seen(scene);
  applyC1(copy).dispose();
  scene.remove(copy);
  results["copies are named, and then drawn"] = told.length === 1 && told[0].includes("copies") && apart(own, seen(scene)) === 0;
  applied.dispose();
  results["dispose gives everything back"] = apart(before, seen(scene)) === 0 && renderer.info.memory.textures === textures;
  for (const way of ["the card", "few varyings"]) {
    if (way === "few varyings") renderer.capabilities.maxVaryings = 15;
    applied = applyC1(scene, { gpu: way === "the card" });
    results[`the same picture with ${way}`] = Math.max(apart(own, seen(scene)), apart(other, seen(scene, second))) <= 1;
    applied.dispose();
  }
  results["dispose frees the card's textures"] = renderer.info.memory.textures === textures;
  const uneven = new THREE.Mesh(knot, material), many = new THREE.InstancedMesh(knot, material, 1);
  many.setMatrixAt(0, new THREE.Matrix4());
  uneven.scale.set(1, 2, 1);
  for (const [mesh, first, word] of [[uneven, "warn", "unevenly"], [many, "info", "many places"]]) {
    told.length = 0;
    const alone = new THREE.Scene().add(light, mesh), phong = seen(alone);
    applied = applyC1(alone);
    const most = apart(phong, seen(alone));
    seen(alone);
    applied.dispose();
    const isNamed = told.length === 1 && told[0].startsWith(first) && told[0].includes(word);
    results[`${word}: named once`] = isNamed && (most > 0) === (first === "info");
  }
  applied = applyC1(scene.add(light), { gpu: true });
  seen(scene);
  const another = new THREE.WebGLRenderer(), reversed = new THREE.WebGLRenderer({ reversedDepthBuffer: true });
  results["the same picture with another renderer"] = apart(own, seen(scene, camera, another)) <= 1;
  results["the same picture with a reversed depth buffer"] = apart(own, seen(scene, camera.clone(), reversed)) <= 1;
  for (const happens of ["Loss", "Restore"]) {
    another[`forceContext${happens}`]();
    await new Promise((resolve) => setTimeout(resolve, 200));
  }
  results["the same picture after a lost context"] = apart(own, seen(scene, camera, another)) <= 1;
  told.length = 0;
  parts[0].geometry.attributes.position.needsUpdate = true;
  const changed = seen(scene);
  results["a changed geometry is named"] = apart(own, changed) > 10 && told.length === 2 && told[0].includes("has changed");
  Object.assign(console, { warn, info });
  return results;
}

// Runs in the page: a mesh as machband sees it, in codes from the bottom row on, with the lights of three.js and no shine; or,
// with `shine`, with machband's own light in a user's onBeforeCompile.
function codes({ positions, normals, index, shader, shine, gpu, side, distance }) {
  const { THREE, applyC1 } = window, renderer = (window.renderer ??= new THREE.WebGLRenderer());
  const attribute = (array) => new THREE.Float32BufferAttribute(array, 3), material = new THREE.MeshPhongMaterial({ specular: 0 });
  const geometry = new THREE.BufferGeometry().setAttribute("position", attribute(positions))
    .setAttribute("normal", attribute(normals)).setIndex(index);
  const lamp = new THREE.Vector3(0.36, 0.48, 0.8);
  if (shine) {
    // Reflection after Phong, where three.js has that after Blinn.
    material.onBeforeCompile = (shader) => {
      shader.fragmentShader = shader.fragmentShader.replace("#include <opaque_fragment>", `
        vec3 lamp = normalize(vec3(${lamp.toArray()})), eye = isOrthographic ? vec3(0.0, 0.0, 1.0) : normalize(vViewPosition);
        float cosine = dot(normal, lamp), shine = max(2.0 * cosine * dot(normal, eye) - dot(lamp, eye), 0.0);
        outgoingLight = vec3(cosine > 0.0 ? 0.1 + 0.6 * cosine + 0.3 * pow(shine, 20.0) : 0.1);
        #include <opaque_fragment>`);
    };
  }
  const mesh = new THREE.Mesh(geometry, material), { position } = geometry.attributes, place = new THREE.Vector3(), fill = 0.9;
  const center = new THREE.Box3().setFromBufferAttribute(position).getCenter(new THREE.Vector3());
  let radius = 0;
  for (let i = 0; i < position.count; i++) radius = Math.max(radius, center.distanceTo(place.fromBufferAttribute(position, i)));
  mesh.rotation.set(...[25, -35, 10].map(THREE.MathUtils.degToRad), "ZYX");
  mesh.scale.setScalar(1 / radius);
  mesh.position.copy(center).divideScalar(-radius).applyEuler(mesh.rotation);
  let eye = new THREE.OrthographicCamera(-1 / fill, 1 / fill, 1 / fill, -1 / fill, 0.1, 10);
  if (distance) {
    eye = new THREE.PerspectiveCamera((2 * Math.atan(1 / (fill * Math.sqrt(distance ** 2 - 1))) * 180) / Math.PI, 1, 0.01, 100);
  }
  eye.position.z = distance || 3;
  const sun = new THREE.DirectionalLight(0xffffff, 0.6 * Math.PI);
  sun.position.copy(lamp);
  const scene = new THREE.Scene().add(mesh, sun, new THREE.AmbientLight(0xffffff, 0.1 * Math.PI));
  const own = shader === "c1-phong" && applyC1(scene, { gpu });
  const target = new THREE.WebGLRenderTarget(side, side, { type: THREE.FloatType }), pixels = new Float32Array(4 * side * side);
  renderer.setRenderTarget(target);
  renderer.render(scene, eye);
  renderer.readRenderTargetPixels(target, 0, 0, side, side, pixels);
  if (own) own.dispose();
  target.dispose();
  const code = (light) => Math.round(255 * (light <= 0.0031308 ? 12.92 * light : 1.055 * light ** (1 / 2.4) - 0.055));
  return Array.from({ length: side * side }, (_, i) => code(pixels[4 * i]));
}

// Runs in the page.
async function measure(rounds) {
  const { THREE, applyC1 } = window, renderer = new THREE.WebGLRenderer(), { info } = console, pixel = new Uint8Array(4);
  console.info = () => {};
  const median = (list) => list.sort((a, b) => a - b)[list.length >> 1];
  const camera = new THREE.PerspectiveCamera(40, 1, 0.1, 100);
  camera.position.z = 4;
  const of = (around, along, kind) => {
    const torus = new THREE.Mesh(new THREE.TorusGeometry(1, 0.4, along, around), new THREE[kind]({ color: 0xffffff }));
    torus.rotation.set(0.4, -0.6, 0);
    return new THREE.Scene().add(torus, new THREE.DirectionalLight(0xffffff, 3));
  };
  const rows = [];
  for (const kind of ["MeshPhongMaterial", "MeshStandardMaterial"]) {
    for (const [around, along, side] of [[28, 28, 1024], [70, 70, 512], [70, 70, 1024]]) {
      const scenes = [of(around, along, kind), of(around, along, kind)], times = [[], []];
      const target = new THREE.WebGLRenderTarget(side, side), { dispose } = applyC1(scenes[1]);
      renderer.setRenderTarget(target);
      for (let round = -2; round < rounds; round++) {
        scenes.forEach((scene, i) => {
          const start = performance.now();
          for (let k = 0; k < 4; k++) renderer.render(scene, camera);
          renderer.readRenderTargetPixels(target, 0, 0, 1, 1, pixel);
          if (round >= 0) times[i].push((performance.now() - start) / 4);
        });
      }
      dispose();
      rows.push([kind, 2 * around * along, side, ...times.map(median)]);
    }
  }
  const scene = of(224, 224, "MeshStandardMaterial"), before = performance.now();
  applyC1(scene);
  const prepared = performance.now() - before, frames = [];
  renderer.setRenderTarget(new THREE.WebGLRenderTarget(512, 512));
  for (let frame = 0; frame < 20; frame++) {
    scene.children[0].rotation.x += 0.02;
    const start = performance.now();
    renderer.render(scene, camera);
    frames.push(performance.now() - start);
    renderer.readRenderTargetPixels(renderer.getRenderTarget(), 0, 0, 1, 1, pixel);
  }
  console.info = info;
  return { rows, prepared, frame: median(frames) };
}

const { page, faults } = await open();
if (process.argv[2] === "--speed") {
  const { rows, prepared, frame } = await page.evaluate(measure, Number(process.argv[3] ?? 9));
  console.log("| material | triangles, window | alone | C1 normals over it |\n|---|---|---:|---:|");
  for (const [kind, triangles, side, alone, c1] of rows) {
    console.log(`| ${kind} | ${triangles.toLocaleString("en")}, ${side} × ${side} | ${alone.toFixed(1)} ms | ${(c1 / alone).toFixed(2)} |`);
  }
  console.log(`100,352 triangles: ${prepared.toFixed(0)} ms to prepare, ${frame.toFixed(2)} ms of JavaScript for a frame that turns`);
  await page.context().browser().close();
  process.exit();
}
try {
  const jobs = [];
  for (const [name, geometry] of Object.entries(shapes)) {
    const shape = plain(geometry), file = join(folder, `${name}.obj`), shine = name === "knot";
    const item = (key, x) => (key === "f" ? `${x + 1}//${x + 1}` : x);
    const lines = (key, of) => of.map((x, i) => (i % 3 === 0 ? `\n${key} ` : " ") + item(key, x)).join("");
    writeFileSync(file, `${lines("v", shape.positions)}${lines("vn", shape.normals)}${lines("f", shape.index)}\n`);
    if (shine) jobs.push({ ...shape, name, file, shader: "phong" });
    for (const distance of [0, 3]) jobs.push({ ...shape, name, file, shader: "c1-phong", shine, distance });
  }
  for (const job of jobs) {
    const data = picture(job);
    for (const gpu of job.shader === "phong" ? [false] : [false, true]) {
      const drawn = await page.evaluate(codes, { ...job, gpu, side: SIDE });
      // The page's rows begin at the bottom.
      const of = [(x, y) => drawn[(SIDE - 1 - y) * SIDE + x], (x, y) => data[4 * (y * SIDE + x)]];
      let worst = 0, compared = 0, above = 0;
      for (let y = 2; y < SIDE - 2; y++) {
        for (let x = 2; x < SIDE - 2; x++) {
          // Inside the outline: both show the surface everywhere around, without steps.
          const around = of.map((code) => [-2, -1, 0, 1, 2].flatMap((dy) => [-2, -1, 0, 1, 2].map((dx) => code(x + dx, y + dy))));
          if (around.some((near) => Math.min(...near) === 0 || Math.max(...near) - Math.min(...near) > 20)) continue;
          const difference = Math.abs(of[0](x, y) - of[1](x, y));
          worst = Math.max(worst, difference);
          above += difference > MOST;
          compared++;
        }
      }
      const view = job.distance ? `from ${job.distance} radii` : "parallel", where = gpu ? "on the card" : "in JavaScript";
      expect(above <= compared / 10_000 && compared > 30_000, `${job.name}, ${job.shader} ${where}, ${view}: `
        + `at most ${worst} codes apart over ${compared} pixels${above ? `, ${above} above ${MOST}` : ""}`);
    }
  }
  for (const [text, is] of Object.entries(await page.evaluate(usage))) expect(is === true, `${text}${is === true ? "" : `: ${is}`}`);
  expect(faults.length === 0, `the browser complains ${faults.length} times ${faults.join("\n")}`);
} finally {
  await page.context().browser().close();
  rmSync(folder, { recursive: true });
}
process.exit(failed ? 1 : 0);
