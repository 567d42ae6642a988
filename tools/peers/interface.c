/* The interface that CasADi expects of an external function, behind a problem's own code, which has
 * `evaluate`, `hessian_upper` and in `P` its sizes `n` and `m` and patterns as compressed columns: `jacobian`, the
 * Hessian's `upper` triangle, the `full` one, and in `full_map` where every entry of the former goes in
 * the latter, twice. The problem is global state: one at a time per process. */
static real upper_entries[1 << 20];

static int hessian(const real *x, real sigma, const real *lambda, real *out) {
    if (form == UPPER) return hessian_upper(x, sigma, lambda, out);
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
    if (!strcmp(name, "p") || !strcmp(name, "grad_gamma_p")) return empty;
    return column(column_one, 1);
}

#define EXTERNAL(name, ins, outs, ...)                                                     \
    static const char *name##_in[] = {"x", "p", "lam_f", "lam_g"};                          \
    integer name##_n_in(void) { return ins; }                                              \
    integer name##_n_out(void) { return outs; }                                            \
    const char *name##_name_in(integer i) { return name##_in[i]; }                         \
    const char *name##_name_out(integer i) {                                               \
        const char *out[] = {__VA_ARGS__};                                                 \
        return out[i];                                                                     \
    }                                                                                      \
    const integer *name##_sparsity_in(integer i) { return pattern_of(name##_in[i]); }      \
    const integer *name##_sparsity_out(integer i) { return pattern_of(name##_name_out(i)); }    \
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
EXTERNAL(nlp_grad_f, 2, form == FATROP ? 1 : 2, form == FATROP ? "grad_f_x" : "f", "grad_f_x") {
    counts[1]++;
    TIMED(evaluate(arg[0], form == FATROP ? 0 : res[0], res[form == FATROP ? 0 : 1], 0, 0));
}
EXTERNAL(nlp_jac_g, 2, 2, "g", "jac_g_x") { TIMED(evaluate(arg[0], 0, 0, res[0], res[1])); }
EXTERNAL(nlp_jac_fg, 2, 4, "f", "grad_f_x", "g", "jac_g_x") {
    counts[1]++;
    TIMED(evaluate(arg[0], res[0], res[1], res[2], res[3]));
}
/* The last of its results is the Hessian. */
static const char *hessian_in[] = {"x", "p", "lam_f", "lam_g"};
integer nlp_hess_l_n_in(void) { return 4; }
integer nlp_hess_l_n_out(void) { return form == FATROP ? 2 : 1; }
const char *nlp_hess_l_name_in(integer i) { return hessian_in[i]; }
const char *nlp_hess_l_name_out(integer i) {
    if (i + 1 < nlp_hess_l_n_out()) return "grad_gamma_x";
    return form == UPPER ? "triu_hess_gamma_x_x" : "hess_gamma_x_x";
}
const integer *nlp_hess_l_sparsity_in(integer i) { return pattern_of(hessian_in[i]); }
const integer *nlp_hess_l_sparsity_out(integer i) { return pattern_of(nlp_hess_l_name_out(i)); }
int nlp_hess_l_work(integer *a, integer *r, integer *i, integer *w) {
    *a = 4; *r = 2; *i = 0; *w = 0;
    return 0;
}

/* Gradient of sigma * objective + lambda' constraints. */
static int pulled(const real *x, real sigma, const real *lambda, real *gradient) {
    static real entries[1 << 20], unused[1 << 16];
    if (evaluate(x, 0, gradient, unused, entries)) return 1;
    const integer *start = P.jacobian + 2, *row = start + P.n + 1;
    for (integer c = 0; c < P.n; ++c) {
        gradient[c] *= sigma;
        for (integer k = start[c]; lambda && k < start[c + 1]; ++k)
            gradient[c] += entries[k] * lambda[row[k]];
    }
    return 0;
}

/* All at the end, for fatrop. */
EXTERNAL(nlp_grad, 4, 4, "f", "g", "grad_gamma_x", "grad_gamma_p") {
    real sigma = arg[2] ? arg[2][0] : 0.0;
    if (res[2] && pulled(arg[0], sigma, arg[3], res[2])) return 1;
    TIMED(evaluate(arg[0], res[0], 0, res[1], 0));
}

int nlp_hess_l(const real **arg, real **res, integer *iw, real *w, int mem) {
    counts[2]++;
    real sigma = arg[2] ? arg[2][0] : 0.0, *out = res[nlp_hess_l_n_out() - 1];
    if (form == FATROP && res[0]) {
        double began = now();
        if (began > deadline || pulled(arg[0], sigma, arg[3], res[0])) return 1;
        spent += now() - began;
    }
    if (!out) return 0;
    TIMED(hessian(arg[0], sigma, arg[3], out));
}
