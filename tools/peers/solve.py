"""Solves exported problems by general solvers.

    solve.py FOLDER ANSWERS [--repeats N] [--limit S] [--tolerance U] [--from POINT] [--peers NAMES]

reads every `*.json` of the folder in the order of their names, shows that its own formulas agree
with what the files say, solves, and writes ANSWERS (JSON). README.md has both formats.
"""

import argparse
import json
import os
import pathlib
import platform
import select
import signal
import sys

os.environ.setdefault("OMP_NUM_THREADS", "1")
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import casadi as ca
import numpy as np
import pydrake

import agree
import solvers
from assemble import Assembled, Unsupported
from compiled import FLAGS, LEVELS, Library

# Formulas that differ by more, or derivatives that are off by more, make no comparison.
AGREES, DERIVES = 1e-9, 1e-5
# What a solver is given beyond the limit, for it looks at the clock now and then only [s].
GRACE_S = 1.0
OVER = "over the limit"


def disagreement(agreement):
    for key in ("objective", "constraint"):
        if not agreement[key] < AGREES:
            return f"the {key} differs by {agreement[key]:.1e}"
    if not agreement["derivative"] < DERIVES:
        return f"a derivative is off by {agreement['derivative']:.1e}"
    return None


def number(value):
    """For JSON: none in place of what is no number."""
    return float(value) if value is not None and np.isfinite(value) else None


def answer_of(index, problem, name, repeats, limit, tolerance):
    """The best of some solves, as JSON has it."""
    solve = solvers.PEERS[name](problem, limit, tolerance)
    best, seconds = None, []
    for _ in range(repeats):
        outcome = solve(limit)
        formulas = problem.library.c.clock_spent()
        evaluations = int(problem.library.c.clock_count(0))
        seconds.append(outcome.seconds)
        if outcome.seconds <= min(seconds):
            best = (outcome, formulas, evaluations)
        if outcome.x is None or outcome.seconds > 0.5 * limit:
            break
    outcome, formulas, evaluations = best
    objective = violation = None
    problem.library.c.clock_start(1e9)
    x = outcome.x if outcome.x is not None and np.all(np.isfinite(outcome.x)) else None
    if x is not None:
        objective = problem.evaluate(x)[0]
        violation = problem.violation(x)
    return {
        "problem": index,
        "peer": name,
        "status": OVER if outcome.seconds >= limit else str(outcome.status),
        "succeeded": bool(outcome.succeeded),
        "seconds": [min(seconds), max(seconds)],
        "formula_seconds": formulas,
        "callback_seconds": outcome.callback_seconds,
        "objective": number(objective),
        "violation": number(violation),
        "evaluations": evaluations,
        "iterations": outcome.iterations,
        **problem.described(x),
    }


def answer_within(index, problem, name, repeats, limit, tolerance):
    """The same in a process of its own, which is ended where a solver does not end by itself."""
    reader, writer = os.pipe()
    child = os.fork()
    if child == 0:
        os.close(reader)
        try:
            answer = answer_of(index, problem, name, repeats, limit, tolerance)
            os.write(writer, json.dumps(answer).encode())
        finally:
            os._exit(0)
    os.close(writer)
    patience = repeats * limit + GRACE_S
    text, status = b"", "ended without an answer"
    if select.select([reader], [], [], patience)[0]:
        with os.fdopen(reader, "rb") as pipe:
            text = pipe.read()
    else:
        os.close(reader)
        os.kill(child, signal.SIGKILL)
        status = OVER
    os.waitpid(child, 0)
    if text:
        return json.loads(text)
    return {
        "problem": index,
        "peer": name,
        "status": status,
        "succeeded": False,
        "seconds": [limit, limit],
        "formula_seconds": 0.0,
        "callback_seconds": None,
        "objective": None,
        "violation": None,
        "evaluations": 0,
        "iterations": None,
        **problem.described(None),
    }


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("folder", type=pathlib.Path)
    parser.add_argument("answers", type=pathlib.Path)
    parser.add_argument("--repeats", type=int, default=3)
    parser.add_argument("--limit", type=float, default=2.0)
    parser.add_argument("--tolerance", type=float, default=solvers.TOLERANCE)
    parser.add_argument("--from", dest="start", default="start")
    parser.add_argument("--peers", default="|".join(solvers.UNSTAGED))
    options = parser.parse_args()
    names = options.peers.split("|")

    library = Library()
    agreements, problems, answers = [], [], []
    for index, path in enumerate(sorted(options.folder.glob("*.json"))):
        given = json.loads(path.read_text())
        agreement = {"objective": 0.0, "constraint": 0.0, "derivative": 0.0, "refused": None}
        try:
            problem = Assembled(library, given, options.start)
            agreement |= agree.agreement(problem)
            agreement["refused"] = disagreement(agreement)
        except Unsupported as reason:
            agreement["refused"] = str(reason)
        agreements.append({"problem": index, **agreement})
        if agreement["refused"] is None:
            problems.append((index, problem))
    # What is loaded at the first solve is not the solver's time.
    for index, problem in problems[:1]:
        for name in names:
            answer_of(index, problem, name, 1, options.limit, options.tolerance)
    for index, problem in problems:
        for name in names:
            how = (options.repeats, options.limit, options.tolerance)
            answers.append(answer_within(index, problem, name, *how))
    versions = {
        "python": platform.python_version(),
        "casadi": ca.__version__,
        "drake": getattr(pydrake, "__version__", None) or solvers.drake_version(),
        "numpy": np.__version__,
        "flags": " ".join([*FLAGS, *LEVELS.values()]),
        "compile_s": library.seconds,
    }
    report = {"versions": versions, "agreements": agreements, "answers": answers}
    options.answers.write_text(json.dumps(report))


if __name__ == "__main__":
    sys.exit(main())
