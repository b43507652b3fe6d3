#!/usr/bin/env bash
# Reproduces the paper's Figures 8-12 and shades the same meshes with our own shaders (docs/figures/paper.png), and shows
# five meshes next to the smooth surface (truth.png). docs/shaders.md discusses them. glass.png is the scene of
# docs/shading.md.
#
#   scripts/figures.sh                             # with target/release/machband
#   MACHBAND=target/debug/machband scripts/figures.sh
#
# Needs ImageMagick.
set -euo pipefail
cd "$(dirname "$0")/.."

machband=$(realpath "${MACHBAND:-target/release/machband}")
figures=$PWD/docs/figures
[ -x "$machband" ] || { echo "error: $machband: not found; expected a built machband (or MACHBAND=PATH)" >&2; exit 1; }
for tool in convert montage; do
    command -v "$tool" >/dev/null || { echo "error: $tool: not found; expected it on the PATH" >&2; exit 1; }
done

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
mkdir -p "$figures"

# panel FIGURE LABEL OPTION…: renders one picture.
panel() {
    local figure=$1 label=$2
    shift 2
    "$machband" shade --size 240 --force --out "$work/raw.png" "$@"
    # The label goes below the picture; the picture itself does not change.
    convert "$work/raw.png" -strip -background white -gravity south -splice 0x22 -pointsize 13 -fill black \
        -annotate +0+4 "$label" "$work/$figure-$(printf '%02d' "${#panels[@]}").png"
    panels+=("$work/$figure-$(printf '%02d' "${#panels[@]}").png")
}
# sheet TITLE [COLUMNS]: arranges the panels so far below a title, three per row unless COLUMNS says otherwise.
sheet() {
    montage "${panels[@]}" -tile "${2:-3}x" -geometry +4+4 -background white "$work/sheet.png"
    convert "$work/sheet.png" -background white -gravity northwest -splice 0x30 -pointsize 20 -fill black \
        -annotate +8+4 "$1" "$work/sheet-$(printf '%02d' "${#sheets[@]}").png"
    sheets+=("$work/sheet-$(printf '%02d' "${#sheets[@]}").png")
    panels=()
}
# saved NAME FILE…: writes sheets below each other into one file.
saved() {
    local name=$1
    shift
    convert "$@" -background white -append -strip -define png:exclude-chunks=date,time,tIME \
        -define png:compression-level=9 "PNG24:$figures/$name.png"
}
panels=() sheets=()
cube=(--mesh cube --rotate 25,-35,0)

panel figure8 '(a) flat' "${cube[@]}" --shader flat
panel figure8 '(b) Gouraud' "${cube[@]}" --shader gouraud
panel figure8 '(c) Phong' "${cube[@]}" --shader phong
for letter_n_b in 'd 3 0.05' 'e 3 0.2' 'f 3 0.33' 'g 5 0.05' 'h 5 0.2' 'i 5 0.33'; do
    read -r letter n b <<<"$letter_n_b"
    panel figure8 "($letter) fixed ($n, $b)" "${cube[@]}" --shader fixed --depth "$n" --boundary "$b"
done
sheet 'Figure 8'

for figure in '9 vertex' '10 reweight'; do
    read -r number correction <<<"$figure"
    for how in printed repaired; do
        for b in 0.05 0.2 0.33; do
            panel "figure$number" "$correction, $how (3, $b)" "${cube[@]}" --shader fixed --depth 3 --boundary "$b" \
                "--$correction" "$how"
        done
    done
    sheet "Figure $number"
done

for figure in '11 313' '12 771'; do
    read -r number vertices <<<"$figure"
    blob=(--mesh blob --vertices "$vertices")
    panel "figure$number" '(a) fixed (1, 0.05)' "${blob[@]}" --shader fixed --depth 1 --boundary 0.05
    panel "figure$number" '(b) fixed (3, 0.2)' "${blob[@]}" --shader fixed --depth 3 --boundary 0.2
    panel "figure$number" '(c) vertex (3, 0.2)' "${blob[@]}" --shader fixed --depth 3 --boundary 0.2 --vertex printed
    panel "figure$number" '(d) reweight (3, 0.33)' "${blob[@]}" --shader fixed --depth 3 --boundary 0.33 --reweight printed
    panel "figure$number" 'Gouraud' "${blob[@]}" --shader gouraud
    panel "figure$number" 'patch' "${blob[@]}" --shader patch
    sheet "Figure $number"
done

for mesh in cube blob; do
    turned=(--mesh "$mesh" --rotate 25,-35,0)
    panel ours "$mesh: Gouraud" "${turned[@]}" --shader gouraud
    panel ours 'patch' "${turned[@]}" --shader patch
    panel ours 'quadratic' "${turned[@]}" --shader quadratic
    panel ours 'Phong' "${turned[@]}" --shader phong
done
sheet 'The other shaders' 4
saved paper "${sheets[@]}"

# Before, after and truth: what the mesh approximates.
while IFS='|' read -r name options; do
    read -ra options <<<"$options"
    panel truth "$name: Gouraud" "${options[@]}" --shader gouraud
    panel truth 'patch' "${options[@]}" --shader patch
    panel truth 'c1-phong' "${options[@]}" --shader c1-phong
    panel truth 'the smooth surface' "${options[@]}" --truth
done <<'END'
slivers|--mesh uv-sphere --vertices 200 --specular 0.4 --light 0.5,0.5,0.7 --rotate 60,-35,0
highlight|--mesh blob --vertices 200 --specular 0.5 --light 0.5,0.5,0.7
terminator|--mesh torus --vertices 200 --specular 0 --light 0.9,0.4,-0.2
filleted cylinder|--mesh filleted-cylinder --vertices 194 --specular 0.3 --rotate 60,-35,0
terrain|--mesh terrain --vertices 289 --specular 0.3 --light 0.5,0.5,0.7 --rotate -35,10,20
END
montage "${panels[@]}" -tile 4x -geometry +4+4 -background white "$work/truth.png"
saved truth "$work/truth.png"

"$machband" shade examples/scenes/glass.toml --size 480 --force --out "$work/glass.png"
saved glass "$work/glass.png"

echo "$figures: paper.png, truth.png, glass.png"
