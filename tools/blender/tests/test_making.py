# SPDX-License-Identifier: GPL-3.0-or-later
"""Make Physical: a new action on the frames and at impacts, what was acted on a ghost, and what it says."""

import bpy
import numpy as np
import pytest
import stage
from mathutils import Matrix

RADIUS = 0.1


def made(**how):
    thing, table, hit, last = stage.tossed_ball(**how)
    stage.select(thing)
    before = thing.animation_data.action
    assert bpy.ops.motion_sketch.make_physical() == {"FINISHED"}
    return thing, before, hit, last


def flies(frames, places, fps, gravity=stage.G):
    """Whether places on frames are a flight: second differences are those of gravity."""
    second = np.diff(places, n=2, axis=0) * fps**2
    assert np.allclose(np.diff(frames), 1, atol=1e-5)
    return np.abs(second - [0, 0, -gravity]).max()


def away(one, other):
    """The greatest difference of two matrices."""
    return max(abs(a - b) for row, beside in zip(one, other) for a, b in zip(row, beside))


@pytest.mark.parametrize("fps", [24, 30, 60])
@pytest.mark.parametrize("first", [1, 101, -20])
def test_keys_are_on_frames_and_at_the_impact(fps, first):
    thing, before, hit, last = made(fps=fps, first=first, strays=0.02)
    frames, rows = stage.keys(thing)
    whole = np.abs(frames - np.round(frames)) < 1e-4
    exact = frames[~whole]
    bounce = next(of for of in thing.animation_data.action["motion_sketch_events"] if of["kind"] == "collision")
    assert min(abs(exact - bounce["frame"])) < 1e-3, "the impact has a key of its own"
    assert abs(bounce["frame"] - hit) < 0.35
    assert set(np.arange(np.ceil(frames[0]), np.floor(frames[-1]) + 1)) <= set(np.round(frames[whole]))
    for before_hit in (True, False):
        of = whole & ((frames < bounce["frame"] - 1e-3) if before_hit else (frames > bounce["frame"] + 1e-3))
        # Keys are of single precision.
        assert flies(frames[of], rows[of, :3], fps) < 2e-6 * fps**2 + 1e-3
    at = rows[np.argmin(abs(frames - bounce["frame"])), :3]
    assert abs(at[2] - RADIUS) < 1e-5, "it touches the table there"


def test_keys_are_linear_and_quaternions_have_one_sign():
    thing, *_ = made(strays=0.02)
    assert thing.rotation_mode == "QUATERNION"
    for curve in stage.curves(thing).values():
        assert all(point.interpolation == "LINEAR" for point in curve.keyframe_points) and not len(curve.modifiers)
    _, rows = stage.keys(thing)
    turns = rows[:, 3:]
    assert np.allclose(np.linalg.norm(turns, axis=1), 1, atol=1e-6)
    assert ((turns[1:] * turns[:-1]).sum(axis=1) > 0).all()


def test_what_was_acted_stays_on_a_ghost():
    thing, before, hit, last = made(strays=0.02)
    ghost = thing.motion_sketch.ghost
    assert thing.animation_data.action != before and ghost.animation_data.action == before
    assert ghost.data == thing.data and ghost.hide_render and ghost.motion_sketch.acts == thing
    assert ghost.name not in bpy.context.scene.rigidbody_world.collection.objects
    fresh, *_ = stage.tossed_ball(strays=0.02)
    for frame in (1.0, 5.5, 12.25):
        assert away(stage.world(ghost, frame), stage.world(fresh, frame)) < 1e-6


def test_again_reads_what_was_acted_and_leaves_one_action():
    thing, before, *_ = made(strays=0.02)
    first = stage.keys(thing)[1]
    actions, things = len(bpy.data.actions), len(bpy.data.objects)
    stage.select(thing)
    for of in (thing, thing.motion_sketch.ghost):
        stage.select(of)
        assert bpy.ops.motion_sketch.make_physical() == {"FINISHED"}
        assert np.array_equal(stage.keys(thing)[1], first), "the same again, to the bit"
    assert (len(bpy.data.actions), len(bpy.data.objects)) == (actions, things)
    assert thing.animation_data.action.name == "Ball physical"


