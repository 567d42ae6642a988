/* Multiple shooting of a tree's motion with exact derivatives: the method of Runge and Kutta and the sums over samples,
 * by hand; all that is of a mechanism, compiled from trees.py.
 *
 * Unknowns are the states x = offset + scale * z at the nodes 0 to `segments`; node k + 1 is where `steps`
 * intervals end that begin at node k. Objective: squares of samples, the first at node 0 and one after every
 * interval, and of the rates at node 0. Rows: `x_{k+1} - flow(x_k)` in scales, after k = 0 what holds at the start,
 * at the end what holds there: the order that fatrop asks for. */
#include "interface.h"

#include "mechanism.h"

enum { MOST_NODES = 65, MOST_STAGES = 16, MOST_STORED = 4096 };

typedef struct {
    integer n, m, segments, steps, substeps, stages;
    /* The method: `a`, stages by stages, and `b`. */
    const real *a, *b;
    /* Intervals; samples and their weights, the first sample's before the others'; what holds. */
    const real *interval_s, *seen, *weight, *first, *last;
    const real *rate_weight, *offset, *scale;
    const integer *jacobian, *upper, *full;
    const int *full_map;
} problem;

typedef real matrix[NX][NX];

/* What an evaluation of a stage leaves for second derivatives. */
typedef struct {
    real x[NX], a[NV], by_x[NX * NX];
    matrix by_node;
} stage;

/* What a segment comes to from a node. */
typedef struct {
    real node[NX], end[NX], cost, gradient[NX];
    matrix by_node;
    int has_value, has_slope;
} segment;

static problem P;
static segment segments[MOST_NODES];
static stage stored[MOST_STORED];
static real work[WORK];
static integer integers[IWORK];

void problem_set(const problem *given) {
    P = *given;
    memset(segments, 0, sizeof segments);
}

static void state(const real *x, integer k, real *out) {
    for (int i = 0; i < NX; ++i) {
        integer at = k * NX + i;
        out[i] = P.offset[at] + P.scale[at] * x[at];
    }
}

static void rate(const real *x, real *speed, real *a) {
    real *out[2] = {speed, a};
    tree_rate(&x, out, integers, work, 0);
    memcpy(speed + NQ, a, NV * sizeof *a);
}

/* C = A B, A by columns as CasADi has it. */
static void times(const real *a, matrix b, matrix c) {
    memset(c, 0, sizeof(matrix));
    for (int s = 0; s < NX; ++s)
        for (int r = 0; r < NX; ++r) {
            real factor = a[s * NX + r];
            if (factor == 0.0) continue;
            for (int i = 0; i < NX; ++i) c[r][i] += factor * b[s][i];
        }
}

/* H += Y' A Y. */
static void add_between(const real *a, matrix y, matrix h) {
    static matrix half;
    times(a, y, half);
    for (int s = 0; s < NX; ++s)
        for (int i = 0; i < NX; ++i) {
            real factor = y[s][i];
            if (factor == 0.0) continue;
            for (int j = 0; j < NX; ++j) h[i][j] += factor * half[s][j];
        }
}

/* One step; `y`, the derivative by the node, where it is asked for; `kept`, its stages. */
static void step(real *x, real h, matrix y, stage *kept) {
    static real speed[MOST_STAGES][NX];
    static matrix moved[MOST_STAGES], here;
    static stage spare;
    for (int i = 0; i < P.stages; ++i) {
        stage *own = kept ? kept + i : &spare;
        const real *row = P.a + i * P.stages;
        memcpy(own->x, x, NX * sizeof *x);
        for (int j = 0; j < i; ++j)
            for (int r = 0; r < NX; ++r) own->x[r] += h * row[j] * speed[j][r];
        rate(own->x, speed[i], own->a);
        if (!y) continue;
        memcpy(here, y, sizeof here);
        for (int j = 0; j < i; ++j) {
            if (row[j] == 0.0) continue;
            for (int r = 0; r < NX * NX; ++r) (&here[0][0])[r] += h * row[j] * (&moved[j][0][0])[r];
        }
        const real *arg[2] = {own->x, own->a};
        real *res[1] = {own->by_x};
        tree_slope(arg, res, integers, work, 0);
        times(own->by_x, here, moved[i]);
        if (kept) memcpy(own->by_node, here, sizeof here);
    }
    for (int i = 0; i < P.stages; ++i) {
        for (int r = 0; r < NX; ++r) x[r] += h * P.b[i] * speed[i][r];
        for (int r = 0; y && r < NX * NX; ++r) (&y[0][0])[r] += h * P.b[i] * (&moved[i][0][0])[r];
    }
}

