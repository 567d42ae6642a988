# SPDX-License-Identifier: GPL-3.0-or-later
"""A motion becomes a new action; what was acted stays on a ghost beside the object."""

import bpy
import numpy as np
from mathutils import Matrix, Quaternion, Vector

from . import acted, channels, motion, poses

GHOST = "Motion Sketch ghosts"
#: Custom properties of a new action: what happens, for sounds and effects.
EVENTS = "motion_sketch_events"


def bake(scene, solved, loops=1):
    """Writes the motion of every body: all or, where something fails, nothing."""
    made = [(thing_named(scene, name), keys(scene, solved, name, loops)) for name in solved.reading.flying]
    for thing, rows in made:
        keep_acted(scene, thing)
        write(thing, rows, events_of(solved, thing.name))
    last = max(float(rows[0][-1]) for _, rows in made)
    if scene.frame_end < last:
        scene.frame_end = int(np.ceil(last))


def thing_named(scene, name):
    """An object by its name, as it is now."""
    return scene.objects[name]


def keys(scene, solved, name, loops):
    """Frames, places and turns in the space of the object's own channels."""
    thing = thing_named(scene, name)
    rows = motion.keys_of(solved, name)
    if loops > 1:
        rows = motion.repeated(rows, loops)
    above = poses.moved(scene, thing)
    frames = [float(of) for of in rows.frames]
    if isinstance(above, poses.Stepped):
        above.look(frames)
    places, turns = [], []
    for frame, place, turn in zip(frames, rows.position / solved.reading.units.metre, rows.quaternion):
        world = Matrix.LocRotScale(Vector(place), Quaternion(turn), scale_above(above.above(frame)))
        own = above.above(frame).inverted() @ world
        at, turned, _ = own.decompose()
        places.append(at[:])
        turns.append(turned.normalized()[:])
    return rows.frames, np.array(places), motion.one_sign(np.array(turns))


def scale_above(above):
    """The scale that parents give an object whose own is one."""
    return above.to_scale()


def keep_acted(scene, thing):
    """The ghost: a copy of the object that goes on as it was acted. There is one already where it was made before."""
    settings = thing.motion_sketch
    if acted.is_made(thing):
        return
    action = thing.animation_data.action
    old = settings.ghost
    if old is not None and old.animation_data and old.animation_data.action == action:
        ghost = old
    else:
        ghost = thing.copy()
        ghost.name = f"{thing.name} acted"
        ghost.motion_sketch.acts = thing
        ghost.motion_sketch.made = ghost.motion_sketch.acted = ghost.motion_sketch.ghost = None
        folder(scene).objects.link(ghost)
        leave_physics(ghost)
        look_like_ghost(ghost)
    settings.ghost, settings.acted = ghost, action


def leave_physics(ghost):
    """A copy of a rigid body is one, too, and would be simulated."""
    if ghost.rigid_body is not None:
        with bpy.context.temp_override(object=ghost, active_object=ghost, selected_objects=[ghost]):
            bpy.ops.rigidbody.object_remove()


def look_like_ghost(ghost):
    """Seen through, and not rendered."""
    ghost.display_type = "WIRE"
    ghost.hide_render = True
    ghost.select_set(False)


def folder(scene):
    """The collection of the ghosts, made where there is none; a scene has its own."""
    for child in scene.collection.children:
        if child.name.split(".")[0] == GHOST:
            return child
    made = bpy.data.collections.new(GHOST)
    scene.collection.children.link(made)
    return made


def write(thing, rows, happens):
    """A new action on the object, in place of one that was made before."""
    frames, places, turns = rows
    settings, data = thing.motion_sketch, thing.animation_data
    before = settings.made if acted.is_made(thing) else None
    slot_name = thing.name
    action, slot, curves = channels.new_action(f"{thing.name} physical", slot_name)
    for axis in range(3):
        channels.write_linear(curves, "location", axis, frames, places[:, axis])
    for axis in range(4):
        channels.write_linear(curves, "rotation_quaternion", axis, frames, turns[:, axis])
    mark(action, happens)
    thing.rotation_mode = "QUATERNION"
    data.action_blend_type, data.action_influence = "REPLACE", 1.0
    channels.assign(thing, action, slot)
    settings.made = action
    if before is not None and before.users == 0:
        bpy.data.actions.remove(before)
        action.name = f"{thing.name} physical"
    # Else the simulation takes the object away from its action.
    if thing.rigid_body is not None and not thing.rigid_body.kinematic:
        thing.rigid_body.kinematic = True


def events_of(solved, name):
    """What happens to a body, with exact frames and speeds."""
    units, happens = solved.reading.units, []
    for of in solved.estimate.events:
        if name not in of.bodies and of.kind != "end":
            continue
        row = {"event": of.name, "kind": of.kind, "frame": motion.frame_of(solved, of.time), "time_s": of.time}
        if of.sd is not None:
            row["sd_s"] = of.sd
        if of.impacts:
            hit = of.impacts[0]
            row |= {
                "contact": hit.contact or of.contact or "",
                "point": [of / units.metre for of in hit.point],
                "normal": list(hit.normal),
                "approach_m_s": hit.approach_speed,
                "slip_m_s": hit.slip_speed,
                "impulse_n_s": float(np.linalg.norm(of.impulse)),
            }
        happens.append(row)
    return happens


def mark(action, happens):
    """Pose markers at the nearest frames, and beside them, as custom properties, the exact ones."""
    for of in happens:
        marker = action.pose_markers.new(of["event"])
        marker.frame = round(of["frame"])
    action[EVENTS] = [dict(of) for of in happens]


def restore(thing):
    """Gives an object back what was acted, and removes its ghost."""
    holder, action = acted.source(thing)
    settings, made = thing.motion_sketch, thing.motion_sketch.made
    thing.rotation_mode = holder.rotation_mode
    channels.assign(thing, action, channels.slot_of_action(holder))
    settings.ghost = settings.acted = settings.made = None
    if holder is not thing:
        bpy.data.objects.remove(holder)
    if made.users == 0:
        bpy.data.actions.remove(made)
