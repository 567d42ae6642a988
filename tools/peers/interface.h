/* What stands before a problem's own code: types of CasADi's C, options, a clock. */
#include <math.h>
#include <string.h>
#include <time.h>

typedef double real;
typedef long long int integer;
typedef int (*function)(const real **, real **, integer *, real *, int);

/* How the Hessian is handed over: its upper triangle; the full matrix; that after the Lagrangian's gradient, as fatrop
 * has it, which has the objective's gradient without the objective. */
enum { UPPER, FULL, FATROP };
static int form, gauss_newton;
static double deadline;
static double spent;
static long long counts[4];

static double now(void) {
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return t.tv_sec + 1e-9 * t.tv_nsec;
}

void options_set(int which, int least_squares) { form = which; gauss_newton = least_squares; }
void clock_start(double limit) {
    spent = 0.0;
    memset(counts, 0, sizeof counts);
    deadline = now() + limit;
}
double clock_spent(void) { return spent; }
long long clock_count(int which) { return counts[which]; }
