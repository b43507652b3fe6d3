#!/usr/bin/env bash
# Checks the files in shaders/ that programmers copy: glslangValidator compiles every GLSL and HLSL file, and a browser
# with the package for three.js and OpenGL draw meshes as `machband shade` does. Needs glslangValidator, Node.js, npm,
# Chromium, Python with venv and Mesa's EGL, and the program in PROGRAMS (default: target/debug).
set -euo pipefail
cd "$(dirname "$0")/../shaders"

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

for file in glsl/* glsl_es/*; do
    glslangValidator "$file"
done
# Every entry point of the HLSL files.
entry() { # stage file name
    glslangValidator -D -V -S "$1" -e "$3" -o "$work/$3.spv" "hlsl/$2.hlsl"
}
for name in c1_vertex patch_vertex; do entry vert c1 "$name"; done
for name in c1_phong_pixel patch_pixel patch_color_pixel; do entry frag c1 "$name"; done
for name in slopes coefficients; do entry comp coefficients "$name"; done
entry vert coefficients everywhere
for name in slopes_texel coefficients_texel; do entry frag coefficients "$name"; done

cd three
npm install --no-audit --no-fund --no-package-lock
programs=${PROGRAMS:-target/debug}
[[ $programs = /* ]] || programs=$(cd ../.. && pwd)/$programs
export MACHBAND=$programs/machband
npm test
python3 -m venv "$work/venv"
"$work/venv/bin/python" -m pip install --quiet moderngl numpy pillow
"$work/venv/bin/python" ../../benches/kit_llvmpipe.py --check "$MACHBAND"
