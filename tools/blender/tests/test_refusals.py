# SPDX-License-Identifier: GPL-3.0-or-later
"""What cannot be done is refused by name, says what was expected, and leaves the scene as it was."""

import bpy
import pytest
import stage


def scaled():
    thing, *_ = stage.tossed_ball()
    thing.scale = (2, 2, 2)
    return thing, "Ball: its scale is 2, 2, 2, expected 1"


def passive():
    thing, *_ = stage.tossed_ball()
    thing.rigid_body.type = "PASSIVE"
    return thing, "nothing to make physical"


def without_body():
    thing, *_ = stage.tossed_ball()
    stage.select(thing)
    bpy.ops.rigidbody.object_remove()
    return thing, "Ball: has no Rigid Body"


def without_action():
    thing = stage.rigid(stage.ball("Ball", 0.1))
    return thing, "Ball: has no action"


def constraint():
    thing, table, *_ = stage.tossed_ball()
    thing.constraints.new("COPY_LOCATION").target = table
    return thing, "Ball: the constraint 'Copy Location' moves it too"


def driver():
    thing, *_ = stage.tossed_ball()
    thing.driver_add("location", 0)
    return thing, "a driver of location moves it too"


def nla():
    thing, *_ = stage.tossed_ball()
    action = thing.animation_data.action
    thing.animation_data.nla_tracks.new().strips.new("Strip", 1, action)
    return thing, "strips in the Nonlinear Animation editor"


def joint():
    thing, *_ = stage.tossed_ball()
    holder = bpy.data.objects.new("Hinge", None)
    bpy.context.scene.collection.objects.link(holder)
    with bpy.context.temp_override(object=holder, active_object=holder, selected_objects=[holder]):
        bpy.context.view_layer.objects.active = holder
        bpy.ops.rigidbody.constraint_add(type="HINGE")
    holder.rigid_body_constraint.object1 = thing
    return thing, "Hinge: ties 'Ball' (hinge); joints are not read"


def compound():
    thing, *_ = stage.tossed_ball()
    thing.rigid_body.collision_shape = "COMPOUND"
    return thing, "Ball: collides as a compound"


def deltas():
    thing, *_ = stage.tossed_ball()
    thing.delta_location = (1, 0, 0)
    return thing, "Ball: has delta transforms"


def uneven_parent():
    thing, *_ = stage.tossed_ball()
    parent = bpy.data.objects.new("Parent", None)
    bpy.context.scene.collection.objects.link(parent)
    parent.scale = (1, 2, 1)
    thing.parent = parent
    return thing, "Ball: a parent is scaled unevenly"


def nothing_to_hit():
    thing, table, *_ = stage.tossed_ball()
    bpy.data.objects.remove(table)
    return thing, "nothing is there to bounce off"


def two_ends():
    thing, *_ = stage.tossed_ball()
    stage.marker("end", 12)
    stage.marker("end", 14)
    return thing, "marker 'end': at frames 12 and 14, expected one"


def bounce_after_end():
    thing, *_ = stage.tossed_ball()
    stage.marker("end", 5)
    return thing, "not before 'end' at 5"


def unknown_name():
    thing, *_ = stage.tossed_ball()
    stage.marker("bounce: Ball, Chair", 12)
    return thing, "names 'Chair', expected a rigid body of the scene: Ball, Table"


def goal_without_event():
    thing, *_ = stage.tossed_ball()
    stage.select(thing)
    bpy.ops.motion_sketch.add_goal(goal="POSE", event="bounce 3")
    return thing, "Ball pose: its event is 'bounce 3', expected a marker in the interval: bounce, end, rest"


def goal_without_faces():
    thing, *_ = stage.tossed_ball()
    stage.select(thing)
    bpy.ops.motion_sketch.add_goal(goal="FACES")
    bpy.data.objects["Ball faces"].motion_sketch.faces = "six"
    return thing, "its faces are 'six', expected some of +x"


def goal_of_nothing():
    thing, *_ = stage.tossed_ball()
    stage.select(thing)
    bpy.ops.motion_sketch.add_goal(goal="POSE")
    settings = bpy.data.objects["Ball pose"].motion_sketch
    settings.is_place = settings.is_turn = False
    return thing, "asks neither for a place nor for a turn"


def flat_body():
    thing, *_ = stage.tossed_ball()
    for vertex in thing.data.vertices:
        vertex.co.z = 0
    thing.rigid_body.collision_shape = "CONVEX_HULL"
    return thing, "Ball: its mesh is flat, expected a solid"


def short():
    thing, *_ = stage.tossed_ball()
    settings = bpy.context.scene.motion_sketch
    settings.use_interval, settings.first, settings.last = True, 4, 4
    return thing, "expected an interval of more than a frame"


