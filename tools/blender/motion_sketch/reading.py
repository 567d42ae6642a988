# SPDX-License-Identifier: GPL-3.0-or-later
"""What is in the scene becomes a scene file, poses and marks: plain data, which no undo takes away."""

from dataclasses import dataclass, field

import numpy as np

from . import acted, goals, happening, markers, poses, things, toml_text, weighing
from .refusal import Refused
from .units import Units

#: Samples a second that an action is read with, about.
RATE_HZ = 120.0
#: Most samples of one body.
SAMPLES = 100_000


@dataclass
class Named:
    """A body of which only the name is known."""

    name: str
    thing: object
    held: bool = False


@dataclass
class Reading:
    """All that an estimate is made of."""

    units: Units
    #: The scene without its goals, and these.
    text: str
    goals: list
    #: Poses of each body by name: seconds, metres, quaternions w x y z; whether they are held.
    poses: dict
    #: None of samples; else how far keys may be from their times, seconds.
    keys_within: float | None
    marks: list
    #: Names of events and the frames of their markers.
    events: dict
    flying: list
    #: Other faces that a goal may show in the end, by the place of that goal in the list.
    faces: dict = field(default_factory=dict)
    #: Poses on whole frames before a flight begins, as acted: frames, metres, quaternions, by name.
    before: dict = field(default_factory=dict)
    #: What to know of it.
    notes: list = field(default_factory=list)

    def is_same_but_goals(self, other):
        """Whether all but the goals is the same."""
        return (
            other is not None
            and self.text == other.text
            and self.units == other.units
            and self.marks == other.marks
            and self.keys_within == other.keys_within
            and self.poses.keys() == other.poses.keys()
            and all(np.array_equal(a, b) for name in self.poses for a, b in zip(self.poses[name], other.poses[name]))
        )


def bodies_wanted(scene, selected, active):
    """The objects to be made physical: of those selected the active rigid bodies, or all of the scene that are animated."""
    # Who selects a ghost means its object.
    meant = {of.motion_sketch.acts or of for of in selected}
    chosen = [of for of in meant if of.rigid_body and of.rigid_body.type == "ACTIVE"]
    if not chosen and active in selected and active.type == "MESH" and not goals.is_goal(active) and not active.rigid_body:
        chosen = [active]
    if not chosen:
        every = things.rigid_things(scene)
        chosen = [of for of in every if of.rigid_body.type == "ACTIVE" and of.animation_data and of.animation_data.action]
    if not chosen:
        raise Refused(scene.name, "nothing to make physical, expected an animated object with an active Rigid Body: Make Body")
    return sorted(chosen, key=lambda of: of.name)


def read(scene, chosen, is_live=False):
    """Reads objects, what stands around them, markers and goals; refuses by name what cannot be read.

    `is_live`: whether something is being dragged, when the scene may not go to other frames.
    """
    settings = scene.motion_sketch
    for thing in chosen:
        things.check_body(thing)
    names = [of.name for of in chosen]
    things.check_joints(scene, set(chosen))
    sources = {of.name: acted.source(of) for of in chosen}
    for name, (_, action) in sources.items():
        if action is None:
            raise Refused(name, "has no action, expected keys of place and rotation: act it first")
    for thing in chosen:
        check_alone(thing)
    moved = {name: poses.moved(scene, holder) for name, (holder, _) in sources.items()}
    for name, of in moved.items():
        if is_live and isinstance(of, poses.Stepped):
            raise Refused(name, "its parent is moved by more than curves, which is not followed live: Make Physical does")
        if not of.own.is_moving:
            raise Refused(name, "its action moves it nowhere, expected keys of place and rotation")
    first, last = interval(settings, moved)
    units = Units.of(scene, first)
    found = markers.marked(scene, {name: action for name, (_, action) in sources.items()}, first, last)
    if settings.loops > 1:
        markers.begin(found, first)
    last = min(last, next(of.frame for of in found if of.kind == "end"))
    frames = frames_between(first, last, units)
    bodies = [flying(of, moved[of.name], frames, units, settings) for of in chosen]
    stands = around(scene, chosen, bodies, frames, units)
    bodies += [of for of in stands if isinstance(of, things.Body)]
    stands = [of for of in stands if isinstance(of, things.Standing)]
    asked = goals.of_scene(scene)
    tables, faces = goals_of(asked, bodies, found, units)
    tables += closed(found, bodies, settings)
    events = [happening.event(of, bodies, stands, moved, frames) for of in found]
    weighing.free_end(events, tables, settings, units)
    table = {
        "name": ", ".join(names),
        **({"settle_s": settings.settle_s} if settings.settle_s > 0 or faces else {}),
        "gravity_m_s2": weighing.gravity(scene, units),
        "timing": weighing.timing(settings, units),
        "weights": {"position_mm": weighing.strays(settings, bodies)},
        "body": [of.table for of in bodies],
        "surface": [of.table for of in stands if of.is_flat],
        "obstacle": [of.table for of in stands if not of.is_flat],
        "event": events,
        "free": [{"quantity": of} for of in settings.free.split("|") if of],
    }
    if faces and settings.settle_s <= 0:
        table["settle_s"] = 5.0
    table = {key: of for key, of in table.items() if of != []}
    return Reading(
        units=units,
        text=toml_text.text(table),
        goals=tables,
        poses={of.name: (seconds(of.frames, units), of.position, of.quaternion, np.array(of.held)) for of in bodies},
        keys_within=weighing.keys_within(settings, units),
        marks=[(of.event, units.seconds(of.frame)) for of in found],
        events={of.event: of.frame for of in found},
        flying=names,
        faces=faces,
        before=before(found, bodies, moved, frames, units),
        notes=weighing.notes(scene, units),
    )