def test_it_says_what_it_is(parts):
    made(strays=0.01)
    said = parts.account.kept(bpy.context.scene)
    assert said["verdict"] == "physical" and said["fit"] == "yes", said
    bounce = said["events"][0]
    assert bounce["event"] == "bounce" and 0 < bounce["sd_frames"] < 1
    assert "Table" in bounce["contact"]
    bpy.ops.motion_sketch.jump(frame=bounce["frame"])
    scene = bpy.context.scene
    assert scene.frame_current + scene.frame_subframe == pytest.approx(bounce["frame"], abs=1e-4)
    assert any(line.startswith("next:") for line in parts.account.lines(said))


def test_contact_speeds_are_with_the_action():
    thing, *_ = made()
    action = thing.animation_data.action
    bounce = next(of for of in action["motion_sketch_events"] if of["event"] == "bounce")
    fell = np.sqrt(2 * stage.G * (1.0 - RADIUS))
    assert bounce["approach_m_s"] == pytest.approx(fell, rel=0.02) and bounce["impulse_n_s"] > 0
    assert bounce["point"][2] == pytest.approx(0, abs=1e-5)
    assert [of.name for of in action.pose_markers] == [of["event"] for of in action["motion_sketch_events"]]


def test_restitution_and_friction_multiply_as_in_the_physics(parts):
    thing, table, *_ = stage.tossed_ball()
    thing.rigid_body.restitution, table.rigid_body.restitution = 0.8, 0.5
    thing.rigid_body.friction, table.rigid_body.friction = 0.5, 0.4
    contact = parts.happening.contact(*(type("T", (), {"thing": of}) for of in (thing, table)))
    assert contact == {"restitution": 0.4, "friction": 0.2}
    table.rigid_body.restitution = 0.0
    assert parts.happening.contact(*(type("T", (), {"thing": of}) for of in (thing, table)))["restitution"] == 0.8


@pytest.mark.parametrize("metre", [1.0, 0.01])
def test_units_of_the_scene_are_heeded(metre):
    scene = bpy.context.scene
    scene.unit_settings.system, scene.unit_settings.scale_length = "METRIC", metre
    scene.gravity = (0, 0, -stage.G / metre)
    thing, *_ = made(unit=metre)
    frames, rows = stage.keys(thing)
    bounce = next(of for of in thing.animation_data.action["motion_sketch_events"] if of["kind"] == "collision")
    at = rows[np.argmin(abs(frames - bounce["frame"])), 2]
    assert at * metre == pytest.approx(RADIUS, abs=1e-5)
    assert bounce["point"][0] == pytest.approx(rows[np.argmin(abs(frames - bounce["frame"])), 0], rel=1e-3)


def test_parents_that_are_turned_scaled_and_moving_are_heeded():
    thing, table, *_ = stage.tossed_ball()
    stage.select(thing)
    bpy.ops.motion_sketch.make_physical()
    plain = [stage.world(thing, frame) for frame in range(1, 20)]
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)

    thing, table, *_ = stage.tossed_ball()
    parent = bpy.data.objects.new("Parent", None)
    bpy.context.scene.collection.objects.link(parent)
    stage.key(parent, 1, (0.3, 0.2, 0.1))
    stage.key(parent, 20, (1.3, -0.2, 0.5))
    parent.rotation_euler, parent.scale = (0.3, 0.5, 1.0), (2, 2, 2)
    bpy.context.view_layer.update()
    # The same motion in the world, in the parent's space.
    frames, rows = stage.keys(thing)
    worlds = [stage.world(thing, frame) for frame in frames]
    action = thing.animation_data.action
    thing.animation_data_clear()
    bpy.data.actions.remove(action)
    thing.parent = parent
    thing.matrix_parent_inverse = Matrix.Scale(0.5, 4) @ Matrix.Rotation(0.4, 4, "X")
    for frame, of in zip(frames, worlds):
        local = (stage.world(parent, frame) @ thing.matrix_parent_inverse).inverted() @ of
        place, turn, _ = local.decompose()
        stage.key(thing, frame, place, turn)
    thing.scale = (1, 1, 1)
    stage.select(thing)
    assert bpy.ops.motion_sketch.make_physical() == {"FINISHED"}
    for frame, of in zip(range(1, 20), plain):
        away = (stage.world(thing, frame).translation - of.translation).length
        assert away < 2e-4, (frame, away)


