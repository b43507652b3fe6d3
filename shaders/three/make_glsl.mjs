// Writes glsl.js, the parts of ../glsl_es that the package needs, as strings, because a package has no files beside it.
// `node make_glsl.mjs`; test.mjs says when it is stale.

import { readFileSync, writeFileSync } from "node:fs";
import { fileURLToPath } from "node:url";

export function glsl() {
  const read = (name) => readFileSync(new URL(`../glsl_es/${name}.frag`, import.meta.url), "utf8");
  // three.js writes the version, and sets a plain uniform more easily than a block.
  const pass = (name) => read(name).replace(/^#version.*\n(\/\/.*\n)*\s*/, "")
    .replace(/layout\(std140\) uniform \w+ \{ Camera camera; \};/, "uniform Camera camera;").trim();
  const [cubic] = /vec4 terms_of[^]*?(?=\n\nvec3 value_of)/.exec(read("c1_phong_pixel"));
  const parts = { slopes: pass("slopes_texel"), coefficients: pass("coefficients_texel"), cubic };
  return `// Generated from ../glsl_es, which is generated from ../wgsl. Do not edit: \`node make_glsl.mjs\` writes it.\n`
    + Object.entries(parts).map(([name, text]) => `\nexport const ${name} = \`\n${text}\n\`;\n`).join("");
}

if (process.argv[1] === fileURLToPath(import.meta.url)) writeFileSync(new URL("glsl.js", import.meta.url), glsl());
