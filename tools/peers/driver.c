/* Objective, constraints and derivatives of one problem, summed from compiled terms, behind the
 * interface that CasADi expects of an external function. The problem is global state: one at a
 * time per process.
 *
 * Unknowns are z = offset + scale * x. Every element is a term (`kind`), the unknowns it reads
 * (-1: a constant), its constants, and where its rows go: >= 0 a constraint, -1 the objective as
 * weight * square, -2 nowhere. */
#include <math.h>
#include <string.h>
#include <time.h>

typedef double real;
typedef long long int integer;
typedef int (*function)(const real **, real **, integer *, real *, int);

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
static int wants_full, gauss_newton;
static double deadline;
static double spent;
static long long counts[4];
static real work[WORK], slopes[4096], curves[8192], values[64], gathered[128], unknowns[65536];
static integer integers[4096];

static double now(void) {
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return t.tv_sec + 1e-9 * t.tv_nsec;
}

void problem_set(const problem *given) { P = *given; }
void options_set(int full, int least_squares) { wants_full = full; gauss_newton = least_squares; }
void clock_start(double limit) {
    spent = 0.0;
    memset(counts, 0, sizeof counts);
    deadline = now() + limit;
}
double clock_spent(void) { return spent; }
long long clock_count(int which) { return counts[which]; }

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

static real upper_entries[1 << 20];

static int hessian(const real *x, real sigma, const real *lambda, real *out) {
    if (!wants_full) return hessian_upper(x, sigma, lambda, out);
    if (hessian_upper(x, sigma, lambda, upper_entries)) return 1;
    for (integer k = 0; k < P.upper[2 + P.n]; ++k) {
        out[P.full_map[2 * k]] = upper_entries[k];
        out[P.full_map[2 * k + 1]] = upper_entries[k];
    }
    return 0;
}

/* Straight calls, for what is not CasADi. */
int problem_evaluate(const real *x, real *f, real *gradient, real *g, real *jacobian) {
    double began = now();
    if (began > deadline) return 2;
    counts[0] += f != 0;
    counts[1] += gradient != 0 || jacobian != 0;
    int failed = evaluate(x, f, gradient, g, jacobian);
    spent += now() - began;
    return failed;
}

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

int problem_hessian(const real *x, real sigma, const real *lambda, real *out) {
    return hessian_upper(x, sigma, lambda, out);
}

/* CasADi's interface. */
static integer column_x[8], column_g[8], column_one[8], empty[4] = {0, 0, 0};

static const integer *column(integer *pattern, integer rows) {
    pattern[0] = rows;
    pattern[1] = 1;
    pattern[2] = 1; /* dense */
    return pattern;
}

static const integer *pattern_of(const char *name) {
    if (!strcmp(name, "x") || !strcmp(name, "grad_f_x") || !strcmp(name, "grad_gamma_x"))
        return column(column_x, P.n);
    if (!strcmp(name, "g") || !strcmp(name, "lam_g")) return column(column_g, P.m);
    if (!strcmp(name, "jac_g_x")) return P.jacobian;
    if (!strcmp(name, "triu_hess_gamma_x_x")) return P.upper;
    if (!strcmp(name, "hess_gamma_x_x")) return P.full;
    if (!strcmp(name, "p")) return empty;
    return column(column_one, 1);
}

#define EXTERNAL(name, ins, outs, ...)                                                     \
    static const char *name##_in[] = {"x", "p", "lam_f", "lam_g"};                          \
    static const char *name##_out[] = {__VA_ARGS__};                                       \
    integer name##_n_in(void) { return ins; }                                              \
    integer name##_n_out(void) { return outs; }                                            \
    const char *name##_name_in(integer i) { return name##_in[i]; }                         \
    const char *name##_name_out(integer i) { return name##_out[i]; }                       \
    const integer *name##_sparsity_in(integer i) { return pattern_of(name##_in[i]); }      \
    const integer *name##_sparsity_out(integer i) { return pattern_of(name##_out[i]); }    \
    int name##_work(integer *a, integer *r, integer *i, integer *w) {                      \
        *a = ins; *r = outs; *i = 0; *w = 0; return 0;                                     \
    }                                                                                      \
    int name(const real **arg, real **res, integer *iw, real *w, int mem)

#define TIMED(call)                                                                        \
    double began = now();                                                                  \
    if (began > deadline) return 1;                                                        \
    int failed = call;                                                                     \
    spent += now() - began;                                                                \
    return failed

EXTERNAL(nlp, 2, 2, "f", "g") { TIMED(evaluate(arg[0], res[0], 0, res[1], 0)); }
EXTERNAL(nlp_f, 2, 1, "f") { counts[0]++; TIMED(evaluate(arg[0], res[0], 0, 0, 0)); }
EXTERNAL(nlp_g, 2, 1, "g") { TIMED(evaluate(arg[0], 0, 0, res[0], 0)); }
EXTERNAL(nlp_fg, 2, 2, "f", "g") {
    counts[0]++;
    TIMED(evaluate(arg[0], res[0], 0, res[1], 0));
}
EXTERNAL(nlp_grad_f, 2, 2, "f", "grad_f_x") {
    counts[1]++;
    TIMED(evaluate(arg[0], res[0], res[1], 0, 0));
}
EXTERNAL(nlp_jac_g, 2, 2, "g", "jac_g_x") { TIMED(evaluate(arg[0], 0, 0, res[0], res[1])); }
EXTERNAL(nlp_jac_fg, 2, 4, "f", "grad_f_x", "g", "jac_g_x") {
    counts[1]++;
    TIMED(evaluate(arg[0], res[0], res[1], res[2], res[3]));
}
static const char *hessian_in[] = {"x", "p", "lam_f", "lam_g"};
integer nlp_hess_l_n_in(void) { return 4; }
integer nlp_hess_l_n_out(void) { return 1; }
const char *nlp_hess_l_name_in(integer i) { return hessian_in[i]; }
const char *nlp_hess_l_name_out(integer i) {
    (void)i;
    return wants_full ? "hess_gamma_x_x" : "triu_hess_gamma_x_x";
}
const integer *nlp_hess_l_sparsity_in(integer i) { return pattern_of(hessian_in[i]); }
const integer *nlp_hess_l_sparsity_out(integer i) { return pattern_of(nlp_hess_l_name_out(i)); }
int nlp_hess_l_work(integer *a, integer *r, integer *i, integer *w) {
    *a = 4; *r = 1; *i = 0; *w = 0;
    return 0;
}
int nlp_hess_l(const real **arg, real **res, integer *iw, real *w, int mem) {
    counts[2]++;
    if (!res[0]) return 0;
    TIMED(hessian(arg[0], arg[2] ? arg[2][0] : 0.0, arg[3], res[0]));
}
