#!/bin/sh
# Opens an output file with clients that are not ours and fails if any of them complains.
#
#     tools/check_clients.sh [FILE.mcap...]
#
# Without a file it makes two: tools/sample_output.rs, and the estimate of a ROS 2 recording that
# rosbags writes of it, which rosbags must read whole. Clients are installed once, pinned,
# under target/clients. Needs python3 with venv, node and npm.
set -eu
cd "$(dirname "$0")/.."
tools=$PWD/tools
home=$PWD/target/clients
python=$home/bin/python

if [ ! -x "$home/bin/rerun" ]; then
    python3 -m venv "$home"
    "$home/bin/pip" install -q mcap==1.6.0 mcap-protobuf-support==0.6.0 \
        'rerun-sdk[catalog]==0.41.0' rosbags==0.11.9 jsonschema==4.26.0
fi
"$home/bin/rerun" analytics disable >/dev/null 2>&1
if [ ! -d "$home/node_modules/@mcap/nodejs" ]; then
    npm install --silent --no-audit --no-fund --prefix "$home" \
        @mcap/core@2.2.2 @mcap/nodejs@1.0.2 @mcap/support@1.1.0 protobufjs@8.8.1 >/dev/null
fi

if [ $# -eq 0 ]; then
    made=$(mktemp -d)
    trap 'rm -rf "$made"' EXIT
    cargo run -q --release -p enact-tools --bin sample_output -- "$made"
    "$python" "$tools/check_clients.py" make-ros2 "$made/pencil_in.mcap" "$made/ros2"
    cargo run -q --release -- replay "$made"/ros2/*.mcap --scene config/pencil_tip.toml \
        -o "$made/ros2_out.mcap"
    set -- "$made/pencil_out.mcap" "$made/ros2_out.mcap"
fi

for file in "$@"; do
    echo "== $file"
    "$python" "$tools/check_clients.py" mcap "$file"
    "$python" "$tools/check_clients.py" rerun "$file"
    NODE_PATH=$home/node_modules node "$tools/check_clients.js" "$file"
    "$python" "$tools/check_clients.py" rosbags "$file"
done
