#!/bin/sh
# Eight trackers at 1 kHz on the daemon: what it received, how late, in how much memory.
#
#     tools/live/soak.sh [SECONDS] [TAKES] [CHUNK_MS]
#
# Prints the daemon's memory and processor time and the machine's load on the way, the counts of every
# take, and at the end the daemon's metrics. Viewers look on if `../check_live.sh` has installed their
# client. On an iceoryx2 of its own, with copies of the programs, so that builds may go on meanwhile.
set -eu
seconds=${1:-600}
takes=${2:-1}
chunk_ms=${3:-100}
cd "$(dirname "$0")/../.."
root=$PWD
cargo build -q --release --workspace --bin enact --bin tracker
made=$(mktemp -d)
trap 'kill "$daemon" 2>/dev/null || true; rm -rf "$made" /dev/shm/enact_soak_$$_*' EXIT
cp "${CARGO_TARGET_DIR:-target}/release/enact" "${CARGO_TARGET_DIR:-target}/release/tracker" "$made"
cd "$made"
printf '[global]\nroot-path = "%s/iceoryx2/"\nprefix = "enact_soak_%s_"\n' "$made" $$ >iceoryx2.toml
{
    printf 'name = "eight trackers"\n[timing]\nstamps = "physical"\n[capture]\nchunk_ms = %s\n' "$chunk_ms"
    for k in 1 2 3 4 5 6 7 8; do
        printf '[[body]]\nname = "t%s"\nshape = { kind = "sphere", radius_mm = 20 }\nmass_g = 50\n' $k
    done
} >scene.toml
./enact capture scene.toml -o takes --iceoryx2 iceoryx2.toml --format ndjson \
    --viewer-port 0 --metrics-port 0 >said.txt &
daemon=$!
until grep -q '"ready"' said.txt; do sleep 0.1; done
address() { head -1 said.txt | sed "s/.*\"$1\":\"\([^\"]*\)\".*/\1/"; }
if [ -d "$root/target/clients/node_modules/@foxglove/ws-protocol" ]; then
    NODE_PATH=$root/target/clients/node_modules node "$root/tools/live/watch.js" "$(address viewer)" "$seconds" stay >watched.txt 2>&1 &
fi
echo "time resident_kb user_ticks system_ticks load health"
(while sleep 10 && kill -0 $daemon 2>/dev/null; do
    echo "$(date -u +%T) $(awk '/VmRSS/ { print $2 }' /proc/$daemon/status)" \
        "$(cut -d' ' -f14,15 /proc/$daemon/stat) $(cut -d' ' -f1 /proc/loadavg)" \
        "$(curl -s -o metrics.txt -w '%{http_code}' "$(address metrics)/health")"
    curl -s -o metrics.txt "$(address metrics)/metrics"
done) &
for _ in $(seq "$takes"); do
    ./tracker --load 8 --rate-hz 1000 --seconds "$seconds" --take --iceoryx2 iceoryx2.toml
done
curl -s "$(address metrics)/metrics" | grep -v '^#'
cat watched.txt 2>/dev/null || true
kill -TERM $daemon
wait $daemon || true # 3: takes of ten minutes are left to `enact process`
cat said.txt
