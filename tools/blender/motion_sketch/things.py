# SPDX-License-Identifier: GPL-3.0-or-later
"""What moves and what stands: objects with Rigid Body settings, as a scene file has them."""

from dataclasses import dataclass, field

import numpy as np
from mathutils.bvhtree import BVHTree

from . import poses, shapes
from .refusal import Refused

#: How far apart two places of one object are if it moves, in units.
STILL = 1e-6
#: So many corners of a mesh tell how far it is from another one.
CORNERS = 1000


@dataclass
class Body:
    """Something that flies, or that moves as it is animated and is hit."""

    thing: object
    table: dict
    held: bool = False
    #: Frames of the samples, places in metres, quaternions w x y z.
    frames: list = field(default_factory=list)
    position: np.ndarray = None
    quaternion: np.ndarray = None

    @property
    def name(self):
        return self.table["name"]


@dataclass
class Standing:
    """A surface or an obstacle."""

    thing: object
    table: dict
    is_flat: bool

    @property
    def name(self):
        return self.table["name"]


def rigid_things(scene):
    """The objects of the scene's rigid body world; none where it has no such world."""
    world = scene.rigidbody_world
    things = world.collection.objects if world and world.collection else ()
    inside = set(scene.objects)
    return [of for of in things if of in inside and of.rigid_body and not of.hide_viewport]


def check_body(thing):
    """Refuses by name what cannot fly."""
    if thing.rigid_body is None:
        raise Refused(thing.name, "has no Rigid Body, expected one of type Active: Make Body, or Physics > Rigid Body")
    if thing.rigid_body.type != "ACTIVE":
        raise Refused(thing.name, "its Rigid Body is Passive, expected Active: Physics > Rigid Body > Type")
    if thing.library is not None and thing.override_library is None:
        raise Refused(thing.name, "is linked from another file, expected a local one: Object > Library Override > Make")
    if thing.rigid_body_constraint is not None:
        raise Refused(thing.name, "has a Rigid Body Constraint; joints are not read, expected bodies by themselves")
    if any(abs(scale - 1) > poses.NEARLY for scale in thing.scale):
        scale = ", ".join(f"{of:g}" for of in thing.scale)
        raise Refused(thing.name, f"its scale is {scale}, expected 1: Object > Apply > Scale")


def check_joints(scene, things):
    """Refuses by name what a constraint of the physics ties to something."""
    world = scene.rigidbody_world
    holders = world.constraints.objects if world and world.constraints else ()
    for holder in holders:
        joint = holder.rigid_body_constraint
        for tied in (joint.object1, joint.object2) if joint and joint.enabled else ():
            if tied in things:
                what = f"ties {tied.name!r} ({joint.type.lower()}); joints are not read, expected bodies by themselves"
                raise Refused(holder.name, what)


def body(thing, units, scale):
    """The table of what flies; its frame is the object's, without a scale."""
    settings = thing.rigid_body
    table = shapes.shape_of(thing, units.mm * scale, 1e3 * settings.mass)
    return Body(thing, {"name": thing.name} | table)


def held(thing, units, scale):
    """The table of a passive body that is animated."""
    table = shapes.shape_of(thing, units.mm * scale, 1.0)
    # Nothing deflects it: it has no mass.
    without = {"mass_g", "centre_mm", "inertia_kg_m2"}
    table = {key: value for key, value in table.items() if key not in without}
    return Body(thing, {"name": thing.name, "held": True} | table, held=True)


