"""The terms of the estimation problem as CasADi expressions.

Written from the format's documentation (README.md), independently of the Rust code. Every term
is a function of a few unknowns `z` and of constants `p`. Terms of the objective are scalars;
terms of the constraints are vectors in natural units. Unknowns of a state are, in this order,
position [m], rotation vector from a given orientation [rad, body, right], velocity [m/s],
angular velocity [rad/s, body].
"""

import casadi as ca

# Below this squared angle series are used.
SMALL = 1e-3


def series(x, coefficients):
    """Polynomial in x by Horner's rule."""
    value = 0
    for c in reversed(coefficients):
        value = value * x + c
    return value


def exponential(theta):
    """Unit quaternion (w, v) of a rotation vector."""
    square = ca.dot(theta, theta)
    small = square < SMALL
    angle = ca.sqrt(ca.if_else(small, 1, square))
    h = square / 4
    w = ca.if_else(
        small,
        series(h, [1, -1 / 2, 1 / 24, -1 / 720, 1 / 40320, -1 / 3628800]),
        ca.cos(angle / 2),
    )
    scale = ca.if_else(
        small,
        0.5 * series(h, [1, -1 / 6, 1 / 120, -1 / 5040, 1 / 362880, -1 / 39916800]),
        ca.sin(angle / 2) / angle,
    )
    return ca.vertcat(w, scale * theta)


def logarithm(q):
    """Rotation vector, of angle at most π, of a unit quaternion."""
    w, v = q[0], q[1:4]
    square = ca.dot(v, v)
    small = square < SMALL
    sine = ca.sqrt(ca.if_else(small, 1, square))
    sign = ca.if_else(w < 0, -1, 1)
    asin = [1, 1 / 6, 3 / 40, 5 / 112, 35 / 1152, 63 / 2816, 231 / 13312, 143 / 10240]
    ratio = ca.if_else(
        small, series(square, asin), ca.atan2(sine, ca.if_else(small, 1, sign * w)) / sine
    )
    return (2 * sign * ratio) * v


def squared_angle(q):
    """|logarithm(q)|², in fewer operations."""
    square = ca.dot(q[1:4], q[1:4])
    small = square < SMALL
    half = ca.atan2(ca.sqrt(ca.if_else(small, 1, square)), ca.fabs(ca.if_else(small, 1, q[0])))
    # asin² in powers of the squared sine.
    squares = [1, 1 / 3, 8 / 45, 4 / 35, 128 / 1575, 128 / 2079, 1024 / 21021, 256 / 6435]
    return 4 * ca.if_else(small, square * series(square, squares), half * half)


def conjugate(q):
    return ca.vertcat(q[0], -q[1:4])


def product(a, b):
    return ca.vertcat(
        a[0] * b[0] - ca.dot(a[1:4], b[1:4]),
        a[0] * b[1:4] + b[0] * a[1:4] + ca.cross(a[1:4], b[1:4]),
    )


def rotated(q, v):
    """Vector in the outer axes."""
    t = 2 * ca.cross(q[1:4], v)
    return v + q[0] * t + ca.cross(q[1:4], t)


class Constants:
    """The constants `p` of a term, by name."""

    def __init__(self):
        self.names, self.symbols = [], []

    def take(self, name, count=1):
        symbol = ca.SX.sym(name, count)
        self.names.append((name, count))
        self.symbols.append(symbol)
        return symbol

    def vector(self):
        return ca.vertcat(*self.symbols)


class Top:
    """How a body turns: `scale` is I/I_t, `excess` 1 - I_a/I_t, about the axis of symmetry."""

    def __init__(self, constants, prefix, is_axial):
        self.is_axial = is_axial
        if is_axial:
            self.scale = constants.take(prefix + "scale", 3)
            self.excess = constants.take(prefix + "excess")
            self.axis = constants.take(prefix + "axis", 3)

    def turn(self, omega, s):
        """R(0)⁻¹R(s) and ω(s)."""
        if not self.is_axial:
            return exponential(omega * s), omega
        first = exponential(self.scale * omega * s)
        second = exponential(self.axis * (self.excess * ca.dot(self.axis, omega) * s))
        return product(first, second), rotated(conjugate(second), omega)


class State:
    """A body's state."""

    def __init__(self, x, q, v, omega):
        self.x, self.q, self.v, self.omega = x, q, v, omega

    @staticmethod
    def unknown(z, start_q):
        return State(z[0:3], product(start_q, exponential(z[3:6])), z[6:9], z[9:12])

    def after(self, s, gravity, top):
        turn, omega = top.turn(self.omega, s)
        return State(
            self.x + self.v * s + gravity * (s * s / 2),
            product(self.q, turn),
            self.v + gravity * s,
            omega,
        )


