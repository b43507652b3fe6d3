// The cost of the package for three.js in Chromium with SwiftShader, in one page whose draws alternate: C1 normals over the
// material alone, with medians of frames that the page waits for; and, for 100,352 triangles, the time of JavaScript for
// preparing them and for a frame in which they turn. `npm install && npm run copy` in shaders/three, then
// `node benches/kit_three.mjs [rounds]`; CHROMIUM is the browser.

import { open } from "../shaders/three/page.mjs";

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

const { page } = await open();
try {
  const { rows, prepared, frame } = await page.evaluate(measure, Number(process.argv[2] ?? 9));
  console.log("| material | triangles, window | alone | C1 normals over it |\n|---|---|---:|---:|");
  for (const [kind, triangles, side, alone, c1] of rows) {
    console.log(`| ${kind} | ${triangles.toLocaleString("en")}, ${side} × ${side} | ${alone.toFixed(1)} ms | ${(c1 / alone).toFixed(2)} |`);
  }
  console.log(`100,352 triangles: ${prepared.toFixed(0)} ms to prepare, ${frame.toFixed(2)} ms of JavaScript for a frame that turns`);
} finally {
  await page.context().browser().close();
}