def test_a_parent_with_a_constraint_is_read_frame_by_frame():
    thing, table, *_ = stage.tossed_ball()
    target = bpy.data.objects.new("Target", None)
    parent = bpy.data.objects.new("Parent", None)
    for of in (target, parent):
        bpy.context.scene.collection.objects.link(of)
    parent.constraints.new("COPY_LOCATION").target = target
    target.location = (5, 0, 0)
    thing.parent = parent
    thing.matrix_parent_inverse = Matrix.Translation((-5, 0, 0))
    bpy.context.scene.frame_set(7)
    stage.select(thing)
    assert bpy.ops.motion_sketch.make_physical() == {"FINISHED"}
    assert bpy.context.scene.frame_current == 7
    bounce = next(of for of in thing.animation_data.action["motion_sketch_events"] if of["kind"] == "collision")
    assert stage.world(thing, bounce["frame"]).translation.z == pytest.approx(RADIUS, abs=1e-4)


def test_curves_and_frames_say_the_same(parts):
    thing, *_ = stage.tossed_ball(strays=0.02)
    thing.rotation_mode = "QUATERNION"
    moved, stepped = parts.poses.Moved(thing), parts.poses.Stepped(bpy.context.scene, thing)
    for frame in (1.0, 3.3, 9.75):
        assert away(moved.world(frame), stage.world(thing, frame)) < 1e-6
    assert stepped.own.frames() == moved.own.frames()


@pytest.mark.parametrize("mode", ["XYZ", "ZYX", "QUATERNION", "AXIS_ANGLE"])
def test_every_rotation_mode_is_read(parts, mode):
    thing = stage.box("Box", 0.1, 0.2, 0.3)
    thing.rotation_mode = mode
    path = {"QUATERNION": "rotation_quaternion", "AXIS_ANGLE": "rotation_axis_angle"}.get(mode, "rotation_euler")
    for frame, values in ((1, (0.9, 0.1, 0.2, 0.3)), (10, (0.7, 0.5, -0.4, 0.1))):
        setattr(thing, path, values[: len(getattr(thing, path))])
        thing.keyframe_insert(path, frame=frame)
    moved = parts.poses.Moved(thing)
    for frame in (1, 4.5, 10):
        assert away(moved.world(frame), stage.world(thing, frame)) < 1e-6


def test_an_interval_alone_is_read():
    thing, table, hit, last = stage.tossed_ball(first=1)
    settings = bpy.context.scene.motion_sketch
    settings.use_interval, settings.first, settings.last = True, 3, int(last) - 2
    stage.select(thing)
    assert bpy.ops.motion_sketch.make_physical() == {"FINISHED"}
    frames, _ = stage.keys(thing)
    assert frames[0] == pytest.approx(3, abs=1e-3) and frames[-1] == pytest.approx(int(last) - 2, abs=1e-3)


def test_back_to_acted(parts):
    thing, before, *_ = made(strays=0.01)
    stage.select(thing)
    assert bpy.ops.motion_sketch.restore() == {"FINISHED"}
    assert thing.animation_data.action == before and thing.motion_sketch.ghost is None
    assert "Ball acted" not in bpy.data.objects and "Ball physical" not in bpy.data.actions


def test_loops_end_as_they_begin_and_repeat():
    """A ball that jumps up and down for ever: half a bounce up, a whole one down, is a loop where it bounces as it should."""
    scene = bpy.context.scene
    scene.render.fps = 24
    thing = stage.rigid(stage.ball("Ball", RADIUS), shape="SPHERE", restitution=1.0, friction=0.0)
    stage.passive(stage.plane(), restitution=1.0, friction=0.0)
    fall = np.sqrt(2 * 0.5 / stage.G)
    t = np.linspace(0, 2 * fall, 60)
    z = 0.6 - stage.G * np.minimum(t, 2 * fall - t) ** 2 / 2
    stage.record(thing, 1 + t * 24, np.column_stack([0 * t, 0 * t, z]) + stage.wander(t, 0.01, 1), [(1, 0, 0, 0)] * 60)
    stage.marker("bounce", round(1 + fall * 24))
    scene.motion_sketch.loops = 4
    stage.select(thing)
    assert bpy.ops.motion_sketch.make_physical() == {"FINISHED"}
    frames, rows = stage.keys(thing)
    length = (frames[-1] - frames[0]) / 4
    assert length == pytest.approx(2 * fall * 24, abs=0.1) and scene.frame_end >= frames[-1] - 1
    for number in range(4):
        at = [stage.world(thing, frames[0] + (number + share) * length).translation.z for share in (0, 0.5, 1)]
        assert at[0] == pytest.approx(at[2], abs=2e-3) and at[1] == pytest.approx(RADIUS, abs=4e-3)
    assert np.abs(np.diff(rows[:, 2])).max() < 0.2, "it never jumps"


