/* Objective, constraints and derivatives of one problem, summed from compiled terms.
 *
 * Unknowns are z = offset + scale * x. Every element is a term (`kind`), the unknowns it reads
 * (-1: a constant), its constants, and where its rows go: >= 0 a constraint, -1 the objective as
 * weight * square, -2 nowhere. */
#include "interface.h"

typedef struct {
    function value, slope, curve, square;
    int z, p, rows, is_scalar;
    int slope_entries, curve_entries;
    const int *slope_row, *slope_column;
} term;

#include "table.c"

typedef struct {
    integer n, m, elements;
    const int *kind, *variable_at, *p_at, *row_at, *slope_at, *curve_at;
    const int *variable, *row, *slope_map, *curve_map;
    const real *constant, *p, *weight, *offset, *scale;
    /* Compressed columns: rows, columns, column starts, row indices. */
    const integer *jacobian, *upper, *full;
    /* Where every entry of the upper triangle goes in the full matrix, twice. */
    const int *full_map;
} problem;

static problem P;
static real work[WORK], slopes[4096], curves[8192], values[64], gathered[128], unknowns[65536];
static integer integers[4096];

void problem_set(const problem *given) { P = *given; }
static void gather(int e) {
    const int *variable = P.variable + P.variable_at[e];
    const real *constant = P.constant + P.variable_at[e];
    int n = terms[P.kind[e]].z;
    for (int k = 0; k < n; ++k)
        gathered[k] = variable[k] >= 0 ? unknowns[variable[k]] : constant[k];
}

static void place(const real *x) {
    for (integer i = 0; i < P.n; ++i) unknowns[i] = P.offset[i] + P.scale[i] * x[i];
}

/* Whether an element is part of the objective, of the constraints. */
static int touches(int e, int objective) {
    const term *t = &terms[P.kind[e]];
    if (t->is_scalar) return objective;
    const int *row = P.row + P.row_at[e];
    for (int r = 0; r < t->rows; ++r)
        if (objective ? row[r] == -1 : row[r] >= 0) return 1;
    return 0;
}

static int evaluate(const real *x, real *f, real *gradient, real *g, real *jacobian) {
    place(x);
    if (f) *f = 0.0;
    if (gradient) memset(gradient, 0, sizeof(real) * P.n);
    if (jacobian) memset(jacobian, 0, sizeof(real) * P.jacobian[2 + P.n]);
    int for_objective = f || gradient, for_rows = g || jacobian;
    int with_slopes = gradient || jacobian;
    for (int e = 0; e < P.elements; ++e) {
        if (!((for_objective && touches(e, 1)) || (for_rows && touches(e, 0)))) continue;
        const term *t = &terms[P.kind[e]];
        const int *variable = P.variable + P.variable_at[e];
        gather(e);
        const real *arg[2] = {gathered, P.p + P.p_at[e]};
        real *res[2] = {values, slopes};
        if ((with_slopes ? t->slope : t->value)(arg, res, integers, work, 0)) return 1;
        if (t->is_scalar) {
            if (f) *f += values[0];
            if (gradient)
                for (int k = 0; k < t->z; ++k)
                    if (variable[k] >= 0) gradient[variable[k]] += slopes[k] * P.scale[variable[k]];
            continue;
        }
        const int *row = P.row + P.row_at[e];
        real weight = P.weight[e];
        for (int r = 0; r < t->rows; ++r) {
            if (row[r] >= 0 && g) g[row[r]] = values[r];
            if (row[r] == -1 && f) *f += weight * values[r] * values[r];
        }
        if (!with_slopes) continue;
        const int *map = P.slope_map + P.slope_at[e];
        for (int k = 0; k < t->slope_entries; ++k) {
            int v = variable[t->slope_column[k]], r = t->slope_row[k];
            if (v < 0) continue;
            if (row[r] == -1 && gradient)
                gradient[v] += 2.0 * weight * values[r] * slopes[k] * P.scale[v];
            if (row[r] >= 0 && jacobian) jacobian[map[k]] = slopes[k] * P.scale[v];
        }
    }
    return 0;
}

static void add_curves(int e, real factor, real *hessian) {
    const term *t = &terms[P.kind[e]];
    const int *map = P.curve_map + P.curve_at[e];
    for (int k = 0; k < t->curve_entries; ++k)
        if (map[k] >= 0) hessian[map[k]] += factor * curves[k];
}

