#!/bin/sh
# Load until it breaks: more and more trackers, faster and faster, and what became of every sample.
#
#     tools/live/load.sh [SECONDS] [TRACKERS RATE_HZ]...
#
# Prints a row for each pair: what the driver sent and how fast it really was, what is in the journal,
# what the daemon says is missing, and what is neither (`unsaid`: it must be 0). Then how late samples
# were [ms], processor time [% of one processor], the daemon's memory [MB], the worst answer of
# `/health`, exit codes of `take status` during the take and of the daemon. On an iceoryx2 of its own,
# with copies of the programs. Needs curl and python3.
set -eu
seconds=${1:-10}
[ $# -eq 0 ] || shift
if [ $# -eq 0 ]; then
    for trackers in 1 8 32 64; do
        for rate_hz in 1000 2000 4000 8000 16000 32000; do set -- "$@" $trackers $rate_hz; done
    done
fi
cd "$(dirname "$0")/../.."
[ -n "${PROGRAMS:-}" ] || cargo build -q --release --workspace --bin enact --bin tracker
programs=${PROGRAMS:-${CARGO_TARGET_DIR:-target}/release}
made=$(mktemp -d)
daemon=
finish() {
    [ -z "$daemon" ] || kill -KILL "$daemon" 2>/dev/null || true
    rm -rf "$made" /dev/shm/enact_load_$$_*
}
trap finish EXIT
trap 'exit 1' INT TERM
cp "$programs/enact" "$programs/tracker" "$made"
cd "$made"
printf '[global]\nroot-path = "%s/iceoryx2/"\nprefix = "enact_load_%s_"\n' "$made" $$ >iceoryx2.toml
echo "trackers rate_hz sent sent_hz journalled missing overflows unsaid p50_ms p99_ms max_ms" \
    "driver_cpu daemon_cpu daemon_mb health status daemon load"
while [ $# -ge 2 ]; do
    trackers=$1 rate_hz=$2
    shift 2
    {
        printf 'name = "load"\n[timing]\nstamps = "physical"\n'
        for k in $(seq "$trackers"); do
            printf '[[body]]\nname = "t%s"\nshape = { kind = "sphere", radius_mm = 20 }\nmass_g = 50\n' "$k"
        done
    } >scene.toml
    : >said.txt
    rm -rf takes health.txt
    ./enact capture scene.toml -o takes --iceoryx2 iceoryx2.toml --format ndjson --metrics-port 0 \
        >said.txt 2>errors.txt &
    daemon=$!
    until grep -q '"ready"' said.txt; do sleep 0.1; done
    address=$(head -1 said.txt | sed 's/.*"metrics":"\([^"]*\)".*/\1/')
    (while sleep 0.5; do
        curl -s -m 5 -o health.body -w '%{http_code}\n' "$address/health" >>health.txt || echo 000 >>health.txt
    done) &
    asking=$!
    (sleep "$(awk "BEGIN { print 0.6 * $seconds }")"
        code=0
        ./enact take status --iceoryx2 iceoryx2.toml >status.txt 2>&1 || code=$?
        echo $code >status.code) &
    looking=$!
    /usr/bin/env bash -c 'TIMEFORMAT="%U %S %R"; time ./tracker "$@" >sent.txt 2>sent.errors' driver \
        --load "$trackers" --rate-hz "$rate_hz" --seconds "$seconds" --take --wait 60 \
        --iceoryx2 iceoryx2.toml 2>driver.txt || true
    cut -d' ' -f14,15 /proc/$daemon/stat >ticks.txt
    awk '/VmHWM/ { print $2 }' /proc/$daemon/status >memory.txt
    wait $looking || true
    kill $asking 2>/dev/null || true
    tries=0
    until grep -q '"closed"\|"broken"' said.txt || [ $tries -ge 300 ]; do sleep 0.1; tries=$((tries + 1)); done
    # What is estimated afterwards is not of the load: a second signal does not wait for it.
    kill -TERM $daemon
    (sleep 3 && kill -TERM $daemon && sleep 5 && kill -KILL $daemon) 2>/dev/null &
    code=0
    wait $daemon || code=$?
    daemon=
    python3 - "$trackers" "$rate_hz" "$code" <<'END'
import json, os, sys

trackers, rate_hz, code = sys.argv[1:]
text = lambda name: open(name).read().split() if os.path.exists(name) else []
try:
    driver = json.load(open("sent.txt"))
except ValueError:
    driver = {"poses": 0, "first_ns": 0, "last_ns": 0}
    print("# the driver said:", open("sent.errors").read().strip()[-300:])
sent = driver["poses"]
lasted_s = max((driver["last_ns"] - driver["first_ns"]) * 1e-9, 1e-9)
closed = [said for said in map(json.loads, open("said.txt")) if said["what"] in ("closed", "broken")]
lines = [line["counts"] for line in closed[-1]["counts"]["trackers"]] if closed and "counts" in closed[-1] else []
of = lambda name: sum(line[name] for line in lines)
received, missing = of("received") - of("duplicated"), of("missing")
late = closed[-1]["counts"]["latency_ms"] if lines else {"p50": -1, "p99": -1, "max": -1}
user, system, wall = map(float, text("driver.txt")[-3:])
ticks = sum(map(int, text("ticks.txt")))
print(
    trackers, rate_hz, sent, f"{sent / int(trackers) / lasted_s:.0f}", received, missing, of("overflows"),
    sent - received - missing, *(f"{late[k]:.2f}" for k in ("p50", "p99", "max")),
    f"{100 * (user + system) / wall:.0f}", f"{ticks / os.sysconf('SC_CLK_TCK') / wall * 100:.0f}",
    f"{int(text('memory.txt')[0]) / 1024:.0f}", max(text("health.txt"), default="none"),
    *(text("status.code") or ["none"]), code, text("/proc/loadavg")[0], flush=True,
)
END
done
