#!/bin/sh
# Acts in a headless browser, by mouse and by a headset that iwer plays, and looks at what comes back: see
# docs/acting.md. Prints what was measured, and where pictures are that somebody should look at.
#
#     tools/acting/check.sh [FOLDER]
#
# ENACT says which program (default: target/release/enact, built with live takes), CHROMIUM which browser. Ends with 77
# where Node, its packages or a browser cannot be had.
set -eu
cd "$(dirname "$0")"
root=$(cd ../.. && pwd)

cannot() {
    echo "tools/acting/check.sh: $1" >&2
    exit 77
}

for name in node npm; do
    command -v $name >/dev/null || cannot "$name is not there"
done
browser=${CHROMIUM:-$(command -v chromium || command -v chromium-browser || command -v google-chrome || true)}
[ -n "$browser" ] || cannot "no Chromium: install one, or say where it is by CHROMIUM"
if [ ! -d node_modules/playwright-core ]; then
    npm ci --silent --ignore-scripts || cannot "npm ci has no packages"
fi
npm run --silent build

if [ -z "${ENACT:-}" ]; then
    cargo build -q --locked --release --features live --manifest-path "$root/Cargo.toml"
    ENACT=${CARGO_TARGET_DIR:-$root/target}/release/enact
fi
folder=${1:-$(mktemp -d)}
mkdir -p "$folder"
node check/browser.js "$ENACT" "$browser" "$(cd "$folder" && pwd)"
