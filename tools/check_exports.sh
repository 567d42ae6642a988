#!/bin/sh
# Opens exported files with programs that are not ours: glTF with Khronos' validator, which must report no error and no
# warning; glTF and BVH with Blender, and ROS 2 with rosbags and evo, whose poses must be those of the CSV of the same motion.
#
#     tools/check_exports.sh [FILE.estimate.mcap...]
#
# Without a file it estimates recordings of the repository. Clients are installed once, pinned, under
# target/exports. Needs node, npm and Python 3.11, for which Blender's module is made (PYTHON says which).
set -eu
cd "$(dirname "$0")/.."
tools=$PWD/tools
home=${EXPORT_CLIENTS:-$PWD/target/exports}
enact=${ENACT:-"cargo run -q --release --"}
python=$home/bin/python

if [ ! -x "$python" ]; then
    "${PYTHON:-python3}" -m venv "$home"
    "$home/bin/pip" install -q bpy==5.0.1 rosbags==0.11.9 evo==1.38.1
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

export_to() { # FORMAT -o OUTPUT OPTION...
    $enact export "$file" --to "$@" >/dev/null || [ $? -eq 3 ]
}

for file in "$@"; do
    echo "== $file"
    for fps in 24 60; do
        export_to glb -o "$made/x.glb" --fps $fps --ghost
        export_to csv -o "$made/x.csv" --fps $fps --ghost
        export_to bvh -o "$made/x.bvh" --fps $fps
        NODE_PATH=$home/node_modules node "$tools/check_gltf.js" "$made/x.glb"
        "$python" "$tools/check_gltf.py" "$made/x.glb" "$made/x.csv" $fps
        "$python" "$tools/check_bvh.py" "$made/x.bvh" "$made/x.csv" $fps
    done
    export_to csv -o "$made/x.csv" --fps 240
    export_to ros2 -o "$made/x.mcap"
    "$python" "$tools/check_ros2.py" "$made/x.mcap" "$made/x.csv"
done