def interval(settings, moved):
    """The first frame and the last."""
    keyed = [of.own.frames() for of in moved.values()]
    first, last = max(of[0] for of in keyed), min(of[-1] for of in keyed)
    if settings.use_interval:
        first, last = max(first, float(settings.first)), min(last, float(settings.last))
    if last - first < 1:
        raise Refused(", ".join(moved), f"keys from frame {first:g} to {last:g}, expected an interval of more than a frame")
    return first, last


def frames_between(first, last, units):
    """Frames, with parts of them, evenly spread from the first to the last."""
    count = max(8, round((last - first) / units.fps * RATE_HZ))
    if count > SAMPLES:
        raise Refused("interval", f"{count} samples, expected {SAMPLES} at most: set First and Last")
    return [float(of) for of in np.linspace(first, last, count + 1)]


def seconds(frames, units):
    return np.array([units.seconds(of) for of in frames])


def check_alone(thing):
    """Refuses by name where more than an action would move the result."""
    by = poses.moved_by_more(thing)
    if by is not None:
        raise Refused(thing.name, f"{by} moves it too, expected its action alone: mute it, or bake it (Object > Animation)")


def flying(thing, moved, frames, units, settings):
    """A body with its samples, or its keys alone."""
    if settings.reads == "KEYS":
        keyed = [of for of in moved.own.frames() if frames[0] <= of <= frames[-1]]
        if len(keyed) < 2:
            raise Refused(thing.name, f"{len(keyed)} keys in the interval, expected two at least")
        frames = [float(of) for of in keyed]
    scale = one_scale(thing.name, moved, frames)
    of = things.body(thing, units, scale)
    sample(of, moved, frames, units)
    return of


def one_scale(name, moved, frames):
    """The scale of an object, which must stay the same."""
    if isinstance(moved, poses.Stepped):
        moved.look(frames)
    scales = [poses.rigid(name, moved.world(frame))[2] for frame in (frames[0], frames[len(frames) // 2], frames[-1])]
    if max(scales) - min(scales) > poses.NEARLY * max(scales):
        raise Refused(name, f"its scale goes from {min(scales):g} to {max(scales):g}, expected one that stays: remove its keys")
    return 1.0 if abs(scales[0] - 1) < poses.NEARLY else scales[0]


def sample(body, moved, frames, units):
    """Reads where a body is at frames."""
    body.frames, body.position, body.quaternion = placed(moved, frames, units)


def placed(moved, frames, units):
    """Frames, places in metres and quaternions of something that moves."""
    rows = [moved.world(frame).decompose()[:2] for frame in frames]
    places = units.metre * np.array([place[:] for place, _ in rows])
    return frames, places, np.array([turn[:] for _, turn in rows])


def around(scene, chosen, bodies, frames, units):
    """What the bodies may touch: everything passive of the physics, still or animated."""
    ways = np.concatenate([of.position for of in bodies])
    reach = max(things.reach_m(of.thing, units, 1.0) for of in bodies)
    found = []
    for thing in sorted(things.rigid_things(scene), key=lambda of: of.name):
        if thing in chosen or thing.rigid_body.type != "PASSIVE":
            continue
        moved = poses.moved(scene, thing)
        if isinstance(moved, poses.Stepped):
            moved.look(frames)
        if things.is_animated(moved, frames):
            of = things.held(thing, units, one_scale(thing.name, moved, frames))
            sample(of, moved, frames, units)
            found.append(of)
        else:
            found.append(things.standing(thing, moved.world(frames[0]), units, ways, reach))
    return found


def goals_of(asked, bodies, found, units):
    """The tables of all goals, and other faces by their places."""
    tables, faces = [], {}
    others = goals.other_faces(asked)
    for thing in asked:
        if others.get(thing.name):
            faces[len(tables)] = others[thing.name]
        elif thing.name in others:
            faces.setdefault(len(tables), [])
        tables += goals.tables(thing, bodies, found, units)
    return tables, faces


def before(found, bodies, moved, frames, units):
    """Where bodies are before they are let go: none where they fly from the first frame on."""
    start = next((of.frame for of in found if of.kind == "start"), None)
    if start is None or start <= frames[0]:
        return {}
    held = [float(of) for of in range(int(np.ceil(frames[0])), int(np.ceil(start)))]
    return {of.name: placed(moved[of.name], held, units) for of in bodies if not of.held and held}


def closed(found, bodies, settings):
    """Of what is repeated: it ends where and as it begins, which is as it was acted."""
    if settings.loops < 2:
        return []
    ends = [of.event for of in found if of.kind in ("start", "end")]
    flies = [of for of in bodies if not of.held]
    pose = {
        of.name: {
            "point_mm": [0.0, 0.0, 0.0],
            "position_mm": (1e3 * of.position[0]).tolist(),
            "orientation_wxyz": of.quaternion[0].tolist(),
        }
        for of in flies
    }
    return [{"event": event, "body": of.name} | pose[of.name] for of in flies for event in ends]
