#!/usr/bin/env bash
# Checks the files in shaders/ that programmers copy: glslangValidator compiles every GLSL and HLSL file, and a browser
# draws the three.js page and Godot draws the mesh as `machband shade` does. Needs glslangValidator, Node.js, npm,
# Chromium, Godot 3 and xvfb-run, and the program in PROGRAMS (default: target/debug).
set -euo pipefail
cd "$(dirname "$0")/../shaders"

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

# Joins a first line and the files of a shader, and compiles them.
compile() { # name first-lines files…
    local out=$work/$1 first=$2
    shift 2
    { printf '%b\n' "$first"; cat "$@"; } >"$out"
    glslangValidator "$out"
    echo "$(basename "$out"): compiled"
}

es='#version 300 es\nprecision highp float;'
compile es_triangle.vert "$es" glsl_es/triangle.vert
compile triangle.vert '#version 450' glsl/triangle.vert
for shader in c1_phong patch; do
    compile "es_$shader.frag" "$es" glsl/patch.glsl glsl_es/ordinates.glsl "glsl_es/$shader.frag"
    compile "$shader.frag" '#version 450' glsl/patch.glsl glsl/ordinates.glsl "glsl/$shader.frag"
done
for pass in 1 2; do
    compile "ordinates_$pass.comp" "#version 450\n#define PASS $pass" glsl/ordinates.comp
done
glslangValidator -D -V -S vert -e triangle_vertex -o "$work/triangle.spv" hlsl/c1_phong.hlsl
glslangValidator -D -V -S frag -e c1_phong_pixel -o "$work/c1_phong.spv" hlsl/c1_phong.hlsl
glslangValidator -D -V -S frag -e patch_pixel -o "$work/patch.spv" hlsl/patch.hlsl

cd three
npm ci --no-audit --no-fund
programs=${PROGRAMS:-target/debug}
[[ $programs = /* ]] || programs=$(cd ../.. && pwd)/$programs
export MACHBAND=$programs/machband
node test.mjs
xvfb-run -a -s '-screen 0 800x700x24' node ../godot/test.mjs
