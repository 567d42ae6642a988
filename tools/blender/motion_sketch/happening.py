# SPDX-License-Identifier: GPL-3.0-or-later
"""What happens at a marker: whom it is of, what is hit, and how that bounces."""

from . import markers, things
from .refusal import Refused

#: Restitution and friction of what Rigid Body says nothing of.
UNSET = 0.0


def event(of, bodies, stands, moved, frames):
    """What a scene says of a marker: whom it is of, and what is nearest then."""
    if of.kind not in ("bounce", "through"):
        return markers.table(of, None, None, None, {})
    flies = [each for each in bodies if not each.held]
    named = [each for each in flies if each.name in of.names]
    body = named[0] if named else flies[0] if len(flies) == 1 else None
    where = f"marker {of.kind!r} at frame {of.frame:g}"
    if body is None:
        raise Refused(where, f"of which of {', '.join(each.name for each in flies)}? expected a name, as in '{of.kind}: {flies[0].name}'")
    known = {each.name: each for each in (*bodies, *stands)}
    unknown = [name for name in of.names if name not in known]
    if unknown:
        raise Refused(where, f"names {unknown[0]!r}, expected a rigid body of the scene: {', '.join(known)}")
    if of.kind == "through":
        return markers.table(of, body.name, None, None, {})
    other = next((known[name] for name in of.names if name != body.name), None)
    other = other or nearest(of.frame, body, [*(each for each in bodies if each is not body), *stands], moved)
    if other is None:
        raise Refused(where, "nothing is there to bounce off, expected a passive Rigid Body: Physics > Rigid Body > Passive")
    is_body = isinstance(other, things.Body)
    surface = None if is_body or not other.is_flat else flat_surface(other, stands)
    return markers.table(of, body.name, other.name if is_body else None, surface, contact(body, other))


def flat_surface(of, stands):
    """A surface by name where no edge of it may be meant."""
    return None if "size_mm" in of.table else of.name


def nearest(frame, body, others, moved):
    """What is nearest to a body at a frame, by their meshes."""
    if len(others) < 2:
        return others[0] if others else None
    own, world = things.Near(body.thing), moved[body.name].world(frame)

    def away(other):
        at = moved[other.name].world(frame) if other.name in moved else other.thing.matrix_world
        return own.distance(things.Near(other.thing), world.inverted() @ at)

    return min(others, key=away)


def contact(body, other):
    """How two things bounce: as Rigid Body multiplies them; what a surface leaves at zero is not told by it."""
    a, b = body.thing.rigid_body, other.thing.rigid_body
    of = {name: x * (1.0 if y == UNSET else y) for name, x, y in (
        ("restitution", a.restitution, b.restitution), ("friction", a.friction, b.friction))}
    return {name: round(min(value, 1.0) if name == "restitution" else value, 7) for name, value in of.items()}
