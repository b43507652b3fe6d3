#!/usr/bin/env bash
# Updates the documentation's pictures from the program itself:
# docs/pictures/{start,stimuli,shaders,categories,dither,figure4a}.png and trial.gif.
#
#   scripts/pictures.sh                             # with target/release/machband
#   MACHBAND=target/debug/machband scripts/pictures.sh
#
# Needs Xvfb, openbox, xdotool, ImageMagick and the font DejaVu Sans.
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
press_to_next ctrl+3
picture "$(window)" stimuli.png
press_to_next ctrl+4
# The first sentence needs a prediction, which takes a while.
sleep 10
rest
picture "$(window)" shaders.png
kill "$start"
wait "$start" 2>/dev/null || true
rm -r results

# A session of four trials, in which the band vanishes: the smoother the ramp, the weaker the band.
cat >vanish.toml <<'END'
schema = 1
name = "vanish"
title = "A band that vanishes"

[stimulus]
kind = "mach-band"

[factors]
depth = [1, 2, 3, "inf"]

[design]
repetitions = 1
practice = 0
order = "random"

[recovery]
duration_s = 3.0
level = 0.5

[viewing]
distance_cm = 50.0
window_deg = 11.0
END
file=vanish/data/subject-S001_session-1_task-vanish_data.csv
csv=results/$file
# Prints the depths of a session in their order.
depths_of() { tail -n +2 "$1" | cut -d, -f12 | paste -sd' '; }
# The first seed that shows the smoother ramps later.
for ((seed = 1; seed <= 1000; seed++)); do
    "$machband" simulate vanish.toml --seed "$seed" --results "simulated-$seed" >/dev/null
    [ "$(depths_of "simulated-$seed/$file")" != '1 2 3 inf' ] || break
done
"$machband" run vanish.toml --participant S001 --seed "$seed" &
children+=($!)
until_so has_window
rest
# Preflight, welcome, categories.
press_to_next space
press_to_next space
picture root categories.png
# Takes a part of the screen in its own pixels.
frame() { import -window root -crop 640x480+320+276 +repage -depth 8 "$work/$1.png"; }
answers=(3 2 1 0)
for i in "${!answers[@]}"; do
    until is_trial; do
        xdotool key space
        sleep 0.5
    done
    [ "$i" != 0 ] || { until_so is_field && frame field; }
    until_so is_stimulus
    frame "$i-stimulus"
    xdotool key "${answers[i]}"
    # The mark that acknowledges an answer, the same for all, is on the field for 0.4 s. A slow machine misses some.
    until_so is_field
    frame answered
    [ "$(identify -format %k "$work/answered.png")" = 1 ] || cp "$work/answered.png" "$work/mark.png"
    until_so has_rows $((i + 1))
done
[ "$(depths_of "$csv")" = '1 2 3 inf' ] ||
    { echo "error: $csv: the order of the depths is not 1, 2, 3, inf; expected it with seed $seed" >&2; exit 1; }
[ -e "$work/mark.png" ] || { echo 'error: no mark was on the field in time; expected a faster machine' >&2; exit 1; }

# The moving picture: what the screen shows, and below it the luminance along a line through the stimulus. The line has
# no overshoot at the ends of the ramp: the band is not in the light. A strip has few colors, so that the palette of a
# GIF frame has room for every code of the stimulus.

# Writes the strip below a frame: the name of its file, then what is drawn on it.
strip() {
    convert -size 640x96 xc:'#202020' -font DejaVu-Sans -pointsize 15 -fill '#e8e8e8' "${@:2}" +dither -colors 32 \
        -depth 8 "PNG24:$work/strip-$1.png"
}
depths=(1 2 3 inf)
moving=()
strip field -gravity west -annotate +12+0 'uniform field'
for i in "${!depths[@]}"; do
    depth=${depths[i]}
    "$machband" stimulus --depth "$depth" --size 364 --out "$work/$i.png" --profile "$work/$i.csv" >/dev/null
    line=$(tail -n +2 "$work/$i.csv" | awk -F, '{ printf "%.1f,%.1f ", 320 + 364 * $1, 116 - 136 * $2 }')
    strip stimulus -gravity west -annotate +12+0 "depth ${depth/inf/∞}" -gravity east -annotate +12+0 luminance \
        -fill none -stroke '#e8e8e8' -strokewidth 2 -draw "polyline $line"
    strip mark -gravity west -annotate +12+0 "answer: ${answers[i]}"
    for part in field "$i-stimulus" mark; do
        convert "$work/$part.png" "$work/strip-${part#*-}.png" -append -strip -depth 8 \
            "PNG24:$work/moving-$i-${part#*-}.png"
    done
    moving+=(-delay 70 "$work/moving-$i-field.png" -delay 220 "$work/moving-$i-stimulus.png")
    moving+=(-delay 60 "$work/moving-$i-mark.png")
done
# It begins with the first stimulus, which programs show that do not move pictures.
convert "${moving[@]:3}" "${moving[@]:0:3}" +dither -treedepth 8 -loop 0 "$pictures/trial.gif"

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

echo "$pictures: start.png, stimuli.png, shaders.png, categories.png, trial.gif, dither.png, figure4a.png"
