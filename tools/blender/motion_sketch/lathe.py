# SPDX-License-Identifier: GPL-3.0-or-later
"""Meshes that a lathe could make about their z axis: their profiles, filled or with a wall, as scenes have them. Plain numbers."""

import numpy as np

#: Fewest corners of a ring that counts as round, and how exactly rings are rings, of the largest side.
AROUND, EXACT = 12, 1e-4
#: How far the thickness of a wall may be off its median, as a share.
EVEN = 0.15


def revolution(points, polygons):
    """The shape of a mesh of revolution: `profile_mm`, perhaps `wall_mm`; None of what is none.

    `points`: (n, 3) millimetres; `polygons`: indices of corners of each face.
    """
    found = profile(points, polygons)
    if found is None:
        return None
    return filled(found) or walled(found)


def profile(points, polygons):
    """The outline from the axis to the axis, (n, 2) radii and heights; None where corners are not in rings."""
    size = float(np.ptp(points, axis=0).max())
    if size <= 0:
        return None
    flat = np.column_stack([np.hypot(points[:, 0], points[:, 1]), points[:, 2]])
    rings, ring_of = [], []
    for of in flat:
        near = next((at for at, known in enumerate(rings) if np.abs(known - of).max() < EXACT * size), len(rings))
        if near == len(rings):
            rings.append(of)
        ring_of.append(near)
        if len(rings) > 200:
            return None
    counts = np.bincount(ring_of)
    on_axis = [at for at, of in enumerate(rings) if of[0] < EXACT * size]
    around = {int(counts[at]) for at in range(len(rings)) if at not in on_axis}
    if len(around) != 1 or min(around) < AROUND or len(on_axis) != 2 or any(counts[at] != 1 for at in on_axis):
        return None
    return ordered(rings, neighbours(ring_of, polygons), on_axis)


def neighbours(ring_of, polygons):
    """Which rings are side by side on a face."""
    beside = {at: set() for at in set(ring_of)}
    for corners in polygons:
        for a, b in zip(corners, [*corners[1:], corners[0]]):
            one, other = ring_of[a], ring_of[b]
            if one != other:
                beside[one].add(other)
                beside[other].add(one)
    return beside


def ordered(rings, beside, on_axis):
    """The rings from one end on the axis to the other, the lower one first."""
    first, last = sorted(on_axis, key=lambda at: rings[at][1])
    way, before = [first], None
    while way[-1] != last:
        after = [of for of in beside[way[-1]] if of != before]
        if len(after) != 1 or after[0] in way:
            return None
        before = way[-1]
        way.append(after[0])
    return np.array([rings[at] for at in way]) if len(way) == len(rings) else None


def filled(outline):
    """A solid whose heights rise; the ends on the axis are left to the filling."""
    if (np.diff(outline[:, 1]) < -1e-9 * np.ptp(outline)).any():
        return None
    return {"kind": "revolution", "profile_mm": np.round(outline, 6).tolist()}


def walled(outline):
    """A cup or a hat: out along one side, back along the other, everywhere about as far from it."""
    if len(outline) % 2:
        return None
    half = len(outline) // 2
    for one, other in ((outline[:half], outline[half:][::-1]), (outline[half:][::-1], outline[:half])):
        # A wall is on the left of the profile as it is written.
        thick = lefts(one, other)
        if thick is not None and (thick > 0).all():
            wall = float(np.median(thick))
            if (np.abs(thick - wall) < EVEN * wall).all():
                return {"kind": "revolution", "profile_mm": np.round(one, 6).tolist(), "wall_mm": round(wall, 6)}
    return None


def lefts(one, other):
    """How far each side of a line is to the left of the same side of another, where these are parallel."""
    way, beside = np.diff(one, axis=0), np.diff(other, axis=0)
    lengths, others = np.linalg.norm(way, axis=1), np.linalg.norm(beside, axis=1)
    if min(lengths.min(), others.min()) <= 0:
        return None
    way, beside = way / lengths[:, None], beside / others[:, None]
    if ((way * beside).sum(axis=1) < 0.99).any():
        return None
    left = np.column_stack([-way[:, 1], way[:, 0]])
    return ((other[:-1] - one[:-1]) * left).sum(axis=1)
