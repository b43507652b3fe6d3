// Writes mesh.glb, the mesh that the page shows first: a bumpy torus of 768 uneven triangles with the normals of the
// smooth surface. `node make_mesh.mjs`

import { writeFileSync } from "node:fs";

const [AROUND, TUBE] = [32, 12];

// The surface at two angles.
function place(u, v) {
  const tube = 0.42 + 0.07 * Math.sin(3 * u + 2 * v) + 0.04 * Math.cos(5 * u);
  const out = 1 + tube * Math.cos(v);
  return [out * Math.cos(u), out * Math.sin(u), tube * Math.sin(v)];
}

function normal(u, v) {
  const h = 1e-4;
  const slope = (a, b) => a.map((x, i) => (x - b[i]) / (2 * h));
  const [a, b] = [slope(place(u + h, v), place(u - h, v)), slope(place(u, v + h), place(u, v - h))];
  const n = [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
  return n.map((x) => x / Math.hypot(...n));
}

const positions = [], normals = [], index = [];
for (let row = 0; row < TUBE; row++) {
  for (let column = 0; column < AROUND; column++) {
    // Uneven steps, as in meshes from scanners and simplifiers.
    const moved = (k) => 0.25 * Math.sin(12.9898 * (row * AROUND + column) + 78.233 * k);
    const u = (2 * Math.PI * (column + 0.5 * (row % 2) + moved(0))) / AROUND;
    const v = (2 * Math.PI * (row + moved(1))) / TUBE;
    positions.push(...place(u, v));
    normals.push(...normal(u, v));
    const at = (up, on) => ((row + up) % TUBE) * AROUND + ((column + on) % AROUND);
    index.push(...(row % 2 === 0
      ? [at(0, 0), at(0, 1), at(1, 0), at(0, 1), at(1, 1), at(1, 0)]
      : [at(0, 0), at(1, 1), at(1, 0), at(0, 0), at(0, 1), at(1, 1)]));
  }
}

const parts = [new Float32Array(positions), new Float32Array(normals), new Uint16Array(index)];
const bytes = Buffer.concat(parts.map((part) => Buffer.from(part.buffer)));
const low = [0, 1, 2].map((i) => Math.min(...parts[0].filter((_, k) => k % 3 === i)));
const high = [0, 1, 2].map((i) => Math.max(...parts[0].filter((_, k) => k % 3 === i)));
let from = 0;
const bufferViews = parts.map((part, i) => {
  const view = { buffer: 0, byteOffset: from, byteLength: part.byteLength, target: i < 2 ? 34962 : 34963 };
  from += part.byteLength;
  return view;
});
const count = positions.length / 3;
const json = Buffer.from(JSON.stringify({
  asset: { version: "2.0" },
  scene: 0,
  scenes: [{ nodes: [0] }],
  nodes: [{ mesh: 0 }],
  meshes: [{ primitives: [{ attributes: { POSITION: 0, NORMAL: 1 }, indices: 2 }] }],
  buffers: [{ byteLength: bytes.length }],
  bufferViews,
  accessors: [
    { bufferView: 0, componentType: 5126, count, type: "VEC3", min: low, max: high },
    { bufferView: 1, componentType: 5126, count, type: "VEC3" },
    { bufferView: 2, componentType: 5123, count: index.length, type: "SCALAR" },
  ],
}));
const chunk = (data, type, fill) => {
  const padded = Buffer.concat([data, Buffer.alloc((4 - (data.length % 4)) % 4, fill)]);
  const head = Buffer.alloc(8);
  head.writeUInt32LE(padded.length, 0);
  head.writeUInt32LE(type, 4);
  return Buffer.concat([head, padded]);
};
const chunks = Buffer.concat([chunk(json, 0x4e4f534a, 0x20), chunk(bytes, 0x004e4942, 0)]);
const head = Buffer.alloc(12);
head.writeUInt32LE(0x46546c67, 0);
head.writeUInt32LE(2, 4);
head.writeUInt32LE(12 + chunks.length, 8);
writeFileSync(new URL("mesh.glb", import.meta.url), Buffer.concat([head, chunks]));
