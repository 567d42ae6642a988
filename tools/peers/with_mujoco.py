"""A mechanism as MuJoCo's model.

MuJoCo has no massless bodies and refuses moments below 1e-15 kg m², so all masses are scaled to one
kilogram together. It has no derivatives but differences; of its accelerations better ones are made here.
"""

import mujoco
import numpy as np

from layout import depth_first, places

# Of differences of order eight: step [rad], weights of ±1, ±2, ±3, ±4 steps.
STEP = 5e-3
WEIGHTS = [4 / 5, -1 / 5, 4 / 105, -1 / 280]
# Steps of a flight.
STEPS = 20_000


def numbers(values):
    return " ".join(repr(float(value)) for value in values)


def turned(q, v):
    """A vector turned by a quaternion (w, x, y, z)."""
    result = np.zeros(3)
    mujoco.mju_rotVecQuat(result, np.array(v, dtype=float), np.array(q, dtype=float))
    return result


def times(a, b):
    q = np.zeros(4)
    mujoco.mju_mulQuat(q, np.array(a[1], dtype=float), np.array(b[1], dtype=float))
    return a[0] + turned(a[1], b[0]), q


def inverse(a):
    q = np.array(a[1], dtype=float) * [1, -1, -1, -1]
    return -turned(q, a[0]), q


def placed(pose):
    return np.array(pose["position_m"]), np.array(pose["orientation_wxyz"])


class Peer:
    def __init__(self, given):
        self.given = given
        self.scale = 1 / sum(link["mass_kg"] for link in given["links"])
        children = {}
        for index, link in enumerate(given["links"]):
            children.setdefault(link["parent"], []).append(index)
        whole = (np.zeros(3), np.array([1.0, 0, 0, 0]))
        bodies = "".join(self.body(children, index, whole) for index in children[None])
        text = f"""<mujoco>
            <compiler angle="radian" inertiafromgeom="false"/>
            <option gravity="{numbers(given["gravity_m_s2"])}" integrator="RK4" timestep="1e-3">
              <flag constraint="disable" contact="disable" energy="enable" eulerdamp="disable"/>
            </option>
            <worldbody>{bodies}</worldbody></mujoco>"""
        self.model = mujoco.MjModel.from_xml_string(text)
        self.data = mujoco.MjData(self.model)
        # MuJoCo's numbers in the file's order; its quaternions have the scalar first.
        own = places(given["links"])
        order = depth_first(given["links"])
        self.q_of = np.array([k for index in order for k in self.reordered(index, own[index][0])])
        self.u_of = np.array([k for index in order for k in own[index][1]])
        self.set(*self.given_state())

    def body(self, children, index, parent):
        """A body's frame is the link's side of its joint."""
        link = self.given["links"][index]
        joint = link["joint"]
        place = times(parent, placed(joint["parent_from_joint"]))
        frame = inverse(placed(joint["link_from_joint"]))
        if joint["kind"] == "free":
            place = frame = (np.zeros(3), np.array([1.0, 0, 0, 0]))
            held = "<freejoint/>"
        elif joint["kind"] == "ball":
            held = '<joint type="ball"/>'
        else:
            axes = joint["axes"]
            held = "".join(f'<joint type="hinge" axis="{numbers(axis)}"/>' for axis in axes)
        inner = "".join(self.body(children, child, frame) for child in children.get(index, []))
        mass, moments = link["mass_kg"] * self.scale, np.array(link["moments_kg_m2"]) * self.scale
        return f"""<body pos="{numbers(place[0])}" quat="{numbers(place[1])}">{held}
            <inertial pos="{numbers(frame[0])}" quat="{numbers(frame[1])}" mass="{mass!r}"
              diaginertia="{numbers(moments)}"/>{inner}</body>"""

    def reordered(self, index, q):
        if self.given["links"][index]["joint"]["kind"] not in ("free", "ball"):
            return q
        return [*q[:-4], q[-1], *q[-4:-1]]

    def given_state(self):
        state = self.given["state"]
        q, u = np.array(state["coordinates"]), np.array(state["rates"])
        return q[self.q_of], u[self.u_of]

    def set(self, q, u):
        self.data.qpos[:], self.data.qvel[:] = q, u
        mujoco.mj_forward(self.model, self.data)
        return self.data.qacc.copy()

    def accelerations(self):
        return self.back(self.set(*self.given_state()))

    def back(self, mine):
        """Rows in the file's order."""
        result = np.zeros_like(mine)
        result[self.u_of] = mine
        return result

    def derivatives(self):
        """By tangents of the coordinates: differences of order eight. By rates: differences, exact
        but for rounding since accelerations are of second degree in them."""
        q, u = self.given_state()
        nv = self.model.nv
        units = np.array(self.given["tangent_units"])[self.u_of]
        rate_units = np.array(self.given["rate_units"])[self.u_of]
        by_q, by_u = np.zeros((nv, nv)), np.zeros((nv, nv))
        for column in range(nv):
            direction = np.zeros(nv)
            direction[column] = step = STEP * units[column]
            for count, weight in enumerate(WEIGHTS, 1):
                for sign in (1, -1):
                    moved = q.copy()
                    mujoco.mj_integratePos(self.model, moved, direction, sign * count)
                    by_q[:, column] += sign * weight / step * self.set(moved, u)
            ahead = np.zeros(nv)
            ahead[column] = step = rate_units[column]
            by_u[:, column] = (self.set(q, u + ahead) - self.set(q, u - ahead)) / (2 * step)
        result = np.zeros((2, nv, nv))
        for to, of in zip(result, (by_q, by_u)):
            to[np.ix_(self.u_of, self.u_of)] = of
        return result

    def energy(self):
        self.set(*self.given_state())
        return self.data.energy.sum() / self.scale

    def flight(self, duration_s):
        """By MuJoCo's own integrator."""
        mujoco.mj_resetData(self.model, self.data)
        self.model.opt.timestep = duration_s / STEPS
        self.set(*self.given_state())
        mujoco.mj_step(self.model, self.data, STEPS)
        q, u = np.zeros(len(self.q_of)), np.zeros(len(self.u_of))
        q[self.q_of], u[self.u_of] = self.data.qpos, self.data.qvel
        return {"coordinates": q, "rates": u}
