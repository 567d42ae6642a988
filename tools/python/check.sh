#!/usr/bin/env bash
# Builds the wheel as it is given to people, installs it where nothing else is, and runs what is said of it: parity with the
# program over every recording, the tests, the documentation's examples, the stubs.
#
# PYTHON says which Python (3.11 or later); exits with 77 where there is none, or where PyPI is not reached. ENACT says which
# program it is compared with; without, that is built.
set -euo pipefail
cd "$(dirname "$0")/../.."
export CARGO_TARGET_DIR="${CARGO_TARGET_DIR:-$PWD/target}"
python="${PYTHON:-python3}"
here="$CARGO_TARGET_DIR/python"

unable() {
    echo "$1" >&2
    exit 77
}

"$python" -c 'import sys; sys.exit(sys.version_info < (3, 11))' 2>/dev/null || unable "no Python of 3.11 or later: PYTHON=$python"
mkdir -p "$here"
if [ ! -x "$here/venv/bin/ray" ]; then
    rm -rf "$here/venv"
    "$python" -m venv "$here/venv" || unable "no module venv of $python"
    timeout 600 "$here/venv/bin/python" -m pip install --quiet --disable-pip-version-check \
        'maturin>=1.9,<2' 'matplotlib>=3.8' 'mypy>=1.18' 'numpy>=1.24' 'pytest>=8' 'ray[data]>=2.40,<3' 'scipy>=1.11' >"$here/pip" 2>&1 ||
        unable "no packages of PyPI: $(tail -n 1 "$here/pip")"
fi
bin="$here/venv/bin"

rm -rf "$here/wheels"
"$bin/maturin" build --quiet --release --locked --manifest-path tools/python/Cargo.toml --out "$here/wheels"
wheel=("$here"/wheels/*.whl)
bytes="$(wc -c <"${wheel[0]}")"
echo "wheel: $bytes bytes, $(basename "${wheel[0]}")"
[ "$bytes" -lt 15000000 ] || {
    echo "expected less than 15 MB" >&2
    exit 1
}
"$bin/python" -m pip install --quiet --disable-pip-version-check --no-index --no-deps --force-reinstall "${wheel[0]}"

if [ -z "${ENACT:-}" ]; then
    cargo build --quiet --locked --release -p enact --bin enact
    ENACT="$CARGO_TARGET_DIR/release/enact"
fi
export ENACT
# Without the sources in its path: what is tested is what was installed.
"$bin/python" -P -m pytest --quiet -p no:cacheprovider -o doctest_optionflags=ELLIPSIS tools/python/tests
"$bin/python" -P -m mypy.stubtest enact_motion --mypy-config-file tools/python/pyproject.toml --allowlist tools/python/stubtest.txt
"$bin/python" -P -m mypy --config-file tools/python/pyproject.toml --no-incremental tools/python/tests/typed.py
