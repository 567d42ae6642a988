# SPDX-License-Identifier: GPL-3.0-or-later
"""Goals that are objects hold in the baked action."""

import math

import bpy
import numpy as np
import pytest
import stage
from mathutils import Euler, Vector


def tossed_box(fps=30, last=14):
    """A box in flight, as it was acted, without a bounce."""
    scene = bpy.context.scene
    scene.render.fps = fps
    thing = stage.rigid(stage.box("Box", 0.1, 0.2, 0.3))
    t = np.linspace(0, last / fps, 40)
    places = np.column_stack([1.0 * t, 0.2 * t, 1 + 2 * t - stage.G * t**2 / 2]) + stage.wander(t, 0.01, 3)
    turns = [Euler((0.3, 4.0 * s, 0.2 * s)).to_quaternion() for s in t]
    stage.record(thing, 1 + t * fps, places, turns)
    stage.select(thing)
    return thing, 1.0 + last


def goal(kind, thing, event="end"):
    stage.select(thing)
    bpy.ops.motion_sketch.add_goal(goal=kind, event=event)
    return bpy.data.objects[f"{thing.name} {kind.lower()}"]


def make(thing):
    stage.select(thing)
    assert bpy.ops.motion_sketch.make_physical() == {"FINISHED"}


def test_a_pose_at_the_end():
    thing, last = tossed_box()
    of = goal("POSE", thing)
    of.location, of.rotation_euler = (0.5, 0.15, 0.9), (0.3, 1.7, 0.2)
    make(thing)
    at = stage.world(thing, last)
    assert (at.translation - Vector((0.5, 0.15, 0.9))).length < 1e-5
    assert at.to_quaternion().rotation_difference(Euler((0.3, 1.7, 0.2)).to_quaternion()).angle % (2 * math.pi) < 1e-3


def test_a_place_within_millimetres_through_a_point():
    thing, last = tossed_box()
    stage.marker("through", 8)
    of = goal("POSE", thing, "through")
    of.location = (0.25, 0.1, 1.3)
    of.motion_sketch.is_turn, of.motion_sketch.within_mm = False, 5
    make(thing)
    frame = next(each["frame"] for each in thing.animation_data.action["motion_sketch_events"] if each["kind"] == "waypoint")
    assert (stage.world(thing, frame).translation - Vector((0.25, 0.1, 1.3))).length < 5.1e-3


@pytest.mark.parametrize("turn", [0.0, 0.6])
def test_a_region(turn):
    thing, last = tossed_box()
    of = goal("REGION", thing)
    of.location, of.rotation_euler, of.scale = (0.6, 0.0, 0.95), (0, 0, turn), (1, 1, 1)
    of.empty_display_size = 0.02
    make(thing)
    bpy.context.view_layer.update()
    inside = of.matrix_world.inverted() @ stage.world(thing, last).translation
    assert max(map(abs, inside)) < 0.02 + 1e-5


def test_a_direction():
    thing, last = tossed_box()
    of = goal("DIRECTION", thing)
    of.rotation_euler = (0, math.pi / 2, 0)
    of.motion_sketch.axis, of.motion_sketch.within_deg = "+z", 2
    make(thing)
    axis = stage.world(thing, last).to_quaternion() @ Vector((0, 0, 1))
    assert math.degrees(axis.angle(Vector((1, 0, 0)))) < 2.01


def test_a_wish_is_weighed():
    thing, last = tossed_box()
    of = goal("POSE", thing)
    of.location, of.motion_sketch.is_turn = (0.6, 0.1, 0.95), False
    of.motion_sketch.wish_mm = 20
    make(thing)
    away = (stage.world(thing, last).translation - of.location).length
    of.motion_sketch.goal = "NONE"
    make(thing)
    without = (stage.world(thing, last).translation - of.location).length
    assert 1e-4 < away < without - 1e-3


def test_several_faces_may_be_up():
    thing, *_ = thrown_die()
    of = goal("FACES", thing)
    of.motion_sketch.faces = "+x, -x, +y, -y, +z, -z"
    make(thing)
    frames, _ = stage.keys(thing)
    turn = stage.world(thing, frames[-1]).to_quaternion()
    up = max((turn @ Vector(axis)).z for axis in ((1, 0, 0), (-1, 0, 0), (0, 1, 0), (0, -1, 0), (0, 0, 1), (0, 0, -1)))
    assert up > math.cos(math.radians(10))


@pytest.mark.parametrize("face", ["+z", "-x", "+y"])
def test_a_die_shows_the_face_that_is_asked(face):
    thing, *_ = thrown_die()
    of = goal("FACES", thing)
    of.motion_sketch.faces, of.motion_sketch.free_labels = face, True
    make(thing)
    frames, _ = stage.keys(thing)
    axis = Vector([(1 if face[0] == "+" else -1) * (of == face[1]) for of in "xyz"])
    assert (stage.world(thing, frames[-1]).to_quaternion() @ axis).z > math.cos(math.radians(10))


def thrown_die(fps=60, size=0.016):
    """A die on its way to the table; what comes after is simulated."""
    scene = bpy.context.scene
    scene.render.fps = fps
    thing = stage.rigid(stage.box("Die", size, size, size), mass=0.005, restitution=0.5, friction=0.3)
    stage.passive(stage.plane(size=4), friction=0.6)
    t = np.linspace(0, 0.2, 25)
    places = np.column_stack([0.9 * t, 0.1 * t, 0.25 + 0.1 * t - stage.G * t**2 / 2])
    turns = [Euler((0.4 + 9 * s, 0.2 + 14 * s, 5 * s)).to_quaternion() for s in t]
    stage.record(thing, 1 + t * fps, places, turns)
    stage.select(thing)
    return thing, 1 + 0.2 * fps


def test_two_bodies_that_meet():
    scene = bpy.context.scene
    scene.render.fps = 60
    one = stage.rigid(stage.ball("One", 0.05), shape="SPHERE", mass=0.1, restitution=0.8, friction=0.0)
    two = stage.rigid(stage.ball("Two", 0.05), shape="SPHERE", mass=0.1, restitution=0.8, friction=0.0)
    t = np.linspace(0, 0.4, 49)
    # They meet head on after 0.2 s and part with 0.8 × 0.8 of their speeds.
    hit, speed = 0.2, 1.0
    gap = speed * hit + 0.05
    for thing, side in ((one, -1), (two, 1)):
        x = side * np.where(t < hit, gap - speed * t, 0.05 + 0.64 * speed * (t - hit))
        z = 1 + 1 * t - stage.G * t**2 / 2
        stage.record(thing, 1 + t * 60, np.column_stack([x, 0 * t, z]), [(1, 0, 0, 0)] * len(t))
    stage.marker("bounce: One, Two", 13)
    stage.select(one, two)
    assert bpy.ops.motion_sketch.make_physical() == {"FINISHED"}
    frame = next(of["frame"] for of in one.animation_data.action["motion_sketch_events"] if of["kind"] == "collision")
    apart = (stage.world(one, frame).translation - stage.world(two, frame).translation).length
    assert apart == pytest.approx(0.1, abs=2e-5)
    assert frame == pytest.approx(13, abs=0.3)
