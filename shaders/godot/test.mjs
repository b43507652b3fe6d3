// Draws the kit's mesh in Godot 3 and holds its pixels against the picture of `machband shade`: at most 2 codes apart
// inside the outline, apart from one pixel in ten thousand. Needs a display. `node test.mjs`; MACHBAND is the program,
// GODOT the engine.

import { execFileSync } from "node:child_process";
import { copyFileSync, mkdtempSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { createRequire } from "node:module";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { fileURLToPath } from "node:url";
import { coefficients, curvature, welded } from "../ordinates.js";

const { PNG } = createRequire(new URL("../three/package.json", import.meta.url))("pngjs");
const SIDE = 512, FILL = 0.9, ROTATE = [25, -35, 10], MOST = 2, PER_ROW = 64;
const here = (name) => fileURLToPath(new URL(name, import.meta.url));
const MACHBAND = process.env.MACHBAND ?? here("../../target/debug/machband"), GODOT = process.env.GODOT ?? "godot3";

// The mesh, rotated and in the unit sphere.
const glb = readFileSync(here("../three/mesh.glb"));
const length = glb.readUInt32LE(12), bytes = glb.subarray(28 + length);
const json = JSON.parse(glb.subarray(20, 20 + length));
const { attributes, indices } = json.meshes[0].primitives[0];
const read = (at, width, of, each) => {
  const { bufferView, count } = json.accessors[at], { byteOffset } = json.bufferViews[bufferView];
  return Array.from({ length: count * each }, (_, i) => of.call(bytes, byteOffset + width * i));
};
const [places, directions] = [attributes.POSITION, attributes.NORMAL].map((at) => read(at, 4, bytes.readFloatLE, 3));
const [x, y, z] = ROTATE.map((degrees) => (degrees * Math.PI) / 180);
const rotated = ([a, b, c]) => {
  [b, c] = [b * Math.cos(x) - c * Math.sin(x), b * Math.sin(x) + c * Math.cos(x)];
  [a, c] = [a * Math.cos(y) + c * Math.sin(y), c * Math.cos(y) - a * Math.sin(y)];
  return [a * Math.cos(z) - b * Math.sin(z), a * Math.sin(z) + b * Math.cos(z), c];
};
const each = (flat, of) => Array.from({ length: flat.length / 3 }, (_, i) => of(flat.slice(3 * i, 3 * i + 3))).flat();
const axis = [0, 1, 2].map((k) => places.filter((_, i) => i % 3 === k));
const center = axis.map((values) => (Math.min(...values) + Math.max(...values)) / 2);
const moved = each(places, (p) => p.map((value, k) => value - center[k]));
const radius = Math.max(...each(moved, (p) => Math.hypot(...p)));
const unit = each(moved, (p) => rotated(p.map((value) => value / radius)));
const shape = welded(unit, each(directions, rotated), read(indices, 2, bytes.readUInt16LE, 1));

// A camera at z = 5 that sees 2 / FILL units from top to bottom.
const view = [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, -5, 1], size = 2 / FILL, near = 0.1, far = 10;
const projection = [FILL, 0, 0, 0, 0, FILL, 0, 0, 0, 0, -2 / (far - near), 0, 0, 0, -(far + near) / (far - near), 1];
const table = coefficients(shape, curvature(shape), view, projection, [SIDE, SIDE]);
const folder = mkdtempSync(join(tmpdir(), "godot-"));
let failed = true;
try {
  const height = Math.ceil(shape.triangles.length / 3 / PER_ROW), texels = new Float32Array(height * PER_ROW * 36);
  texels.set(table);
  const corners = (of) => Array.from(shape.triangles).flatMap((v) => Array.from(of.slice(3 * v, 3 * v + 3)));
  const mesh = { width: 9 * PER_ROW, height, size, positions: corners(shape.positions), normals: corners(shape.normals) };
  writeFileSync(join(folder, "mesh.json"), JSON.stringify(mesh));
  writeFileSync(join(folder, "coefficients.bin"), Buffer.from(texels.buffer));
  for (const name of ["c1_phong.shader", "project.godot", "show.gd", "show.tscn"]) {
    copyFileSync(here(name), join(folder, name));
  }
  const environment = { ...process.env, HOME: folder, DATA: folder, LANG: "en_US.UTF-8" };
  const said = execFileSync(GODOT, ["--path", folder, "--audio-driver", "Dummy"], { env: environment, timeout: 120_000 });
  if (/error/i.test(said)) console.error(`${said}`);
  const out = join(folder, "expected.png");
  execFileSync(MACHBAND, [
    "shade", "--mesh", here("../three/mesh.glb"), "--shader", "c1-phong", "--rotate", ROTATE.join(), "--size", `${SIDE}`,
    "--background", "0", "--ambient", "0.1", "--diffuse", "0.6", "--specular", "0.3", "--shininess", "20", "--out", out,
  ]);
  const [own, expected] = [join(folder, "picture.png"), out].map((name) => PNG.sync.read(readFileSync(name)).data);
  let worst = 0, compared = 0, above = 0;
  for (let row = 2; row < SIDE - 2; row++) {
    for (let column = 2; column < SIDE - 2; column++) {
      // Inside the outline: both show the surface everywhere around, without steps.
      const code = (data, dx, dy) => data[4 * ((row + dy) * SIDE + column + dx)], near = [-2, -1, 0, 1, 2];
      const around = [own, expected].map((data) => near.flatMap((dy) => near.map((dx) => code(data, dx, dy))));
      if (around.some((codes) => Math.min(...codes) === 0 || Math.max(...codes) - Math.min(...codes) > 20)) continue;
      const difference = Math.abs(around[0][12] - around[1][12]);
      worst = Math.max(worst, difference);
      above += difference > MOST;
      compared++;
    }
  }
  const many = above ? `, ${above} above ${MOST}` : "";
  console.log(`c1-phong in Godot: at most ${worst} codes apart over ${compared} pixels${many}`);
  failed = above > compared / 10_000 || compared < 30_000;
  if (process.env.KEEP) copyFileSync(join(folder, "picture.png"), process.env.KEEP);
} finally {
  rmSync(folder, { recursive: true });
}
process.exit(failed ? 1 : 0);
