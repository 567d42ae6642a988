#!/bin/sh
# How long previews take while pencils are acted live at 240 Hz: histograms of the daemon's metrics.
#
#     tools/live/previews.sh [TAKES]
set -eu
takes=${1:-20}
cd "$(dirname "$0")/../.."
cargo build -q --release --workspace --bin enact --bin tracker
release=$PWD/target/release
made=$(mktemp -d)
daemon=
trap '[ -z "$daemon" ] || kill "$daemon" 2>/dev/null || true; rm -rf "$made" /dev/shm/enact_previews_$$_*' EXIT
printf '[global]\nroot-path = "%s/iceoryx2/"\nprefix = "enact_previews_%s_"\n' "$made" $$ >"$made/iceoryx2.toml"
for stamps in physical tempo; do
    preset=acted
    [ "$stamps" = tempo ] || preset=timing-known
    sed "s/^stamps = .*/stamps = \"$stamps\"/" config/pencil_tip.toml >"$made/scene.toml"
    : >"$made/said.txt"
    "$release/enact" capture "$made/scene.toml" -o "$made/takes" --iceoryx2 "$made/iceoryx2.toml" \
        --metrics-port 0 --format ndjson >"$made/said.txt" &
    daemon=$!
    until grep -q '"ready"' "$made/said.txt"; do sleep 0.1; done
    for seed in $(seq "$takes"); do
        "$release/tracker" --perform tip --preset "$preset" --rate-hz 240 --seed "$seed" --take \
            --iceoryx2 "$made/iceoryx2.toml" >/dev/null
    done
    echo "== stamps = $stamps, $takes takes"
    address=$(head -1 "$made/said.txt" | sed 's/.*"metrics":"\([^"]*\)".*/\1/')
    curl -s "$address/metrics" | grep -E '^enact_(preview|estimate)_seconds'
    kill -TERM $daemon
    wait $daemon || true
    daemon=
done
