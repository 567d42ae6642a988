# SPDX-License-Identifier: GPL-3.0-or-later
"""While something is dragged. Timers do not fire without a window: what they call is called here."""

import time
import tracemalloc

import bpy
import numpy as np
import pytest
import stage


@pytest.fixture
def dragged(parts):
    """A ball with a goal at its end, made and followed; the goal, and the ball."""
    thing, table, hit, last = stage.tossed_ball(strays=0.01)
    stage.select(thing)
    bpy.ops.motion_sketch.add_goal(goal="POSE")
    goal = bpy.data.objects["Ball pose"]
    goal.motion_sketch.is_turn = False
    goal.location = (0.75, 0.3, 0.35)
    stage.select(thing)
    assert bpy.ops.motion_sketch.make_physical() == {"FINISHED"}
    assert bpy.ops.motion_sketch.live() == {"FINISHED"}
    pump(parts)
    yield goal, thing, last
    parts.live.end()


def pump(parts, now=None):
    """What a timer does until all that was asked is shown."""
    scene = bpy.context.scene
    bpy.context.view_layer.update()
    said = [parts.live.tick(scene, now)]
    assert parts.live.state.worker.wait(10)
    said.append(parts.live.tick(scene, now))
    return said


def end_of(parts):
    return parts.live.state.paths["Ball"][-1]


def test_a_dragged_goal_moves_the_path(parts, dragged):
    goal, thing, last = dragged
    for x in (0.76, 0.78, 0.8):
        goal.location.x = x
        assert "shown" in pump(parts)
        assert end_of(parts) == pytest.approx((x, 0.3, 0.35), abs=1e-5)
        assert parts.live.state.worker.solved.estimate.is_warm


def test_the_action_is_made_once_all_rests(parts, dragged):
    goal, thing, last = dragged
    rows = stage.keys(thing)[1]
    goal.location.x = 0.8
    now = time.monotonic()
    pump(parts, now)
    assert np.array_equal(stage.keys(thing)[1], rows), "nothing is written while it is dragged"
    assert parts.live.tick(bpy.context.scene, now + 0.1) is None
    assert parts.live.tick(bpy.context.scene, now + 0.3) == "final"
    parts.handlers.make_final(bpy.context.scene)
    assert stage.world(thing, last).translation.x == pytest.approx(0.8, abs=1e-5)
    count = parts.live.state.worker.count
    assert parts.live.tick(bpy.context.scene, now + 1) is None and parts.live.tick(bpy.context.scene, now + 9) is None
    assert parts.live.state.worker.count == count, "its own keys are no change"


def test_one_solve_in_33_ms_and_the_last_one_wins(parts, dragged):
    goal, thing, last = dragged
    worker = parts.live.state.worker
    begun, count = time.monotonic(), worker.count
    for x in np.linspace(0.7, 0.82, 120):
        goal.location.x = x
        bpy.context.view_layer.update()
        parts.live.tick(bpy.context.scene)
        time.sleep(0.002)
    assert worker.wait(10)
    spent = time.monotonic() - begun
    parts.live.tick(bpy.context.scene)
    assert 1 <= worker.count - count <= spent / parts.worker.BETWEEN_S + 1.5
    assert end_of(parts)[0] == pytest.approx(0.82, abs=1e-5)


@pytest.mark.parametrize("what", ["key", "marker", "surface", "event", "rename"])
def test_whatever_is_changed_is_followed(parts, dragged, what):
    goal, thing, last = dragged
    before = parts.live.state.paths["Ball"].copy()
    read = parts.live.state.read
    if what == "key":
        ghost = thing.motion_sketch.ghost
        curve = stage.curves(ghost)["location", 1]
        for point in curve.keyframe_points:
            point.co[1] += 0.05 * (point.co[0] - 1) / 10
        curve.update()
        ghost.animation_data.action.update_tag()
    elif what == "marker":
        bpy.context.scene.timeline_markers[0].frame += 1
    elif what == "surface":
        bpy.data.objects["Table"].location.z = -0.05
    elif what == "event":
        goal.motion_sketch.within_mm = 30
    else:
        thing.name = "Kugel"
        thing.update_tag()
    pump(parts)
    assert parts.live.state.read is not read, "it is read again"
    if what in ("key", "surface", "event"):
        after = parts.live.state.paths["Ball"]
        assert np.abs(before - after[: len(before)]).max() > 1e-4 if len(before) == len(after) else True
    if what == "rename":
        assert "Kugel" in parts.live.state.paths


