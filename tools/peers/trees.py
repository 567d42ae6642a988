"""Equations of motion of a tree of rigid bodies as CasADi expressions, from the links of a mechanism file.

By Jourdain's principle: for every virtual motion `w` of the joints that they allow, the power of gravity
and of what is left of each link's inertia vanishes,

    S(x, a, w) = sum_i  m v_i(w) . (g - dv_i/dt) - Omega_i(w) . (I dOmega_i/dt + Omega_i x I Omega_i) = 0,

with velocities `v`, `Omega` linear in the rates. `dS/dw = Q(x) - M(x) a` gives the accelerations `a`, and all
derivatives follow from `S`. No recursion over bodies and no inertia of several: another way than enact's.
"""

import casadi as ca

from layout import counts, places


def product(a, b):
    """Of quaternions (x, y, z, w)."""
    vector = a[3] * b[:3] + b[3] * a[:3] + ca.cross(a[:3], b[:3])
    return ca.vertcat(vector, a[3] * b[3] - ca.dot(a[:3], b[:3]))


def conjugate(q):
    return ca.vertcat(-q[:3], q[3])


def about(axis, angle):
    return ca.vertcat(ca.sin(angle / 2) * axis, ca.cos(angle / 2))


def matrix(q):
    """Of a quaternion of any length."""
    cross = ca.skew(q[:3])
    return ca.SX.eye(3) + 2 / ca.dot(q, q) * (q[3] * cross + cross @ cross)


def matrix_about(axis, angle):
    cross = ca.skew(axis)
    return ca.SX.eye(3) + ca.sin(angle) * cross + (1 - ca.cos(angle)) * (cross @ cross)


def xyzw(wxyz):
    return ca.vertcat(*wxyz[1:], wxyz[0])


class Link:
    """How a link is turned, as quaternion and as matrix, where its centre is in the world and its `velocity`
    there, and its `spin` in its own axes."""

    def __init__(self, turn, matrix, place, velocity, spin):
        self.turn, self.matrix, self.place = turn, matrix, place
        self.velocity, self.spin = velocity, spin

    def at(self, point):
        """Where a point of it is in the world."""
        return self.place + self.matrix @ ca.DM(point)


