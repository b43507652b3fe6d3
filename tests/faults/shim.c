/* Makes the disk and the clock fail on request, for tests. It is loaded before the C library (LD_PRELOAD) and
 * intercepts the program's calls that use paths below one folder.
 *
 * MACHBAND_FAULT_UNDER  the folder
 * MACHBAND_FAULT        OP:N:WHAT[+], separated by commas: what the N-th call of OP does; with +, every later one too
 * MACHBAND_FAULT_LOG    a file that receives "hit OP N WHAT PATH" when a fault takes effect, "count OP N" at the end
 *
 * OP: open read write sync rename truncate seek stat unlink mkdir lock clock (clock has no path).
 * WHAT: the name of an errno; short (transfers half and reports half); lie (writes half and reports all); torn (writes
 * half, then fails with EIO); kill-before, kill-after, kill-torn (kills its own process with SIGKILL before, after or
 * halfway through the call); back (sets the clock back an hour from this call on). */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/types.h>
#include <time.h>
#include <unistd.h>

enum op { OPEN, READ, WRITE, SYNC, RENAME, TRUNCATE, SEEK, STAT, UNLINK, MKDIR, LOCK, CLOCK, OPS };
static const char *const op_names[OPS] = {"open", "read", "write", "sync", "rename", "truncate",
                                          "seek", "stat", "unlink", "mkdir", "lock", "clock"};

static const struct { const char *name; int number; } errors[] = {
    {"EIO", EIO}, {"ENOSPC", ENOSPC}, {"EROFS", EROFS}, {"EACCES", EACCES}, {"EMFILE", EMFILE}, {"EINTR", EINTR},
    {"ENOLCK", ENOLCK}};

static struct { enum op op; long n; char what[16]; int from_then_on; } faults[8];
static int fault_count;
static long counts[OPS];
static char *under;
static int log_fd = -1;
/* Paths of the open descriptors of files below the folder. */
#define DESCRIPTORS 1024
static char *paths[DESCRIPTORS];

#define REAL(name) ((__typeof__(&name))dlsym(RTLD_NEXT, #name))

__attribute__((constructor)) static void begin(void) {
    under = getenv("MACHBAND_FAULT_UNDER");
    const char *log = getenv("MACHBAND_FAULT_LOG");
    if (log) log_fd = REAL(open)(log, O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0600);
    const char *spec = getenv("MACHBAND_FAULT");
    while (spec && *spec && fault_count < 8) {
        char op[16], what[16];
        long n;
        if (sscanf(spec, "%15[a-z]:%ld:%15[^,]", op, &n, what) != 3) abort();
        size_t length = strlen(what);
        faults[fault_count].from_then_on = what[length - 1] == '+';
        if (what[length - 1] == '+') what[length - 1] = 0;
        int i = 0;
        while (i < OPS && strcmp(op_names[i], op)) i++;
        if (i == OPS) abort();
        faults[fault_count].op = i;
        faults[fault_count].n = n;
        strcpy(faults[fault_count++].what, what);
        spec = strchr(spec, ',');
        if (spec) spec++;
    }
}

__attribute__((destructor)) static void end(void) {
    for (int i = 0; i < OPS && log_fd >= 0; i++) dprintf(log_fd, "count %s %ld\n", op_names[i], counts[i]);
}

static int is_below(const char *path) {
    size_t length = under ? strlen(under) : 0;
    return length && path && !strncmp(path, under, length) && (path[length] == '/' || !path[length]);
}

static const char *path_of(int fd) { return fd >= 0 && fd < DESCRIPTORS ? paths[fd] : NULL; }

/* What this call must do; NULL for the real call. */
static const char *strike(enum op op, const char *path) {
    long n = __atomic_add_fetch(&counts[op], 1, __ATOMIC_SEQ_CST);
    for (int i = 0; i < fault_count; i++) {
        if (faults[i].op != op || (n != faults[i].n && !(faults[i].from_then_on && n > faults[i].n))) continue;
        if (log_fd >= 0)
            dprintf(log_fd, "hit %s %ld %s%s %s\n", op_names[op], n, faults[i].what, faults[i].from_then_on ? "+" : "", path);
        return faults[i].what;
    }
    return NULL;
}

static void die(void) {
    syscall(SYS_kill, getpid(), SIGKILL);
    for (;;) pause();
}

/* Does what a fault requires before the call; partial reads and writes are handled elsewhere. Returns 1 if the call
 * must return -1. */
static int refused(const char *what) {
    if (!what) return 0;
    if (!strcmp(what, "kill-before")) die();
    for (size_t i = 0; i < sizeof errors / sizeof *errors; i++) {
        if (!strcmp(what, errors[i].name)) {
            errno = errors[i].number;
            return 1;
        }
    }
    return 0;
}

/* A call that needs no special treatment. */
#define CALL(type, op, path, call)                                     \
    do {                                                               \
        const char *what = strike(op, path);                           \
        if (refused(what)) return -1;                                  \
        type done = call;                                              \
        int kept = errno;                                              \
        if (what && !strcmp(what, "kill-after")) die();                \
        errno = kept;                                                  \
        return done;                                                   \
    } while (0)

