"""Imports a BVH in Blender and compares poses of every joint at every frame with the CSV of the same motion.

    check_bvh.py FILE.bvh FILE.csv FPS
"""

import csv
import sys
from collections import defaultdict
from math import atan2

import bpy
from mathutils import Quaternion, Vector

bvh, table, fps = sys.argv[1], sys.argv[2], float(sys.argv[3])
bpy.ops.wm.read_factory_settings(use_empty=True)
bpy.context.scene.render.fps = round(fps)
bpy.ops.import_anim.bvh(filepath=bvh, axis_forward="-Z", axis_up="Y", rotate_mode="QUATERNION")
skeleton = bpy.context.object

keys = defaultdict(list)
with open(table) as rows:
    for row in csv.DictReader(line for line in rows if not line.startswith("#")):
        frame = float(row["t_s"]) * fps
        # A BVH has frames alone, and no performance.
        if row["motion"] == "acted" or abs(frame - round(frame)) > 1e-6 * fps:
            continue
        place = Vector([float(row[c]) for c in ("x_m", "y_m", "z_m")])
        turn = Quaternion([float(row[c]) for c in ("qw", "qx", "qy", "qz")])
        # Blanks end names in a BVH.
        keys[row["body"].replace(" ", "_")].append((round(frame), place, turn))
first = min(frame for of in keys.values() for frame, _, _ in of)

seen = 0
farthest_m = widest_rad = 0.0
for name, of in keys.items():
    bone, rest = skeleton.pose.bones[name], skeleton.data.bones[name].matrix_local
    # Blender stores y-up files turned upright; what a bone is turned by at rest is not the body's.
    for frame, place, turn in of:
        bpy.context.scene.frame_set(frame - first + 1)
        at = skeleton.matrix_world @ bone.matrix
        farthest_m = max(farthest_m, (at.translation - place).length)
        moved = at.to_quaternion() @ rest.to_quaternion().inverted()
        upright = Quaternion((1.0, 0.0, 0.0), -3.141592653589793 / 2)
        apart = (moved @ upright.inverted()).rotation_difference(turn)
        widest_rad = max(widest_rad, 2 * atan2(Vector(apart[1:]).length, abs(apart.w)))
        seen += 1
print(f"Blender {bpy.app.version_string}: {len(keys)} joints, {seen} poses, at most {farthest_m:.1e} m and {widest_rad:.1e} rad off")
if seen == 0 or farthest_m > 1e-5 or widest_rad > 1e-4:
    sys.exit("poses differ")
