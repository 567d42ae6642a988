#!/bin/sh
# Opens exported glTF with programs that are not ours: Khronos' validator, which must report no error and
# no warning, and Blender, whose poses must be those of the CSV of the same motion.
#
#     tools/check_gltf.sh [FILE.estimate.mcap...]
#
# Without a file it estimates recordings of the repository. Clients are installed once, pinned, under
# target/gltf. Needs node, npm and Python 3.11, for which Blender's module is made (PYTHON says which).
set -eu
cd "$(dirname "$0")/.."
tools=$PWD/tools
home=${GLTF_CLIENTS:-$PWD/target/gltf}
enact=${ENACT:-"cargo run -q --release --"}

if [ ! -x "$home/bin/python" ]; then
    "${PYTHON:-python3}" -m venv "$home"
    "$home/bin/pip" install -q bpy==5.0.1
fi
if [ ! -d "$home/node_modules/gltf-validator" ]; then
    npm install --silent --no-audit --no-fund --prefix "$home" gltf-validator@2.0.0-dev.3.10 >/dev/null
fi

made=$(mktemp -d)
trap 'rm -rf "$made"' EXIT
if [ $# -eq 0 ]; then
    for name in pencil_tip die hat_box chain; do
        # 3: a doubt is no obstacle.
        $enact replay "recordings/$name.mcap" -o "$made/$name.estimate.mcap" >/dev/null || [ $? -eq 3 ]
        set -- "$@" "$made/$name.estimate.mcap"
    done
fi

for file in "$@"; do
    echo "== $file"
    for fps in 24 60; do
        $enact export "$file" --to glb --fps $fps --ghost -o "$made/x.glb" >/dev/null || [ $? -eq 3 ]
        $enact export "$file" --to csv --fps $fps --ghost -o "$made/x.csv" >/dev/null || [ $? -eq 3 ]
        NODE_PATH=$home/node_modules node "$tools/check_gltf.js" "$made/x.glb"
        "$home/bin/python" "$tools/check_gltf.py" "$made/x.glb" "$made/x.csv" $fps
    done
done
