"""Imports a GLB in Blender and compares poses of every object at every key with the CSV of the same motion.

    check_gltf.py FILE.glb FILE.csv FPS
"""

import csv
import sys
from collections import defaultdict
from math import atan2

import bpy
from mathutils import Quaternion, Vector

# A quarter turn about x.
UPRIGHT = Quaternion((0.5**0.5, 0.5**0.5, 0.0, 0.0))

glb, table, fps = sys.argv[1], sys.argv[2], float(sys.argv[3])
bpy.ops.wm.read_factory_settings(use_empty=True)
scene = bpy.context.scene
scene.render.fps, scene.render.fps_base = round(fps), round(fps) / fps
bpy.ops.import_scene.gltf(filepath=glb)

keys = defaultdict(list)
with open(table) as rows:
    for row in csv.DictReader(line for line in rows if not line.startswith("#")):
        name = row["body"] + (" acted" if row["motion"] == "acted" else "")
        place = Vector([float(row[c]) for c in ("x_m", "y_m", "z_m")])
        turn = Quaternion([float(row[c]) for c in ("qw", "qx", "qy", "qz")])
        keys[name].append((float(row["t_s"]), place, turn))
# The file begins at a frame: zero, or the last one before the first key.
first_s = min(t for of in keys.values() for t, _, _ in of)
before_s = -min(0.0, (first_s * fps) // 1) / fps

seen = 0
farthest_m = widest_rad = 0.0
for name, of in keys.items():
    thing = bpy.data.objects[name]
    for t, place, turn in of:
        frame = (t + before_s) * fps
        whole = int(frame // 1)
        scene.frame_set(whole, subframe=min(frame - whole, 0.999999))
        # Blender makes every node z-up, which turns an object's own axes, and its mesh with them, about x.
        at = thing.matrix_world
        farthest_m = max(farthest_m, (at.translation - place).length)
        apart = (at.to_quaternion() @ UPRIGHT).rotation_difference(turn)
        # By its vector: near no turn a scalar of single precision tells nothing below 5e-4.
        widest_rad = max(widest_rad, 2 * atan2(Vector(apart[1:]).length, abs(apart.w)))
        seen += 1
print(f"Blender {bpy.app.version_string}: {len(keys)} objects, {seen} poses, at most {farthest_m:.1e} m and {widest_rad:.1e} rad off")
# A frame and a time of single precision: 1e-4 of a frame at 10 m/s and 60 rad/s.
if seen == 0 or farthest_m > 5e-5 or widest_rad > 5e-3:
    sys.exit("poses differ")