static int opened(int fd, const char *path) {
    int kept = errno;
    if (fd >= 0 && fd < DESCRIPTORS) {
        free(paths[fd]);
        paths[fd] = strdup(path);
    }
    errno = kept;
    return fd;
}

#define OPEN_BODY(name, path, ...)                                     \
    va_list rest;                                                      \
    va_start(rest, flags);                                             \
    mode_t mode = flags & (O_CREAT | O_TMPFILE) ? va_arg(rest, mode_t) : 0; \
    va_end(rest);                                                      \
    if (!is_below(path)) return REAL(name)(__VA_ARGS__, mode);         \
    CALL(int, OPEN, path, opened(REAL(name)(__VA_ARGS__, mode), path))

int open(const char *path, int flags, ...) { OPEN_BODY(open, path, path, flags); }
int open64(const char *path, int flags, ...) { OPEN_BODY(open64, path, path, flags); }
int openat(int at, const char *path, int flags, ...) { OPEN_BODY(openat, path, at, path, flags); }
int openat64(int at, const char *path, int flags, ...) { OPEN_BODY(openat64, path, at, path, flags); }

int close(int fd) {
    if (path_of(fd)) {
        free(paths[fd]);
        paths[fd] = NULL;
    }
    return REAL(close)(fd);
}

ssize_t read(int fd, void *to, size_t size) {
    const char *path = path_of(fd);
    if (!path) return REAL(read)(fd, to, size);
    const char *what = strike(READ, path);
    if (refused(what)) return -1;
    return REAL(read)(fd, to, what && !strcmp(what, "short") && size > 1 ? size / 2 : size);
}

ssize_t write(int fd, const void *from, size_t size) {
    const char *path = path_of(fd);
    if (!path) return REAL(write)(fd, from, size);
    const char *what = strike(WRITE, path);
    if (refused(what)) return -1;
    int whole = !what || !strcmp(what, "kill-after");
    ssize_t done = REAL(write)(fd, from, whole ? size : (size + 1) / 2);
    if (!what) return done;
    if (!strncmp(what, "kill", 4)) die();
    if (!strcmp(what, "torn")) {
        errno = EIO;
        return -1;
    }
    return strcmp(what, "lie") ? done : (ssize_t)size;
}

#define ON_DESCRIPTOR(type, op, fd, call)                              \
    do {                                                               \
        const char *path = path_of(fd);                                \
        if (!path) return call;                                        \
        CALL(type, op, path, call);                                    \
    } while (0)

int fsync(int fd) { ON_DESCRIPTOR(int, SYNC, fd, REAL(fsync)(fd)); }
int fdatasync(int fd) { ON_DESCRIPTOR(int, SYNC, fd, REAL(fdatasync)(fd)); }
int ftruncate(int fd, off_t size) { ON_DESCRIPTOR(int, TRUNCATE, fd, REAL(ftruncate)(fd, size)); }
int ftruncate64(int fd, off64_t size) { ON_DESCRIPTOR(int, TRUNCATE, fd, REAL(ftruncate64)(fd, size)); }

/* Only seeks to an absolute position fail: Rust's read functions query the current position as a hint. */
off_t lseek(int fd, off_t to, int from) {
    if (from != SEEK_SET) return REAL(lseek)(fd, to, from);
    ON_DESCRIPTOR(off_t, SEEK, fd, REAL(lseek)(fd, to, from));
}
off64_t lseek64(int fd, off64_t to, int from) {
    if (from != SEEK_SET) return REAL(lseek64)(fd, to, from);
    ON_DESCRIPTOR(off64_t, SEEK, fd, REAL(lseek64)(fd, to, from));
}

int flock(int fd, int how) {
    if (how & LOCK_UN) return REAL(flock)(fd, how);
    ON_DESCRIPTOR(int, LOCK, fd, REAL(flock)(fd, how));
}

#define ON_PATH(type, op, path, call)                                  \
    do {                                                               \
        if (!is_below(path)) return call;                              \
        CALL(type, op, path, call);                                    \
    } while (0)

int rename(const char *from, const char *to) { ON_PATH(int, RENAME, to, REAL(rename)(from, to)); }
int unlink(const char *path) { ON_PATH(int, UNLINK, path, REAL(unlink)(path)); }
int mkdir(const char *path, mode_t mode) { ON_PATH(int, MKDIR, path, REAL(mkdir)(path, mode)); }

/* Only calls by name fail: Rust's read functions query the size of an open file as a hint. */
int statx(int at, const char *path, int flags, unsigned int mask, struct statx *found) {
    ON_PATH(int, STAT, path, REAL(statx)(at, path, flags, mask, found));
}

int clock_gettime(clockid_t id, struct timespec *now) {
    static int back;
    int done = REAL(clock_gettime)(id, now);
    if (done || id != CLOCK_REALTIME) return done;
    if (strike(CLOCK, "-")) back = 1;
    if (back) now->tv_sec -= 3600;
    return done;
}