/* A sample's residual at a state, and `slope`, its derivative by the state: by columns, three rows. */
static void sample(const real *x, integer index, real *residual, real *slope) {
    const real *arg[2] = {x, P.seen + 3 * index};
    tree_seen(arg, &residual, integers, work, 0);
    if (slope) tree_seen_slope(arg, &slope, integers, work, 0);
    for (int r = 0; r < 3; ++r) residual[r] *= P.weight[index];
    for (int r = 0; slope && r < 3 * NX; ++r) slope[r] *= P.weight[index];
}

/* slope Y: three rows. */
static void sample_by_node(const real *slope, matrix y, real by[3][NX]) {
    memset(by, 0, 3 * NX * sizeof(real));
    for (int s = 0; s < NX; ++s)
        for (int r = 0; r < 3; ++r) {
            real factor = slope[s * 3 + r];
            if (factor == 0.0) continue;
            for (int i = 0; i < NX; ++i) by[r][i] += factor * y[s][i];
        }
}

static void begin(integer k, matrix y) {
    memset(y, 0, sizeof(matrix));
    for (int i = 0; i < NX; ++i) y[i][i] = P.scale[k * NX + i];
}

static void add_sample(segment *own, const real *x, integer index, matrix y) {
    real residual[3], slope[3 * NX], by[3][NX];
    sample(x, index, residual, y ? slope : 0);
    for (int r = 0; r < 3; ++r) own->cost += residual[r] * residual[r];
    if (!y) return;
    sample_by_node(slope, y, by);
    for (int r = 0; r < 3; ++r)
        for (int i = 0; i < NX; ++i) own->gradient[i] += 2.0 * residual[r] * by[r][i];
}

/* A segment from its node's state, which is evaluated once however often it is asked for. */
static segment *flown(integer k, const real *node, int with_slope) {
    segment *own = segments + k;
    if (own->has_value && (own->has_slope || !with_slope) && !memcmp(own->node, node, sizeof own->node))
        return own;
    memset(own, 0, sizeof *own);
    memcpy(own->node, node, sizeof own->node);
    memcpy(own->end, node, sizeof own->end);
    real(*y)[NX] = 0;
    if (with_slope) begin(k, y = own->by_node);
    if (k == 0) {
        add_sample(own, own->end, 0, y);
        for (int i = 0; i < NX; ++i) {
            real weighed = P.rate_weight[i] * node[i];
            own->cost += weighed * node[i];
            own->gradient[i] += 2.0 * weighed * P.scale[i];
        }
    }
    for (integer s = k * P.steps; s < (k + 1) * P.steps; ++s) {
        for (integer part = 0; part < P.substeps; ++part)
            step(own->end, P.interval_s[s] / P.substeps, y, 0);
        add_sample(own, own->end, s + 1, y);
    }
    own->has_value = 1;
    own->has_slope = with_slope;
    return own;
}

static integer row_of(integer k) { return k == 0 ? 0 : FIRST + k * NX; }

/* What holds at the start (`end` 0) or at the end. */
static void held(int end, const real *x, real *values, real *slope) {
    const real *arg[2] = {x, end ? P.last : P.first};
    if (values) (end ? tree_last : tree_first)(arg, &values, integers, work, 0);
    if (slope) (end ? tree_last_slope : tree_first_slope)(arg, &slope, integers, work, 0);
}