def test_it_is_written_though_the_physics_would_move_it():
    thing, *_ = stage.tossed_ball()
    thing.rigid_body.kinematic = False
    stage.select(thing)
    assert bpy.ops.motion_sketch.make_physical() == {"FINISHED"}
    assert thing.rigid_body.kinematic
    frames, rows = stage.keys(thing)
    assert (stage.world(thing, 5).translation - stage.Vector(rows[np.argmin(abs(frames - 5)), :3])).length < 1e-5


def wrong_bounciness():
    """A ball that was acted as bouncy as 0.6 and is said to be as bouncy as 0.75."""
    thing, *_ = stage.tossed_ball(fps=60)
    thing.rigid_body.restitution = 0.75
    stage.select(thing)
    return thing


def test_what_is_suspected_is_set_free(parts):
    wrong_bounciness()
    bpy.ops.motion_sketch.make_physical()
    said = parts.account.kept(bpy.context.scene)
    quantity = said["suspects"][0]["quantity"]
    assert "restitution" in quantity and said["fit"] == "no", said
    assert bpy.ops.motion_sketch.set_free(quantity=quantity) == {"FINISHED"}
    said = parts.account.kept(bpy.context.scene)
    (found,) = said["freed"].values()
    assert found["value"] == pytest.approx(0.6, abs=0.02) and said["fit"] == "yes", said
    assert bpy.context.scene.motion_sketch.free == quantity
    assert bpy.ops.motion_sketch.fix_all() == {"FINISHED"} and bpy.context.scene.motion_sketch.free == ""


def test_what_cannot_be_free_is_refused():
    wrong_bounciness()
    before = stage.snapshot()
    with pytest.raises(RuntimeError, match="scene: "):
        bpy.ops.motion_sketch.set_free(quantity="Ball.colour")
    assert stage.snapshot() == before


def test_an_estimate_in_a_thread_tells_its_phase_and_is_stopped(parts):
    thing, *_ = stage.tossed_ball(strays=0.02)
    stage.select(thing)
    taken = parts.operators.read(bpy.context)
    work = parts.working.Work(taken)
    work.thread.join(30)
    assert work.is_done and work.found.is_motion and work.phase != "begins" or work.found.is_motion
    stopped = parts.working.Work(taken)
    stopped.is_stopped = True
    stopped.thread.join(30)
    assert stopped.is_done and not isinstance(stopped.found, parts.refusal.Refused)


def in_a_window(parts, thing, event_types):
    """What the modal operator does there, event by event: what it returned, and what it said. A window alone would call it."""
    from types import SimpleNamespace

    stage.select(thing)
    said = []
    manager = SimpleNamespace(event_timer_remove=lambda timer: said.append("timer removed"))
    workspace = SimpleNamespace(status_text_set=lambda text: said.append(text))
    context = SimpleNamespace(scene=bpy.context.scene, window_manager=manager, workspace=workspace)
    modal = parts.operators.MakePhysical
    operator = SimpleNamespace(timer=1, report=lambda level, words: said.append((level, words)))
    operator.end = lambda *of: modal.end(operator, *of)
    parts.working.current = parts.working.Work(parts.operators.read(bpy.context))
    for kind in event_types:
        done = modal.modal(operator, context, SimpleNamespace(type=kind))
    parts.working.current and parts.working.current.thread.join(30)
    while done == {"PASS_THROUGH"}:
        done = modal.modal(operator, context, SimpleNamespace(type="TIMER"))
    assert parts.working.current is None and "timer removed" in said
    return done, said


def test_progress_is_shown_and_it_ends_with_an_action(parts):
    thing, *_ = stage.tossed_ball(strays=0.01)
    done, said = in_a_window(parts, thing, ["MOUSEMOVE", "TIMER"])
    assert done == {"FINISHED"} and thing.animation_data.action.name == "Ball physical"
    assert any(isinstance(of, str) and of.startswith("Motion Sketch: ") for of in said), said


def test_escape_stops_it_and_nothing_changes(parts):
    thing, *_ = stage.tossed_ball(strays=0.01)
    stage.select(thing)
    before = stage.snapshot()
    done, said = in_a_window(parts, thing, ["ESC"])
    assert done == {"CANCELLED"} and ({"WARNING"}, "stopped: the scene is as it was") in said
    assert stage.snapshot() == before


