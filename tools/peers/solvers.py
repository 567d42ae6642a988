"""The peers: general solvers on an assembled problem, each from x = 0, the starting point."""

import time

import casadi as ca
import numpy as np

# Of constraints, in units. Far tighter than the judgement (1e-6 units, 2e-5 of the objective)
# needs would cost time.
TOLERANCE = 1e-8
ITERATIONS = 3000
# Which Hessian: `gauss_newton` of driver.c.
EXACT, GAUSS_NEWTON = 0, 2
# In which form: interface.h.
UPPER, FULL, FATROP = 0, 1, 2

QUIET = {
    "show_eval_warnings": False,
    "print_time": False,
    "error_on_fail": False,
    "no_nlp_grad": True,
    "calc_lam_p": False,
    "calc_multipliers": False,
}
QUIET_QP = {"print_iter": False, "print_header": False, "print_info": False}
QUIET_PIQP = {"error_on_fail": False, "piqp": {"verbose": False}}
# Unknowns up to which CasADi's dense-minded active set method is the fastest for the programmes
# of its SQP, and beyond which PIQP is.
SMALL = 50
QUIET_QP |= {"error_on_fail": False, "max_iter": 300}


class Outcome:
    """Where a solve ended and what it says of itself."""

    def __init__(self, x, status, iterations, seconds, callback_seconds=None, succeeded=False):
        self.x, self.status, self.iterations, self.seconds = x, status, iterations, seconds
        # Whether it says that it has converged.
        self.succeeded = succeeded
        # In Python, between the solver and the compiled formulas.
        self.callback_seconds = callback_seconds


def drake_version():
    from importlib.metadata import version

    return version("drake")


def casadi_solver(problem, plugin, options, form, least_squares):
    """A function that solves by one of CasADi's solvers."""
    library = problem.library

    def select():
        problem.select()
        library.c.options_set(form, least_squares)

    select()
    solver = ca.nlpsol("solver", plugin, library.path, {**QUIET, **options})
    bounds = {
        "x0": np.zeros(problem.n),
        "lbx": problem.lower,
        "ubx": problem.upper,
        "lbg": problem.row_lower,
        "ubg": problem.row_upper,
    }
    bounds = {key: ca.DM(value) for key, value in bounds.items()}

    def solve(limit):
        select()
        library.c.clock_start(limit)
        began = time.perf_counter()
        try:
            x = solver(**bounds)["x"]
            seconds = time.perf_counter() - began
            stats = solver.stats()
            return Outcome(
                np.array(x).ravel(),
                stats["return_status"],
                stats.get("iter_count"),
                seconds,
                succeeded=stats["success"],
            )
        except RuntimeError as error:
            seconds = time.perf_counter() - began
            status = "over the limit" if seconds >= limit else str(error).splitlines()[-1]
            return Outcome(None, status, None, seconds)

    return solve


def casadi_ipopt(problem, limit, tolerance=TOLERANCE, **more):
    options = {
        "print_level": 0,
        "sb": "yes",
        "tol": tolerance,
        "constr_viol_tol": 10 * tolerance,
        "max_iter": ITERATIONS,
        "max_wall_time": float(limit),
        # Solves one in twenty more than the default, in as much time.
        "mu_init": 1e-3,
        **more,
    }
    return casadi_solver(problem, "ipopt", {"ipopt": options}, UPPER, EXACT)


def casadi_sqp(problem, limit, tolerance=TOLERANCE, least_squares=GAUSS_NEWTON, **more):
    """With the exact Hessian instead it solves half as many, with each of CasADi's other SQP
    methods fewer, with OSQP, qpOASES or DAQP for its programmes as many or fewer."""
    is_small = problem.n <= SMALL
    options = {
        "qpsol": "qrqp" if is_small else "piqp",
        "qpsol_options": QUIET_QP if is_small else QUIET_PIQP,
        "print_header": False,
        "print_iteration": False,
        "print_status": False,
        "max_iter": ITERATIONS,
        "max_iter_ls": 10,
        "beta": 0.5,
        "tol_pr": tolerance,
        "tol_du": 1e3 * tolerance,
        **more,
    }
    return casadi_solver(problem, "sqpmethod", options, FULL, least_squares)


