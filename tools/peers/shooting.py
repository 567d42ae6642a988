"""A joined problem of the documented format as a multiple-shooting programme."""

import ctypes
import hashlib
import json
import subprocess
import time

import casadi as ca
import numpy as np
from scipy.integrate import DOP853

import trees
from compiled import BUILD, FLAGS, HERE, loaded
from program import Program

# Segments into which the motion is cut, as nearly as samples allow.
SEGMENTS = 6
# Steps between samples are as many as change the objective by less than this, relative, when doubled.
INTEGRATES, MOST_SUBSTEPS = 1e-8, 8
# Natural sizes of a length [m], a part of a quaternion, an angle [rad], a velocity [m/s], a rate [rad/s].
LENGTH, PART, ANGLE, VELOCITY, RATE = 0.01, 0.05, 0.1, 0.1, 1.0
# What is called at every stage is worth -O2; `curve` is so long that gcc takes a minute at that, for nothing.
LEVELS = {"often": "-O2", "seldom": "-O1"}
SOURCES = ("trees.py", "layout.py", "shoot.c", "interface.h", "interface.c", "shooting.py")
# Of inverse kinematics: damping [m^2], rounds, and samples on either side that tell a velocity.
DAMPING, ROUNDS, BESIDE = 9e-5, 50, 3


class Unsupported(Exception):
    """A problem that has what the formulas lack."""


def parted(given):
    """What holds at the start, and what at the end."""
    start, end = given["span_s"]
    for goal in given["goals"]:
        if goal["time_s"] not in (start, end):
            raise Unsupported("a goal on the way")
    parts = [[goal for goal in given["goals"] if goal["time_s"] == at] for at in (start, end)]
    if any(goal["kind"] != "position" for goal in parts[1]) or len(parts[1]) != 1:
        raise Unsupported("anything but one place at the end")
    return parts


def rows_of(tree, goals, held):
    """Rows of goals as the solvers have them, in units; smooth, unlike a rotation vector."""
    rows, at = [], 0
    for goal in goals:
        values = held[at : at + len(goal["value"])]
        at += len(goal["value"])
        body = tree.bodies[goal["link"]]
        if goal["kind"] == "angles":
            row = tree.q[tree.places[goal["link"]][0]] - values
        elif goal["kind"] == "orientation":
            turn = trees.product(trees.conjugate(trees.xyzw(ca.vertsplit(values))), body.turn)
            row = 2 * turn[:3]
        else:
            row = body.at(goal["point_m"]) - values
        rows.append(row / goal["unit"])
    return ca.vertcat(*rows)


def moving(rows, x):
    """Those that depend on anything: the place of a pendulum of pins across its plane does not, and would make more
    equations than unknowns."""
    return rows[[r for r in range(rows.numel()) if ca.jacobian(rows[r], x).nnz()]]


def place_of(given):
    """Link, point and unit of all samples."""
    places = {(s["link"], tuple(s["point_m"]), s["unit_m"]) for s in given["samples"]}
    if len(places) != 1:
        raise Unsupported("samples of several points")
    return places.pop()


