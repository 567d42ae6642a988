# SPDX-License-Identifier: GPL-3.0-or-later
"""Where an object is at any time: by its curves and its parents', or, where more than curves moves a parent, frame by frame."""

from mathutils import Euler, Matrix, Quaternion

from . import channels
from .refusal import Refused

#: What a sum of rounding errors makes of a scale of one.
NEARLY = 1e-5


def moved_by_more(thing):
    """What moves an object besides the curves of its action, in words; None where nothing does."""
    for constraint in thing.constraints:
        if not constraint.mute and constraint.influence > 0:
            return f"the constraint {constraint.name!r}"
    data = thing.animation_data
    if data is None:
        return None
    for driver in data.drivers:
        if driver.data_path.split(".")[-1] in ("location", "scale") or "rotation" in driver.data_path:
            return f"a driver of {driver.data_path}"
    if data.use_nla and any(not track.mute and len(track.strips) for track in data.nla_tracks):
        return "strips in the Nonlinear Animation editor"
    return None


class Channels:
    """An object's curves, looked up once: its basis at any frame."""

    def __init__(self, thing):
        self.thing = thing
        self.by_path = {}
        for curve in channels.curves_of(thing.animation_data):
            if not curve.mute:
                self.by_path[curve.data_path, curve.array_index] = curve

    @property
    def is_moving(self):
        """Whether any curve moves it."""
        paths = ("location", "scale", "rotation_euler", "rotation_quaternion", "rotation_axis_angle")
        return any(path in paths for path, _ in self.by_path)

    def _values(self, path, frame, count):
        still = getattr(self.thing, path)
        curves = (self.by_path.get((path, index)) for index in range(count))
        return [curve.evaluate(frame) if curve else still[index] for index, curve in enumerate(curves)]

    def rotation(self, frame):
        """Its own rotation, a quaternion of unit length."""
        mode = self.thing.rotation_mode
        if mode == "QUATERNION":
            of = Quaternion(self._values("rotation_quaternion", frame, 4))
        elif mode == "AXIS_ANGLE":
            angle, *axis = self._values("rotation_axis_angle", frame, 4)
            of = Quaternion(axis, angle)
        else:
            of = Euler(self._values("rotation_euler", frame, 3), mode).to_quaternion()
        of.normalize()
        return of

    def basis(self, frame):
        """What its own channels make of it."""
        return Matrix.LocRotScale(
            self._values("location", frame, 3), self.rotation(frame), self._values("scale", frame, 3)
        )

    def frames(self):
        """The frames of its keys, in order."""
        return sorted({point.co[0] for curve in self.by_path.values() for point in curve.keyframe_points})


class Moved:
    """An object with its parents, of all of whom curves alone tell where they are."""

    def __init__(self, thing):
        self.own = Channels(thing)
        self.parents = []
        child = thing
        while child.parent is not None:
            self.parents.append((Channels(child.parent), child.matrix_parent_inverse.copy()))
            child = child.parent

    def above(self, frame):
        """World from the space in which the object's own channels are."""
        world = Matrix()
        for parent, inverse in reversed(self.parents):
            world = world @ parent.basis(frame) @ inverse
        return world

    def world(self, frame):
        """World from object."""
        return self.above(frame) @ self.own.basis(frame)


class Stepped:
    """The same where a parent is moved by more than curves: the scene goes to each frame. Only between redraws."""

    def __init__(self, scene, thing):
        self.scene = scene
        self.own = Channels(thing)
        self.known = {}

    def look(self, frames):
        """Looks at all frames at once; the scene is left at the frame where it was."""
        scene, parent = self.scene, self.own.thing.parent
        inverse = self.own.thing.matrix_parent_inverse
        whole, part = scene.frame_current, scene.frame_subframe
        try:
            for frame in frames:
                first = int(frame // 1)
                scene.frame_set(first, subframe=frame - first)
                self.known[frame] = parent_matrix(self.own.thing, parent) @ inverse
        finally:
            scene.frame_set(whole, subframe=part)

    def above(self, frame):
        if frame not in self.known:
            self.look([frame])
        return self.known[frame]

    def world(self, frame):
        return self.above(frame) @ self.own.basis(frame)


def parent_matrix(thing, parent):
    """World from what an object hangs from, as it is now."""
    if thing.parent_type == "BONE":
        bone = parent.pose.bones.get(thing.parent_bone)
        if bone is None:
            raise Refused(thing.name, f"its parent has no bone {thing.parent_bone!r}, expected one: Object > Parent")
        tail = Matrix.Translation((0, bone.length, 0))
        return parent.matrix_world @ bone.matrix @ tail
    return parent.matrix_world.copy()


def moved(scene, thing):
    """How an object moves by its curves and its parents."""
    if has_deltas(thing):
        raise Refused(thing.name, "has delta transforms, expected none: zero them in Object > Delta Transform")
    child, plain = thing, True
    while child.parent is not None:
        if child.parent_type not in ("OBJECT", "BONE"):
            raise Refused(thing.name, f"its parent is a {child.parent_type.lower()}, expected an object or a bone")
        plain &= child.parent_type == "OBJECT" and moved_by_more(child.parent) is None and not has_deltas(child.parent)
        child = child.parent
    return Moved(thing) if plain else Stepped(scene, thing)


def has_deltas(thing):
    """Whether an object has transforms besides its channels."""
    quaternion = Quaternion(thing.delta_rotation_quaternion)
    turned = quaternion.rotation_difference(Quaternion()).angle > NEARLY
    return turned or any(thing.delta_location) or any(thing.delta_rotation_euler) or any(s != 1 for s in thing.delta_scale)


def rigid(name, world):
    """Place, quaternion and the one scale of a matrix; refused by name where it shears, mirrors or has several scales."""
    place, turn, scale = world.decompose()
    least, most = min(scale), max(scale)
    if least <= 0:
        raise Refused(name, "is mirrored, expected a scale of 1: Object > Apply > Scale")
    if most - least > NEARLY * most or not is_unskewed(world, most):
        raise Refused(name, "a parent is scaled unevenly, expected the same scale along all axes: Object > Apply > Scale of it")
    return place, turn, most


def is_unskewed(world, scale):
    """Whether the axes of a matrix are at right angles."""
    x, y, z = (world.col[axis].to_3d() / scale for axis in range(3))
    return max(abs(x.dot(y)), abs(y.dot(z)), abs(z.dot(x))) < 10 * NEARLY
