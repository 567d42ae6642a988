# SPDX-License-Identifier: GPL-3.0-or-later
"""What was made survives undo, redo, saving, loading, renaming and copies."""

import bpy
import numpy as np
import pytest
import stage


def window():
    return bpy.context.temp_override(window=bpy.context.window_manager.windows[0])


def make(thing):
    stage.select(thing)
    with window():
        assert bpy.ops.motion_sketch.make_physical("EXEC_DEFAULT", True) == {"FINISHED"}


def test_undo_and_redo():
    thing, *_ = stage.tossed_ball(strays=0.01)
    with window():
        bpy.ops.ed.undo_push(message="acted")
    before = stage.snapshot()
    make(thing)
    after, rows = stage.snapshot(), stage.keys(thing)[1]
    assert after != before
    with window():
        assert bpy.ops.ed.undo() == {"FINISHED"}
    # Undo replaces objects: the reference from before is dead.
    thing = bpy.data.objects["Ball"]
    assert stage.snapshot() == before and thing.motion_sketch.ghost is None and thing.motion_sketch.made is None
    with window():
        assert bpy.ops.ed.redo() == {"FINISHED"}
    thing = bpy.data.objects["Ball"]
    assert stage.snapshot() == after and np.array_equal(stage.keys(thing)[1], rows)
    make(thing)
    assert np.array_equal(stage.keys(thing)[1], rows)


def test_every_operator_is_undone():
    thing, *_ = stage.tossed_ball(strays=0.01)
    make(thing)
    for operator, how in (
        (bpy.ops.motion_sketch.add_goal, {"goal": "REGION"}),
        (bpy.ops.motion_sketch.propose, {}),
        (bpy.ops.motion_sketch.restore, {}),
    ):
        stage.select(bpy.data.objects["Ball"])
        with window():
            bpy.ops.ed.undo_push(message="before")
        before = stage.snapshot()
        with window():
            assert operator("EXEC_DEFAULT", True, **how) == {"FINISHED"}, operator
            bpy.ops.ed.undo()
        assert stage.snapshot() == before, operator


def test_saved_and_loaded(tmp_path, parts):
    thing, *_ = stage.tossed_ball(strays=0.01)
    make(thing)
    rows, said = stage.keys(thing)[1], parts.account.kept(bpy.context.scene)
    path = str(tmp_path / "made.blend")
    bpy.ops.wm.save_as_mainfile(filepath=path)
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    bpy.ops.wm.open_mainfile(filepath=path)
    thing = bpy.data.objects["Ball"]
    assert np.array_equal(stage.keys(thing)[1], rows) and parts.account.kept(bpy.context.scene) == said
    assert thing.motion_sketch.ghost.name == "Ball acted" and thing.motion_sketch.acted.name == "BallAction"
    make(thing)
    assert np.array_equal(stage.keys(thing)[1], rows)


def test_renamed():
    thing, *_ = stage.tossed_ball(strays=0.01)
    make(thing)
    rows = stage.keys(thing)[1]
    thing.name, thing.motion_sketch.ghost.name, thing.motion_sketch.acted.name = "Kugel äöü/1.5 \"x\"", "Geist", "Alt"
    bpy.data.objects["Table"].name = "Tisch"
    make(thing)
    assert np.array_equal(stage.keys(thing)[1], rows)


def test_a_copy_is_made_by_itself():
    thing, *_ = stage.tossed_ball(strays=0.01)
    make(thing)
    rows = stage.keys(thing)[1]
    action = thing.motion_sketch.acted
    with window():
        stage.select(thing)
        bpy.ops.object.duplicate()
    copy = bpy.context.view_layer.objects.active
    assert copy is not None and copy != thing
    # A copy has its own action with these keys: they are what was acted, until another is assigned.
    copy.animation_data.action = action
    copy.motion_sketch.made = copy.motion_sketch.ghost = copy.motion_sketch.acted = None
    make(copy)
    assert np.allclose(stage.keys(copy)[1], rows, atol=1e-6)
    assert np.array_equal(stage.keys(thing)[1], rows), "the other one is as it was"


def test_a_failure_in_between_changes_nothing(parts, monkeypatch):
    thing, *_ = stage.tossed_ball(strays=0.01)
    stage.select(thing)
    before = stage.snapshot()

    def fails(*_):
        raise parts.refusal.Refused("Ball", "fails")

    monkeypatch.setattr(parts.motion, "keys_of", fails)
    with pytest.raises(RuntimeError, match="Ball: fails"):
        bpy.ops.motion_sketch.make_physical()
    assert stage.snapshot() == before