class Mechanism:
    """The machine code of a tree and of what is asked of it; built once."""

    def __init__(self, given):
        self.tree = trees.Tree(given["links"], given["gravity_m_s2"])
        self.goals = parted(given)
        self.sampled = place_of(given)
        self.lengths = [sum(len(goal["value"]) for goal in part) for part in self.goals]
        shape = [(g["kind"], g["link"], g["point_m"], g["unit"]) for part in self.goals for g in part]
        text = json.dumps([given["links"], given["gravity_m_s2"], shape, self.lengths, self.sampled])
        text += "".join((HERE / name).read_text() for name in SOURCES) + ca.__version__
        self.folder = BUILD / hashlib.sha256(text.encode()).hexdigest()[:16]
        self.path, self.seconds = str(self.folder / "shoot.so"), 0.0
        self.functions = self.tree.functions()
        terms = self._terms()
        self.rows = {name: made[0].numel_out(0) for name, made in terms.items()}
        self.place = terms["seen"]
        if not (self.folder / "shoot.so").exists():
            self._build(terms)
        self.c = loaded(self.path)
        whole, pointer = ctypes.c_longlong, ctypes.c_void_p
        self.c.part_evaluate.argtypes = [ctypes.c_int, whole, pointer, pointer, pointer]
        self.c.flight.argtypes = [whole, pointer, pointer]

    def _terms(self):
        tree = self.tree
        link, point, unit = self.sampled
        seen = ca.SX.sym("seen", 3)
        norms = [
            (ca.sumsqr(tree.q[at : at + 4]) - 1) / (2 * PART) for at in tree.quaternions()
        ]
        held = [ca.SX.sym("held", length) for length in self.lengths]
        rows = [rows_of(tree, goals, values) for goals, values in zip(self.goals, held)]
        self.all_rows = [
            ca.Function("rows", [tree.x, values], [row]) for values, row in zip(held, rows)
        ]
        rows = [moving(row, tree.x) for row in rows]
        return {
            "seen": trees.term("seen", tree.x, seen, (tree.bodies[link].at(point) - seen) / unit),
            "first": trees.term("first", tree.x, held[0], ca.vertcat(rows[0], *norms)),
            "last": trees.term("last", tree.x, held[1], rows[1]),
        }

    def _build(self, terms):
        began = time.perf_counter()
        self.folder.mkdir(parents=True, exist_ok=True)
        parts = {
            "often": [self.functions[name] for name in ("rate", "slope", "lift")] + terms["seen"],
            "seldom": [self.functions["curve"], *terms["first"], *terms["last"]],
        }
        work = max(f.sz_w() for part in parts.values() for f in part)
        whole = max(f.sz_iw() for part in parts.values() for f in part)
        sizes = {"NQ": self.tree.nq, "NV": self.tree.nv, "NX": self.tree.nx}
        sizes |= {"FIRST": self.rows["first"], "LAST": self.rows["last"]}
        sizes |= {"WORK": work + 1, "IWORK": whole + 1}
        text = [f"#define {name} {size}" for name, size in sizes.items()]
        text += [f'#include "{name}.h"' for name in parts]
        objects = []
        for name, functions in parts.items():
            generator = ca.CodeGenerator(name + ".c", {"with_header": True})
            for function in functions:
                # The prefix keeps them apart from what else the process has.
                generator.add(renamed(function, "tree_" + function.name()))
            generator.generate(str(self.folder) + "/")
            objects.append((self.folder / f"{name}.c", LEVELS[name]))
        (self.folder / "mechanism.h").write_text("\n".join(text) + "\n")
        objects.append((HERE / "shoot.c", "-O3"))
        linked = []
        for source, level in objects:
            linked.append(str(self.folder / (source.stem + ".o")))
            places = [f"-I{self.folder}", f"-I{HERE}"]
            subprocess.run(["gcc", level, *FLAGS, *places, "-c", source, "-o", linked[-1]], check=True)
        # What is not whole has another name: a build that was broken off is made again.
        whole = self.path + ".new"
        subprocess.run(["gcc", "-shared", "-Wl,-Bsymbolic", *linked, "-lm", "-o", whole], check=True)
        (self.folder / "shoot.so.new").rename(self.path)
        self.seconds = time.perf_counter() - began


def renamed(function, name):
    ins = [ca.SX.sym(f"i{k}", *function.size_in(k)) for k in range(function.n_in())]
    return ca.Function(name, ins, function.call(ins))


class Structure(ctypes.Structure):
    """`problem` of shoot.c."""

    _fields_ = [
        (name, ctypes.c_longlong) for name in "n m segments steps substeps stages".split()
    ] + [
        (name, ctypes.c_void_p)
        for name in (
            "a b interval_s seen weight first last rate_weight offset scale "
            "jacobian upper full full_map"
        ).split()
    ]


class Part:
    """The objective of a segment, or some rows, on their own unknowns: `part` of shoot.c."""

    is_linear = False

    def __init__(self, problem, part, k):
        nx, library = problem.nx, problem.library
        self.problem, self.part, self.k = problem, part, k
        nodes = 2 if part == 1 else 1
        self.variables = np.arange(k * nx, (k + nodes) * nx)
        count = [1, nx, library.rows["first"], library.rows["last"]][part]
        first = [0, problem.row_of(k), nx, problem.row_of(k)][part]
        self.rows = None if part == 0 else np.arange(first, first + count)
        self.value, self.slope = np.zeros(count), np.zeros((count, nodes * nx))
        self.pattern = [
            (r, c)
            for r in range(count)
            for c in range(nodes * nx)
            if part != 1 or c < nx or c == nx + r
        ]

    def evaluate(self, x):
        """Values and their derivatives; they are overwritten by the next call."""
        x = np.ascontiguousarray(x, float)
        pointers = [x.ctypes.data, self.value.ctypes.data, self.slope.ctypes.data]
        if self.problem.library.c.part_evaluate(self.part, self.k, *pointers):
            raise TimeoutError("over the limit")
        return self.value, self.slope


