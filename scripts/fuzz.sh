#!/usr/bin/env bash
# Fuzzes the readers of files from other sources (libFuzzer, AddressSanitizer, debug assertions): runs each target for
# SECONDS (600), two at a time. A crash, an input that takes more than a second, or one that needs more than 512 MiB is an
# error. Needs nightly Rust and cargo-fuzz (`cargo install cargo-fuzz`).
#
#   scripts/fuzz.sh [SECONDS] [TARGET…]
#
# Prints executions, executions per second and the size of the corpus. Findings are written to fuzz/artifacts.
#
# fuzz/targets.rs defines what each reader must do: it must not panic, its errors must give a reason and a location, and
# data that is read, written and read again must stay the same. fuzz/words.dict lists the words of all formats.
# fuzz/corpus.tar.gz contains the initial inputs and the inputs that the fuzzers found worth keeping: the smallest set that
# covers the same code (`-set_cover_merge=1 -use_counters=0`) and, of the inputs to which the program gives the same answer,
# the smallest and the largest. `cargo test` runs all of them (tests/store/reading.rs), so that fixed faults stay fixed. To
# update the archive:
#
#   tar --sort=name --mtime=@0 --owner=0 --group=0 --numeric-owner -cf - -C fuzz/target corpus | gzip -9n >fuzz/corpus.tar.gz
#
# Last run: ten minutes for each of the eight targets on two shared cores, with inputs of at most 8 KiB; 83,617 to 1,359,668
# executions, at most 274 MiB, no findings. Not fuzzed: sidecars, frames files, scenes, and the matches that *Gamma by eye*
# saves.
set -euo pipefail
cd "$(dirname "$0")/.."
seconds=${1:-600}
shift || true
targets=("$@")
if [ ${#targets[@]} = 0 ]; then
    targets=(definition results ratings profile readings obj png observer)
fi
logs=fuzz/target/logs
mkdir -p "$logs"
cargo +nightly fuzz build
tar -xzf fuzz/corpus.tar.gz -C fuzz/target

# New inputs go to a separate folder. To update the committed corpus, merge both with `-set_cover_merge=1
# -use_counters=0`.
one() {
    local found=fuzz/target/found/$1
    mkdir -p "$found" "fuzz/artifacts/$1"
    "fuzz/target/x86_64-unknown-linux-gnu/release/$1" "$found" "fuzz/target/corpus/$1" \
        -max_total_time="$2" -timeout=1 -rss_limit_mb=512 -max_len=8192 -print_final_stats=1 \
        -dict=fuzz/words.dict -artifact_prefix="fuzz/artifacts/$1/" >"$3/$1.log" 2>&1
    local status=$?
    local runs rate peak
    runs=$(sed -n 's/^stat::number_of_executed_units: *//p' "$3/$1.log")
    rate=$(sed -n 's/^stat::average_exec_per_sec: *//p' "$3/$1.log")
    peak=$(sed -n 's/^stat::peak_rss_mb: *//p' "$3/$1.log")
    printf '%-11s exit %s  %12s runs  %8s/s  %4s MiB  %5s inputs\n' \
        "$1" "$status" "$runs" "$rate" "$peak" "$(find "$found" "fuzz/target/corpus/$1" -type f | wc -l)"
    return $status
}
export -f one
printf '%s\n' "${targets[@]}" | xargs -P 2 -I{} bash -c "one {} $seconds $logs"
