"""Solves a joined problem by general solvers, from several starts.

    joined.py FILE ANSWERS [--limit S] [--tolerance U] [--from POINTS] [--peers NAMES]

shows by how much its own formulas agree with what the file says, solves, and writes ANSWERS (JSON). README.md has both
formats. What agrees enough is judged by who asks.
"""

import argparse
import json
import os
import pathlib
import platform
import sys

os.environ.setdefault("OMP_NUM_THREADS", "1")
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import casadi as ca
import numpy as np

import agree
import solvers
from shooting import Mechanism, Shooting
from solve import answer_within, number

PEERS = ["CasADi, IPOPT", "CasADi, SQP", "CasADi, fatrop", "Drake, SNOPT"]


def agreement(problem):
    """Largest differences over all points of the file."""
    result = {"accelerations": 0.0, "objective": 0.0, "rows": 0.0, "derivative": 0.0}

    def worst(key, off):
        result[key] = float(np.maximum(result[key], off))

    rate = problem.library.functions["rate"]
    problem.library.c.options_set(0, solvers.EXACT)
    for point in problem.given["points"]:
        name, theirs = point["name"], np.array(point["accelerations"])
        ours = np.array(rate(problem.point_named(name))[1]).ravel()
        # At rest there are none: what is less than a rad/s^2 counts as one.
        worst("accelerations", np.max(np.abs(ours - theirs)) / max(np.max(np.abs(theirs)), 1.0))
        x = problem.unknowns(name)
        problem.select()
        problem.library.c.clock_start(1e9)
        f, _ = problem.evaluate(x)
        worst("objective", abs(f / point["objective"] - 1))
        worst("rows", np.max(np.abs(problem.rows_of_format(x) - point["rows"])))
        worst("derivative", agree.slopes_differ(problem, x))
    result["integration"] = problem.integration
    return {key: number(off) for key, off in result.items()} | {
        "substeps": int(problem.structure.substeps),
    }


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("file", type=pathlib.Path)
    parser.add_argument("answers", type=pathlib.Path)
    parser.add_argument("--limit", type=float, default=60.0)
    parser.add_argument("--tolerance", type=float, default=solvers.TOLERANCE)
    parser.add_argument("--from", dest="starts", default="start|sketch|truth")
    parser.add_argument("--peers", default="|".join(PEERS))
    options = parser.parse_args()
    given = json.loads(options.file.read_text())
    assert given["format"] == "enact joined problem 1", given["format"]
    names = [point["name"] for point in given["points"]]
    assert len(set(names)) == len(names), "points are found by their names"
    library = Mechanism(given)
    problem = Shooting(library, given)
    agrees = agreement(problem)
    answers = []
    for start in options.starts.split("|"):
        from_there = Shooting(library, given, start, agrees["substeps"])
        for name in options.peers.split("|"):
            answer = answer_within(0, from_there, name, 1, options.limit, options.tolerance)
            answers.append(answer | {"from": start})
    versions = {
        "python": platform.python_version(),
        "casadi": ca.__version__,
        "drake": solvers.drake_version(),
        "numpy": np.__version__,
        "build_s": library.seconds,
    }
    report = {"versions": versions, "agreement": agrees, "answers": answers}
    options.answers.write_text(json.dumps(report))


if __name__ == "__main__":
    sys.exit(main())
