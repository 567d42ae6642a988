#!/usr/bin/env bash
# Builds the wheel as it is given to people, installs it where nothing else is, and runs what is said of it: parity with the
# program over every recording, the tests, the documentation's examples, the stubs.
#
# PYTHON says which Python (3.11 or later), without it the first of the usual names is taken that is one; exits with 77 where there is
# none, or where PyPI is not reached. ENACT says which program it is compared with; without, that is built.
set -euo pipefail
cd "$(dirname "$0")/../.."
export CARGO_TARGET_DIR="${CARGO_TARGET_DIR:-$PWD/target}"
here="$CARGO_TARGET_DIR/python"

unable() {
    echo "$1" >&2
    exit 77
}

is_enough() { "$1" -c 'import ensurepip, sys, venv; sys.exit(sys.version_info < (3, 11))' >/dev/null 2>&1; }
names=(${PYTHON:-python3 python3.14 python3.13 python3.12 python3.11})
python=
for name in "${names[@]}"; do
    if is_enough "$name"; then
        python="$name"
        break
    fi
done
[ -n "$python" ] || unable "no Python of 3.11 or later that has venv, of ${names[*]}: PYTHON says another"
mkdir -p "$here"
if [ ! -x "$here/venv/bin/ray" ]; then
    rm -rf "$here/venv"
    "$python" -m venv "$here/venv"
    # Once more is enough where there is no net: pip waits longer each time.
    timeout 600 "$here/venv/bin/python" -m pip install --quiet --disable-pip-version-check --retries 1 \
        'maturin>=1.9,<2' 'matplotlib>=3.8' 'mypy>=1.18' 'numpy>=1.24' 'pytest>=8' 'ray[data]>=2.40,<3' 'scipy>=1.11' >"$here/pip" 2>&1 ||
        unable "no packages of PyPI: $(tail -n 1 "$here/pip")"
fi
bin="$here/venv/bin"

if [ -z "${ENACT:-}" ]; then
    # With the module at once: apart they have other features of what both depend on, and all of it is built twice.
    cargo build --quiet --locked --release --package enact --package enact-python
    ENACT="$CARGO_TARGET_DIR/release/enact"
fi
export ENACT

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

# Without the sources in its path: what is tested is what was installed.
"$bin/python" -P -m pytest --quiet -p no:cacheprovider -o doctest_optionflags=ELLIPSIS tools/python/tests
"$bin/python" -P -m mypy.stubtest enact_motion --mypy-config-file tools/python/pyproject.toml --allowlist tools/python/stubtest.txt
"$bin/python" -P -m mypy --config-file tools/python/pyproject.toml --no-incremental tools/python/tests/typed.py
