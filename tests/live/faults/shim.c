/* Makes one call of the system fail, the n-th of its kind on files below a folder, for tests.
 *
 *   cc -shared -fPIC -O1 -o shim.so shim.c
 *   LD_PRELOAD=./shim.so FAULT=write:3:28 FAULT_BELOW=/tmp/x/ FAULT_FIRED=/tmp/fired program
 *
 * FAULT is KIND:N:HOW, several separated by commas. KIND is open, read, write, sync, rename, lock,
 * truncate or unlink. HOW is an errno; `short`, which lets a write do half of its work; or `torn`,
 * which kills the process in the middle of it. N is a number, with a `+` after it the N-th and all
 * that follow. When a fault happens, the file FAULT_FIRED is made.
 *
 * Calls are trapped by a filter of seccomp, not by the names of libc: part of the program calls the
 * system without libc. The handler makes the call itself, marked by a sixth argument that no call
 * here has, so that the filter lets it pass.
 */
#define _GNU_SOURCE
#include <errno.h>
#include <fcntl.h>
#include <linux/audit.h>
#include <linux/filter.h>
#include <linux/seccomp.h>
#include <signal.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>
#include <sys/prctl.h>
#include <sys/syscall.h>
#include <ucontext.h>
#include <unistd.h>

#define MARK 0x656e6163UL /* "enac" */

enum { OPEN, READ, WRITE, SYNC, RENAME, LOCK, TRUNCATE, UNLINK, KINDS };
static const char *const names[KINDS] = {"open", "read", "write", "sync",
                                         "rename", "lock", "truncate", "unlink"};
enum { SHORT = -1, TORN = -2 };

#define FAULTS 8
static struct {
    int kind, how, and_after;
    long number;
} faults[FAULTS];
static int fault_count;
static long counts[KINDS];
static const char *below, *fired;

static long call(long number, long a, long b, long c, long d, long e) {
#if defined(__x86_64__)
    register long r10 __asm__("r10") = d;
    register long r8 __asm__("r8") = e;
    register long r9 __asm__("r9") = MARK;
    long result;
    __asm__ volatile("syscall"
                     : "=a"(result)
                     : "a"(number), "D"(a), "S"(b), "d"(c), "r"(r10), "r"(r8), "r"(r9)
                     : "rcx", "r11", "memory");
    return result;
#elif defined(__aarch64__)
    register long x8 __asm__("x8") = number;
    register long x0 __asm__("x0") = a;
    register long x1 __asm__("x1") = b;
    register long x2 __asm__("x2") = c;
    register long x3 __asm__("x3") = d;
    register long x4 __asm__("x4") = e;
    register long x5 __asm__("x5") = MARK;
    __asm__ volatile("svc 0"
                     : "+r"(x0)
                     : "r"(x8), "r"(x1), "r"(x2), "r"(x3), "r"(x4), "r"(x5)
                     : "memory");
    return x0;
#else
#error "the registers of this machine are not known"
#endif
}

/* Whether a path leads below the folder. One that is relative does: the program runs there. */
static int is_path_below(long path) {
    const char *text = (const char *)path;
    return text && (text[0] != '/' || strstr(text, below) != NULL);
}

/* Whether a descriptor is that of a file below the folder. */
static int is_below(long descriptor) {
    char link[32] = "/proc/self/fd/", digits[16], path[4096];
    int count = 0, at = (int)strlen(link);
    if (descriptor < 0) return 0;
    do digits[count++] = (char)('0' + descriptor % 10);
    while ((descriptor /= 10) > 0 && count < 15);
    while (count > 0) link[at++] = digits[--count];
    link[at] = 0;
    long length = call(SYS_readlinkat, AT_FDCWD, (long)link, (long)path, sizeof path - 1, 0);
    if (length <= 0) return 0;
    path[length] = 0;
    return strstr(path, below) != NULL;
}

/* The kind of a call, or -1 if it is none of ours. */
static int kind_of(long number, const long *a) {
    switch (number) {
    case SYS_openat: return is_path_below(a[1]) ? OPEN : -1;
    case SYS_read: return is_below(a[0]) ? READ : -1;
    case SYS_write: return is_below(a[0]) ? WRITE : -1;
    case SYS_fsync:
    case SYS_fdatasync: return is_below(a[0]) ? SYNC : -1;
    case SYS_renameat2:
    case SYS_linkat:
    case SYS_renameat: return is_path_below(a[1]) ? RENAME : -1;
    case SYS_flock: return is_below(a[0]) ? LOCK : -1;
    case SYS_ftruncate: return is_below(a[0]) ? TRUNCATE : -1;
    case SYS_unlinkat: return is_path_below(a[1]) ? UNLINK : -1;
#if defined(__x86_64__)
    case SYS_open: return is_path_below(a[0]) ? OPEN : -1;
    case SYS_rename:
    case SYS_link: return is_path_below(a[0]) ? RENAME : -1;
    case SYS_unlink: return is_path_below(a[0]) ? UNLINK : -1;
#endif
    }
    return -1;
}

