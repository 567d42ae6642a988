#!/usr/bin/env bash
# Coverage-guided fuzzing with the stable toolchain: the instrumentation is that of cargo-fuzz without a
# sanitizer. Needs a C++ compiler, for libFuzzer.
#
#     tools/fuzz.sh build
#     tools/fuzz.sh smoke SECONDS       all targets, that long in all; fails at the first finding
#     tools/fuzz.sh run TARGET [ARGUMENTS of libFuzzer]
#
# Inputs that reach new code are kept in target/fuzz/corpus/TARGET; what is found, in
# target/fuzz/artifacts. Seeds are the recordings and scenes that come along.
set -euo pipefail
cd "$(dirname "$0")/.."

targets=(reader scene sketch urdf recover merge replay peers)
folder="${CARGO_TARGET_DIR:-target}/fuzz"
host="$(rustc -vV | sed -n 's/^host: //p')"

build() {
    # The versions are those of the program.
    cp Cargo.lock tools/fuzz/Cargo.lock
    RUSTFLAGS="--cfg fuzzing -Cpasses=sancov-module -Cllvm-args=-sanitizer-coverage-level=4 \
-Cllvm-args=-sanitizer-coverage-inline-8bit-counters -Cllvm-args=-sanitizer-coverage-pc-table \
-Cllvm-args=-sanitizer-coverage-trace-compares -Ccodegen-units=16" \
        cargo build --release --manifest-path tools/fuzz/Cargo.toml --target "$host" \
        --target-dir "$folder"
}

# Small valid files, so that the inside is reached.
seeds() { # TARGET
    local corpus="$folder/corpus/$1"
    mkdir -p "$corpus" "$folder/artifacts/$1"
    case "$1" in
    scene) cp config/*.toml "$corpus" ;;
    sketch) cp tools/fuzz/seeds/*.csv "$corpus" ;;
    urdf) cp tools/fuzz/seeds/*.urdf "$corpus" ;;
    peers) cp tools/fuzz/seeds/*.peer "$corpus" ;;
    *) cp tools/fuzz/seeds/*.mcap recordings/chain.mcap "$corpus" ;;
    esac
}

run() { # TARGET ARGUMENTS
    local target="$1"
    shift
    seeds "$target"
    # A quarter of a minute for one input is a finding, and two gigabytes are.
    "$folder/$host/release/$target" "$folder/corpus/$target" -timeout=15 -rss_limit_mb=2048 \
        -artifact_prefix="$folder/artifacts/$target/" "$@"
}

case "${1:-}" in
build) build ;;
smoke)
    build
    each=$((${2:-60} / ${#targets[@]}))
    for target in "${targets[@]}"; do
        run "$target" -max_total_time="$each" -seed=7 -print_final_stats=1 2>&1 |
            grep -E '^stat::number_of_executed_units|^==|SUMMARY|panicked|Test unit written' | sed "s/^/$target: /"
    done
    ;;
run)
    run "${@:2}"
    ;;
*)
    sed -n '2,/^set/p' "$0" | sed -n 's/^# \{0,1\}//p' >&2
    exit 2
    ;;
esac
