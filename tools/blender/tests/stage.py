# SPDX-License-Identifier: GPL-3.0-or-later
"""Scenes for the tests: meshes, rigid bodies, keys and markers made by script."""

import math

import bmesh
import bpy
import numpy as np
from mathutils import Quaternion, Vector

G = 9.81


def link(name, work):
    mesh = bpy.data.meshes.new(name)
    work.to_mesh(mesh)
    work.free()
    thing = bpy.data.objects.new(name, mesh)
    bpy.context.scene.collection.objects.link(thing)
    return thing


def box(name, x, y, z):
    work = bmesh.new()
    bmesh.ops.create_cube(work, size=1)
    bmesh.ops.scale(work, vec=(x, y, z), verts=work.verts)
    return link(name, work)


def ball(name, radius):
    work = bmesh.new()
    bmesh.ops.create_icosphere(work, subdivisions=3, radius=radius)
    return link(name, work)


def cylinder(name, radius, length):
    work = bmesh.new()
    bmesh.ops.create_cone(work, cap_ends=True, segments=32, radius1=radius, radius2=radius, depth=length)
    return link(name, work)


def plane(name="Table", size=4.0, at=(0, 0, 0)):
    work = bmesh.new()
    bmesh.ops.create_grid(work, x_segments=1, y_segments=1, size=size / 2)
    thing = link(name, work)
    thing.location = at
    return thing


def rigid(thing, kind="ACTIVE", shape="BOX", mass=1.0, restitution=0.5, friction=0.5):
    """Rigid Body settings; what is active goes by its action."""
    bpy.context.view_layer.objects.active = thing
    with bpy.context.temp_override(object=thing, active_object=thing, selected_objects=[thing]):
        bpy.ops.rigidbody.object_add(type=kind)
    body = thing.rigid_body
    body.collision_shape, body.mass, body.restitution, body.friction = shape, mass, restitution, friction
    body.kinematic = kind == "ACTIVE"
    return thing


def passive(thing, shape="BOX", restitution=0.0, friction=0.5):
    return rigid(thing, "PASSIVE", shape, 1.0, restitution, friction)


def key(thing, frame, place, turn=None):
    """A key of place and rotation, linear."""
    thing.location = place
    thing.keyframe_insert("location", frame=frame)
    if turn is not None:
        thing.rotation_mode = "QUATERNION"
        thing.rotation_quaternion = turn
        thing.keyframe_insert("rotation_quaternion", frame=frame)


def record(thing, frames, places, turns):
    """Keys at frames, with parts of them, as a recorder leaves them."""
    turns = [Quaternion(of) for of in turns]
    for before, of in zip(turns, turns[1:]):
        if before.dot(of) < 0:
            of.negate()
    for frame, place, turn in zip(frames, places, turns):
        key(thing, frame, place, turn)


def marker(name, frame):
    return bpy.context.scene.timeline_markers.new(name, frame=frame)


def select(*things):
    for of in bpy.context.scene.objects:
        of.select_set(of in things)
    bpy.context.view_layer.objects.active = things[0]
    bpy.context.view_layer.update()


def wander(t, size, seed=0):
    """A hand that strays slowly, three metres for each time."""
    draw = np.random.default_rng(seed)
    waves = draw.uniform(0.3, 1.2, (3, 3)), draw.uniform(0, 2 * np.pi, (3, 3)), draw.normal(0, size / 2, (3, 3))
    rate, phase, tall = waves
    return np.array([[sum(tall[a] * np.sin(2 * np.pi * rate[a] * s + phase[a])) for a in range(3)] for s in t])


def tossed_ball(fps=24, first=1, strays=0.0, seed=0, radius=0.1, restitution=0.6, unit=1.0):
    """A ball that falls, bounces once off a table and flies on, as it was acted; the frames of the bounce and the end.

    `unit`: metres of a unit."""
    scene = bpy.context.scene
    scene.render.fps, scene.render.fps_base = fps, 1.0
    thing = rigid(ball("Ball", radius / unit), shape="SPHERE", mass=0.2, restitution=restitution, friction=0.0)
    table = passive(plane(size=6 / unit), friction=0.0)
    start, speed = 1.0, np.array([0.8, 0.3, 0.0])
    hit = math.sqrt(2 * (start - radius) / G)
    up = restitution * G * hit
    last = hit + 1.3 * up / G
    t = np.linspace(0, last, 60)
    z = np.where(t < hit, start - G * t**2 / 2, radius + up * (t - hit) - G * (t - hit) ** 2 / 2)
    places = np.column_stack([speed[0] * t, speed[1] * t, z]) + (wander(t, strays, seed) if strays else 0)
    turns = [Quaternion((0, 1, 0), 2.0 * s) for s in t]
    record(thing, first + t * fps, [Vector(of) / unit for of in places], turns)
    marker("bounce", round(first + hit * fps))
    return thing, table, first + hit * fps, first + last * fps


def world(thing, frame):
    """Where an object is at a frame, by the scene itself."""
    scene = bpy.context.scene
    whole = math.floor(frame)
    scene.frame_set(whole, subframe=frame - whole)
    return thing.matrix_world.copy()


def curves(thing):
    """An object's curves, by path and index."""
    data = thing.animation_data
    if hasattr(data, "action_slot"):
        from bpy_extras.anim_utils import action_get_channelbag_for_slot

        found = action_get_channelbag_for_slot(data.action, data.action_slot).fcurves
    else:
        found = data.action.fcurves
    return {(of.data_path, of.array_index): of for of in found}


def keys(thing):
    """Frames of the keys, and values of all seven curves at them."""
    found = curves(thing)
    frames = np.array([point.co[0] for point in found["location", 0].keyframe_points])
    paths = [("location", of) for of in range(3)] + [("rotation_quaternion", of) for of in range(4)]
    return frames, np.array([[point.co[1] for point in found[path].keyframe_points] for path in paths]).T


def snapshot():
    """All that a refusal must not change."""
    scene = bpy.context.scene
    scene.frame_set(scene.frame_current)
    return (
        sorted((of.name, tuple(tuple(row) for row in of.matrix_basis), of.rotation_mode,
                of.animation_data.action.name if of.animation_data and of.animation_data.action else None)
               for of in bpy.data.objects),
        sorted(of.name for of in bpy.data.actions),
        sorted(of.name for of in bpy.data.collections),
        sorted((of.name, of.frame) for of in scene.timeline_markers),
        (scene.frame_start, scene.frame_end, scene.frame_current, scene.motion_sketch.said, scene.motion_sketch.free),
    )


