"""Whether the formulas here and enact's give the same numbers, and whether derivatives are right."""

import numpy as np

# A step for difference quotients, in units of the solvers' unknowns.
STEP = 1e-5


def agreement(problem):
    """Largest differences over all points of the format."""
    problem.select()
    problem.library.c.clock_start(1e9)
    problem.library.c.options_set(0, 0)
    objective = constraint = derivative = 0.0
    for point in problem.given["points"]:
        x = problem.unknowns(point)
        f, _ = problem.evaluate(x)
        rows = problem.rows_of_format(x)
        theirs = np.array([row["value"] for row in point["rows"]])
        objective = max(objective, abs(f - point["objective"]) / max(point["objective"], 1e-12))
        constraint = max(constraint, np.max(np.abs(rows - theirs), initial=0.0))
        derivative = max(derivative, slopes_differ(problem, x))
    return {
        "objective": float(objective),
        "constraint": float(constraint),
        "derivative": derivative,
    }


def slopes_differ(problem, x):
    """First and second derivatives along one direction against central differences."""
    direction = np.cos(np.arange(problem.n) * 1.7 + 0.3)
    pull = np.sin(np.arange(problem.m) * 0.9 + 0.2)

    def lagrangian_slope(x):
        _, gradient, _, jacobian = problem.evaluate(x, slopes=True)
        slope = gradient.copy()
        for (column, row), entry in zip(problem.jacobian_entries, jacobian):
            slope[column] += entry * pull[row]
        return slope

    def lagrangian(x):
        f, g = problem.evaluate(x)
        return f + pull @ g

    ahead, behind = x + STEP * direction, x - STEP * direction
    slope = (lagrangian(ahead) - lagrangian(behind)) / (2 * STEP)
    exact = lagrangian_slope(x)
    first = abs(slope - exact @ direction) / np.abs(exact * direction).sum()
    curve = (lagrangian_slope(ahead) - lagrangian_slope(behind)) / (2 * STEP)
    exact = problem.hessian(x, 1.0, pull) @ direction
    second = np.max(np.abs(curve - exact)) / np.max(np.abs(exact))
    return float(max(first, second))