def still():
    thing = stage.rigid(stage.ball("Ball", 0.1))
    thing.scale = (1, 1, 1)
    thing["x"] = 1.0
    thing.keyframe_insert('["x"]', frame=1)
    return thing, "Ball: its action moves it nowhere"


def two_places():
    """Goals that contradict each other."""
    thing, *_ = stage.tossed_ball()
    for place in (0.3, 0.6):
        stage.select(thing)
        bpy.ops.motion_sketch.add_goal(goal="POSE")
        bpy.context.scene.objects[-1].location = (0.5, 0.5, place)
    bpy.context.view_layer.update()
    return thing, "scene: "


CASES = [scaled, passive, without_body, without_action, constraint, driver, nla, joint, compound, deltas, uneven_parent,
         nothing_to_hit, two_ends, bounce_after_end, unknown_name, goal_without_event, goal_without_faces, goal_of_nothing, flat_body,
         short, still, two_places]


@pytest.mark.parametrize("case", CASES, ids=[of.__name__ for of in CASES])
def test_it_is_refused_by_name_and_nothing_changes(case):
    thing, words = case()
    stage.select(thing)
    before = stage.snapshot()
    for operator in (bpy.ops.motion_sketch.make_physical, bpy.ops.motion_sketch.live):
        with pytest.raises(RuntimeError) as raised:
            operator()
        assert words in str(raised.value), raised.value
        assert stage.snapshot() == before


def test_two_bodies_and_a_marker_that_names_none():
    one, *_ = stage.tossed_ball()
    other = stage.rigid(stage.box("Box", 0.1, 0.1, 0.1))
    stage.key(other, 1, (2, 0, 1))
    stage.key(other, 20, (2, 0, 0.5))
    stage.select(one, other)
    with pytest.raises(RuntimeError, match="of which of Ball, Box\\? expected a name, as in 'bounce: Ball'"):
        bpy.ops.motion_sketch.make_physical()


def test_linked_objects_are_refused_and_overrides_taken(tmp_path):
    thing, *_ = stage.tossed_ball()
    path = str(tmp_path / "library.blend")
    collection = bpy.data.collections.new("Toss")
    bpy.context.scene.collection.children.link(collection)
    collection.objects.link(thing)
    bpy.ops.wm.save_as_mainfile(filepath=path)
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    with bpy.data.libraries.load(path, link=True) as (there, here):
        here.objects = ["Ball"]
    linked = here.objects[0]
    scene = bpy.context.scene
    scene.collection.objects.link(linked)
    stage.passive(stage.plane(), friction=0.0)
    stage.marker("bounce", 11)
    stage.select(linked)
    with pytest.raises(RuntimeError, match="Ball: is linked from another file, expected a local one"):
        bpy.ops.motion_sketch.make_physical()
    own = linked.override_create(remap_local_usages=True)
    stage.rigid(own, shape="SPHERE", mass=0.2, restitution=0.6, friction=0.0)
    stage.select(own)
    assert bpy.ops.motion_sketch.make_physical() == {"FINISHED"}
    assert own.animation_data.action.name == "Ball physical" and own.motion_sketch.ghost.animation_data.action.library is not None


def test_a_take_that_cannot_be_written_is_refused(tmp_path):
    thing, *_ = stage.tossed_ball()
    stage.select(thing)
    with pytest.raises(RuntimeError, match="expected a file that can be written"):
        bpy.ops.motion_sketch.save_take(filepath=str(tmp_path / "nowhere" / "x.mcap"))


def test_a_ghost_that_somebody_deleted():
    thing, *_ = stage.tossed_ball(strays=0.01)
    stage.select(thing)
    bpy.ops.motion_sketch.make_physical()
    bpy.data.objects.remove(thing.motion_sketch.ghost)
    stage.select(thing)
    before = stage.snapshot()
    with pytest.raises(RuntimeError, match="Ball: its ghost is gone, expected the action 'BallAction' on it"):
        bpy.ops.motion_sketch.make_physical()
    assert stage.snapshot() == before


def test_a_motion_that_failed_is_said_and_not_written(parts, monkeypatch):
    """Stopped at once there is no motion: the scene stays as it is, and the panel says why."""
    thing, *_ = stage.tossed_ball(strays=0.02)
    stage.select(thing)
    before = stage.snapshot()
    solve = parts.solving.solve
    monkeypatch.setattr(parts.solving, "solve", lambda reading, **how: solve(reading, deadline=0.0))
    with pytest.raises(RuntimeError, match="Move the marker to the impact"):
        bpy.ops.motion_sketch.make_physical()
    assert stage.snapshot() == before
    said = parts.operators.said(bpy.context.scene)
    assert said["verdict"] == "failed" and said["reason"]
