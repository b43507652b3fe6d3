#!/usr/bin/env bash
# Runs every attack that the tests know and prints the table of classes. With a log file as its argument, it only adds up
# the lines that the tests printed into this file. A full run took 17 minutes on two cores.
set -euo pipefail
cd "$(dirname "$0")/.."

if [ $# -eq 1 ]; then
    log=$1
else
    log=$(mktemp)
    trap 'rm -f "$log"' EXIT
    export MACHBAND_FAULTS=${MACHBAND_FAULTS:-20000} MACHBAND_CUTS=${MACHBAND_CUTS:-1000}
    export MACHBAND_READS=${MACHBAND_READS:-1000000}
    export MACHBAND_REQUIRE_GPU=1 MACHBAND_REQUIRE_DISPLAY=1 MACHBAND_REQUIRE_FAULTS=1
    # A program that `nohup` started ignores a signal that the tests send.
    test=(env --default-signal=HUP,INT cargo test)
    "${test[@]}" --test faults --test store --test window 2>&1 | tee "$log"
    # Each command runs alone.
    RAYON_NUM_THREADS=1 "${test[@]}" --test cli -- --test-threads=1 2>&1 | tee -a "$log"
fi

printf '\n| class of attack | attacks | rows lost | files destroyed | silent lies | panics | hangs |\n|---|--:|--:|--:|--:|--:|--:|\n'
# A printed line may follow, on the same line, the name of a test that has not ended.
sed -n 's/.*ATTACKS //p' "$log" | sort
sed -n 's/.*ATTACKS //p' "$log" | awk -F ' *[|] *' '
    { attacks += $3; for (i = 4; i <= 8; i++) if ($i != "–") sum[i] += $i }
    END { printf "| all | %d | %d | %d | %d | %d | %d |\n", attacks, sum[4], sum[5], sum[6], sum[7], sum[8] }'
