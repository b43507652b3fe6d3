// Writes what the package needs from the folders above: ordinates.js, the README, the licenses, and parts of ../glsl_es as
// strings in glsl.js, because a package has no files beside it. npm runs it before it packs or tests.

import { copyFileSync, readFileSync, writeFileSync } from "node:fs";

const read = (name) => readFileSync(new URL(`../glsl_es/${name}.frag`, import.meta.url), "utf8");
// three.js writes the version, and sets a plain uniform more easily than a block.
const pass = (name) => read(name).replace(/^#version.*\n(\/\/.*\n)*\s*/, "")
  .replace(/layout\(std140\) uniform \w+ \{ Camera camera; \};/, "uniform Camera camera;").trim();
const [cubic] = /vec4 terms_of[^]*?(?=\n\nvec3 value_of)/.exec(read("c1_phong_pixel"));
const parts = { slopes: pass("slopes_texel"), coefficients: pass("coefficients_texel"), cubic };
const text = Object.entries(parts).map(([name, part]) => `export const ${name} = \`\n${part}\n\`;\n`);
const own = (name) => new URL(name, import.meta.url);
writeFileSync(own("glsl.js"), text.join("\n"));
for (const name of ["ordinates.js", "README.md"]) copyFileSync(own(`../${name}`), own(name));
for (const name of ["LICENSE-MIT", "LICENSE-APACHE"]) copyFileSync(own(`../../${name}`), own(name));