/* Upper triangle of the Hessian of sigma * objective + lambda' constraints. */
static int hessian_upper(const real *x, real sigma, const real *lambda, real *hessian) {
    place(x);
    memset(hessian, 0, sizeof(real) * P.upper[2 + P.n]);
    real pull[64], square[64];
    for (int e = 0; e < P.elements; ++e) {
        const term *t = &terms[P.kind[e]];
        gather(e);
        real *res[1] = {curves};
        if (t->is_scalar) {
            const real *arg[2] = {gathered, P.p + P.p_at[e]};
            if ((gauss_newton ? t->square : t->curve)(arg, res, integers, work, 0)) return 1;
            add_curves(e, sigma, hessian);
            continue;
        }
        const int *row = P.row + P.row_at[e];
        const real *arg[3] = {gathered, P.p + P.p_at[e], pull};
        int priced = touches(e, 1);
        if (priced) {
            real *value[1] = {values};
            if (t->value(arg, value, integers, work, 0)) return 1;
        }
        for (int r = 0; r < t->rows; ++r) {
            real w = 2.0 * sigma * P.weight[e];
            square[r] = row[r] == -1 ? w : 0.0;
            pull[r] = row[r] >= 0 ? (lambda ? lambda[row[r]] : 0.0)
                    : row[r] == -1 && !gauss_newton ? w * values[r] : 0.0;
        }
        if (gauss_newton < 2) {
            if (t->curve(arg, res, integers, work, 0)) return 1;
            add_curves(e, 1.0, hessian);
        }
        if (priced) {
            arg[2] = square;
            if (t->square(arg, res, integers, work, 0)) return 1;
            add_curves(e, 1.0, hessian);
        }
    }
    const integer *start = P.upper + 2, *index = start + P.n + 1;
    for (integer c = 0; c < P.n; ++c)
        for (integer k = start[c]; k < start[c + 1]; ++k)
            hessian[k] *= P.scale[c] * P.scale[index[k]];
    return 0;
}

#include "interface.c"

/* Elements `from` to `to` on their own unknowns: the sum of what they add to the objective, and
 * its gradient; or else their rows, from `first` on, and the Jacobian, row by row. */
static int place_of[65536];
int group_evaluate(const real *x, const int *own, int n, int from, int to, int first, int rows,
                   real *value, real *slope) {
    double began = now();
    if (began > deadline) return 2;
    for (int k = 0; k < n; ++k) {
        unknowns[own[k]] = P.offset[own[k]] + P.scale[own[k]] * x[k];
        place_of[own[k]] = k;
    }
    memset(slope, 0, sizeof(real) * n * (rows ? rows : 1));
    memset(value, 0, sizeof(real) * (rows ? rows : 1));
    for (int e = from; e < to; ++e) {
        const term *t = &terms[P.kind[e]];
        const int *variable = P.variable + P.variable_at[e], *row = P.row + P.row_at[e];
        gather(e);
        const real *arg[2] = {gathered, P.p + P.p_at[e]};
        real *res[2] = {values, slopes}, weight = P.weight[e];
        if (t->slope(arg, res, integers, work, 0)) return 1;
        if (t->is_scalar) {
            value[0] += values[0];
            for (int k = 0; k < t->z; ++k)
                if (variable[k] >= 0)
                    slope[place_of[variable[k]]] += slopes[k] * P.scale[variable[k]];
            continue;
        }
        for (int r = 0; r < t->rows; ++r) {
            if (rows && row[r] >= 0) value[row[r] - first] = values[r];
            if (!rows && row[r] == -1) value[0] += weight * values[r] * values[r];
        }
        for (int k = 0; k < t->slope_entries; ++k) {
            int v = variable[t->slope_column[k]], r = t->slope_row[k];
            if (v < 0) continue;
            if (rows && row[r] >= 0)
                slope[(row[r] - first) * n + place_of[v]] = slopes[k] * P.scale[v];
            if (!rows && row[r] == -1)
                slope[place_of[v]] += 2.0 * weight * values[r] * slopes[k] * P.scale[v];
        }
    }
    counts[0] += from == 0;
    spent += now() - began;
    return 0;
}
