"""A problem of the documented format as sparse sums of compiled terms."""

import ctypes
import math

import numpy as np

from program import Program

INF = float("inf")
# Least time between neighbouring samples, where sample times are unknown [s].
LEAST_GAP_S = 1e-7
# Natural sizes of position [m], rotation [rad], velocity [m/s], angular velocity [rad/s]; of times.
STATE_SIZES = [0.01] * 3 + [0.1] * 3 + [0.1] * 3 + [1.0] * 3
TIME_SIZE = 0.01


class Unsupported(Exception):
    """A problem that has what the formulas lack."""


def log(q):
    """Rotation vector of a unit quaternion."""
    q = np.asarray(q, float)
    if q[0] < 0:
        q = -q
    sine = np.linalg.norm(q[1:])
    return 2 * q[1:] if sine < 1e-12 else q[1:] * (2 * math.atan2(sine, q[0]) / sine)


def product(a, b):
    a, b = np.asarray(a, float), np.asarray(b, float)
    vector = a[0] * b[1:] + b[0] * a[1:] + np.cross(a[1:], b[1:])
    return np.concatenate([[a[0] * b[0] - a[1:] @ b[1:]], vector])


def conjugate(q):
    return np.array([q[0], -q[1], -q[2], -q[3]])


def turning(body):
    """Scale, excess and axis of a body's turn."""
    moments = np.array(body["moments_kg_m2"])
    if body["symmetry"] == "spherical":
        return {"scale": np.ones(3), "excess": 0.0, "axis": np.array([0.0, 0.0, 1.0])}
    if body["symmetry"] != "axial":
        raise Unsupported("a body with three different moments")
    axis = body["axis"]
    transverse = moments[(axis + 1) % 3]
    return {
        "scale": moments / transverse,
        "excess": (transverse - moments[axis]) / transverse,
        "axis": np.eye(3)[axis],
    }


class Structure(ctypes.Structure):
    """`problem` of driver.c."""

    _fields_ = [(name, ctypes.c_longlong) for name in ("n", "m", "elements")] + [
        (name, ctypes.c_void_p)
        for name in (
            "kind variable_at p_at row_at slope_at curve_at variable row slope_map curve_map "
            "constant p weight offset scale jacobian upper full full_map"
        ).split()
    ]


class Group:
    """Some elements on their own unknowns: a part of the objective, or some rows."""

    def __init__(self, problem, first, last, of_rows):
        self.problem, self.first, self.last = problem, first, last
        elements = problem.elements[first:last]
        terms = [problem.library.terms[element[0]] for element in elements]
        variables = {v for element in elements for v in element[1] if v >= 0}
        self.variables = np.array(sorted(variables), np.int32)
        place = {v: k for k, v in enumerate(self.variables)}
        rows = [row for element in elements for row in element[4] if row >= 0]
        self.rows = np.array(rows) if of_rows else None
        self.is_linear = all(term["name"] == "step" for term in terms)
        size = len(rows) if of_rows else 1
        self.value, self.slope = np.zeros(size), np.zeros((size, len(self.variables)))
        self.first_row, self.row_count = (rows[0], len(rows)) if of_rows else (0, 0)
        self.pattern = [
            (element[4][r] - self.first_row, place[element[1][c]])
            for element, term in zip(elements, terms)
            if of_rows
            for r, c in zip(*term["slope"])
            if element[4][r] >= 0 and element[1][c] >= 0
        ]

    def evaluate(self, x):
        """Values and their derivatives; they are overwritten by the next call."""
        x = np.ascontiguousarray(x, float)
        code = self.problem.library.c.group_evaluate(
            x.ctypes.data,
            self.variables.ctypes.data,
            len(self.variables),
            self.first,
            self.last,
            self.first_row,
            self.row_count,
            self.value.ctypes.data,
            self.slope.ctypes.data,
        )
        if code:
            raise TimeoutError("over the limit")
        return self.value, self.slope