static long serve(long number, long *a) {
    int kind = kind_of(number, a);
    if (kind >= 0) {
        long count = __atomic_add_fetch(&counts[kind], 1, __ATOMIC_SEQ_CST);
        for (int i = 0; i < fault_count; i++) {
            int is_due = count == faults[i].number
                         || (faults[i].and_after && count > faults[i].number);
            if (faults[i].kind != kind || !is_due) continue;
            long file = call(SYS_openat, AT_FDCWD, (long)fired, O_CREAT | O_WRONLY, 0600, 0);
            if (file >= 0) call(SYS_close, file, 0, 0, 0, 0);
            if (faults[i].how > 0) return -faults[i].how;
            if (kind == WRITE && a[2] > 1) a[2] /= 2;
            if (faults[i].how == TORN) {
                call(number, a[0], a[1], a[2], a[3], a[4]);
                call(SYS_kill, getpid(), SIGKILL, 0, 0, 0);
            }
            break;
        }
    }
    return call(number, a[0], a[1], a[2], a[3], a[4]);
}

static void trapped(int signal, siginfo_t *info, void *context) {
    (void)signal;
    ucontext_t *at = context;
    int saved = errno;
#if defined(__x86_64__)
    greg_t *r = at->uc_mcontext.gregs;
    long a[5] = {r[REG_RDI], r[REG_RSI], r[REG_RDX], r[REG_R10], r[REG_R8]};
    r[REG_RAX] = serve(info->si_syscall, a);
#elif defined(__aarch64__)
    unsigned long long *r = at->uc_mcontext.regs;
    long a[5] = {r[0], r[1], r[2], r[3], r[4]};
    r[0] = serve(info->si_syscall, a);
#endif
    errno = saved;
}

static void parse(char *text) {
    for (char *part = strtok(text, ","); part; part = strtok(NULL, ",")) {
        char *number = strchr(part, ':');
        char *how = number ? strchr(number + 1, ':') : NULL;
        if (!how || fault_count == FAULTS) _exit(99);
        *number++ = 0;
        *how++ = 0;
        int kind = 0;
        while (kind < KINDS && strcmp(names[kind], part) != 0) kind++;
        if (kind == KINDS) _exit(99);
        faults[fault_count].kind = kind;
        faults[fault_count].number = atol(number);
        faults[fault_count].and_after = strchr(number, '+') != NULL;
        faults[fault_count].how = strcmp(how, "short") == 0  ? SHORT
                                  : strcmp(how, "torn") == 0 ? TORN
                                                             : atoi(how);
        fault_count++;
    }
}

#if defined(__x86_64__)
#define ARCH AUDIT_ARCH_X86_64
#else
#define ARCH AUDIT_ARCH_AARCH64
#endif

#define TRAP(number) \
    BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, (number), 0, 1), \
        BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_TRAP)

__attribute__((constructor)) static void begin(void) {
    char *text = getenv("FAULT");
    below = getenv("FAULT_BELOW");
    fired = getenv("FAULT_FIRED");
    if (!text || !below || !fired) return;
    parse(text);
    struct sigaction action = {.sa_sigaction = trapped, .sa_flags = SA_SIGINFO | SA_NODEFER};
    struct sock_filter filter[] = {
        BPF_STMT(BPF_LD | BPF_W | BPF_ABS, offsetof(struct seccomp_data, arch)),
        BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, ARCH, 1, 0),
        BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_ALLOW),
        BPF_STMT(BPF_LD | BPF_W | BPF_ABS, offsetof(struct seccomp_data, args[5])),
        BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, MARK, 0, 1),
        BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_ALLOW),
        BPF_STMT(BPF_LD | BPF_W | BPF_ABS, offsetof(struct seccomp_data, nr)),
        TRAP(SYS_openat),
        TRAP(SYS_read),
        TRAP(SYS_write),
        TRAP(SYS_fsync),
        TRAP(SYS_fdatasync),
        TRAP(SYS_renameat),
        TRAP(SYS_renameat2),
        TRAP(SYS_linkat),
        TRAP(SYS_flock),
        TRAP(SYS_ftruncate),
        TRAP(SYS_unlinkat),
#if defined(__x86_64__)
        TRAP(SYS_open),
        TRAP(SYS_rename),
        TRAP(SYS_link),
        TRAP(SYS_unlink),
#endif
        BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_ALLOW),
    };
    struct sock_fprog program = {sizeof filter / sizeof *filter, filter};
    if (sigaction(SIGSYS, &action, NULL) != 0 || prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) != 0
        || prctl(PR_SET_SECCOMP, SECCOMP_MODE_FILTER, &program) != 0)
        _exit(98);
}
