# SPDX-License-Identifier: GPL-3.0-or-later
"""Three scenes made by script, for the benchmark, the tests and the film strips: a die to a six, a pencil into the mug, a hat on a box.

Each function leaves an animated object, what stands around it, markers and goals in the scene, and returns what is to be made physical.
"""

import math
from pathlib import Path

import bmesh
import bpy
import numpy as np
from mathutils import Euler, Matrix, Quaternion, Vector

ROOT = Path(__file__).parents[2]
G = 9.81


def material(name, colour, rough=0.5):
    found = bpy.data.materials.get(name)
    if found is None:
        found = bpy.data.materials.new(name)
        if found.node_tree is None:
            found.use_nodes = True
        shader = found.node_tree.nodes["Principled BSDF"]
        shader.inputs["Base Color"].default_value = (*colour, 1)
        shader.inputs["Roughness"].default_value = rough
        found.diffuse_color = (*colour, 1)
    return found


def link(name, work, colour):
    """An object of a mesh that was built."""
    bmesh.ops.recalc_face_normals(work, faces=work.faces)
    mesh = bpy.data.meshes.new(name)
    work.to_mesh(mesh)
    work.free()
    mesh.materials.append(colour)
    thing = bpy.data.objects.new(name, mesh)
    bpy.context.scene.collection.objects.link(thing)
    return thing


def turned(name, profile, colour, around=48):
    """What a closed profile of radii and heights sweeps about z."""
    work = bmesh.new()
    rings = []
    for radius, height in profile:
        if radius == 0:
            rings.append([work.verts.new((0, 0, height))])
            continue
        angles = (2 * math.pi * of / around for of in range(around))
        rings.append([work.verts.new((radius * math.cos(a), radius * math.sin(a), height)) for a in angles])
    for low, high in zip(rings, rings[1:] + rings[:1]):
        for of in range(around):
            a, b = low[of % len(low)], low[(of + 1) % len(low)]
            c, d = high[(of + 1) % len(high)], high[of % len(high)]
            corners = list(dict.fromkeys([a, b, c, d]))
            if len(corners) > 2 and not (len(low) == 1 and len(high) == 1):
                work.faces.new(corners)
    return link(name, work, colour)


def box(name, size, colour):
    work = bmesh.new()
    bmesh.ops.create_cube(work, size=1)
    bmesh.ops.scale(work, vec=size, verts=work.verts)
    return link(name, work, colour)


def table(size=3.0):
    work = bmesh.new()
    bmesh.ops.create_grid(work, x_segments=1, y_segments=1, size=size / 2)
    return rigid(link("Table", work, material("Wood", (0.45, 0.3, 0.18), 0.6)), "PASSIVE", "BOX", friction=0.6)


def rigid(thing, kind, shape, mass=1.0, restitution=0.0, friction=0.5):
    bpy.context.view_layer.objects.active = thing
    with bpy.context.temp_override(object=thing, active_object=thing, selected_objects=[thing]):
        bpy.ops.rigidbody.object_add(type=kind)
    body = thing.rigid_body
    body.collision_shape, body.mass, body.restitution, body.friction = shape, mass, restitution, friction
    body.kinematic = kind == "ACTIVE"
    return thing


def acted(thing, frames, places, turns):
    """Keys as a recorder leaves them."""
    thing.rotation_mode = "QUATERNION"
    before = Quaternion(turns[0])
    for frame, place, turn in zip(frames, places, turns):
        turn = Quaternion(turn)
        if turn.dot(before) < 0:
            turn.negate()
        thing.location, thing.rotation_quaternion, before = place, turn, turn
        thing.keyframe_insert("location", frame=frame)
        thing.keyframe_insert("rotation_quaternion", frame=frame)


def hand(t, size, seed):
    """A hand that strays slowly: (n, 3)."""
    draw = np.random.default_rng(seed)
    rate, phase, tall = draw.uniform(0.3, 1.0, (3, 2)), draw.uniform(0, 6, (3, 2)), draw.normal(0, size, (3, 2))
    return sum(tall[:, k] * np.sin(2 * np.pi * np.outer(t, rate[:, k]) + phase[:, k]) for k in range(2))


def goal(body, kind, event, **how):
    made = bpy.data.objects.new(f"{body.name} {kind.lower()}", None)
    made.empty_display_size = 0.1
    bpy.context.scene.collection.objects.link(made)
    settings = made.motion_sketch
    settings.goal, settings.body, settings.event = kind, body, event
    for name, value in how.items():
        setattr(settings, name, value)
    return made


def only(*things):
    for of in bpy.context.scene.objects:
        of.select_set(of in things)
    bpy.context.view_layer.objects.active = things[0]
    bpy.context.view_layer.update()
    return things