class Shooting(Program):
    """Unknowns and rows of a problem, from a point of it; `substeps` between samples, or as many as it needs."""

    def __init__(self, library, given, start="start", substeps=None):
        self.library, self.given = library, given
        self.tree, self.nx = library.tree, library.tree.nx
        self._lay_samples()
        self._lay_patterns()
        tree, shift = self.tree, self.tree.shift
        sizes = np.full(tree.nx, ANGLE)
        sizes[:shift] = LENGTH
        for at in tree.quaternions():
            sizes[at : at + 4] = PART
        sizes[tree.nq :] = RATE
        sizes[tree.nq : tree.nq + shift] = VELOCITY
        self.scale = np.tile(sizes, self.segments + 1)
        weight = np.zeros(tree.nx)
        weight[tree.nq + shift :] = given["rate_sd_rad_s"] ** -2
        held = [[v for goal in part for v in goal["value"]] for part in parted(given)]
        self.arrays |= {
            "a": np.ascontiguousarray(DOP853.A[:, : DOP853.n_stages]),
            "b": np.ascontiguousarray(DOP853.B),
            "first": np.array(held[0], float),
            "last": np.array(held[1], float),
            "rate_weight": weight,
            "scale": self.scale,
        }
        self.offset = np.zeros(self.n)
        self.arrays["offset"] = self.offset
        self.row_lower = self.row_upper = np.zeros(self.m)
        self.lower, self.upper = np.full(self.n, -np.inf), np.full(self.n, np.inf)
        self.integration = None
        self._link(substeps or 1)
        if substeps is None:
            self._choose_substeps()
        self.offset[:] = self.nodes_of(start)
        self._link(self.structure.substeps)

    def _lay_samples(self):
        given = self.given
        samples, (start, end) = given["samples"], given["span_s"]
        times = np.array([sample["time_s"] for sample in samples])
        if times[0] != start or times[-1] != end or not np.all(np.diff(times) > 0):
            raise Unsupported("samples that do not reach from start to end, one at a time")
        count = len(times) - 1
        self.steps = -(-count // SEGMENTS)
        self.segments = -(-count // self.steps)
        # What is left of the last segment is steps of no length, and samples of no weight.
        spare = self.segments * self.steps - count
        self.node_samples = np.minimum(np.arange(self.segments + 1) * self.steps, count)
        seen = [sample["seen_m"] for sample in samples]
        self.arrays = {
            "interval_s": np.concatenate([np.diff(times), np.zeros(spare)]),
            "seen": np.array(seen + [seen[-1]] * spare, float),
            "weight": np.concatenate([np.ones(count + 1), np.zeros(spare)]),
        }

    def row_of(self, k):
        return 0 if k == 0 else self.library.rows["first"] + k * self.nx

    def _lay_patterns(self):
        nx, last, rows = self.nx, self.segments, self.library.rows
        self.n, self.m = nx * (last + 1), rows["first"] + nx * last + rows["last"]
        jacobian, upper = [], []
        for k in range(last + 1):
            for c in range(nx):
                column = k * nx + c
                own = [self.row_of(k - 1) + c] if k > 0 else []
                own += [self.row_of(k) + r for r in range(nx if k < last else rows["last"])]
                own += [nx + r for r in range(rows["first"] if k == 0 else 0)]
                jacobian += [(column, row) for row in own]
                upper += [(column, k * nx + r) for r in range(c + 1)]
        self.arrays |= self._patterns(jacobian, upper)
        ng = [rows["first"]] + [0] * (last - 1) + [rows["last"]]
        # For solvers that are told how stages follow one another.
        self.stages = {"N": last, "nx": [nx] * (last + 1), "nu": [0] * (last + 1), "ng": ng}

    def _link(self, substeps):
        pointers = {name: array.ctypes.data for name, array in self.arrays.items()}
        sizes = (self.n, self.m, self.segments, self.steps, substeps, DOP853.n_stages)
        self.structure = Structure(*sizes, **pointers)

    def _choose_substeps(self):
        points = [point["name"] for point in self.given["points"]]
        before = None
        for substeps in 2 ** np.arange(MOST_SUBSTEPS.bit_length() + 1):
            self._link(int(substeps))
            here = np.array([self.value_at(name) for name in points])
            if before is not None:
                self.integration = float(np.max(np.abs(here / before - 1)))
                if self.integration < INTEGRATES or substeps > MOST_SUBSTEPS:
                    break
            before = here
        self._link(int(substeps) // 2)

    def value_at(self, name):
        self.offset[:] = 0
        self.select()
        self.library.c.clock_start(1e9)
        return self.evaluate(self.nodes_of(name) / self.scale)[0]

    # Points.

    def point_named(self, name):
        for point in self.given["points"]:
            if point["name"] == name:
                return np.array(point["state"]["coordinates"] + point["state"]["rates"])
        raise Unsupported(f"no point {name}")

    def nodes_of(self, name):
        """States at all nodes, with no gaps between them; `sketch`: along the samples, with gaps."""
        if name == "sketch":
            return self._along_the_sketch(self.point_named("start"))
        x = self.point_named(name)
        self.select()
        nodes = [x]
        for k in range(self.segments):
            end = np.zeros(self.nx)
            self.library.c.flight(k, nodes[-1].ctypes.data, end.ctypes.data)
            nodes.append(end)
        return np.concatenate(nodes)

    def unknowns(self, name):
        return (self.nodes_of(name) - self.offset) / self.scale

    def _along_the_sketch(self, state):
        """Every node by damped inverse kinematics from the one before it, with the least rates that follow
        the samples about it."""
        tree, samples = self.tree, self.given["samples"]
        link, point, _ = self.library.sampled
        q_rate = ca.Function("q_rate", [tree.q, tree.u], [tree.q_rate])
        place = tree.bodies[link].at(point)
        moving = ca.jacobian(ca.jtimes(place, tree.q, tree.q_rate), tree.u)
        kinematics = ca.Function("kinematics", [tree.q], [place, moving])
        q, nodes = state[: tree.nq], []
        last = len(samples) - 1
        for at in self.node_samples:
            seen = np.array(samples[at]["seen_m"])
            for _ in range(ROUNDS if len(nodes) else 0):
                here, by = (np.array(out) for out in kinematics(q))
                inverse = by.T @ np.linalg.inv(by @ by.T + DAMPING * np.eye(3))
                q = q + np.array(q_rate(q, inverse @ (seen - here.ravel()))).ravel()
                for first in tree.quaternions():
                    q[first : first + 4] /= np.linalg.norm(q[first : first + 4])
            before, after = samples[max(at - BESIDE, 0)], samples[min(at + BESIDE, last)]
            moved = np.array(after["seen_m"]) - np.array(before["seen_m"])
            by = np.array(kinematics(q)[1])
            inverse = by.T @ np.linalg.inv(by @ by.T + DAMPING * np.eye(3))
            rates = inverse @ (moved / (after["time_s"] - before["time_s"]))
            nodes.append(np.concatenate([q, rates]))
        return np.concatenate(nodes)

    def groups(self):
        """The objective and the rows, segment by segment; what holds at the start and at the end."""
        parts = [Part(self, part, k) for k in range(self.segments) for part in (0, 1)]
        return parts + [Part(self, 2, 0), Part(self, 3, self.segments)]

    def rows_of_format(self, x):
        """Rows of the goals in the order of the format: orientations as rotation vectors."""
        state = (self.offset + self.scale * x).reshape(-1, self.nx)
        held = [self.arrays["first"], self.arrays["last"]]
        of = zip(self.library.all_rows, (state[0], state[-1]), held)
        rows = [np.array(function(node, values)).ravel() for function, node, values in of]
        at, result = [0, 0], []
        for goal in self.given["goals"]:
            which = int(goal["time_s"] != self.given["span_s"][0])
            size = len(goal["value"]) if goal["kind"] == "angles" else 3
            row = rows[which][at[which] : at[which] + size]
            at[which] += size
            if goal["kind"] == "orientation":
                half = np.linalg.norm(row) * goal["unit"] / 2
                row = row * (np.arcsin(min(half, 1.0)) / half if half > 1e-9 else 1.0)
            result.append(row)
        return np.concatenate(result)

    def described(self, x):
        """The state at the start, where there is one; its quaternions are of length one within the tolerance."""
        if x is None:
            return {"state": None}
        first = self.offset[: self.nx] + self.scale[: self.nx] * x[: self.nx]
        nq = self.tree.nq
        for at in self.tree.quaternions():
            first[at : at + 4] /= np.linalg.norm(first[at : at + 4])
        return {"state": {"coordinates": list(first[:nq]), "rates": list(first[nq:])}}