class Tree:
    """`x`: coordinates, then rates, as in the file."""

    def __init__(self, links, gravity):
        self.links, self.places = links, places(links)
        self.nq = sum(counts(link)[0] for link in links)
        self.nv = sum(counts(link)[1] for link in links)
        self.nx = self.nq + self.nv
        self.q, self.u = ca.SX.sym("q", self.nq), ca.SX.sym("u", self.nv)
        self.x, self.a = ca.vertcat(self.q, self.u), ca.SX.sym("a", self.nv)
        self.w = ca.SX.sym("w", self.nv)
        self.bodies = self.moved(self.u)
        self.q_rate = self.coordinate_rate()
        self.power = self.virtual_power(ca.DM(gravity))
        self.rest = ca.gradient(self.power, self.w)
        self.mass = -ca.jacobian(self.rest, self.a)
        # Positions of a free base are lengths; all else are angles.
        self.shift = 3 if links[0]["joint"]["kind"] == "free" else 0

    def quaternions(self):
        """First coordinates of the quaternions."""
        first = {"free": 3, "ball": 0}
        kinds = [link["joint"]["kind"] for link in self.links]
        return [own[0][first[kind]] for kind, own in zip(kinds, self.places) if kind in first]

    def moved(self, u):
        """Every link where `q` has it, moving as `u` says."""
        bodies = []
        for link, (own_q, own_u) in zip(self.links, self.places):
            joint, parent = link["joint"], link["parent"]
            q, rate = self.q[own_q], u[own_u]
            if joint["kind"] == "free":
                bodies.append(Link(q[3:], matrix(q[3:]), q[:3], rate[:3], rate[3:]))
                continue
            if parent is None:
                turn, turned = ca.DM([0, 0, 0, 1]), ca.SX.eye(3)
                place, velocity, spin = ca.DM.zeros(3), ca.DM.zeros(3), ca.DM.zeros(3)
            else:
                body = bodies[parent]
                turn, turned = body.turn, body.matrix
                place, velocity, spin = body.place, body.velocity, turned @ body.spin
            to_joint, to_link = joint["parent_from_joint"], joint["link_from_joint"]
            lever = turned @ ca.DM(to_joint["position_m"])
            place, velocity = place + lever, velocity + ca.cross(spin, lever)
            fixed = xyzw(to_joint["orientation_wxyz"])
            turn, turned = product(turn, fixed), turned @ matrix(fixed)
            if joint["kind"] == "ball":
                turn, turned = product(turn, q), turned @ matrix(q)
                spin = spin + turned @ rate
            for axis, angle, speed in zip(joint["axes"], ca.vertsplit(q), ca.vertsplit(rate)):
                axis = ca.DM(axis) / ca.norm_2(ca.DM(axis))
                spin = spin + turned @ axis * speed
                turn, turned = product(turn, about(axis, angle)), turned @ matrix_about(axis, angle)
            fixed = conjugate(xyzw(to_link["orientation_wxyz"]))
            turn, turned = product(turn, fixed), turned @ matrix(fixed)
            lever = -turned @ ca.DM(to_link["position_m"])
            place, velocity = place + lever, velocity + ca.cross(spin, lever)
            bodies.append(Link(turn, turned, place, velocity, turned.T @ spin))
        return bodies

    def coordinate_rate(self):
        rates = []
        for link, (own_q, own_u) in zip(self.links, self.places):
            q, rate = self.q[own_q], self.u[own_u]
            if link["joint"]["kind"] in ("free", "ball"):
                turning = product(q[-4:], ca.vertcat(rate[-3:], 0)) / 2
                rate = ca.vertcat(rate[:-3], turning)
            rates.append(rate)
        return ca.vertcat(*rates)

    def virtual_power(self, gravity):
        rate = ca.vertcat(self.q_rate, self.a)
        power = 0
        for link, body, virtual in zip(self.links, self.bodies, self.moved(self.w)):
            moments = ca.DM(link["moments_kg_m2"])
            acceleration = ca.jtimes(body.velocity, self.x, rate)
            turning = moments * ca.jtimes(body.spin, self.x, rate)
            turning += ca.cross(body.spin, moments * body.spin)
            power += link["mass_kg"] * ca.dot(virtual.velocity, gravity - acceleration)
            power -= ca.dot(virtual.spin, turning)
        return power

    def solved(self, right):
        """`M^-1` times it."""
        factors = ca.ldl(self.mass)
        columns = [ca.ldl_solve(column, *factors) for column in ca.horzsplit(right)]
        return ca.horzcat(*columns)

    def functions(self):
        """`rate` of x; its `slope` by x, given the accelerations; `lift`: `M^-1` of a pull; `curve`: the Hessian
        of a pull on the coordinates' rates and, with the lifted pull `w`, on the accelerations, of which `by` is
        the slope. For `a` with `Q - M a = 0` and `w = M^-1 k`, second derivatives of `k . a` are those of
        `S(x, a, w)` by x and once by x, once by a along `by`."""
        free = ca.substitute(self.rest, self.a, ca.SX.zeros(self.nv))
        k, by = ca.SX.sym("k", self.nv), ca.SX.sym("by", self.nv, self.nx)
        pull = ca.SX.sym("pull", self.nq)
        slope = ca.vertcat(
            ca.jacobian(self.q_rate, self.x), self.solved(ca.jacobian(self.rest, self.x))
        )
        gradient = ca.gradient(self.power + ca.dot(pull, self.q_rate), self.x)
        cross = ca.jacobian(gradient, self.a) @ by
        curve = ca.jacobian(gradient, self.x) + cross + cross.T
        made = {
            "rate": ([self.x], [self.q_rate, self.solved(free)]),
            "slope": ([self.x, self.a], [slope]),
            "lift": ([self.x, k], [self.solved(k)]),
            "curve": ([self.x, self.a, pull, self.w, by], [curve]),
        }
        return {
            name: ca.Function(name, ins, [ca.densify(out) for out in ca.cse(outs)])
            for name, (ins, outs) in made.items()
        }


def term(name, x, given, rows):
    """Rows that read x and what is given: themselves, their slope, the Hessian of a pull on them."""
    pull = ca.SX.sym("pull", rows.numel())
    outs = {
        name: ([x, given], rows),
        name + "_slope": ([x, given], ca.jacobian(rows, x)),
        name + "_curve": ([x, given, pull], ca.hessian(ca.dot(pull, rows), x)[0]),
    }
    return [
        ca.Function(key, ins, [ca.densify(out) for out in ca.cse([out])])
        for key, (ins, out) in outs.items()
    ]
