#!/usr/bin/env bash
# Updates the documentation's pictures from the program itself:
# docs/pictures/{start,stimuli,shaders,categories,trial,dither,figure4a}.png.
#
#   scripts/pictures.sh                             # with target/release/machband
#   MACHBAND=target/debug/machband scripts/pictures.sh
#
# Needs Xvfb, openbox, xdotool and ImageMagick. The simulated observer supplies the answers.
set -euo pipefail
cd "$(dirname "$0")/.."

root=$PWD
machband=$(realpath "${MACHBAND:-target/release/machband}")
pictures=$root/docs/pictures
field='188 188 0'
width=1280 height=1024

for tool in Xvfb openbox xdotool import convert; do
    command -v "$tool" >/dev/null || { echo "error: $tool: not found; expected it on the PATH" >&2; exit 1; }
done
[ -x "$machband" ] || { echo "error: $machband: not found; expected a built machband (or MACHBAND=PATH)" >&2; exit 1; }

work=$(mktemp -d)
children=()
end() {
    for ((i = ${#children[@]} - 1; i >= 0; i--)); do
        kill "${children[i]}" 2>/dev/null || true
        wait "${children[i]}" 2>/dev/null || true
    done
    rm -rf "$work"
}
trap end EXIT

mkdir -p "$work/home" "$work/runtime" "$pictures"
chmod 700 "$work/runtime"
Xvfb -displayfd 3 -screen 0 "${width}x${height}x24" -dpi 96 -noreset -nolisten tcp 3>"$work/display" 2>/dev/null &
children+=($!)

# Repeats a check until it holds, for at most two minutes.
until_so() {
    local until=$((SECONDS + 120))
    until "$@"; do
        [ "$SECONDS" -lt "$until" ] || { echo "error: waited two minutes for: $*" >&2; exit 1; }
        sleep 0.1
    done
}
until_so test -s "$work/display"
DISPLAY=:$(<"$work/display")
export DISPLAY HOME=$work/home XDG_RUNTIME_DIR=$work/runtime WINIT_X11_SCALE_FACTOR=1
unset WAYLAND_DISPLAY
openbox >/dev/null 2>&1 &
children+=($!)
until_so xdotool get_num_desktops >/dev/null 2>&1
# Keep the pointer away from buttons, which change color under it.
xdotool mousemove $((width - 1)) $((height - 1))

# Prints red, green and blue at a point of the screen.
pixel() {
    import -window root -crop "1x1+$1+$2" -depth 8 rgb:- | od -An -tu1 | xargs
}
is_trial() { [ "$(pixel 4 4)" = "$field" ]; }
is_page() { ! is_trial; }
is_field() { is_trial && [ "$(pixel 480 352)" = "$field" ]; }
is_stimulus() { is_trial && [ "$(pixel 480 352)" != "$field" ]; }
rows() { if [ -f "$csv" ]; then tail -n +2 "$csv" | wc -l; else echo 0; fi; }
has_rows() { [ "$(rows)" -ge "$1" ]; }
window() { xdotool search --onlyvisible --name '^machband$' 2>/dev/null | tail -n 1; }
has_window() { [ -n "$(window)" ]; }
screen() { import -window root -depth 8 rgb:- | sha256sum; }

# Waits until the screen has not changed for a second.
rest() {
    local last='' now
    now=$(screen)
    while [ "$now" != "$last" ]; do
        last=$now
        sleep 1
        now=$(screen)
    done
}
# Presses a key and waits until the screen has changed and is stable again.
press_to_next() {
    local before
    before=$(screen)
    xdotool key "$1"
    until_so changed_from "$before"
    rest
}
changed_from() { [ "$(screen)" != "$1" ]; }

# Takes a small picture of a window (or `root`), without metadata about this machine.
picture() {
    import -window "$1" "$work/raw.png"
    convert "$work/raw.png" -strip -resize '1000x>' -define png:exclude-chunks=date,time,tIME \
        -define png:compression-level=9 "PNG24:$pictures/$2"
}

cd "$work"

# The start page, with finished sessions; the gallery and the shading demo as they first open.
"$machband" simulate quick --participants 2 --seed 1 >/dev/null
"$machband" &
children+=($!)
start=$!
until_so has_window
rest
picture "$(window)" start.png
press_to_next ctrl+2
picture "$(window)" stimuli.png
press_to_next ctrl+3
picture "$(window)" shaders.png
kill "$start"
wait "$start" 2>/dev/null || true
rm -r results

# A session of `quick` with a short recovery and the simulated observer's answers.
sed 's/^duration_s = .*/duration_s = 0.5/' "$root/experiments/quick.toml" >quick.toml
"$machband" simulate quick.toml --seed 7 --results simulated >/dev/null
file=quick/data/subject-S001_session-1_task-quick_data.csv
csv=results/$file
# Prints the cells of a column. The columns used here have no commas in their cells or before them.
column() {
    local number
    number=$(head -n 1 "simulated/$file" | tr ',' '\n' | grep -nx "$1" | cut -d: -f1)
    tail -n +2 "simulated/$file" | cut -d, -f"$number"
}
mapfile -t conditions < <(paste -d, <(column phase) <(column width) <(column depth) <(column orientation_deg))
mapfile -t ratings < <(column rating)

"$machband" run quick.toml --participant S001 --seed 7 &
children+=($!)
until_so has_window
rest
# Preflight, welcome, categories.
press_to_next space
press_to_next space
picture root categories.png
# The page that announces the practice trials.
press_to_next space
xdotool key space
for i in "${!ratings[@]}"; do
    until is_trial; do
        xdotool key space
        sleep 0.5
    done
    until_so is_stimulus
    # The main trial whose ramp shows the clearest Mach band.
    if [ "${conditions[i]}" = main,0.4,1,0 ]; then
        picture root trial.png
    fi
    xdotool key "${ratings[i]}"
    until_so has_rows $((i + 1))
done

# A shallow ramp of ten codes, with and without dither, with its contrast stretched to make the codes visible.
for dither in none blue-noise; do
    "$machband" stimulus --width 0.8 --low 0.25 --high 0.29 --color gray --size 400 --dither "$dither" \
        --out "$work/$dither.png"
done
convert "$work/none.png" "$work/blue-noise.png" -normalize -crop 400x160+0+0 +repage -bordercolor white -border 4 \
    +append -strip "$pictures/dither.png"

# The paper's Figure 4 (a), from simulated participants.
"$machband" simulate bangay2003 --participants 8 --seed 1 --results "$work/analyzed" >/dev/null
"$machband" analyze "$work/analyzed" --out "$work/analysis" >/dev/null
cp "$work/analysis/figure4a.png" "$pictures/figure4a.png"

echo "$pictures: start.png, stimuli.png, shaders.png, categories.png, trial.png, dither.png, figure4a.png"
