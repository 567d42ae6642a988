"""What the compiled functions of interface.c compute, for Python, and patterns of the matrices."""

import ctypes

import numpy as np


class Program:
    """A problem with `n` unknowns and `m` rows, the `library` that computes it, its `structure` there and the
    `arrays` behind that."""

    def _patterns(self, jacobian, upper):
        """Compressed columns of matrices with these entries, (column, row)."""
        full = set(upper) | {(i, j) for j, i in upper}
        place = {key: k for k, key in enumerate(sorted(full))}
        full_map = [[place[j, i], place[i, j]] for j, i in sorted(upper)]
        self.jacobian_entries, self.hessian_entries = sorted(jacobian), len(upper)

        def columns(entries, rows):
            counts = np.zeros(self.n + 1, np.int64)
            for column, _ in entries:
                counts[column + 1] += 1
            start = np.cumsum(counts)
            index = [entry[1] for entry in sorted(entries)]
            return np.array([rows, self.n, *start, *index], np.int64)

        return {
            "jacobian": columns(jacobian, self.m),
            "upper": columns(upper, self.n),
            "full": columns(full, self.n),
            "full_map": np.array(full_map, np.int32),
        }

    def select(self):
        """Makes it the problem that the compiled functions are of."""
        self.library.c.problem_set(ctypes.byref(self.structure))

    def evaluate(self, x, slopes=False):
        """Objective and rows; with slopes, gradient and entries of the Jacobian too."""
        x = np.ascontiguousarray(x, float)
        f, g = np.zeros(1), np.zeros(self.m)
        gradient, jacobian = np.zeros(self.n), np.zeros(len(self.jacobian_entries))
        pointers = [f, gradient if slopes else None, g, jacobian if slopes else None]
        pointers = [None if a is None else a.ctypes.data for a in pointers]
        code = self.library.c.problem_evaluate(x.ctypes.data, *pointers)
        if code:
            raise TimeoutError
        return (f[0], gradient, g, jacobian) if slopes else (f[0], g)

    def hessian(self, x, sigma, pull):
        """Upper triangle of the Lagrangian's Hessian, dense and symmetric."""
        x, pull = np.ascontiguousarray(x, float), np.ascontiguousarray(pull, float)
        out = np.zeros(self.hessian_entries)
        self.library.c.problem_hessian(x.ctypes.data, sigma, pull.ctypes.data, out.ctypes.data)
        pattern = self.arrays["upper"]
        start, index = pattern[2 : self.n + 3], pattern[self.n + 3 :]
        dense = np.zeros((self.n, self.n))
        for column in range(self.n):
            for k in range(start[column], start[column + 1]):
                dense[index[k], column] = dense[column, index[k]] = out[k]
        return dense

    def violation(self, x):
        """Largest violation of any row, in its units."""
        _, g = self.evaluate(x)
        if not np.all(np.isfinite(g)):
            return float("inf")
        return float(np.max(np.maximum(self.row_lower - g, g - self.row_upper), initial=0.0))