class Term:
    """A function of z and p: value, first and second derivatives come from CasADi."""

    def __init__(self, name, z, constants, value, residual=None):
        self.name, self.z, self.p = name, z, constants.vector()
        self.layout = constants.names
        self.value = value
        # Twice the product of the Jacobian of these with itself is the Gauss-Newton Hessian.
        self.residual = residual


def turn_terms(is_axial, time_is_unknown):
    """Σ over one sample of |Log(R_iᵀ R(s))|²/u²: z = θ, ω, and s where that is unknown."""
    p = Constants()
    z = ca.SX.sym("z", 7 if time_is_unknown else 6)
    start_q, measured = p.take("start_q", 4), p.take("measured", 4)
    epoch = p.take("epoch")
    s = (z[6] if time_is_unknown else p.take("time")) - epoch
    unit = p.take("unit")
    top = Top(p, "", is_axial)
    turn, _ = top.turn(z[3:6], s)
    q = product(product(start_q, exponential(z[0:3])), turn)
    error = product(conjugate(measured), q)
    r = logarithm(error) / unit
    name = f"turn_{'axial' if is_axial else 'round'}_{'free' if time_is_unknown else 'known'}"
    return Term(name, z, p, squared_angle(error) / (unit * unit), r)


def place_known():
    """Σ over an arc's samples of |x(s) − x_i|²/u², from sums: z = x, v."""
    p = Constants()
    z = ca.SX.sym("z", 6)
    origin = p.take("origin", 6)
    powers, moments, square = p.take("powers", 3), p.take("moments", 6), p.take("square")
    dx, dv = z[0:3] - origin[0:3], z[3:6] - origin[3:6]
    value = square + 2 * (ca.dot(moments[0:3], dx) + ca.dot(moments[3:6], dv))
    value += powers[0] * ca.dot(dx, dx) + 2 * powers[1] * ca.dot(dx, dv)
    value += powers[2] * ca.dot(dv, dv)
    return Term("place_known", z, p, value)


def place_free():
    """|x(s) − x_i|²/u² of one sample: z = x, v, t."""
    p = Constants()
    z = ca.SX.sym("z", 7)
    measured, gravity = p.take("measured", 3), p.take("gravity", 3)
    epoch, unit = p.take("epoch"), p.take("unit")
    s = z[6] - epoch
    r = (z[0:3] + z[3:6] * s + gravity * (s * s / 2) - measured) / unit
    return Term("place_free", z, p, ca.dot(r, r), r)


def tempo():
    """Change of the logarithm of the tempo over three nodes: z = their times."""
    p = Constants()
    z = ca.SX.sym("z", 3)
    acted, sd = p.take("acted", 3), p.take("sd")
    scale = 1 / (sd * ca.sqrt(0.5 * (acted[2] - acted[0])))
    rates = [(z[k + 1] - z[k]) / (acted[k + 1] - acted[k]) for k in (0, 1)]
    r = scale * (ca.log(rates[1]) - ca.log(rates[0]))
    return Term("tempo", z, p, r * r, r)


def prior():
    """((u − u₀)/σ)²."""
    p = Constants()
    z = ca.SX.sym("z", 1)
    initial, sd = p.take("initial"), p.take("sd")
    r = (z - initial) / sd
    return Term("prior", z, p, r * r, r)


