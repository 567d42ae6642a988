# SPDX-License-Identifier: GPL-3.0-or-later
"""The scenes of the film strips end as they are to."""

import math
import sys
from pathlib import Path

import bpy
import numpy as np
import pytest
import stage
from mathutils import Vector

sys.path.insert(0, str(Path(__file__).parents[1]))
import demos  # noqa: E402


def made(name, parts):
    (thing,) = demos.SCENES[name]()
    assert bpy.ops.motion_sketch.make_physical() == {"FINISHED"}
    return thing, parts.account.kept(bpy.context.scene)


def test_the_die_shows_six(parts):
    thing, said = made("die", parts)
    frames, _ = stage.keys(thing)
    assert (stage.world(thing, frames[-1]).to_quaternion() @ Vector((0, 0, 1))).z > math.cos(math.radians(10)), said
    assert said["verdict"] == "physical"


def test_the_pencil_stands_in_the_mug(parts):
    thing, said = made("pencil", parts)
    end = next(of["frame"] for of in thing.animation_data.action["motion_sketch_events"] if of["kind"] == "end")
    at = stage.world(thing, end)
    assert (at.translation - Vector((-0.005, 0.001, 0.1005))).length < 1e-5, said
    frames, rows = stage.keys(thing)
    tip = stage.world(thing, frames[-1]) @ Vector((0, 0, -0.095))
    assert np.hypot(tip.x, tip.y) < 0.041 and tip.z < 0.02, "it is in the mug when all has come to rest"
    assert said["verdict"] == "physical"


def test_the_hat_sits_on_the_box(parts):
    thing, said = made("hat", parts)
    frames, rows = stage.keys(thing)
    at = stage.world(thing, frames[-1])
    assert at.translation.z == pytest.approx(0.19, abs=0.012), said
    assert (at.to_quaternion() @ Vector((0, 0, 1))).z > math.cos(math.radians(8))
    assert said["verdict"] == "physical"
