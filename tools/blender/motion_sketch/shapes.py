# SPDX-License-Identifier: GPL-3.0-or-later
"""Shapes of meshes as scenes have them: by what Rigid Body says an object collides as. Millimetres, in the object's own axes."""

import os
import tempfile
import tomllib

import bmesh
import bpy
import numpy as np

from . import lathe
from .refusal import Refused

#: Most corners of a hull as it is; what has more is thinned as the program does it.
CORNERS = 32
#: How flat a mesh is that counts as a surface, of its largest side.
FLAT = 1e-5


def points_mm(thing, scale_mm):
    """The corners of a mesh with its modifiers, (n, 3)."""
    mesh = evaluated(thing)
    flat = np.empty(3 * len(mesh.vertices), dtype=np.float32)
    mesh.vertices.foreach_get("co", flat)
    if not len(flat):
        raise Refused(thing.name, "its mesh is empty, expected one with faces")
    # Single precision has no more digits.
    return np.round(flat.reshape(-1, 3).astype(float) * scale_mm, 6)


def evaluated(thing):
    """The mesh of an object with its modifiers; refused by name where it has none."""
    if thing.type != "MESH":
        raise Refused(thing.name, f"is a {thing.type.lower()}, expected a mesh: Object > Convert > Mesh")
    return thing.evaluated_get(bpy.context.evaluated_depsgraph_get()).data


def box(points):
    """Middle and sides."""
    low, high = points.min(axis=0), points.max(axis=0)
    return (low + high) / 2, high - low


#: What was made of meshes lately, by all that it is made of: the same is asked for whenever something is dragged.
_made = {}
MADE = 64


def shape_of(thing, scale_mm, mass_g):
    """What a scene says of an object's shape: the keys of a body, `shape` among them, with `mass_g`.

    `scale_mm`: millimetres of one unit of the mesh, of all axes or of each.
    """
    kind = thing.rigid_body.collision_shape
    if kind == "COMPOUND":
        raise Refused(thing.name, "collides as a compound, expected a shape of its own: Physics > Rigid Body > Collisions > Shape")
    points = points_mm(thing, scale_mm)
    mesh = evaluated(thing)
    corners = np.empty(len(mesh.loops), dtype=np.int32)
    mesh.loops.foreach_get("vertex_index", corners)
    of = (kind, mass_g, len(mesh.polygons), points.tobytes(), corners.tobytes())
    if of not in _made:
        if len(_made) >= MADE:
            _made.clear()
        _made[of] = made_of(thing, kind, points, scale_mm, mass_g)
    return dict(_made[of])


def made_of(thing, kind, points, scale_mm, mass_g):
    """The same, made anew."""
    middle, sides = box(points)
    plain = {"mass_g": mass_g}
    if kind in ("BOX", "SPHERE", "CAPSULE", "CYLINDER", "CONE"):
        if min(sides) <= 0:
            raise Refused(thing.name, f"its mesh is flat, expected a solid to collide as a {kind.lower()}")
        return plain | {"shape": simple(kind, middle, sides, radius(points, middle))}
    if kind == "MESH":
        turned = lathe.revolution(points, [of.vertices[:] for of in evaluated(thing).polygons])
        if turned is not None:
            return plain | {"shape": turned}
    if kind == "CONVEX_HULL":
        corners = hull_of(thing, points)
        if len(corners) <= CORNERS:
            return plain | {"shape": {"kind": "hull", "points_mm": corners.tolist()}}
    return of_program(thing, scale_mm, mass_g, kind == "CONVEX_HULL")


def radius(points, middle):
    """How far the mesh reaches from the z axis through its middle."""
    return float(np.linalg.norm((points - middle)[:, :2], axis=1).max())


def simple(kind, middle, sides, about_z):
    """A shape as its bounding box makes it; what is round is about z."""
    at = {"position_mm": middle.tolist()}
    match kind:
        case "BOX":
            return {"kind": "cuboid", "size_mm": sides.tolist()} | at
        case "SPHERE":
            return {"kind": "sphere", "radius_mm": float(max(sides)) / 2} | at
        case "CAPSULE":
            round_mm = min(about_z, float(sides[2]) / 2.001)
            return {"kind": "capsule", "radius_mm": round_mm, "length_mm": float(sides[2]) - 2 * round_mm} | at
        case "CYLINDER":
            return {"kind": "cylinder", "radius_mm": about_z, "length_mm": float(sides[2])} | at
        case _:
            # A cone's origin is a quarter of its height above its base.
            at = {"position_mm": (middle - [0, 0, sides[2] / 4]).tolist()}
            return {"kind": "cone", "radius_mm": about_z, "height_mm": float(sides[2])} | at


def hull_of(thing, points):
    """The corners of the convex hull."""
    work = bmesh.new()
    try:
        for point in points:
            work.verts.new(point)
        bmesh.ops.remove_doubles(work, verts=work.verts, dist=1e-6 * float(np.ptp(points)))
        made = bmesh.ops.convex_hull(work, input=work.verts)
        inside = {of for of in made["geom_interior"] if isinstance(of, bmesh.types.BMVert)}
        outside = [of.co[:] for of in work.verts if of not in inside and of.link_faces]
    finally:
        work.free()
    corners = np.array(outside)
    if len(corners) < 4 or np.linalg.matrix_rank(corners - corners[0], tol=FLAT * float(np.ptp(points))) < 3:
        raise Refused(thing.name, "its mesh is flat, expected a solid: give it thickness")
    return corners


def of_program(thing, scale_mm, mass_g, hull):
    """A body of a mesh as the program makes it: convex pieces, the corners by which it touches, and how its mass lies."""
    import enact_motion

    folder = tempfile.mkdtemp(prefix="motion_sketch")
    path = os.path.join(folder, "mesh.obj")
    try:
        write_obj(path, evaluated(thing), scale_mm)
        scene = enact_motion.Scene.new(path, mass_g=mass_g, unit="mm", hull=hull, stamps="physical")
    except ValueError as error:
        said = str(error).replace(path, "the mesh")
        raise Refused(thing.name, f"{said}; or let it collide as a Convex Hull: Physics > Rigid Body > Collisions") from None
    finally:
        if os.path.exists(path):
            os.remove(path)
        os.rmdir(folder)
    (body,) = tomllib.loads(scene.toml)["body"]
    kept = {"name", "restitution", "friction", "tracker", "topic"}
    return {key: value for key, value in body.items() if key not in kept}


def write_obj(path, mesh, scale_mm):
    """A mesh in its own axes, in millimetres."""
    scales = np.broadcast_to(scale_mm, 3)
    # What mirrors turns its faces inside out.
    step = 1 if np.prod(scales) > 0 else -1
    with open(path, "w", encoding="ascii") as file:
        for vertex in mesh.vertices:
            file.write("v {} {} {}\n".format(*(np.array(vertex.co, dtype=float) * scales)))
        for polygon in mesh.polygons:
            file.write("f " + " ".join(str(index + 1) for index in polygon.vertices[:][::step]) + "\n")


def flat_of(points):
    """Of a flat mesh its middle, the axes and sides of the rectangle around it, and its normal; None of what is not flat."""
    middle, sides = box(points)
    size = float(max(sides))
    thin = int(np.argmin(sides))
    if size <= 0 or sides[thin] > FLAT * size:
        return None
    first, second = (axis for axis in range(3) if axis != thin)
    return middle, (first, second), (float(sides[first]), float(sides[second])), thin
