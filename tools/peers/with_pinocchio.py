"""A mechanism as Pinocchio's model.

Every joint's frame is the link's side of it. A universal joint is two revolute ones, a free base a
translation and a spherical joint, each pair with a body without mass between: then Pinocchio's
coordinates, rates and tangents are those of the file but for their order.
"""

import numpy as np
import pinocchio as pin
from scipy.integrate import solve_ivp

from layout import depth_first, places

# Of the flight: relative, and absolute in units of lengths and rates of the mechanism.
TOLERANCE = 3e-14


def placed(pose):
    w, x, y, z = pose["orientation_wxyz"]
    return pin.SE3(pin.Quaternion(w, x, y, z).matrix(), np.array(pose["position_m"]))


def joints(kind, axes):
    """Pinocchio's joints, one after the other."""
    if kind == "free":
        return [pin.JointModelTranslation(), pin.JointModelSpherical()]
    if kind == "ball":
        return [pin.JointModelSpherical()]
    return [pin.JointModelRevoluteUnaligned(np.array(axis) / np.linalg.norm(axis)) for axis in axes]


class Peer:
    def __init__(self, given):
        self.given = given
        self.model = pin.Model()
        self.model.gravity = pin.Motion(np.array(given["gravity_m_s2"]), np.zeros(3))
        # Each link's joint, and the link's frame in the joint's.
        links = {}
        for index in depth_first(given["links"]):
            link = given["links"][index]
            joint = link["joint"]
            parent, place = (0, pin.SE3.Identity())
            if link["parent"] is not None:
                parent, place = links[link["parent"]]
            place = place * placed(joint["parent_from_joint"])
            frame = placed(joint["link_from_joint"]).inverse()
            if joint["kind"] == "free":
                place = frame = pin.SE3.Identity()
            for part, model in enumerate(joints(joint["kind"], joint["axes"])):
                parent = self.model.addJoint(parent, model, place, f"{index}.{part}")
                place = pin.SE3.Identity()
            own = pin.Inertia(link["mass_kg"], np.zeros(3), np.diag(link["moments_kg_m2"]))
            self.model.appendBodyToJoint(parent, own, frame)
            links[index] = (parent, frame)
        self.data = self.model.createData()
        own = places(given["links"])
        order = depth_first(given["links"])
        self.q_of = np.array([k for index in order for k in own[index][0]])
        self.u_of = np.array([k for index in order for k in own[index][1]])
        self.q = np.array(given["state"]["coordinates"])[self.q_of]
        self.u = np.array(given["state"]["rates"])[self.u_of]
        self.none = np.zeros(self.model.nv)
        assert (len(self.q), len(self.u)) == (self.model.nq, self.model.nv)

    def back(self, mine):
        """A vector of rates, or a matrix by and of such, in the file's order."""
        result = np.zeros_like(mine)
        result[np.ix_(*[self.u_of] * mine.ndim)] = mine
        return result

    def accelerations(self):
        return self.back(pin.aba(self.model, self.data, self.q, self.u, self.none))

    def derivatives(self):
        """By tangents of the coordinates and by rates: analytic, of inverse dynamics, with the mass
        matrix of composite inertias."""
        a = pin.aba(self.model, self.data, self.q, self.u, self.none).copy()
        pin.computeRNEADerivatives(self.model, self.data, self.q, self.u, a)
        by = [self.data.dtau_dq.copy(), self.data.dtau_dv.copy()]
        mass = np.triu(pin.crba(self.model, self.data, self.q))
        mass += np.triu(mass, 1).T
        return [self.back(-np.linalg.solve(mass, rows)) for rows in by]

    def energy(self):
        kinetic = pin.computeKineticEnergy(self.model, self.data, self.q, self.u)
        return kinetic + pin.computePotentialEnergy(self.model, self.data, self.q)

    def flight(self, duration_s):
        """Quaternions as points of four numbers, by SciPy's DOP853."""
        nq = self.model.nq
        balls = [
            (joint.idx_q, joint.idx_v)
            for joint in self.model.joints
            if joint.nq == 4
        ]
        pins = [
            (joint.idx_q + i, joint.idx_v + i)
            for joint in self.model.joints
            if joint.nq == joint.nv
            for i in range(joint.nq)
        ]
        to, of = np.array(pins, dtype=int).reshape(-1, 2).T

        def slope(_, y):
            q, u = y[:nq].copy(), y[nq:]
            rate = np.zeros(nq)
            rate[to] = u[of]
            for at, column in balls:
                v, w, omega = q[at : at + 3], q[at + 3], u[column : column + 3]
                rate[at : at + 3] = 0.5 * (w * omega + np.cross(v, omega))
                rate[at + 3] = -0.5 * (v @ omega)
                q[at : at + 4] /= np.linalg.norm(q[at : at + 4])
            return np.concatenate([rate, pin.aba(self.model, self.data, q, u, self.none)])

        start = np.concatenate([self.q, self.u])
        units = [self.given["coordinate_units"], self.given["rate_units"]]
        scale = np.concatenate([np.array(u)[of] for u, of in zip(units, (self.q_of, self.u_of))])
        end = solve_ivp(
            slope, (0, duration_s), start, "DOP853", rtol=TOLERANCE, atol=TOLERANCE * scale
        )
        assert end.success, end.message
        y = end.y[:, -1]
        for at, _ in balls:
            y[at : at + 4] /= np.linalg.norm(y[at : at + 4])
        q = np.zeros(nq)
        q[self.q_of] = y[:nq]
        return {"coordinates": q, "rates": self.back(y[nq:])}


class Articulated(Peer):
    """The same with the derivatives of Pinocchio's articulated-body algorithm."""

    def derivatives(self):
        pin.computeABADerivatives(self.model, self.data, self.q, self.u, self.none)
        return [self.back(self.data.ddq_dq), self.back(self.data.ddq_dv)]

    def flight(self, _):
        return None
