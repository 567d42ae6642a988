# SPDX-License-Identifier: GPL-3.0-or-later
"""Renders ten frames of each demo side by side, with what was acted seen through: the pictures of docs/blender.md.

    MOTION_SKETCH_ZIP=... python tools/blender/film_strip.py OUT [NAME...]

Cycles on the processor; a minute or so for each.
"""

import math
import sys
from pathlib import Path

sys.path[:0] = [str(Path(__file__).parent), str(Path(__file__).parent / "tests")]

import conftest  # installs the extension, before anything else has bpy

# isort: split
import bpy
import numpy as np
from mathutils import Vector

import demos

FRAMES, COLUMNS, WIDTH, HEIGHT, SAMPLES = 10, 5, 300, 225, 32
#: Where the camera is and what it looks at, and how wide it sees, degrees.
VIEWS = {
    "die": ((-0.06, -0.8, 0.46), (-0.07, 0.0, 0.16), 42),
    "pencil": ((0.42, -0.8, 0.45), (-0.1, 0.05, 0.26), 46),
    "hat": ((0.7, -1.3, 0.85), (-0.06, 0.0, 0.42), 48),
}


def lit(name):
    """Light, camera and the way it is rendered."""
    scene = bpy.context.scene
    at, to, wide = VIEWS[name]
    camera = bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera"))
    camera.data.angle, camera.data.clip_start = math.radians(wide), 0.01
    camera.location = at
    camera.rotation_euler = (Vector(to) - Vector(at)).to_track_quat("-Z", "Y").to_euler()
    sun = bpy.data.objects.new("Sun", bpy.data.lights.new("Sun", "SUN"))
    sun.data.energy, sun.data.angle = 3.5, 0.15
    sun.rotation_euler = (0.6, 0.25, 0.5)
    for of in (camera, sun):
        scene.collection.objects.link(of)
    scene.camera = camera
    world = bpy.data.worlds.new("World")
    world.color = (0.8, 0.86, 0.95)
    if world.node_tree is None:
        world.use_nodes = True
    world.node_tree.nodes["Background"].inputs[0].default_value = (0.75, 0.82, 0.95, 1)
    world.node_tree.nodes["Background"].inputs[1].default_value = 0.7
    scene.world = world
    render = scene.render
    render.engine = "CYCLES"
    scene.cycles.samples, scene.cycles.use_denoising, scene.cycles.device = SAMPLES, False, "CPU"
    render.resolution_x, render.resolution_y, render.resolution_percentage = WIDTH, HEIGHT, 100
    render.image_settings.file_format = "PNG"
    scene.view_settings.view_transform = "Standard"


def seen_through(ghost):
    """The ghost is rendered, pale."""
    pale = bpy.data.materials.new("Ghost")
    if pale.node_tree is None:
        pale.use_nodes = True
    shader = pale.node_tree.nodes["Principled BSDF"]
    shader.inputs["Base Color"].default_value = (0.2, 0.45, 0.9, 1)
    shader.inputs["Alpha"].default_value = 0.18
    ghost.hide_render = False
    for slot in ghost.material_slots:
        slot.link = "OBJECT"
        slot.material = pale


def pixels(path):
    """Rows from the top, (height, width, 4)."""
    image = bpy.data.images.load(path)
    flat = np.empty(4 * image.size[0] * image.size[1], dtype=np.float32)
    image.pixels.foreach_get(flat)
    shaped = flat.reshape(image.size[1], image.size[0], 4)
    bpy.data.images.remove(image)
    return shaped


def strip(name, out):
    """The film strip of a demo, a JPEG file."""
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    (thing,) = demos.SCENES[name]()
    bpy.ops.motion_sketch.make_physical()
    scene = bpy.context.scene
    lit(name)
    seen_through(thing.motion_sketch.ghost)
    data = thing.animation_data
    curve = next(of for of in curves(data) if of.data_path == "location")
    keys = [point.co[0] for point in curve.keyframe_points]
    until = at_rest(data, keys)
    tiles = []
    for frame in np.linspace(keys[0], until, FRAMES):
        scene.frame_set(int(frame // 1), subframe=float(frame % 1))
        scene.render.filepath = str(out / f"tile_{len(tiles)}.png")
        bpy.ops.render.render(write_still=True)
        tiles.append(pixels(scene.render.filepath))
        Path(scene.render.filepath).unlink()
    rows = [np.hstack(tiles[of : of + COLUMNS]) for of in range(0, FRAMES, COLUMNS)]
    # Images have their lowest row first.
    whole = np.vstack(rows[::-1])
    image = bpy.data.images.new(name, whole.shape[1], whole.shape[0])
    image.pixels.foreach_set(whole.astype(np.float32).ravel())
    image.file_format, image.filepath_raw = "JPEG", str(out / f"blender_{name}.jpg")
    image.save(quality=82)
    print(image.filepath_raw)


def at_rest(data, keys):
    """The frame from which on nothing is seen to move any more."""
    values = np.array([[of.evaluate(key) for of in curves(data)] for key in keys])
    moving = np.flatnonzero(np.abs(values - values[-1]).max(axis=1) > 3e-2)
    return keys[min(moving[-1] + 2, len(keys) - 1)] if len(moving) else keys[-1]


def curves(data):
    from importlib import import_module

    return import_module(f"{conftest.MODULE}.channels").curves_of(data)


if __name__ == "__main__":
    folder = Path(sys.argv[1])
    folder.mkdir(parents=True, exist_ok=True)
    for each in sys.argv[2:] or demos.SCENES:
        strip(each, folder)
    conftest.leave(0)