def casadi_fatrop(problem, limit, tolerance=TOLERANCE, **more):
    """Needs to know the stages, and stops by its iterations alone: a limit of time that formulas set."""
    options = {
        "no_nlp_grad": False,
        "structure_detection": "manual",
        **problem.stages,
        "equality": [True] * problem.m,
        "fatrop": {"tol": tolerance, "max_iter": ITERATIONS, "print_level": 0, **more},
    }
    return casadi_solver(problem, "fatrop", options, FATROP, EXACT)


def drake_solver(problem, limit, which, options=None):
    """A function that solves by one of Drake's solvers. Drake hands over and takes back arrays of
    AutoDiff objects, which costs more than the formulas; with one evaluator per arc and per
    event, each on its own unknowns, they are smaller by far than with one for all."""
    from pydrake import solvers
    from pydrake.autodiffutils import ExtractValue, InitializeAutoDiff

    program = solvers.MathematicalProgram()
    x = program.NewContinuousVariables(problem.n)
    bounded = np.isfinite(problem.lower) | np.isfinite(problem.upper)
    if bounded.any():
        program.AddBoundingBoxConstraint(problem.lower[bounded], problem.upper[bounded], x[bounded])
    spent = [0.0]

    def evaluator(group, is_cost):
        def evaluate(x):
            began = time.perf_counter()
            is_plain = x.dtype == float
            values, slopes = group.evaluate(x if is_plain else ExtractValue(x).ravel())
            if not is_plain:
                values = InitializeAutoDiff(values[:, None], slopes).ravel()
            spent[0] += time.perf_counter() - began
            return values[0] if is_cost else values

        return evaluate

    for group in problem.groups():
        own = x[group.variables]
        if group.rows is None:
            program.AddCost(evaluator(group, True), own)
        elif group.is_linear:
            values, slopes = group.evaluate(np.zeros(len(own)))
            low, high = problem.row_lower[group.rows], problem.row_upper[group.rows]
            program.AddLinearConstraint(slopes, low - values, high - values, own)
        else:
            low, high = problem.row_lower[group.rows], problem.row_upper[group.rows]
            binding = program.AddConstraint(evaluator(group, False), low, high, own)
            binding.evaluator().SetGradientSparsityPattern(group.pattern)
    solver = {"snopt": solvers.SnoptSolver, "ipopt": solvers.IpoptSolver}[which]()
    settings = solvers.SolverOptions()
    for key, value in (options or {}).items():
        settings.SetOption(solver.solver_id(), key, value)
    start = np.zeros(problem.n)

    def solve(limit):
        problem.select()
        problem.library.c.clock_start(limit)
        spent[0] = 0.0
        began = time.perf_counter()
        try:
            result = solver.Solve(program, start, settings)
        except Exception as error:
            # What the evaluators raise comes back as one type or another.
            seconds = time.perf_counter() - began
            return Outcome(None, str(error).splitlines()[0], None, seconds, spent[0])
        seconds = time.perf_counter() - began
        details = result.get_solver_details()
        code = getattr(details, "info", getattr(details, "status", None))
        iterations = getattr(details, "iterations", None)
        status = f"{result.get_solution_result().name}, {code}"
        return Outcome(
            np.array(result.GetSolution(x)),
            status,
            iterations,
            seconds,
            spent[0],
            result.is_success(),
        )

    return solve


def drake_snopt(problem, limit, tolerance=TOLERANCE, **more):
    options = {
        "Major optimality tolerance": 100 * tolerance,
        "Major feasibility tolerance": tolerance,
        "Major iterations limit": ITERATIONS,
        "Iterations limit": 100000,
        **{key.replace("_", " "): value for key, value in more.items()},
    }
    return drake_solver(problem, limit, "snopt", options)


def drake_ipopt(problem, limit, tolerance=TOLERANCE, **more):
    options = {
        "tol": tolerance,
        "constr_viol_tol": 10 * tolerance,
        "max_iter": ITERATIONS,
        "max_wall_time": float(limit),
        **more,
    }
    return drake_solver(problem, limit, "ipopt", options)


PEERS = {
    "CasADi, IPOPT": casadi_ipopt,
    "CasADi, SQP": casadi_sqp,
    "CasADi, fatrop": casadi_fatrop,
    "Drake, SNOPT": drake_snopt,
    "Drake, IPOPT": drake_ipopt,
}
# Those that need not know the stages of a problem.
UNSTAGED = [name for name in PEERS if name != "CasADi, fatrop"]
