"""A scene that `enact scene from-urdf` wrote, against Pinocchio's own reading of the URDF file.

    .venv/bin/python agree_urdf.py ROBOT.urdf SCENE.toml

Places of all links with mass and the mass matrix at random angles: Pinocchio reads the description with urdfdom; the
scene's tables are read here, as `docs/joints.md` says what they mean. For trees of pins and universal joints, free or
clamped. Prints the greatest differences, and fails beyond 1e-9.
"""

import sys
import tomllib

import numpy as np
import pinocchio as pin

TOLERANCE = 1e-9


def turn(wxyz):
    w, x, y, z = wxyz
    return pin.Quaternion(w, x, y, z).normalized().toRotationMatrix()


def pose(position_mm=(0, 0, 0), orientation_wxyz=(1, 0, 0, 0)):
    return pin.SE3(turn(orientation_wxyz), np.array(position_mm, dtype=float) / 1e3)


class Scene:
    """Bodies in an order in which parents come first."""

    def __init__(self, scene):
        self.bodies = {body["name"]: body for body in scene["body"]}
        self.joints = {joint["child"]: joint for joint in scene.get("joint", [])}
        self.order = []
        while len(self.order) < len(self.bodies):
            for name in self.bodies:
                parent = self.joints.get(name, {}).get("parent")
                if name not in self.order and (parent is None or parent in self.order):
                    self.order.append(name)

    def turns(self, name):
        """Names of the URDF's joints and axes, of the joint from which a body hangs."""
        joint = self.joints[name]
        if joint["kind"] == "fixed":
            return []
        if joint["kind"] == "ball":
            sys.exit(f"{joint['name']}: balls are not compared")
        axes = [joint["axis"]] if joint["kind"] == "pin" else joint["axes"]
        axes = [np.array(axis, dtype=float) / np.linalg.norm(axis) for axis in axes]
        return list(zip(joint["name"].split(" "), axes, strict=True))

    def motion(self, angles, base):
        """World from body, and per joint its axis and place in the world, of all that each body hangs on; the
        first one's link is where `base` says."""
        poses, hung = {}, {}
        for name in self.order:
            joint = self.joints.get(name)
            if joint is None:
                poses[name], hung[name] = base(name) * self.link(name).inverse(), []
                continue
            parent = joint.get("parent")
            above = poses[parent] if parent else pin.SE3.Identity()
            at = above * pose(joint["parent_at_mm"])
            own = []
            for urdf_joint, axis in self.turns(name):
                own.append((urdf_joint, at.rotation @ axis, at.translation))
                by = pin.AngleAxis(angles[urdf_joint], axis).toRotationMatrix()
                at = at * pin.SE3(by, np.zeros(3))
            at = at * pin.SE3(turn(joint["child_orientation_wxyz"]), np.zeros(3))
            poses[name] = at * pose([-x for x in joint["child_at_mm"]])
            hung[name] = (hung[parent] if parent else []) + own
        return poses, hung

    def link(self, name):
        """Where the link's frame is in the body's axes."""
        return pose(**self.bodies[name]["tracker"])


def compare(urdf_file, scene_file, random):
    with open(scene_file, "rb") as file:
        scene = Scene(tomllib.load(file))
    is_free = any(name not in scene.joints for name in scene.order)
    root = pin.JointModelFreeFlyer() if is_free else None
    model = pin.buildModelFromUrdf(urdf_file, root) if root else pin.buildModelFromUrdf(urdf_file)
    data = model.createData()
    q = pin.neutral(model)
    v = np.zeros(model.nv)
    angles, columns = {}, {}
    for index in range(1, model.njoints):
        joint, name = model.joints[index], model.names[index]
        if joint.nv == 1:
            angles[name] = random.uniform(-3, 3)
            columns[name] = joint.idx_v
            unbounded = joint.nq == 2
            values = [np.cos(angles[name]), np.sin(angles[name])] if unbounded else [angles[name]]
            q[joint.idx_q : joint.idx_q + joint.nq] = values
    base = pin.SE3.Identity()
    if is_free:
        base = pin.SE3.Random()
        q[:7] = pin.SE3ToXYZQUAT(base)
    pin.forwardKinematics(model, data, q)
    pin.updateFramePlacements(model, data)
    mass = pin.crba(model, data, q)
    mass = np.triu(mass) + np.triu(mass, 1).T

    def frame(name):
        return data.oMf[model.getFrameId(name, pin.FrameType.BODY)]

    poses, hung = scene.motion(angles, frame)
    off, own = 0.0, np.zeros_like(mass)
    for name in scene.order:
        body = scene.bodies[name]
        found = (poses[name] * scene.link(name)).homogeneous
        off = max(off, np.abs(found - frame(name).homogeneous).max())
        linear, angular = np.zeros((3, model.nv)), np.zeros((3, model.nv))
        for joint, axis, at in hung[name]:
            column = columns[joint]
            angular[:, column] = axis
            linear[:, column] = np.cross(axis, poses[name].translation - at)
        if is_free:
            # Pinocchio's base has its velocities in its own axes.
            arm = poses[name].translation - base.translation
            linear[:, :3], angular[:, 3:6] = base.rotation, base.rotation
            linear[:, 3:6] = -pin.skew(arm) @ base.rotation
        angular = poses[name].rotation.T @ angular
        own += body["mass_kg"] * linear.T @ linear
        own += angular.T @ np.diag(body["moments_kg_m2"]) @ angular
    return off, np.abs(own - mass).max() / np.abs(mass).max()


def main():
    random = np.random.default_rng(1)
    pin.seed(1)
    differences = [compare(*sys.argv[1:3], random) for _ in range(20)]
    places, mass = np.max(differences, axis=0)
    print(f"pinocchio {pin.__version__}: places {places:.1e}, mass matrix {mass:.1e} of its greatest entry")
    sys.exit(0 if max(places, mass) < TOLERANCE else 1)


if __name__ == "__main__":
    main()