static int evaluate(const real *x, real *f, real *gradient, real *g, real *jacobian) {
    static real nodes[MOST_NODES][NX], slope[2][(FIRST + LAST + 1) * NX];
    integer last = P.segments;
    if (f) *f = 0.0;
    for (integer k = 0; k <= last; ++k) state(x, k, nodes[k]);
    if (gradient) memset(gradient, 0, P.n * sizeof *gradient);
    for (integer k = 0; k < last; ++k) {
        segment *own = flown(k, nodes[k], gradient || jacobian);
        if (f) *f += own->cost;
        if (gradient) memcpy(gradient + k * NX, own->gradient, sizeof own->gradient);
        for (int i = 0; g && i < NX; ++i)
            g[row_of(k) + i] = (nodes[k + 1][i] - own->end[i]) / P.scale[(k + 1) * NX + i];
    }
    if (g) held(0, nodes[0], g + NX, 0);
    if (g) held(1, nodes[last], g + row_of(last), 0);
    if (!jacobian) return 0;
    held(0, nodes[0], 0, slope[0]);
    held(1, nodes[last], 0, slope[1]);
    for (integer k = 0; k <= last; ++k)
        for (int c = 0; c < NX; ++c) {
            real scale = P.scale[k * NX + c];
            if (k > 0) *jacobian++ = 1.0;
            for (int r = 0; k < last && r < NX; ++r)
                *jacobian++ = -segments[k].by_node[r][c] / P.scale[(k + 1) * NX + r];
            for (int r = 0; k == 0 && r < FIRST; ++r) *jacobian++ = slope[0][c * FIRST + r] * scale;
            for (int r = 0; k == last && r < LAST; ++r) *jacobian++ = slope[1][c * LAST + r] * scale;
        }
    return 0;
}

/* H += 2 sigma of a sample's squares; what pulls on the state for it. */
static void add_square(const real *x, integer index, real sigma, matrix y, matrix h, real *pull) {
    real residual[3], slope[3 * NX], by[3][NX];
    sample(x, index, residual, slope);
    sample_by_node(slope, y, by);
    for (int r = 0; r < 3; ++r)
        for (int i = 0; i < NX; ++i)
            for (int j = 0; j < NX; ++j) h[i][j] += 2.0 * sigma * by[r][i] * by[r][j];
    if (gauss_newton) return;
    static real curve[NX * NX];
    real *out[1] = {curve};
    for (int i = 0; i < NX; ++i)
        for (int r = 0; r < 3; ++r) pull[i] += 2.0 * sigma * residual[r] * slope[i * 3 + r];
    for (int r = 0; r < 3; ++r) residual[r] *= 2.0 * sigma * P.weight[index];
    const real *arg[3] = {x, P.seen + 3 * index, residual};
    tree_seen_curve(arg, out, integers, work, 0);
    add_between(curve, y, h);
}

/* Back through a step: `pull` on its end becomes one on its beginning, and H grows by what curves its stages. */
static void back(const stage *kept, real h, real *pull, matrix hessian) {
    static real pulls[MOST_STAGES][NX], by[NV * NX], curve[NX * NX];
    for (int i = (int)P.stages - 1; i >= 0; --i) {
        const stage *own = kept + i;
        real on_rate[NX], lifted[NV];
        for (int r = 0; r < NX; ++r) {
            on_rate[r] = h * P.b[i] * pull[r];
            for (int j = i + 1; j < P.stages; ++j)
                on_rate[r] += h * P.a[j * P.stages + i] * pulls[j][r];
        }
        for (int c = 0; c < NX; ++c) {
            pulls[i][c] = 0.0;
            for (int r = 0; r < NX; ++r) pulls[i][c] += own->by_x[c * NX + r] * on_rate[r];
            for (int r = 0; r < NV; ++r) by[c * NV + r] = own->by_x[c * NX + NQ + r];
        }
        const real *arg[5] = {own->x, on_rate + NQ};
        real *out[1] = {lifted};
        tree_lift(arg, out, integers, work, 0);
        arg[1] = own->a;
        arg[2] = on_rate;
        arg[3] = lifted;
        arg[4] = by;
        out[0] = curve;
        tree_curve(arg, out, integers, work, 0);
        add_between(curve, (real(*)[NX])own->by_node, hessian);
    }
    for (int i = 0; i < P.stages; ++i)
        for (int r = 0; r < NX; ++r) pull[r] += pulls[i][r];
}

