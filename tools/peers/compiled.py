"""The terms of formulas.py as machine code: CasADi writes C, gcc compiles it, once."""

import ctypes
import hashlib
import json
import pathlib
import subprocess
import sys
import time

import casadi as ca

import formulas

HERE = pathlib.Path(__file__).parent
BUILD = HERE / "build"
FLAGS = ["-fno-math-errno", "-fPIC"]
# What is called once per sample; what is called once per event is so long that gcc would take
# minutes at -O3, for little.
LEVELS = {"often": "-O3", "seldom": "-O1"}
LIBRARY = BUILD / "terms.so"
TABLE = BUILD / "terms.json"


def functions(term):
    """Value, first derivative, second derivative, square of the Jacobian."""
    # The prefix keeps them apart from what else the process has: the C library has a `step`.
    name, z, p = "term_" + term.name, term.z, term.p
    is_scalar = term.value.is_scalar()
    if is_scalar and term.name in OBJECTIVE:
        slope = ca.densify(ca.gradient(term.value, z))
        curve = ca.triu(ca.hessian(term.value, z)[0])
        square = curve
        if term.residual is not None:
            j = ca.jacobian(term.residual, z)
            square = ca.project(ca.triu(2 * ca.mtimes(j.T, j)), curve.sparsity())
        arguments = [z, p]
        return [
            ca.Function(name, [z, p], ca.cse([term.value])),
            ca.Function(name + "_slope", [z, p], ca.cse([term.value, slope])),
            ca.Function(name + "_curve", arguments, ca.cse([curve])),
            ca.Function(name + "_square", arguments, ca.cse([square])),
        ]
    pull = ca.SX.sym("pull", term.value.numel())
    slope = ca.jacobian(term.value, z)
    curve = ca.triu(ca.hessian(ca.dot(pull, term.value), z)[0])
    square = ca.triu(ca.mtimes(slope.T, ca.mtimes(ca.diag(pull), slope)))
    pattern = curve.sparsity() + square.sparsity()
    curve, square = ca.project(curve, pattern), ca.project(square, pattern)
    return [
        ca.Function(name, [z, p], ca.cse([term.value])),
        ca.Function(name + "_slope", [z, p], ca.cse([term.value, slope])),
        ca.Function(name + "_curve", [z, p, pull], ca.cse([curve])),
        ca.Function(name + "_square", [z, p, pull], ca.cse([square])),
    ]


OBJECTIVE = set()


def c_array(values):
    return "{" + ", ".join(str(v) for v in values) + "}"


def build():
    """Writes, compiles, and says how long that took."""
    BUILD.mkdir(exist_ok=True)
    began = time.perf_counter()
    objective, constraints = formulas.terms()
    OBJECTIVE.update(term.name for term in objective)
    options = {"with_header": True}
    generators = {name: ca.CodeGenerator(name + ".c", options) for name in LEVELS}
    rows, patterns, about, work = [], [], [], 1
    for index, term in enumerate(objective + constraints):
        made = functions(term)
        for function in made:
            generators["often" if term.name in OBJECTIVE else "seldom"].add(function)
            work = max(work, function.sz_w())
        slope, curve = made[1].sparsity_out(1), made[2].sparsity_out(0)
        slope_row, slope_column = slope.get_triplet()
        curve_row, curve_column = curve.get_triplet()
        is_scalar = term.name in OBJECTIVE
        patterns.append(f"static const int row_{index}[] = {c_array(slope_row or [0])};")
        patterns.append(f"static const int column_{index}[] = {c_array(slope_column or [0])};")
        rows.append(
            f"{{{', '.join(f.name() for f in made)}, {term.z.numel()}, {term.p.numel()}, "
            f"{term.value.numel()}, {int(is_scalar)}, {slope.nnz()}, {curve.nnz()}, "
            f"row_{index}, column_{index}}},"
        )
        about.append(
            {
                "name": term.name,
                "z": term.z.numel(),
                "p": term.layout,
                "rows": term.value.numel(),
                "is_scalar": is_scalar,
                "slope": [list(slope_row), list(slope_column)],
                "curve": [list(curve_row), list(curve_column)],
            }
        )
    text = [f"#include \"{name}.h\"" for name in LEVELS]
    text += [f"#define WORK {work}", *patterns]
    text += ["static const term terms[] = {", *rows, "};"]
    (BUILD / "table.c").write_text("\n".join(text) + "\n")
    for name, generator in generators.items():
        generator.generate(str(BUILD) + "/")
    written = time.perf_counter()
    sources = {name: (str(BUILD / f"{name}.c"), level) for name, level in LEVELS.items()}
    sources["driver"] = (str(HERE / "driver.c"), "-O3")
    for name, (source, level) in sources.items():
        command = ["gcc", level, *FLAGS, f"-I{BUILD}", "-c", source, "-o", f"{BUILD}/{name}.o"]
        subprocess.run(command, check=True)
    objects = [f"{BUILD}/{name}.o" for name in sources]
    subprocess.run(["gcc", "-shared", "-Wl,-Bsymbolic", *objects, "-lm", "-o", str(LIBRARY)], check=True)
    seconds = {"casadi_s": written - began, "gcc_s": time.perf_counter() - written}
    TABLE.write_text(json.dumps({"key": key(), "seconds": seconds, "terms": about}))


def key():
    """Changes with everything that the machine code is made from."""
    names = ("formulas.py", "driver.c", "interface.h", "interface.c", "compiled.py")
    text = "".join((HERE / name).read_text() for name in names)
    return hashlib.sha256((text + ca.__version__).encode()).hexdigest()


def loaded(path):
    """Machine code behind interface.c."""
    c = ctypes.CDLL(path)
    c.clock_spent.restype = ctypes.c_double
    c.clock_count.restype = ctypes.c_longlong
    c.clock_start.argtypes = [ctypes.c_double]
    pointer = ctypes.c_void_p
    c.problem_evaluate.argtypes = [pointer] * 5
    c.problem_hessian.argtypes = [pointer, ctypes.c_double, pointer, pointer]
    return c


class Library:
    """The machine code and what is known of its terms."""

    def __init__(self):
        if not TABLE.exists() or json.loads(TABLE.read_text())["key"] != key():
            build()
        table = json.loads(TABLE.read_text())
        self.seconds, self.terms = table["seconds"], table["terms"]
        self.index = {term["name"]: k for k, term in enumerate(self.terms)}
        self.path = str(LIBRARY)
        self.c = loaded(self.path)
        pointer, whole = ctypes.c_void_p, ctypes.c_int
        self.c.group_evaluate.argtypes = [pointer, pointer, *[whole] * 5, pointer, pointer]


if __name__ == "__main__":
    library = Library()
    print(f"compiled: {library.seconds}", file=sys.stderr)
