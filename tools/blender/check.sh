#!/usr/bin/env bash
# Builds the wheel and the extension's zip as they are given to people, validates the zip by Blender's own tool, installs it in an
# empty home and runs what is said of it: refusals, goals, undo, files, live changes, parity with the program, requests of animators,
# and how fast a dragged goal is answered.
#
# BPY says which versions of the module bpy it is run with, the first of which builds ("5.0.1 4.5.15 4.2.23"). PYTHON says which Python:
# 3.11, for which these are made. WHEEL and ENACT say which wheel and which program are taken; without, they are built. Exits with 77 where there is
# no such Python, or where PyPI is not reached.
set -euo pipefail
cd "$(dirname "$0")/../.."
export CARGO_TARGET_DIR="${CARGO_TARGET_DIR:-$PWD/target}"
python="${PYTHON:-python3}"
versions="${BPY:-5.0.1 4.5.15 4.2.23}"
here="$CARGO_TARGET_DIR/blender"

unable() {
    echo "$1" >&2
    exit 77
}

"$python" -c 'import sys; sys.exit(sys.version_info[:2] != (3, 11))' 2>/dev/null || unable "no Python 3.11, which bpy needs: PYTHON=$python"
mkdir -p "$here"
for version in $versions; do
    venv="$here/venv-$version"
    if [ ! -x "$venv/bin/pytest" ]; then
        rm -rf "$venv"
        "$python" -m venv "$venv" || unable "no module venv of $python"
        timeout 900 "$venv/bin/python" -m pip install --quiet --disable-pip-version-check \
            "bpy==$version" 'maturin>=1.9,<2' 'pytest>=8' 'ruff==0.14.6' >"$here/pip" 2>&1 ||
            unable "no packages of PyPI: $(tail -n 1 "$here/pip")"
    fi
done
first="$here/venv-${versions%% *}/bin"

(cd tools/blender && "$first/ruff" check --quiet .)
if [ -z "${WHEEL:-}" ]; then
    rm -rf "$here/wheels"
    "$first/maturin" build --quiet --release --locked --manifest-path tools/python/Cargo.toml --out "$here/wheels"
    WHEEL="$(echo "$here"/wheels/*.whl)"
fi
if [ -z "${ENACT:-}" ]; then
    cargo build --quiet --locked --release -p enact --bin enact
    ENACT="$CARGO_TARGET_DIR/release/enact"
fi
export ENACT

rm -rf "$here/zips"
MOTION_SKETCH_ZIP="$("$first/python" tools/blender/build.py --out "$here/zips" "$WHEEL")"
export MOTION_SKETCH_ZIP
bytes="$(wc -c <"$MOTION_SKETCH_ZIP")"
echo "zip: $bytes bytes, $(basename "$MOTION_SKETCH_ZIP"), built and validated"
[ "$bytes" -lt 15000000 ] || {
    echo "expected less than 15 MB" >&2
    exit 1
}
for version in $versions; do
    echo "bpy $version"
    "$here/venv-$version/bin/python" -P -m pytest --quiet -p no:cacheprovider tools/blender/tests
done
"$first/python" -P tools/blender/benches/live.py