def test_a_paddle_that_is_animated_hits():
    """A passive object with an action is in a hand: it goes as it does, and the ball bounces off it."""
    scene = bpy.context.scene
    scene.render.fps = 60
    thing = stage.rigid(stage.ball("Ball", 0.05), shape="SPHERE", mass=0.05, restitution=0.8, friction=0.0)
    paddle = stage.passive(stage.box("Paddle", 0.4, 0.4, 0.02), restitution=1.0, friction=0.0)
    paddle.rigid_body.kinematic = True
    # The paddle goes up at 0.5 m/s; its top meets the ball after 0.3 s.
    t = np.linspace(0, 0.6, 73)
    hit = 0.3
    top = 0.5 + 0.5 * (t - hit)
    stage.record(paddle, 1 + t * 60, np.column_stack([0 * t, 0 * t, top - 0.01]), [(1, 0, 0, 0)] * 73)
    fall = stage.G * hit
    after = 0.5 + 0.8 * (fall + 0.5)
    z = np.where(t < hit, 0.55 + stage.G * (hit**2 - t**2) / 2, 0.55 + after * (t - hit) - stage.G * (t - hit) ** 2 / 2)
    stage.record(thing, 1 + t * 60, np.column_stack([0 * t, 0 * t, z]) + stage.wander(t, 0.005, 2), [(1, 0, 0, 0)] * 73)
    stage.marker("bounce", 19)
    action = paddle.animation_data.action
    stage.select(thing)
    assert bpy.ops.motion_sketch.make_physical() == {"FINISHED"}
    happens = next(of for of in thing.animation_data.action["motion_sketch_events"] if of["kind"] == "collision")
    gap = stage.world(thing, happens["frame"]).translation.z - stage.world(paddle, happens["frame"]).translation.z
    assert gap == pytest.approx(0.06, abs=1e-3) and happens["contact"] == "ball on face +z"
    assert paddle.animation_data.action == action and paddle.motion_sketch.ghost is None


def falling_on(place, restitution=0.5, size=0.1):
    """A cube that falls from a metre above a height, level, as it was acted, and its bounce."""
    scene = bpy.context.scene
    scene.render.fps = 60
    thing = stage.rigid(stage.ball("Ball", size / 2), shape="SPHERE", mass=0.2, restitution=restitution, friction=0.0)
    t = np.linspace(0, 0.7, 84)
    hit = np.sqrt(2 * 1.0 / stage.G)
    up = restitution * stage.G * hit
    z = np.where(t < hit, 1 - stage.G * t**2 / 2, up * (t - hit) - stage.G * (t - hit) ** 2 / 2)
    places = np.array(place) + np.column_stack([0.1 * t, 0 * t, z + size / 2])
    stage.record(thing, 1 + t * 60, places, [(1, 0, 0, 0)] * 84)
    stage.marker("bounce", round(1 + hit * 60))
    return thing


def touches_at(thing):
    stage.select(thing)
    assert bpy.ops.motion_sketch.make_physical() == {"FINISHED"}
    return next(of for of in thing.animation_data.action["motion_sketch_events"] if of["kind"] == "collision")


def test_what_stands_may_be_scaled_turned_and_parented():
    block = stage.passive(stage.box("Block", 1, 1, 1), restitution=1.0, friction=0.0)
    parent = bpy.data.objects.new("Parent", None)
    bpy.context.scene.collection.objects.link(parent)
    parent.location, parent.rotation_euler = (2, 3, 1), (0, 0, 0.7)
    block.parent, block.scale = parent, (0.5, 1.5, 0.8)
    bpy.context.view_layer.update()
    hit = touches_at(falling_on((2, 3, 1.4)))
    assert hit["point"][2] == pytest.approx(1.4, abs=1e-5) and hit["normal"][2] == pytest.approx(1)


def test_a_flat_mesh_that_leans_is_a_surface():
    board = stage.passive(stage.plane("Board", size=4), restitution=1.0, friction=0.0)
    board.rotation_euler = (0, 0.2, 0)
    bpy.context.view_layer.update()
    hit = touches_at(falling_on((0, 0, 0)))
    assert list(hit["normal"]) == pytest.approx([np.sin(0.2), 0, np.cos(0.2)], abs=1e-6)


