# SPDX-License-Identifier: GPL-3.0-or-later
"""While something is dragged: at most one solve in 33 ms, the last change wins, the path is shown, and all of it once it rests.

Nothing here holds an object across calls: undo and files replace them. What was read is plain data.
"""

import time
from dataclasses import dataclass, field, replace

from . import goals, markers, motion, reading
from .refusal import Refused
from .worker import Worker

#: How long nothing must change before the motion is final, seconds.
RESTS_S = 0.25


@dataclass
class Live:
    """What is shown, and what has changed since."""

    worker: Worker
    scene_uid: int
    uids: list
    read: object = None
    paths: dict = field(default_factory=dict)
    words: str = ""
    changed: set = field(default_factory=set)
    since: float = 0.0
    is_final: bool = True
    marks: tuple = ()


state = None


def begin(scene, chosen):
    """Begins to follow what is dragged."""
    global state
    end()
    uids = [of.session_uid for of in chosen]
    state = Live(Worker(), scene.session_uid, uids, changed={"all"}, marks=marks_of(scene))


def end():
    """Ends it."""
    global state
    if state is not None:
        state.worker.stop()
    state = None


def is_on(scene):
    """Whether a scene is followed."""
    return state is not None and state.scene_uid == scene.session_uid


def touched():
    """A setting has changed that no update tells."""
    if state is not None:
        state.changed.add("all")


def marks_of(scene):
    """Where the markers are that are events."""
    return tuple((of.name, of.frame) for of in scene.timeline_markers if markers.kind_of(of.name))


def chosen_of(scene):
    """The bodies that are followed, as they are now called."""
    found = [of for of in scene.objects if of.session_uid in state.uids]
    if not found:
        raise Refused("live", "its objects are gone, expected them: turn Live off and on")
    return sorted(found, key=lambda of: of.name)


def changes(scene, updates):
    """What of a scene has changed, of what a motion depends on: its goals, or more."""
    found = set()
    for update in updates:
        of = update.id.original
        kind = of.bl_rna.identifier
        if kind == "Action":
            found.add("all")
        elif kind == "Object" and goals.is_goal(of):
            found.add("goals")
        elif kind == "Object" and (of.rigid_body is not None or of.motion_sketch.acts is not None or of.session_uid in state.uids):
            if update.is_updated_transform or update.is_updated_geometry:
                found.add("all")
    return found


def note(scene, depsgraph):
    """What the handler does: notes what has changed, and nothing else."""
    if is_on(scene):
        noted = changes(scene, depsgraph.updates)
        if noted:
            state.changed |= noted


def tick(scene, now=None):
    """What the timer does: asks for a motion where something has changed, shows what was found. Returns "final" once it rests."""
    if not is_on(scene):
        return None
    now = time.monotonic() if now is None else now
    marks = marks_of(scene)
    if marks != state.marks:
        state.marks = marks
        state.changed.add("all")
    if state.changed:
        ask(scene, now)
    found = state.worker.take()
    if found is not None:
        show(found)
    if not state.is_final and state.worker.is_idle and now - state.since > RESTS_S:
        state.is_final = True
        return "final"
    return "shown" if found is not None else None


def ask(scene, now):
    """Reads what has changed and asks for its motion; of what is as it was nothing is asked."""
    only_goals = state.changed == {"goals"} and state.read is not None
    state.changed = set()
    try:
        if only_goals:
            made = with_goals_now(scene, state.read)
        else:
            made = reading.read(scene, chosen_of(scene), is_live=True)
    except Refused as refused:
        state.words = str(refused)
        return
    is_first = state.read is None
    if not is_first and made.is_same_but_goals(state.read) and made.goals == state.read.goals:
        return
    state.read = made
    state.worker.ask(made)
    if not is_first:
        state.since, state.is_final = now, False


def with_goals_now(scene, before):
    """A reading with the goals as they are now."""
    found = [markers.Marked("", 0.0, (), event=name) for name in before.events]
    bodies = [reading.Named(of, scene.objects[of]) for of in before.flying if of in scene.objects]
    tables, faces = reading.goals_of(goals.of_scene(scene), bodies, found, before.units)
    if scene.motion_sketch.loops > 1:
        return reading.read(scene, chosen_of(scene), is_live=True)
    ends = {of["event"] for of in tables} == {of["event"] for of in before.goals}
    if not ends or faces.keys() != before.faces.keys():
        # What the scene says of its end depends on whether a goal is there.
        return reading.read(scene, chosen_of(scene), is_live=True)
    return replace(before, goals=tables, faces=faces)


def show(found):
    """Keeps the paths for the eye."""
    if isinstance(found, Refused):
        state.words = str(found)
        return
    state.words = found.estimate.verdict
    if found.is_motion:
        metre = found.reading.units.metre
        state.paths = {name: motion.path_of(found, name) / metre for name in found.reading.flying}
