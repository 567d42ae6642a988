#!/usr/bin/env bash
# Puts the faults of `by_hand.txt` into a copy of the tree, one at a time, and says which no test notices.
#
#     tools/mutants/by_hand.sh            # all of them
#     tools/mutants/by_hand.sh journal    # those whose name holds that
#
# Ends with 1 where one went unnoticed, was not found in its file, or does not compile.
set -euo pipefail
cd "$(dirname "$0")/../.."

wanted="${1:-}"
list="$PWD/tools/mutants/by_hand.txt"
export CARGO_TARGET_DIR="${CARGO_TARGET_DIR:-$PWD/target}/by_hand" CARGO_PROFILE_DEV_DEBUG=none
copy="$(mktemp -d)"
said="$(mktemp -d)"
trap 'rm -rf "$copy" "$said"' EXIT
git ls-files -z | xargs -0 cp --parents -t "$copy"
cd "$copy"

# Without a fault all of them pass, or nothing here says anything.
asked="$(sed -n 's/^test: //p' "$list" | tr ' ' '\n' | sort -u | paste -sd' ')"
# The library's tests, and those of the modules that are named as `binary::module`.
run() { # MODULES ARGUMENTS
    local binaries modules
    binaries="$(tr ' ' '\n' <<<"$1" | sed -n 's/::.*//p' | sort -u | sed 's/^/--test=/')"
    modules="$(tr ' ' '\n' <<<"$1" | sed -n 's/.*::\(.*\)/\1::/p')"
    # Words on purpose.
    # shellcheck disable=SC2086
    timeout 900 cargo test --quiet --locked -p enact -p enact-core --no-fail-fast --lib $binaries "${@:2}" -- tests:: $modules
}
run "$asked" >"$said/tests" 2>&1 || { tail -n 40 "$said/tests"; exit 1; }

amiss=0
try() { # NAME FILE FROM TO TESTS
    local text before
    before="$(<"$2")"
    text="${before/"$3"/"$4"}"
    if [ "$text" = "$before" ]; then
        echo "not found: $1"
        amiss=1
        return
    fi
    printf '%s\n' "$text" >"$2"
    if ! run "$5" --no-run >"$said/build" 2>&1; then
        echo "does not compile: $1"
        tail -n 20 "$said/build"
        amiss=1
    elif run "$5" >"$said/tests" 2>&1; then
        echo "UNNOTICED: $1"
        amiss=1
    else
        echo "noticed: $1: $(sed -n 's/^test \(.*\) \.\.\. FAILED$/\1/p; s/^    \([a-z_0-9:]*\)$/\1/p' "$said/tests" | sort -u | paste -sd' ' | cut -c1-300)"
    fi
    printf '%s\n' "$before" >"$2"
}

name='' file='' from='' to='' tests=''
finish() {
    if [ -n "$name" ] && [[ "$name" == *"$wanted"* ]]; then
        try "$name" "$file" "$from" "$to" "$tests"
    fi
    name='' tests=''
}
while IFS= read -r line <&3; do
    case "$line" in
        'name: '*) finish; name="${line#name: }" ;;
        'file: '*) file="${line#file: }" ;;
        'from: '*) from="${line#from: }" ;;
        'to: '*) to="${line#to: }" ;;
        'test: '*) tests="${line#test: }" ;;
    esac
done 3<"$list"
finish
exit "$amiss"