def test_a_board_ends_where_it_ends(parts):
    """Near its border a flat mesh is a board, which has edges; far from it it has no end."""
    thing = falling_on((0, 0, 0))
    stage.passive(stage.plane("Small", size=0.2), restitution=1.0, friction=0.0)
    stage.select(thing)
    assert "size_mm = [200" in parts.operators.read(bpy.context).text
    bpy.data.objects["Small"].scale = (5, 5, 1)
    assert "size_mm" not in parts.operators.read(bpy.context).text


def test_the_nearest_thing_is_hit():
    for name, height in (("Low", 0.0), ("High", 0.5)):
        shelf = stage.passive(stage.box(name, 1, 1, 0.02), restitution=1.0, friction=0.0)
        shelf.location.z = height - 0.01
    bpy.data.objects["Low"].rigid_body.restitution = 0.1
    bpy.context.view_layer.update()
    hit = touches_at(falling_on((0, 0, 0.5)))
    assert hit["point"][2] == pytest.approx(0.5, abs=1e-5) and "High" in hit["contact"]


def test_without_gravity_it_flies_straight():
    scene = bpy.context.scene
    scene.use_gravity, scene.render.fps = False, 30
    thing = stage.rigid(stage.box("Probe", 0.2, 0.1, 0.1))
    t = np.linspace(0, 1, 60)
    stage.record(thing, 1 + t * 30, np.column_stack([t, 0 * t, 0.2 * t]) + stage.wander(t, 0.01, 8), [(1, 0, 0, 0)] * 60)
    stage.select(thing)
    assert bpy.ops.motion_sketch.make_physical() == {"FINISHED"}
    frames, rows = stage.keys(thing)
    assert np.abs(np.diff(rows[:, :3], n=2, axis=0)).max() < 1e-5


def test_a_frame_rate_with_a_base():
    scene = bpy.context.scene
    thing, table, hit, last = stage.tossed_ball(fps=24)
    scene.render.fps_base = 1.001
    curves = stage.curves(thing)
    for curve in curves.values():
        for point in curve.keyframe_points:
            point.co[0] = 1 + (point.co[0] - 1) / 1.001
        curve.update()
    stage.select(thing)
    assert bpy.ops.motion_sketch.make_physical() == {"FINISHED"}
    happens = next(of for of in thing.animation_data.action["motion_sketch_events"] if of["kind"] == "collision")
    assert happens["frame"] == pytest.approx(1 + (hit - 1) / 1.001, abs=0.1)
    assert happens["time_s"] == pytest.approx((hit - 1) / 24, abs=0.004)


def test_what_goes_into_something_is_said_with_its_frame(parts):
    """The ball falls on and is in the table at the last key, and nobody marked a bounce."""
    bpy.context.scene.render.fps = 60
    thing = stage.rigid(stage.ball("Ball", 0.05), shape="SPHERE")
    stage.passive(stage.plane())
    t = np.linspace(0, 0.4, 48)
    stage.record(thing, 101 + t * 60, np.column_stack([0.1 * t, 0 * t, 0.8 - stage.G * t**2 / 2]), [(1, 0, 0, 0)] * 48)
    stage.select(thing)
    bpy.context.scene.frame_set(125)
    bpy.ops.motion_sketch.add_goal(goal="POSE")
    bpy.data.objects["Ball pose"].motion_sketch.is_turn = False
    stage.select(thing)
    bpy.ops.motion_sketch.make_physical()
    said = parts.account.kept(bpy.context.scene)
    assert any("inside `Table`" in of and "(frame 125.0)" in of for of in said["against"]), said["against"]
    assert said["next"].startswith("It goes into something")


@pytest.mark.parametrize(("last", "pace", "begins"), [(0.42, 1.0, "It goes into something"), (0.38, 0.6, "It does not fall as things do")])
def test_what_to_do_next_is_of_what_speaks_against_it(parts, last, pace, begins):
    """A ball that falls into a table nobody marked; one that falls too slowly."""
    bpy.context.scene.render.fps = 60
    thing = stage.rigid(stage.ball("Ball", 0.05), shape="SPHERE")
    stage.passive(stage.plane())
    t = np.linspace(0, last, 60)
    stage.record(thing, 1 + t / pace * 60, np.column_stack([0.1 * t, 0 * t, 0.8 - stage.G * t**2 / 2]), [(1, 0, 0, 0)] * 60)
    stage.select(thing)
    bpy.ops.motion_sketch.make_physical()
    said = parts.account.kept(bpy.context.scene)
    assert said["against"] and said["next"].startswith(begins), said