def collision(is_axial, has_partner):
    """A point of A on a face of B or of the world, without friction.

    z = A before, A after, (B before, B after,) time, restitution, tilts.
    Rows: gap, approach speed, then per body what its state after differs from the impact's.
    """
    p = Constants()
    bodies = 2 if has_partner else 1
    z = ca.SX.sym("z", 24 * bodies + 4)
    time, restitution, tilt = z[24 * bodies], z[24 * bodies + 1], z[24 * bodies + 2 :]
    gravity = p.take("gravity", 3)
    before, after, masses, moments = [], [], [], []
    for body in range(bodies):
        prefix = "ab"[body] + "_"
        top = Top(p, prefix, is_axial[body])
        masses.append(p.take(prefix + "inverse_mass"))
        moments.append(p.take(prefix + "inverse_moments", 3))
        for when, states in (("before", before), ("after", after)):
            at = 24 * body + (0 if when == "before" else 12)
            state = State.unknown(z[at : at + 12], p.take(f"{prefix}{when}_q", 4))
            states.append(state.after(time - p.take(f"{prefix}{when}_epoch"), gravity, top))
    point, radius = p.take("point", 3), p.take("radius")
    face_point, face_normal = p.take("face_point", 3), p.take("face_normal", 3)
    axes = [p.take("axis_0", 3), p.take("axis_1", 3)]
    units = p.take("units", 4)

    a = before[0]
    if has_partner:
        b = before[1]
    else:
        zero = ca.SX.zeros(3)
        b = State(zero, ca.SX([1, 0, 0, 0]), zero, zero)
    normal = rotated(b.q, face_normal)
    centre = a.x + rotated(a.q, point)
    gap = ca.dot(normal, centre - b.x - rotated(b.q, face_point)) - radius
    # The points of contact from the centres of mass, in world axes.
    arm_a = centre - radius * normal - a.x
    arm_b = centre - (gap + radius) * normal - b.x
    spin_a, spin_b = rotated(a.q, a.omega), rotated(b.q, b.omega)
    relative = a.v + ca.cross(spin_a, arm_a) - b.v - ca.cross(spin_b, arm_b)
    # The impact sees the normal turned within the axes of B.
    bent = rotated(b.q, rotated(exponential(axes[0] * tilt[0] + axes[1] * tilt[1]), face_normal))
    levers = [rotated(conjugate(a.q), ca.cross(arm_a, bent))]
    if has_partner:
        levers.append(rotated(conjugate(b.q), ca.cross(arm_b, bent)))
    mobility = sum(m + ca.dot(l, i * l) for m, i, l in zip(masses, moments, levers))
    impulse = -(1 + restitution) * ca.dot(bent, relative) / mobility

    rows = [gap / units[0], ca.dot(normal, relative) / units[2]]
    for body in range(bodies):
        sign = 1 - 2 * body
        s, t = before[body], after[body]
        v = s.v + bent * (sign * impulse * masses[body])
        omega = s.omega + moments[body] * levers[body] * (sign * impulse)
        rows += [
            (t.x - s.x) / units[0],
            logarithm(product(conjugate(s.q), t.q)) / units[1],
            (t.v - v) / units[2],
            (t.omega - omega) / units[3],
        ]
    kinds = "two" if has_partner else "axial" if is_axial[0] else "round"
    return Term(f"collision_{kinds}", z, p, ca.vertcat(*rows))


def goal_pose(is_axial):
    """A body's pose at a time against a given one: z = state, time."""
    p = Constants()
    z = ca.SX.sym("z", 13)
    gravity, start_q, epoch = p.take("gravity", 3), p.take("start_q", 4), p.take("epoch")
    top = Top(p, "", is_axial)
    place, orientation, units = p.take("place", 3), p.take("orientation", 4), p.take("units", 2)
    state = State.unknown(z[0:12], start_q).after(z[12] - epoch, gravity, top)
    turn = logarithm(product(conjugate(orientation), state.q))
    value = ca.vertcat((state.x - place) / units[0], turn / units[1])
    return Term(f"goal_pose_{'axial' if is_axial else 'round'}", z, p, value)


def goal_coordinate():
    """One coordinate at a time: z = coordinate, its velocity, time."""
    p = Constants()
    z = ca.SX.sym("z", 3)
    gravity, epoch, unit = p.take("gravity"), p.take("epoch"), p.take("unit")
    s = z[2] - epoch
    return Term("goal_coordinate", z, p, (z[0] + z[1] * s + gravity * s * s / 2) / unit)


def cone():
    """Squared distance of two parameters from zero, in units of a limit."""
    p = Constants()
    z = ca.SX.sym("z", 2)
    limit = p.take("limit")
    return Term("cone", z, p, ca.dot(z, z) / (limit * limit))


def step():
    """Time between neighbouring nodes, in a unit."""
    p = Constants()
    z = ca.SX.sym("z", 2)
    unit = p.take("unit")
    return Term("step", z, p, (z[1] - z[0]) / unit)


def terms():
    """All of them; scalars are terms of the objective."""
    both = (False, True)
    objective = [turn_terms(axial, free) for axial in both for free in both]
    objective += [place_known(), place_free(), tempo(), prior()]
    constraints = [collision((axial,), False) for axial in both]
    # A body with three equal moments is an axial one too, with nothing in excess.
    constraints += [collision((True, True), True)]
    constraints += [goal_pose(axial) for axial in both]
    constraints += [goal_coordinate(), cone(), step()]
    return objective, constraints