class Assembled(Program):
    """Unknowns, bounds, rows and elements of one problem."""

    def __init__(self, library, given, start="start", scaled=True):
        self.library, self.given = library, given
        self.start = self.point_named(start)
        self.epochs = [arc["epoch_s"] for arc in given["arcs"]]
        self.elements = []
        # What elements belong together.
        self.label = None
        self.row_bounds = []
        self._place_unknowns(scaled)
        self._add_samples()
        self._add_rows()
        self._add_priors()
        self._link()

    def point_named(self, name):
        for point in self.given["points"]:
            if point["name"] == name:
                return point
        raise Unsupported(f"no point {name}")

    # Unknowns.

    def _place_unknowns(self, scaled):
        given, start = self.given, self.start
        if any(p is not None for p in given["gravity_parameters"]):
            raise Unsupported("free gravity")
        offset, scale, lower, upper = [], [], [], []

        def take(value, size, low=-INF, high=INF):
            offset.append(value)
            scale.append(size if scaled else 1.0)
            lower.append(low)
            upper.append(high)
            return len(offset) - 1

        self.states = []
        for state in start["states"]:
            values = [*state["position_m"], 0.0, 0.0, 0.0]
            values += [*state["velocity_m_s"], *state["angular_velocity_rad_s"]]
            self.states.append([take(v, s) for v, s in zip(values, STATE_SIZES)])
        self.times = [
            take(time, TIME_SIZE) if event["is_free"] else -1
            for event, time in zip(given["events"], start["event_times_s"])
        ]
        self.parameters = []
        for index, free in enumerate(given["parameters"]):
            bounds = (free["lower"], free["upper"]) if index in given["bounded"] else (None, None)
            low, high = (-INF if bounds[0] is None else bounds[0]), bounds[1]
            high = INF if high is None else high
            value = start["parameters"][index]
            self.parameters.append(take(value, free["unit"], low, high))
        self.nodes, self.steps = [-1] * len(given["nodes_acted_s"]), 0
        if given["tempo_sd_per_sqrt_s"] is not None:
            times = start["node_times_s"]
            for node in range(1, len(times)):
                self.nodes[node] = take(times[node], TIME_SIZE)
        self.offset, self.scale = np.array(offset), np.array(scale)
        self.lower = (np.array(lower) - self.offset) / self.scale
        self.upper = (np.array(upper) - self.offset) / self.scale
        self.n = len(offset)

    def unknowns(self, point):
        """A point of the format as the unknowns that solvers see."""
        z = self.offset.copy()
        for at, state, from_state in zip(self.states, point["states"], self.start["states"]):
            q = product(conjugate(from_state["orientation_wxyz"]), state["orientation_wxyz"])
            z[at] = np.concatenate(
                [state["position_m"], log(q), state["velocity_m_s"], state["angular_velocity_rad_s"]]
            )
        for at, time in zip(self.times, point["event_times_s"]):
            if at >= 0:
                z[at] = time
        for at, value in zip(self.parameters, point["parameters"]):
            z[at] = value
        times = point["node_times_s"]
        for node, at in enumerate(self.nodes):
            if at >= 0:
                z[at] = times[node]
        return (z - self.offset) / self.scale

    # Elements.

    def _add(self, name, variables, constants, values, rows=None, weight=0.0):
        """`values` are read where a variable is -1."""
        term = self.library.terms[self.library.index[name]]
        p = []
        for key, count in term["p"]:
            value = np.atleast_1d(np.asarray(constants[key], float)).ravel()
            assert value.size == count, (name, key)
            p.extend(value)
        assert len(variables) == term["z"] == len(values), name
        rows = [-1] * term["rows"] if rows is None else rows
        assert len(rows) == term["rows"], name
        self.elements.append((self.library.index[name], variables, values, p, rows, weight, self.label))

    def _row(self, lower=0.0, upper=0.0):
        self.row_bounds.append((lower, upper))
        return len(self.row_bounds) - 1

    def _body(self, index, prefix=""):
        body = self.given["bodies"][index]
        constants = {prefix + key: value for key, value in turning(body).items()}
        constants[prefix + "inverse_mass"] = 1 / body["mass_kg"]
        constants[prefix + "inverse_moments"] = 1 / np.array(body["moments_kg_m2"])
        return constants

    def _kind(self, body):
        return "round" if self.given["bodies"][body]["symmetry"] == "spherical" else "axial"

    def _add_samples(self):
        given = self.given
        known = given["tempo_sd_per_sqrt_s"] is None
        times = self.start["node_times_s"]
        gravity = np.array(given["gravity_m_s2"])
        for index, arc in enumerate(given["arcs"]):
            self.label = ("arc", index)
            epoch, state = self.epochs[index], self.states[index]
            common = {
                **self._body(arc["body"]),
                "start_q": self.start["states"][index]["orientation_wxyz"],
                "epoch": epoch,
                "gravity": gravity,
            }
            place, turn = state[0:3] + state[6:9], state[3:6] + state[9:12]
            if known:
                self._add("place_known", place, self._sums(arc, index, times), [0] * 6)
            for sample in arc["samples"]:
                time = times[sample["node"]]
                node = self.nodes[sample["node"]]
                angle = {**common, "measured": sample["orientation_wxyz"], "time": time}
                angle["unit"] = given["orientation_unit_rad"]
                name = f"turn_{self._kind(arc['body'])}_{'known' if known else 'free'}"
                if known:
                    self._add(name, turn, angle, [0] * 6)
                    continue
                self._add(name, turn + [node], angle, [0] * 6 + [time])
                way = {**common, "measured": sample["position_m"], "unit": given["position_unit_m"]}
                self._add("place_free", place + [node], way, [0] * 6 + [time])

    def _sums(self, arc, index, times):
        state = self.start["states"][index]
        x, v = np.array(state["position_m"]), np.array(state["velocity_m_s"])
        s = np.array([times[sample["node"]] for sample in arc["samples"]]) - self.epochs[index]
        measured = np.array([sample["position_m"] for sample in arc["samples"]])
        gravity = np.array(self.given["gravity_m_s2"])
        r = x + np.outer(s, v) + np.outer(s * s / 2, gravity) - measured
        weight = 1 / self.given["position_unit_m"] ** 2
        return {
            "origin": np.concatenate([x, v]),
            "powers": weight * np.array([s.size, s.sum(), (s * s).sum()]),
            "moments": weight * np.concatenate([r.sum(0), s @ r]),
            "square": weight * (r * r).sum(),
        }

    def _add_rows(self):
        given = self.given
        for index, collision in enumerate(given["collisions"]):
            self.label = ("collision", index)
            self._add_collision(collision)
        units = given["constraint_units"]
        gravity = np.array(given["gravity_m_s2"])
        for index, goal in enumerate(given["goals"]):
            self.label = ("goal", index)
            arc, event = goal["arc"], goal["event"]
            state, time = self.states[arc], self.times[event]
            at = self.start["event_times_s"][event]
            body = given["arcs"][arc]["body"]
            if goal["pose"] is not None:
                constants = {
                    **self._body(body),
                    "gravity": gravity,
                    "start_q": self.start["states"][arc]["orientation_wxyz"],
                    "epoch": self.epochs[arc],
                    "place": goal["pose"][0],
                    "orientation": goal["pose"][1],
                    "units": [units["position_m"], units["orientation_rad"]],
                }
                rows = [self._row() for _ in range(6)]
                name = f"goal_pose_{self._kind(body)}"
                self._add(name, state + [time], constants, [0] * 12 + [at], rows)
            else:
                axis, lower, upper = goal["coordinate"]
                unit = units["position_m"]
                bounds = (
                    -INF if lower is None else lower / unit,
                    INF if upper is None else upper / unit,
                )
                constants = {"gravity": gravity[axis], "epoch": self.epochs[arc], "unit": unit}
                variables = [state[axis], state[6 + axis], time]
                self._add("goal_coordinate", variables, constants, [0, 0, at], [self._row(*bounds)])
        for index, circle in enumerate(given["cones"]):
            self.label = ("cone", index)
            variables = [self.parameters[p] for p in circle["parameters"]]
            row = self._row(-INF, 1.0)
            self._add("cone", variables, {"limit": circle["limit"]}, [0, 0], [row])
        self.label = "steps"
        for node in range(1, len(self.nodes)):
            if self.nodes[node] >= 0:
                first = self.start["node_times_s"][node - 1]
                row = self._row(LEAST_GAP_S / TIME_SIZE, INF)
                variables = [self.nodes[node - 1], self.nodes[node]]
                self._add("step", variables, {"unit": TIME_SIZE}, [first, 0], [row])
                self.steps += 1

    def _add_collision(self, collision):
        given = self.given
        if len(collision["contacts"]) != 1 or collision["has_friction"]:
            raise Unsupported("friction, or several contacts at once")
        contact = collision["contacts"][0]
        a, b = contact["a"], contact["b"]
        if (a["kind"], b["kind"]) != ("point", "face"):
            raise Unsupported(f"a {a['kind']} on a {b['kind']}")
        units = given["constraint_units"]
        event = collision["event"]
        constants = {
            "gravity": given["gravity_m_s2"],
            "point": a["point_m"],
            "radius": a["radius_m"],
            "face_point": b["point_m"],
            "face_normal": b["direction"],
            "axis_0": contact["tilt_axes"][0],
            "axis_1": contact["tilt_axes"][1],
            "units": list(units.values()),
        }
        variables, values, rows = [], [], []
        rows.append(-2 if collision["touches_by_goal"] else self._row())
        rows.append(self._row(-INF, 0.0))
        priced = given["velocity_gap_weight"] is not None
        for side, prefix in zip(collision["sides"], ("a_", "b_")):
            constants |= self._body(side["body"], prefix)
            for when in ("before", "after"):
                arc = side[when]
                variables += self.states[arc]
                values += [0.0] * 12
                constants[f"{prefix}{when}_epoch"] = self.epochs[arc]
                q = self.start["states"][arc]["orientation_wxyz"]
                constants[f"{prefix}{when}_q"] = q
            rows += [self._row() for _ in range(6)]
            rows += [-1] * 6 if priced else [self._row() for _ in range(6)]
        variables.append(self.times[event])
        values.append(self.start["event_times_s"][event])
        free = [collision["restitution_parameter"], *collision["tilt_parameters"]]
        fixed = [collision["restitution"], *collision["tilt_rad"]]
        for parameter, value in zip(free, fixed):
            variables.append(-1 if parameter is None else self.parameters[parameter])
            values.append(value)
        two = len(collision["sides"]) == 2
        name = "collision_" + ("two" if two else self._kind(collision["sides"][0]["body"]))
        weight = given["velocity_gap_weight"] or 0.0
        self._add(name, variables, constants, values, rows, weight)

    def _add_priors(self):
        given = self.given
        self.label = "priors"
        for free, at in zip(given["parameters"], self.parameters):
            if free["prior_sd"] is not None:
                constants = {"initial": free["initial"], "sd": free["prior_sd"]}
                self._add("prior", [at], constants, [0])
        sd = given["tempo_sd_per_sqrt_s"]
        if sd is not None:
            acted, times = given["nodes_acted_s"], self.start["node_times_s"]
            for node in range(len(acted) - 2):
                constants = {"acted": acted[node : node + 3], "sd": sd}
                self._add("tempo", self.nodes[node : node + 3], constants, times[node : node + 3])

    # Sparse structure.

    def _link(self):
        terms = self.library.terms
        self.m = len(self.row_bounds)
        jacobian, upper = {}, {}
        for kind, variables, _, _, rows, _, _ in self.elements:
            term = terms[kind]
            if not term["is_scalar"]:
                for r, c in zip(*term["slope"]):
                    if rows[r] >= 0 and variables[c] >= 0:
                        jacobian[variables[c], rows[r]] = 0
            for r, c in zip(*term["curve"]):
                if variables[r] >= 0 and variables[c] >= 0:
                    i, j = sorted((variables[r], variables[c]))
                    upper[j, i] = 0
        place = [{key: k for k, key in enumerate(sorted(which))} for which in (jacobian, upper)]
        slope_map, curve_map = [], []
        slope_at, curve_at, variable_at, p_at, row_at = [], [], [], [], []
        variable, constant, p, row = [], [], [], []
        for kind, variables, values, constants, rows, _, _ in self.elements:
            term = terms[kind]
            for start, array in zip(
                (slope_at, curve_at, variable_at, p_at, row_at),
                (slope_map, curve_map, variable, p, row),
            ):
                start.append(len(array))
            if not term["is_scalar"]:
                slope_map += [
                    place[0].get((variables[c], rows[r]), -1) if rows[r] >= 0 else -1
                    for r, c in zip(*term["slope"])
                ]
            for r, c in zip(*term["curve"]):
                i, j = sorted((variables[r], variables[c]))
                curve_map.append(place[1].get((j, i), -1) if i >= 0 else -1)
            variable += variables
            constant += values
            p += constants
            row += rows
        self.arrays = {
            "kind": np.array([e[0] for e in self.elements], np.int32),
            "variable_at": np.array(variable_at, np.int32),
            "p_at": np.array(p_at, np.int32),
            "row_at": np.array(row_at, np.int32),
            "slope_at": np.array(slope_at, np.int32),
            "curve_at": np.array(curve_at, np.int32),
            "variable": np.array(variable, np.int32),
            "row": np.array(row, np.int32),
            "slope_map": np.array(slope_map or [0], np.int32),
            "curve_map": np.array(curve_map, np.int32),
            "constant": np.array(constant, float),
            "p": np.array(p, float),
            "weight": np.array([e[5] for e in self.elements], float),
            "offset": self.offset,
            "scale": self.scale,
            **self._patterns(jacobian, upper),
        }
        pointers = {name: array.ctypes.data for name, array in self.arrays.items()}
        self.structure = Structure(self.n, self.m, len(self.elements), **pointers)
        self.row_lower = np.array([low for low, _ in self.row_bounds])
        self.row_upper = np.array([high for _, high in self.row_bounds])

    def groups(self):
        """The objective arc by arc, the rows event by event, and what is left."""
        groups, first = [], 0
        labels = [element[6] for element in self.elements]
        for at in range(1, len(labels) + 1):
            if at == len(labels) or labels[at] != labels[first]:
                of_rows = any(row >= 0 for e in self.elements[first:at] for row in e[4])
                is_priced = any(e[5] > 0 for e in self.elements[first:at])
                if of_rows:
                    groups.append(Group(self, first, at, True))
                if is_priced or not of_rows:
                    groups.append(Group(self, first, at, False))
                first = at
        return groups

    # Values.

    def violation(self, x):
        """Largest violation of any constraint or bound, in the format's units."""
        worst = super().violation(x)
        z = self.offset + self.scale * np.asarray(x)
        for index in self.given["bounded"]:
            free, value = self.given["parameters"][index], z[self.parameters[index]]
            if free["lower"] is not None:
                worst = max(worst, (free["lower"] - value) / free["unit"])
            if free["upper"] is not None:
                worst = max(worst, (value - free["upper"]) / free["unit"])
        return float(worst)

    def rows_of_format(self, x):
        """All rows in the order of the format, bounded parameters included."""
        _, g = self.evaluate(x)
        z = self.offset + self.scale * np.asarray(x)
        cones = len(self.given["cones"])
        own = self.m - self.steps - cones
        bounded = [
            z[self.parameters[k]] / self.given["parameters"][k]["unit"]
            for k in self.given["bounded"]
        ]
        return np.concatenate([g[:own], bounded, g[own : own + cones]])

    def is_in_order(self, x):
        """Whether no event comes before the one before it."""
        z = self.offset + self.scale * np.asarray(x)
        times = [
            z[at] if at >= 0 else fixed
            for at, fixed in zip(self.times, self.start["event_times_s"])
        ]
        return all(a <= b for a, b in zip(times, times[1:]))

    def described(self, x):
        """What else is said of where a solve ended."""
        return {"is_in_order": x is not None and self.is_in_order(x)}