def test_what_is_refused_is_said_and_the_path_stays(parts, dragged):
    goal, thing, last = dragged
    before = parts.live.state.paths["Ball"].copy()
    thing.scale = (2, 2, 2)
    pump(parts)
    assert "its scale is 2, 2, 2" in parts.live.state.words
    assert np.array_equal(parts.live.state.paths["Ball"], before)
    thing.scale = (1, 1, 1)
    pump(parts)
    goal.location.x = 0.8
    pump(parts)
    assert end_of(parts)[0] == pytest.approx(0.8, abs=1e-5)


def test_undo_in_the_middle_of_it(parts, dragged):
    goal, thing, last = dragged
    with bpy.context.temp_override(window=bpy.context.window_manager.windows[0]):
        bpy.ops.ed.undo_push(message="before")
        goal.location.x = 0.8
        pump(parts)
        bpy.ops.ed.undo_push(message="dragged")
        bpy.ops.ed.undo()
    pump(parts)
    goal = bpy.data.objects["Ball pose"]
    assert goal.location.x == pytest.approx(0.75)
    parts.live.touched()
    pump(parts)
    goal.location.x = 0.79
    pump(parts)
    assert end_of(parts)[0] == pytest.approx(0.79, abs=1e-5)


def test_another_file_ends_it(parts, dragged):
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    assert parts.live.state is None and parts.handlers.timer() is None


def test_a_die_that_is_to_show_a_face_is_followed(parts):
    from test_goals import goal, thrown_die

    thing, *_ = thrown_die()
    goal("FACES", thing).motion_sketch.free_labels = True
    stage.select(thing)
    assert bpy.ops.motion_sketch.live() == {"FINISHED"}
    try:
        pump(parts)
        lies = parts.live.state.paths["Die"][-1][2]
        bpy.data.objects["Table"].location.z = -0.02
        pump(parts)
        assert parts.live.state.paths["Die"][-1][2] == pytest.approx(lies - 0.02, abs=2e-3), parts.live.state.words
    finally:
        parts.live.end()


def test_dragging_for_long_takes_no_more_memory(parts, dragged):
    """As many changes as ten minutes at 30 a second would make, a tenth of them by default."""
    goal, thing, last = dragged
    import os
    import resource

    changes = int(os.environ.get("MOTION_SKETCH_CHANGES", "1800"))
    worker = parts.live.state.worker
    scene = bpy.context.scene

    def drag(count):
        for of in range(count):
            goal.location.x = 0.75 + 0.05 * np.sin(of / 20)
            bpy.context.view_layer.update()
            parts.live.tick(scene)
            assert worker.wait(10)
        parts.live.tick(scene)

    parts.worker.BETWEEN_S, kept = 0.0, parts.worker.BETWEEN_S
    try:
        drag(300)
        tracemalloc.start()
        first, resident = tracemalloc.get_traced_memory()[0], resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
        drag(changes)
        grown = tracemalloc.get_traced_memory()[0] - first
        grown_resident = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - resident
    finally:
        tracemalloc.stop()
        parts.worker.BETWEEN_S = kept
    assert grown < 1_000_000, f"{grown} bytes"
    # Kilobytes: what the allocator keeps for itself, and no more.
    assert grown_resident < 30_000, f"{grown_resident} kB"
    assert len(bpy.data.objects) == 4 and len(bpy.data.actions) == 2
