# SPDX-License-Identifier: GPL-3.0-or-later
"""Goals: objects that say what must hold at an event."""

from mathutils import Vector

from . import markers
from .refusal import Refused

AXES = ("+x", "-x", "+y", "-y", "+z", "-z")
#: How far a box's axes are off the world's that counts as along them.
ALONG = 1e-6


def is_goal(thing):
    """Whether an object is a goal."""
    return thing.motion_sketch.goal != "NONE"


def of_scene(scene):
    """The goals of a scene in order of their names: those that can be seen."""
    return sorted((of for of in scene.objects if is_goal(of) and not of.hide_viewport), key=lambda of: of.name)


def faces_of(text, where):
    """Axes of a body: `+z, -x`."""
    faces = [of.strip().lower() for of in text.replace(";", ",").split(",") if of.strip()]
    faces = [of if of[0] in "+-" else f"+{of}" for of in faces]
    wrong = [of for of in faces if of not in AXES]
    if wrong or not faces:
        raise Refused(where, f"its faces are {text!r}, expected some of {', '.join(AXES)}")
    return faces


def tables(thing, bodies, found, units):
    """What a scene says of a goal: one table or several."""
    settings = thing.motion_sketch
    body = body_of(thing, bodies)
    event = markers.event_named(found, settings.event, thing.name)
    head = {"event": event, "body": body.name}
    if settings.goal == "FACES":
        return [face(thing, {"event": "rest", "body": body.name})]
    if event == "rest":
        raise Refused(thing.name, "only faces are asked at rest, expected an event: end, bounce, through")
    world = thing.matrix_world
    at_mm = [units.mm * of for of in world.translation]
    match settings.goal:
        case "POSE":
            return [pose(thing, head, at_mm, world)]
        case "REGION":
            return region(thing, head, world, units)
        case "DIRECTION":
            way = (world.to_3x3() @ Vector((0, 0, 1))).normalized()
            return [head | {"axis": settings.axis, "direction": list(way)} | within(settings, angle=True)]
        case _:
            return [head | {"at_rest": True}]


def body_of(thing, bodies):
    """The body of which a goal asks something."""
    wanted = thing.motion_sketch.body
    flying = [of for of in bodies if not of.held]
    if wanted is None:
        if len(flying) == 1:
            return flying[0]
        raise Refused(thing.name, f"says no body, expected one of {', '.join(of.name for of in flying)}")
    for of in flying:
        if of.thing == wanted:
            return of
    raise Refused(thing.name, f"its body {wanted.name!r} is not among those that move, expected it selected, active and animated")


def pose(thing, head, at_mm, world):
    """A place, a turn, or both."""
    settings = thing.motion_sketch
    if not settings.is_place and not settings.is_turn:
        raise Refused(thing.name, "asks neither for a place nor for a turn, expected one of them")
    table = dict(head)
    if settings.is_place:
        # Of the object's origin, not of its centre of mass.
        table |= {"point_mm": [0.0, 0.0, 0.0], "position_mm": at_mm} | within(settings)
    if settings.is_turn:
        table |= {"orientation_wxyz": list(world.to_quaternion().normalized())} | within(settings, angle=True)
    return table


def within(settings, angle=False):
    """How far off it may be, hard or as a wish."""
    if angle:
        return {"within_deg": settings.within_deg} if settings.within_deg > 0 else {}
    table = {"within_mm": settings.within_mm} if settings.within_mm > 0 else {}
    return table | ({"sd_mm": settings.wish_mm} if settings.wish_mm > 0 else {})


def region(thing, head, world, units):
    """A box: by two corners where it lies along the axes of the world, else by its six sides."""
    size = thing.empty_display_size if thing.type == "EMPTY" else None
    corners = [world @ Vector(of) for of in box_corners(thing, size)]
    origin = {"point_mm": [0.0, 0.0, 0.0]}
    wish = {"sd_mm": thing.motion_sketch.wish_mm} if thing.motion_sketch.wish_mm > 0 else {}
    axes = [world.col[axis].to_3d() for axis in range(3)]
    if min(of.length for of in axes) <= 0:
        raise Refused(thing.name, "has no extent, expected a box: its scale is zero")
    if all(sum(abs(of) > ALONG * axis.length for of in axis) == 1 for axis in axes):
        low, high = ([units.mm * pick(of[axis] for of in corners) for axis in range(3)] for pick in (min, max))
        return [head | origin | {"position_within_mm": [low, high]} | wish]
    middle = sum(corners, Vector()) / len(corners)
    tables = []
    for axis in axes:
        normal = axis.normalized()
        reach = max(abs((of - middle).dot(normal)) for of in corners)
        for side in (1, -1):
            at = [units.mm * of for of in middle - side * reach * normal]
            tables.append(head | origin | {"position_mm": at, "normal": list(side * normal)} | wish)
    return tables


def box_corners(thing, size):
    """The corners of a box in its own axes: of an empty by its size, of a mesh by its bounds."""
    if size is not None:
        return [(x, y, z) for x in (-size, size) for y in (-size, size) for z in (-size, size)]
    return [tuple(of) for of in thing.bound_box]


def face(thing, head):
    """The first of the faces that may be up in the end."""
    settings = thing.motion_sketch
    faces = faces_of(settings.faces, thing.name)
    return head | {"face_up": faces[0], "labels": "free" if settings.free_labels else "fixed"}


def other_faces(things):
    """Of each goal of faces those after the first, by its name."""
    return {of.name: faces_of(of.motion_sketch.faces, of.name)[1:] for of in things if of.motion_sketch.goal == "FACES"}
