#!/bin/sh
# Two machines that are not there: trackers in one network namespace, the daemon in another,
# between them iceoryx2's zenoh tunnel over a virtual cable.
#
#   tools/live/tunnel.sh [SECONDS] [TRACKERS] [RATE_HZ] [POLL_MS]
#
# Needs root, iproute2 and the tunnel, `iox2-link-tunnel-zenoh` on the PATH or in $TUNNEL, which
# may begin with `nice -n -10`:
#   cargo install --locked iceoryx2-integrations-zenoh-link-tunnel-cli
# Says what was sent, what is in the journal and how long it took: the first sample that came
# and all after it are in its counts, those before are not.
set -eu
seconds=${1:-20} trackers=${2:-1} rate_hz=${3:-200} poll_ms=${4:-5}
tunnel=${TUNNEL:-iox2-link-tunnel-zenoh}
cd "$(dirname "$0")/../.."
cargo build --release --quiet --workspace --bin enact --bin tracker
here=$(mktemp -d)
studio=enact-studio-$$ desk=enact-desk-$$
started=""

finish() {
    for process in $started; do kill "$process" 2>/dev/null || true; done
    for process in $started; do wait "$process" 2>/dev/null || true; done
    ip netns del "$studio" 2>/dev/null || true
    ip netns del "$desk" 2>/dev/null || true
    rm -rf "$here" /dev/shm/enacts$$_* /dev/shm/enactd$$_*
}
trap finish EXIT
trap 'exit 1' INT TERM

# A machine: a namespace with its address, an iceoryx2 of its own, a tunnel.
machine() { # namespace, cable's end, address, prefix, zenoh's settings
    mkdir -p "$here/$1/config"
    printf '[global]\nroot-path = "%s/"\nprefix = "%s"\n' "$here/$1/iceoryx2" "$4" \
        >"$here/$1/config/iceoryx2.toml"
    printf '{ mode: "peer", scouting: { multicast: { enabled: false } }, %s }\n' "$5" \
        >"$here/$1/zenoh.json5"
    ip -n "$1" addr add "$3/24" dev "$2"
    ip -n "$1" link set "$2" up
    ip -n "$1" link set lo up
}
ip netns add "$studio"
ip netns add "$desk"
ip link add "es$$" netns "$studio" type veth peer name "ed$$" netns "$desk"
machine "$studio" "es$$" 10.77.0.1 "enacts$$_" 'connect: { endpoints: ["tcp/10.77.0.2:7447"] }, listen: { endpoints: [] }'
machine "$desk" "ed$$" 10.77.0.2 "enactd$$_" 'listen: { endpoints: ["tcp/10.77.0.2:7447"] }'

# What is made first has its maker's quality; what the tunnel makes has a buffer of 2.
{
    printf 'name = "trackers"\n[timing]\nstamps = "physical"\n'
    for k in $(seq "$trackers"); do
        printf '[[body]]\nname = "t%s"\nshape = { kind = "sphere", radius_mm = 20 }\nmass_g = 50\n' "$k"
    done
} >"$here/scene.toml"
ip netns exec "$desk" target/release/enact capture "$here/scene.toml" -o "$here/takes" \
    --iceoryx2 "$here/$desk/config/iceoryx2.toml" --format ndjson >"$here/said" &
started="$started $!"
until grep -q '"ready"' "$here/said" 2>/dev/null; do sleep 0.1; done
ip netns exec "$studio" target/release/tracker --load "$trackers" \
    --rate-hz "$rate_hz" --seconds "$seconds" --take --wait 30 \
    --iceoryx2 "$here/$studio/config/iceoryx2.toml" &
started="$started $!" tracker=$!
until [ -n "$(ls "$here/$studio/iceoryx2/services" 2>/dev/null)" ]; do sleep 0.1; done
sleep 0.5
for end in "$desk" "$studio"; do
    # Where it is started, the tunnel finds config/iceoryx2.toml.
    (cd "$here/$end" && exec ip netns exec "$end" $tunnel --poll "$poll_ms" --allow 'enact/*' \
        --zenoh-config zenoh.json5 >tunnel.log 2>&1) &
    started="$started $!"
done
wait "$tracker" || { cat "$here"/*/tunnel.log; exit 1; }
until grep -q '"closed"\|"broken"' "$here/said"; do sleep 0.1; done
grep '"closed"' "$here/said"
