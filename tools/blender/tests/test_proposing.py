# SPDX-License-Identifier: GPL-3.0-or-later
"""Markers are proposed at kinks and at the end, and nowhere else."""

import bpy
import numpy as np
import pytest
import stage


def bouncing(count, fps, strays, seed, restitution=0.7):
    """A ball that bounces so often, as acted; the frames of its bounces."""
    scene = bpy.context.scene
    scene.render.fps = fps
    thing = stage.rigid(stage.ball("Ball", 0.1), shape="SPHERE", mass=0.2, restitution=restitution, friction=0.0)
    stage.passive(stage.plane(size=20), friction=0.0)
    fall = np.sqrt(2 * 0.9 / stage.G)
    hits, up = [fall], restitution * stage.G * fall
    for _ in range(count - 1):
        hits.append(hits[-1] + 2 * up / stage.G)
        up *= restitution
    last = hits[-1] + 1.2 * up / stage.G if count else fall * 0.9
    t = np.linspace(0, last, int(last * 120))
    done = np.searchsorted(hits[:count], t, side="right")
    z = [1 - stage.G * s**2 / 2 if k == 0 else
         0.1 + restitution**k * stage.G * fall * (s - hits[k - 1]) - stage.G * (s - hits[k - 1]) ** 2 / 2 for s, k in zip(t, done)]
    places = np.column_stack([0.8 * t, 0 * t, z]) + stage.wander(t, strays, seed)
    stage.record(thing, 1 + t * fps, places, [(1, 0, 0, 0)] * len(t))
    stage.select(thing)
    return thing, [1 + of * fps for of in hits[:count]], 1 + last * fps


@pytest.mark.parametrize("fps", [24, 60])
@pytest.mark.parametrize("strays", [0.0, 0.02])
@pytest.mark.parametrize("count", [0, 1, 2, 3, 4])
def test_as_many_as_there_are(count, strays, fps):
    thing, hits, last = bouncing(count, fps, strays, count)
    assert bpy.ops.motion_sketch.propose() == {"FINISHED"}
    found = sorted((of.frame, of.name) for of in bpy.context.scene.timeline_markers)
    bounces = [frame for frame, name in found if name == "bounce"]
    assert len(bounces) == count, (found, hits)
    assert all(abs(a - b) <= 0.5 + fps * 0.02 for a, b in zip(bounces, hits)), (bounces, hits)
    assert [name for _, name in found][-1] == "end" and found[-1][0] == int(last + 1e-6)


def test_again_adds_nothing_and_leads_to_a_motion():
    thing, hits, last = bouncing(3, 24, 0.01, 3)
    bpy.ops.motion_sketch.propose()
    markers = [(of.name, of.frame) for of in bpy.context.scene.timeline_markers]
    bpy.ops.motion_sketch.propose()
    assert [(of.name, of.frame) for of in bpy.context.scene.timeline_markers] == markers
    assert bpy.ops.motion_sketch.make_physical() == {"FINISHED"}
    happens = thing.animation_data.action["motion_sketch_events"]
    assert [of["frame"] for of in happens if of["kind"] == "collision"] == pytest.approx(hits, abs=0.4)


def test_several_bodies_each_have_theirs():
    first, hits, _ = bouncing(2, 24, 0.01, 1)
    second = stage.rigid(stage.ball("Other", 0.1), shape="SPHERE", restitution=0.7, friction=0.0)
    frames, rows = stage.keys(first) if ("rotation_quaternion", 0) in stage.curves(first) else (None, None)
    stage.record(second, frames + 3, rows[:, :3] + [0, 2, 0], rows[:, 3:])
    stage.select(first, second)
    bpy.ops.motion_sketch.propose()
    found = [(of.name, of.frame) for of in bpy.context.scene.timeline_markers]
    own = [frame for name, frame in found if name == "bounce: Ball"]
    others = [frame for name, frame in found if name == "bounce: Other"]
    assert own == pytest.approx(hits, abs=1) and others == pytest.approx([of + 3 for of in hits], abs=1)


def test_markers_of_an_action_count_as_those_of_the_timeline():
    thing, hits, last = bouncing(1, 24, 0.01, 1)
    thing.animation_data.action.pose_markers.new("bounce").frame = round(hits[0])
    assert bpy.ops.motion_sketch.make_physical() == {"FINISHED"}
    happens = thing.animation_data.action["motion_sketch_events"]
    assert [of["frame"] for of in happens if of["kind"] == "collision"] == pytest.approx(hits, abs=0.4)
