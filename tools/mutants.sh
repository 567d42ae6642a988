#!/usr/bin/env bash
# Puts faults into the core, one at a time, and says which no test notices.
#
#     tools/mutants.sh SHARD/OF [FILE...]     # one part of all, or of those in some files
#
# What is changed and which tests are asked is in `.cargo/mutants.toml`; what was found, in
# `tools/mutants/README.md`. Needs `cargo install --locked cargo-mutants`.
set -euo pipefail
cd "$(dirname "$0")/.."

shard="${1:?which part: for example 0/100}"
shift
files=()
for file in "$@"; do
    files+=(--file "$file")
done

# Tests decide, not lints; one copy of the tree, built without debug information.
export CARGO_PROFILE_DEV_DEBUG=none
output="${OUTPUT:-target/mutants}"
mkdir -p "$output"
exec cargo mutants --shard "$shard" "${files[@]}" \
    --jobs "${JOBS:-1}" --cap-lints=true --no-shuffle --baseline="${BASELINE:-run}" \
    --build-timeout 1200 --output "$output"
