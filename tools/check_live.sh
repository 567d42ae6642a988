#!/bin/sh
# Runs the daemon against clients that are not ours and fails if they do not understand each
# other: the PyPI package iceoryx2 as a driver and as a listener, the crate iceoryx2-cli, readers of
# MCAP, CDR and protobuf, and the WebSocket client of Lichtblick.
#
#     tools/check_live.sh
#
# Clients are installed once, pinned, under target/clients. Needs python3 with venv, node and npm.
set -eu
cd "$(dirname "$0")/.."
root=$PWD
home=$root/target/clients
python=$home/bin/python

[ -x "$python" ] || python3 -m venv "$home"
"$python" -c 'import iceoryx2, mcap_ros2, mcap_protobuf, jsonschema' 2>/dev/null ||
    "$home/bin/pip" install -q iceoryx2==0.10.0 mcap==1.6.0 mcap-protobuf-support==0.6.0 \
        mcap-ros2-support==0.6.0 jsonschema==4.26.0
if [ ! -d "$home/node_modules/@foxglove/ws-protocol" ]; then
    npm install --silent --no-audit --no-fund --prefix "$home" \
        @foxglove/ws-protocol@0.8.0 ws@8.23.0 protobufjs@8.8.1 >/dev/null
fi
if [ ! -x "$home/bin/iox2-service" ]; then
    cargo install -q --locked --root "$home" --target-dir "$root/target/iox2" iceoryx2-cli --version 0.10.0
fi
PATH=$home/bin:$PATH
cargo build -q --release --workspace --bin enact --bin tracker
enact=$root/target/release/enact

# An iceoryx2 of our own: everybody finds its configuration in ./config.
made=$(mktemp -d)
mkdir "$made/config"
cat >"$made/config/iceoryx2.toml" <<EOF
[global]
root-path = "$made/iceoryx2/"
prefix = "enact_check_$$_"
EOF
daemon=
trap '[ -z "$daemon" ] || kill "$daemon" 2>/dev/null || true; rm -rf "$made" /dev/shm/enact_check_$$_*' EXIT
cd "$made"

fail() {
    echo "FAILED: $1" >&2
    for file in said.txt heard.txt; do echo "== $file" >&2; cat $file >&2; done
    exit 1
}
wait_for() { # WHAT FILE
    for _ in $(seq 300); do
        grep -q "$1" "$2" 2>/dev/null && return
        sleep 0.1
    done
    fail "no $1 in $2"
}

: >said.txt
"$enact" capture "$root/config/pencil_tip.toml" -o takes --viewer-port 0 --format ndjson >said.txt &
daemon=$!
wait_for '"what":"ready"' said.txt

echo "== iox2 service details"
iox2-service details enact/tracker/pencil/pose >details.txt
grep -q 'enact.Pose.1' details.txt || fail "the type name is not shown"
grep -E 'type_name|max_buffer_size|size' details.txt | head -8

echo "== a take, heard from Python and watched as Lichtblick does"
address=$("$python" -c 'import json; print(json.loads(open("said.txt").readline())["viewer"])')
NODE_PATH=$home/node_modules node "$root/tools/live/watch.js" "$address" 60 >watched.txt 2>&1 &
viewer=$!
"$python" "$root/tools/live/subscribe.py" 12 config/iceoryx2.toml pencil >heard.txt &
listener=$!
sleep 1 # its interpreter starts; what it must hear comes seconds later
"$root/target/release/tracker" "$root/recordings/pencil_tip.mcap" --take --now
wait_for '"is_final": 1' heard.txt
"$python" - <<'EOF' || fail "what was heard is not what was said"
import json
said = [json.loads(line) for line in open("said.txt")]
heard = [json.loads(line) for line in open("heard.txt")]
report = next(line["report"] for line in said if line["what"] == "estimated")
final = next(line for line in heard if line.get("is_final") == 1)
assert final["objective"] == report["objective"] and final["verdict"] == 2
frames = sum(line["frames"] for line in heard if "body" in line and line["last"][0] == final["sequence"])
assert frames == final["frames"], (frames, final["frames"])
print("estimate", final["objective"], "with", frames, "frames")
EOF
wait $listener
wait $viewer || { cat watched.txt; fail "the viewer does not see what it should"; }
tail -1 watched.txt

echo "== the journal, read from Python"
take=$(ls takes/take-*Z.mcap | head -1)
"$python" "$root/tools/live/check_journal.py" "$take" || fail "the journal is not understood"

echo "== a driver in Python, counted by iox2"
kill -TERM $daemon
wait $daemon || true
"$enact" capture "$root/config/pencil_tip.toml" -o takes --start --format ndjson >said.txt &
daemon=$!
wait_for '"what":"started"' said.txt
"$python" "$root/tools/live/publish.py" /tracker/pencil/pose 6 config/iceoryx2.toml &
driver=$!
timeout 5 iox2-service hz enact/tracker/pencil/pose >hz.txt 2>&1 || true
wait $driver
kill -TERM $daemon
wait $daemon || true
daemon=
tail -3 hz.txt
"$python" - <<'EOF' || fail "the daemon did not hear the driver"
import json
closed = next(json.loads(line) for line in open("said.txt") if '"closed"' in line)
counts = closed["counts"]["trackers"][0]["counts"]
assert counts["received"] == 1200 and counts["missing"] == 0 and counts["duplicated"] == 0, counts
print("received", counts["received"], "of 1200")
EOF
echo "all well"
