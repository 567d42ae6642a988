"""The peers: general solvers on an assembled problem, each from x = 0, the starting point."""

import time

import casadi as ca
import numpy as np

# Far tighter than the judgement (1e-6 units, 2e-5 of the objective) needs would cost time.
TOLERANCE = 1e-8
ITERATIONS = 3000

QUIET = {
    "print_time": False,
    "error_on_fail": False,
    "no_nlp_grad": True,
    "calc_lam_p": False,
    "calc_multipliers": False,
}
QUIET_QP = {"print_iter": False, "print_header": False, "print_info": False, "error_on_fail": False}


class Outcome:
    """Where a solve ended and what it says of itself."""

    def __init__(self, x, status, iterations, seconds):
        self.x, self.status, self.iterations, self.seconds = x, status, iterations, seconds


def casadi_solver(problem, plugin, options, full, least_squares):
    """A function that solves by one of CasADi's solvers."""
    library = problem.library

    def select():
        problem.select()
        library.c.options_set(int(full), least_squares)

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
                np.array(x).ravel(), stats["return_status"], stats.get("iter_count"), seconds
            )
        except RuntimeError as error:
            seconds = time.perf_counter() - began
            status = "over the limit" if seconds >= limit else str(error).splitlines()[-1]
            return Outcome(None, status, None, seconds)

    return solve


def casadi_ipopt(problem, limit, **more):
    options = {
        "print_level": 0,
        "sb": "yes",
        "tol": TOLERANCE,
        "constr_viol_tol": 1e-7,
        "max_iter": ITERATIONS,
        "max_wall_time": limit,
        **more,
    }
    return casadi_solver(problem, "ipopt", {"ipopt": options}, False, 0)


def casadi_sqp(problem, limit, plugin="sqpmethod", qp="qrqp", least_squares=0, **more):
    options = {
        "qpsol": qp,
        "qpsol_options": dict(QUIET_QP) if qp == "qrqp" else {"error_on_fail": False},
        "print_header": False,
        "print_iteration": False,
        "print_status": False,
        "max_iter": ITERATIONS,
        "tol_pr": 1e-8,
        "tol_du": 1e-5,
        **more,
    }
    return casadi_solver(problem, plugin, options, True, least_squares)


def drake_solver(problem, limit, which, options=None):
    """A function that solves by one of Drake's solvers."""
    from pydrake.autodiffutils import ExtractValue, InitializeAutoDiff
    from pydrake import solvers

    program = solvers.MathematicalProgram()
    x = program.NewContinuousVariables(problem.n)
    bounded = np.isfinite(problem.lower) | np.isfinite(problem.upper)
    if bounded.any():
        program.AddBoundingBoxConstraint(
            problem.lower[bounded], problem.upper[bounded], x[bounded]
        )
    columns, rows = (np.array(e) for e in zip(*problem.jacobian_entries))
    memory = {"at": None, "answer": None}

    def evaluated(x):
        """Everything at once, for cost and constraint are asked for at the same points."""
        if x.dtype != float:
            x = ExtractValue(x).ravel()
        if memory["at"] is None or not np.array_equal(memory["at"], x):
            memory["answer"] = problem.evaluate(x, slopes=True)
            memory["at"] = x.copy()
        return memory["answer"]

    def cost(x):
        f, gradient, _, _ = evaluated(x)
        if x.dtype == float:
            return f
        return InitializeAutoDiff(np.array([[f]]), gradient[None, :]).ravel()[0]

    def constraint(x):
        _, _, g, entries = evaluated(x)
        if x.dtype == float:
            return g
        jacobian = np.zeros((problem.m, problem.n))
        jacobian[rows, columns] = entries
        return InitializeAutoDiff(g[:, None], jacobian).ravel()

    program.AddCost(cost, x)
    binding = program.AddConstraint(constraint, problem.row_lower, problem.row_upper, x)
    pattern = [(int(r), int(c)) for c, r in problem.jacobian_entries]
    binding.evaluator().SetGradientSparsityPattern(pattern)
    solver = {"snopt": solvers.SnoptSolver, "ipopt": solvers.IpoptSolver}[which]()
    settings = solvers.SolverOptions()
    for key, value in (options or {}).items():
        settings.SetOption(solver.solver_id(), key, value)
    start = np.zeros(problem.n)

    def solve(limit):
        problem.select()
        problem.library.c.clock_start(limit)
        memory["at"] = None
        began = time.perf_counter()
        try:
            result = solver.Solve(program, start, settings)
            seconds = time.perf_counter() - began
            details = result.get_solver_details()
            code = getattr(details, "info", getattr(details, "status", None))
            iterations = getattr(details, "iterations", None)
            status = f"{result.get_solution_result().name}, {code}"
            return Outcome(np.array(result.GetSolution(x)), status, iterations, seconds)
        except TimeoutError:
            return Outcome(None, "over the limit", None, time.perf_counter() - began)
        except RuntimeError as error:
            seconds = time.perf_counter() - began
            return Outcome(None, str(error).splitlines()[0], None, seconds)

    return solve


def drake_snopt(problem, limit, **more):
    options = {
        "Major optimality tolerance": 1e-6,
        "Major feasibility tolerance": 1e-8,
        "Major iterations limit": ITERATIONS,
        "Iterations limit": 100000,
        **{key.replace("_", " "): value for key, value in more.items()},
    }
    return drake_solver(problem, limit, "snopt", options)


def drake_ipopt(problem, limit, **more):
    options = {
        "tol": TOLERANCE,
        "constr_viol_tol": 1e-7,
        "max_iter": ITERATIONS,
        "max_wall_time": float(limit),
        **more,
    }
    return drake_solver(problem, limit, "ipopt", options)


PEERS = {
    "CasADi, IPOPT": casadi_ipopt,
    "CasADi, SQP": casadi_sqp,
    "Drake, SNOPT": drake_snopt,
    "Drake, IPOPT": drake_ipopt,
}