static void segment_hessian(integer k, const real *node, real sigma, const real *lambda, matrix h) {
    static matrix y, between[MOST_STORED];
    static real ends[MOST_STORED][NX];
    real x[NX], unused[NX] = {0}, pull[NX] = {0};
    memcpy(x, node, sizeof x);
    begin(k, y);
    if (k == 0) {
        add_square(x, 0, sigma, y, h, unused);
        for (int i = 0; i < NX; ++i)
            h[i][i] += 2.0 * sigma * P.rate_weight[i] * P.scale[i] * P.scale[i];
    }
    integer each = P.substeps * P.stages;
    for (integer s = 0; s < P.steps; ++s) {
        for (integer part = 0; part < P.substeps; ++part)
            step(x, P.interval_s[k * P.steps + s] / P.substeps, y,
                 gauss_newton ? 0 : stored + s * each + part * P.stages);
        memcpy(ends[s], x, sizeof x);
        memcpy(between[s], y, sizeof y);
    }
    for (int r = 0; lambda && r < NX; ++r)
        pull[r] = -lambda[row_of(k) + r] / P.scale[(k + 1) * NX + r];
    for (integer s = P.steps - 1; s >= 0; --s) {
        add_square(ends[s], k * P.steps + s + 1, sigma, between[s], h, pull);
        for (integer part = P.substeps - 1; !gauss_newton && part >= 0; --part)
            back(stored + s * each + part * P.stages, P.interval_s[k * P.steps + s] / P.substeps, pull, h);
    }
}

/* Upper triangle of the Hessian of sigma * objective + lambda' constraints. */
static int hessian_upper(const real *x, real sigma, const real *lambda, real *hessian) {
    static matrix h, y;
    static real curve[NX * NX];
    for (integer k = 0; k <= P.segments; ++k) {
        real node[NX], *out[1] = {curve};
        memset(h, 0, sizeof h);
        state(x, k, node);
        if (k < P.segments) segment_hessian(k, node, sigma, lambda, h);
        if (lambda && !gauss_newton && (k == 0 || k == P.segments)) {
            const real *pull = lambda + (k == 0 ? NX : row_of(k));
            const real *arg[3] = {node, k == 0 ? P.first : P.last, pull};
            (k == 0 ? tree_first_curve : tree_last_curve)(arg, out, integers, work, 0);
            begin(k, y);
            add_between(curve, y, h);
        }
        for (int c = 0; c < NX; ++c)
            for (int r = 0; r <= c; ++r) *hessian++ = h[r][c];
    }
    return 0;
}

#include "interface.c"

/* A part on its own unknowns: the objective of a segment, its rows, what holds at the start, at the end; the
 * slope row by row. */
enum { COST, FLOW, START, END };
int part_evaluate(int part, integer k, const real *x, real *value, real *slope) {
    static real by[(FIRST + LAST + 1) * NX];
    double began = now();
    if (began > deadline) return 2;
    real node[2][NX];
    for (int i = 0; i < 2 * NX && (part == FLOW || i < NX); ++i)
        (&node[0][0])[i] = P.offset[k * NX + i] + P.scale[k * NX + i] * x[i];
    const real *scale = P.scale + k * NX;
    if (part == COST || part == FLOW) {
        segment *own = flown(k, node[0], 1);
        counts[0] += part == COST && k == 0;
        if (part == COST) {
            *value = own->cost;
            memcpy(slope, own->gradient, sizeof own->gradient);
        }
        for (int r = 0; part == FLOW && r < NX; ++r) {
            value[r] = (node[1][r] - own->end[r]) / scale[NX + r];
            for (int c = 0; c < NX; ++c) {
                slope[r * 2 * NX + c] = -own->by_node[r][c] / scale[NX + r];
                slope[r * 2 * NX + NX + c] = r == c;
            }
        }
    } else {
        int rows = part == START ? FIRST : LAST;
        held(part == END, node[0], value, by);
        for (int r = 0; r < rows; ++r)
            for (int c = 0; c < NX; ++c) slope[r * NX + c] = by[c * rows + r] * scale[c];
    }
    spent += now() - began;
    return 0;
}

/* Where the motion from a state ends after the intervals of segment k. */
void flight(integer k, const real *from, real *end) { memcpy(end, flown(k, from, 0)->end, NX * sizeof *end); }