def is_animated(moved, frames):
    """Whether something that is passive moves between the first frame and the last."""
    if not isinstance(moved, poses.Stepped) and not any(of.is_moving for of in (moved.own, *(c for c, _ in moved.parents))):
        return False
    at = [moved.world(frame) for frame in (frames[0], frames[len(frames) // 2], frames[-1])]
    return any(max(abs(a - b) for row, other in zip(at[0], of) for a, b in zip(row, other)) > STILL for of in at[1:])


def standing(thing, world, units, ways_m, reach_m):
    """A surface or an obstacle where it stands. `ways_m`: where bodies pass, (n, 3); `reach_m`: how far they reach."""
    place, turn, scale = world.decompose()
    kind = thing.rigid_body.collision_shape
    if not poses.is_unskewed(unscaled(world, scale), 1.0):
        raise Refused(thing.name, "a parent skews it, expected none: Object > Apply > Scale of the parent")
    scales_mm = np.array(scale) * units.mm
    points = shapes.points_mm(thing, scales_mm)
    flat = shapes.flat_of(points)
    if flat is None:
        table = shapes.shape_of(thing, scales_mm, 1000.0)
        if "shape" not in table and "part" not in table:
            raise Refused(thing.name, "has no shape to collide with")
        where = {"position_mm": [units.mm * of for of in place], "orientation_wxyz": list(turn)}
        return Standing(thing, {"name": thing.name, "shape": table["shape"]} | where, False)
    if kind == "MESH" and len(points) > 4 and not is_rectangle(points, flat):
        raise Refused(thing.name, "is flat and no rectangle, expected a rectangle or a solid: give it thickness")
    return Standing(thing, {"name": thing.name} | surface(flat, place, turn, units, ways_m, reach_m), True)


def unscaled(world, scale):
    """A matrix with the lengths of its axes taken off."""
    of = world.copy()
    for axis in range(3):
        of.col[axis] /= scale[axis]
    return of


def is_rectangle(points, flat):
    """Whether all corners of the rectangle around a flat mesh are its own."""
    middle, (first, second), (along, across), _ = flat
    off = points - middle
    corners = [(a, b) for a in (-along / 2, along / 2) for b in (-across / 2, across / 2)]
    near = 1e-3 * max(along, across)
    return all((np.abs(off[:, [first, second]] - of).max(axis=1) < near).any() for of in corners)


def surface(flat, place, turn, units, ways_m, reach_m):
    """A plane; a board where bodies come near its border."""
    middle, (first, second), sides, thin = flat
    axes = np.array(turn.to_matrix()).T
    at_mm = units.mm * np.array(place) + middle @ axes
    normal = axes[thin]
    off_mm = 1e3 * ways_m - at_mm
    # It is solid on the side where nothing is.
    if len(off_mm) and off_mm[0] @ normal < 0:
        normal = -normal
    table = {"point_mm": at_mm.tolist(), "normal": normal.tolist()}
    along, across = np.abs(off_mm @ axes[first]), np.abs(off_mm @ axes[second])
    margin = 1e3 * reach_m
    if len(off_mm) and along.max() + margin < sides[0] / 2 and across.max() + margin < sides[1] / 2:
        return table
    return table | {"along": axes[first].tolist(), "size_mm": list(sides)}


def reach_m(thing, units, scale):
    """How far a body reaches from its origin, metres."""
    return float(np.linalg.norm(shapes.points_mm(thing, units.metre * scale), axis=1).max())


class Near:
    """How far a body is from another thing, by their meshes."""

    def __init__(self, thing):
        mesh = shapes.evaluated(thing)
        corners = [vertex.co.copy() for vertex in mesh.vertices]
        faces = [polygon.vertices[:] for polygon in mesh.polygons]
        self.tree = BVHTree.FromPolygons(corners, faces)
        # Of fine meshes some corners tell it.
        self.points = corners[:: 1 + len(corners) // CORNERS]

    def distance(self, other, this_from_other):
        """From the corners of the one to the surface of the other and back, units of the world."""
        back = this_from_other.inverted()
        there = (self.tree.find_nearest(this_from_other @ point)[3] for point in other.points)
        here = (other.tree.find_nearest(back @ point)[3] for point in self.points)
        return min((of for of in (*there, *here) if of is not None), default=float("inf"))