def die():
    """A die is thrown; the six is to be up. Six is at +z, one at -z, two and five at +x and -x, three and four at +y and -y."""
    scene = bpy.context.scene
    scene.render.fps = 60
    size = 0.05
    table()
    thing = rigid(box("Die", (size, size, size), material("Ivory", (0.9, 0.87, 0.78), 0.3)), "ACTIVE", "BOX", 0.1, 0.45, 0.4)
    bevel = thing.modifiers.new("Round", "BEVEL")
    bevel.width, bevel.segments = 0.1 * size, 3
    pips(thing, size)
    t = np.linspace(0, 0.24, 30)
    places = np.column_stack([-0.25 + 0.9 * t, 0.02 - 0.1 * t, 0.32 + 0.3 * t - G * t**2 / 2]) + hand(t, 0.002, 4)
    acted(thing, 1 + t * 60, places, [Euler((0.4 + 8 * s, 0.2 + 13 * s, 5 * s)).to_quaternion() for s in t])
    goal(thing, "FACES", "rest", faces="+z", free_labels=True)
    return only(thing)


def pips(die_object, size):
    """Dark spots on the sides, children of the die."""
    spots = {1: [(0, 0)], 2: [(-1, -1), (1, 1)], 3: [(-1, -1), (0, 0), (1, 1)], 4: [(-1, -1), (-1, 1), (1, -1), (1, 1)]}
    spots[5] = spots[4] + [(0, 0)]
    spots[6] = spots[4] + [(-1, 0), (1, 0)]
    sides = {6: (0, 0, 1), 1: (0, 0, -1), 2: (1, 0, 0), 5: (-1, 0, 0), 3: (0, 1, 0), 4: (0, -1, 0)}
    work = bmesh.new()
    for number, normal in sides.items():
        turn = Vector((0, 0, 1)).rotation_difference(Vector(normal)).to_matrix().to_4x4()
        for x, y in spots[number]:
            at = turn @ Matrix.Translation((0.26 * size * x, 0.26 * size * y, 0.501 * size))
            bmesh.ops.create_circle(work, cap_ends=True, segments=16, radius=0.09 * size, matrix=at)
    made = link("Pips", work, material("Ink", (0.02, 0.02, 0.03)))
    made.parent = die_object
    return made


def pencil():
    """A pencil is dropped on its tip, bounces, tumbles and is to stand in the mug, as the recording of that name has it."""
    import enact_motion

    scene = bpy.context.scene
    scene.render.fps = 60
    table()
    profile = [(0.044, 0), (0.044, 0.095), (0.04, 0.095), (0.04, 0.004), (0, 0.004), (0, 0)]
    mug = turned("Mug", profile, material("Glaze", (0.15, 0.35, 0.6), 0.25))
    rigid(mug, "PASSIVE", "MESH", friction=0.5)
    shaft = [(0, -0.095), (0.00375, -0.088), (0.00375, 0.095), (0, 0.095)]
    thing = rigid(turned("Pencil", shaft, material("Yellow", (0.9, 0.6, 0.05)), 12), "ACTIVE", "CONVEX_HULL", 0.006, 0.75, 0.0)
    thing.rigid_body.friction = 0.0
    known = enact_motion.read(str(ROOT / "recordings/pencil_tip.mcap")).estimate(diagnose=False)
    begin, end = known.span()
    t = np.linspace(0, end - begin, int((end - begin) * 120))
    motion = known.at(begin + t)
    acted(thing, 1 + t * 60, motion.position + hand(t, 0.004, 2), [tuple(of) for of in motion.quaternion])
    bounce = known.events[0].time - begin
    scene.timeline_markers.new("bounce", frame=round(1 + bounce * 60))
    last = goal(thing, "POSE", "end")
    last.rotation_mode = "QUATERNION"
    last.location, last.rotation_quaternion = (-0.005, 0.001, 0.1005), (0.944, 0.016, 0.032, 0.328)
    scene.motion_sketch.settle_s = 1.5
    return only(thing)


def hat():
    """A hat is thrown, turning, and is to sit on a box."""
    scene = bpy.context.scene
    scene.render.fps = 60
    table()
    stand = box("Box", (0.11, 0.11, 0.3), material("Card", (0.55, 0.42, 0.3), 0.8))
    stand.location = (0, 0, 0.15)
    rigid(stand, "PASSIVE", "BOX", friction=0.6)
    # The brim is level with the origin; the crown is 0.11 m high inside.
    profile = [(0.17, 0), (0.17, 0.004), (0.104, 0.004), (0.1, 0.114), (0, 0.114), (0, 0.11), (0.096, 0.11), (0.1, 0.0)]
    thing = rigid(turned("Hat", profile, material("Felt", (0.25, 0.05, 0.07), 0.9)), "ACTIVE", "MESH", 0.09, 0.1, 0.6)
    last = 0.55
    t = np.linspace(0, last, 66)
    speed = np.array([0.45, 0.1, 0.0])
    up = (0.19 + 0.004 - 0.75 + G * last**2 / 2) / last
    places = np.column_stack([speed[0] * (t - last), speed[1] * (t - last), 0.75 + up * t - G * t**2 / 2])
    turns = [(Quaternion((1, 0, 0), 0.5 * (1 - s / last)) @ Quaternion((0, 0, 1), 4 * s)) for s in t]
    acted(thing, 1 + t * 60, places + hand(t, 0.01, 6), turns)
    rests = goal(thing, "POSE", "end", within_deg=2)
    rests.location, rests.rotation_euler = (0.0, 0.0, 0.1935), (0, 0, 3.0)
    scene.motion_sketch.settle_s = 1.0
    return only(thing)


SCENES = {"die": die, "pencil": pencil, "hat": hat}
