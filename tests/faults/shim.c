/* Makes the disk and the clock fail on request, for tests. It is loaded before the C library (LD_PRELOAD) and
 * intercepts the program's calls that use paths below one folder.
 *
 * MACHBAND_FAULT_UNDER  the folder
 * MACHBAND_FAULT        OP:N:WHAT[+], separated by commas: what the N-th call of OP does; with +, every later one too
 * MACHBAND_SHUTDOWN    a mounted ext4 file system to shut down at once, as a power failure would (EXT4_IOC_SHUTDOWN)
 * MACHBAND_FAULT_LOG    a file that receives "hit OP N WHAT PATH" when a fault takes effect, "count OP N" at the end
 *
 * MACHBAND_JOURNAL      a file that receives every change below the folder, in order, for simulated power cuts
 *
 * OP: open read write sync rename truncate seek stat unlink mkdir lock list close names fstat link clock thread alloc
 * (list opens a folder, names reads the names in it, fstat is the state of an open file, link is where a path leads;
 * the last three have no path; thread is pthread_create; allocations count from the first call below the folder).
 * WHAT: the name of an errno; short (transfers half and reports half); end (a file that is read seems to end); lie (writes half and reports all); torn (writes
 * half, then fails with EIO); kill-before, kill-after, kill-torn (kills its own process with SIGKILL before, after or
 * halfway through the call); TERM, INT, HUP, STOP (sends its own process this signal before the call); back, far, ancient,
 * still (from this call on, the clock is an hour back, in the year 12000, in the year -2000, or stands still). */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <errno.h>
#include <dirent.h>
#include <fcntl.h>
#include <linux/filter.h>
#include <linux/seccomp.h>
#include <pthread.h>
#include <signal.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <stdint.h>
#include <string.h>
#include <sys/file.h>
#include <sys/ioctl.h>
#include <sys/prctl.h>
#include <sys/sendfile.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/types.h>
#include <time.h>
#include <ucontext.h>
#include <unistd.h>

enum op {
    OPEN, READ, WRITE, SYNC, RENAME, TRUNCATE, SEEK, STAT, UNLINK, MKDIR, LOCK, LIST, CLOSE, NAMES, FSTAT, LINK, CLOCK,
    THREAD, ALLOC, OPS
};
static const char *const op_names[OPS] = {"open", "read", "write", "sync", "rename", "truncate",
                                          "seek", "stat", "unlink", "mkdir", "lock", "list", "close", "names", "fstat",
                                          "link", "clock", "thread", "alloc"};

static const struct { const char *name; int number; } errors[] = {
    {"EIO", EIO}, {"ENOSPC", ENOSPC}, {"EROFS", EROFS}, {"EACCES", EACCES}, {"EMFILE", EMFILE}, {"EINTR", EINTR},
    {"ENOLCK", ENOLCK}, {"EAGAIN", EAGAIN}, {"ENOMEM", ENOMEM}};
static const struct { const char *name; int number; } signals[] = {{"TERM", SIGTERM}, {"INT", SIGINT}, {"HUP", SIGHUP}, {"STOP", SIGSTOP}};

static struct { enum op op; long n; char what[16]; int from_then_on; } faults[8];
static int fault_count;
static long counts[OPS];
static char *under;
static int log_fd = -1, journal_fd = -1;
/* True once a call below the folder has been made; earlier allocations belong to the test program. */
static int begun;
/* Paths of the open descriptors of files below the folder. */
#define DESCRIPTORS 1024
static char *paths[DESCRIPTORS];

#define REAL(name) ((__typeof__(&name))dlsym(RTLD_NEXT, #name))

static void watch_calls(void);

__attribute__((constructor)) static void begin(void) {
    const char *shutdown = getenv("MACHBAND_SHUTDOWN");
    if (shutdown) {
        uint32_t without_flushing_the_journal = 2;
        int fd = REAL(open)(shutdown, O_RDONLY | O_CLOEXEC);
        if (ioctl(fd, _IOR('X', 125, uint32_t), &without_flushing_the_journal)) _exit(1);
    }
    /* A shell that starts a program in the background makes it ignore this signal. */
    signal(SIGINT, SIG_DFL);
    under = getenv("MACHBAND_FAULT_UNDER");
    const char *log = getenv("MACHBAND_FAULT_LOG");
    if (log) log_fd = REAL(open)(log, O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0600);
    const char *journal = getenv("MACHBAND_JOURNAL");
    if (journal) journal_fd = REAL(open)(journal, O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0600);
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
    if (under) watch_calls();
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
    if (op < CLOCK) begun = 1;
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

static int is_signal(const char *what) {
    for (size_t i = 0; i < sizeof signals / sizeof *signals; i++)
        if (!strcmp(what, signals[i].name)) return signals[i].number;
    return 0;
}

/* Does what a fault requires before the call; partial reads and writes are handled elsewhere. Returns 1 if the call
 * must return -1. */
static int refused(const char *what) {
    if (!what) return 0;
    if (!strcmp(what, "kill-before")) die();
    /* A signal to the whole process could let this thread make the call before it stops. */
    if (is_signal(what) == SIGSTOP) syscall(SYS_tgkill, getpid(), syscall(SYS_gettid), SIGSTOP);
    else if (is_signal(what)) syscall(SYS_kill, getpid(), is_signal(what));
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

/* The journal. One line per change; a lock keeps the lines in the order of the changes. */
static pthread_mutex_t journal_lock = PTHREAD_MUTEX_INITIALIZER;
#define BEGIN int journaled = journal_fd >= 0; if (journaled) pthread_mutex_lock(&journal_lock)
#define END do { int kept = errno; if (journaled) pthread_mutex_unlock(&journal_lock); errno = kept; } while (0)

static unsigned long long inode(int fd) {
    struct stat found;
    return fstat(fd, &found) ? 0 : (unsigned long long)found.st_ino;
}

static unsigned long long inode_at(const char *path) {
    struct stat found;
    return stat(path, &found) ? 0 : (unsigned long long)found.st_ino;
}

#define NOTE(...) do { int kept = errno; if (journal_fd >= 0) dprintf(journal_fd, __VA_ARGS__); errno = kept; } while (0)

/* Notes the bytes that a write has added. */
static void note_write(int fd, const unsigned char *bytes, ssize_t size) {
    if (journal_fd < 0 || size <= 0) return;
    int kept = errno;
    off_t to = REAL(lseek)(fd, 0, SEEK_CUR);
    char *text = malloc(2 * size + 80);
    int length = sprintf(text, "write\t%llu\t%lld\t", inode(fd), (long long)(to - size));
    for (ssize_t i = 0; i < size; i++) length += sprintf(text + length, "%02x", bytes[i]);
    text[length++] = '\n';
    for (int done = 0; done < length;) done += REAL(write)(journal_fd, text + done, length - done);
    free(text);
    errno = kept;
}

/* Notes that a file has a new name. Some libraries rename without the C library. */
static void note_name(int fd) {
    char link[64], name[4096];
    sprintf(link, "/proc/self/fd/%d", fd);
    ssize_t length = readlink(link, name, sizeof name - 1);
    if (journal_fd < 0 || length <= 0) return;
    name[length] = 0;
    size_t deleted = sizeof " (deleted)" - 1;
    if ((size_t)length > deleted && !strcmp(name + length - deleted, " (deleted)")) return;
    if (strcmp(name, paths[fd])) NOTE("rename\t%s\t%s\n", paths[fd], name);
}

static int opened(int fd, const char *path) {
    int kept = errno;
    if (fd >= 0 && fd < DESCRIPTORS) {
        free(paths[fd]);
        paths[fd] = strdup(path);
    }
    errno = kept;
    return fd;
}

/* Notes that a file was created; machband creates files only with O_EXCL or with O_TRUNC. */
static int made(int fd, const char *path, int flags) {
    if (fd >= 0 && flags & O_CREAT) NOTE("create\t%llu\t%s\n", inode(fd), path);
    if (fd >= 0 && flags & O_TRUNC) NOTE("truncate\t%llu\t0\n", inode(fd));
    return fd;
}

#define OPEN_BODY(name, path, ...)                                     \
    va_list rest;                                                      \
    va_start(rest, flags);                                             \
    mode_t mode = flags & (O_CREAT | O_TMPFILE) ? va_arg(rest, mode_t) : 0; \
    va_end(rest);                                                      \
    if (!is_below(path)) return REAL(name)(__VA_ARGS__, mode);         \
    CALL(int, flags & O_DIRECTORY ? LIST : OPEN, path, opened(made(REAL(name)(__VA_ARGS__, mode), path, flags), path))

int open(const char *path, int flags, ...) { OPEN_BODY(open, path, path, flags); }
int open64(const char *path, int flags, ...) { OPEN_BODY(open64, path, path, flags); }
int openat(int at, const char *path, int flags, ...) { OPEN_BODY(openat, path, at, path, flags); }
int openat64(int at, const char *path, int flags, ...) { OPEN_BODY(openat64, path, at, path, flags); }

int close(int fd) {
    const char *path = path_of(fd);
    if (!path) return REAL(close)(fd);
    note_name(fd);
    const char *what = strike(CLOSE, path);
    paths[fd] = NULL;
    free((char *)path);
    int done = REAL(close)(fd);
    return refused(what) ? -1 : done;
}

/* The standard library lists folders with this; it does not report their paths. */
int closedir(DIR *folder) {
    const char *what = begun ? strike(CLOSE, "-") : NULL;
    int done = REAL(closedir)(folder);
    return refused(what) ? -1 : done;
}

/* These fail, so that every copy is made by reads and writes, which the journal records. */
ssize_t copy_file_range(int from, off64_t *at, int to, off64_t *into, size_t size, unsigned int flags) {
    if (journal_fd < 0) return REAL(copy_file_range)(from, at, to, into, size, flags);
    errno = ENOSYS;
    return -1;
}
ssize_t sendfile64(int to, int from, off64_t *at, size_t size) {
    if (journal_fd < 0) return REAL(sendfile64)(to, from, at, size);
    errno = ENOSYS;
    return -1;
}

ssize_t read(int fd, void *to, size_t size) {
    const char *path = path_of(fd);
    if (!path) return REAL(read)(fd, to, size);
    const char *what = strike(READ, path);
    if (refused(what)) return -1;
    if (what && !strcmp(what, "end")) return 0;
    return REAL(read)(fd, to, what && !strcmp(what, "short") && size > 1 ? size / 2 : size);
}

ssize_t write(int fd, const void *from, size_t size) {
    const char *path = path_of(fd);
    /* The journal also records what a program says about its rows. */
    if (fd == 1 && size > 5 && !memcmp(from, "@row ", 5)) NOTE("say\t%.*s", (int)(size - 5), (const char *)from + 5);
    if (!path) return REAL(write)(fd, from, size);
    const char *what = strike(WRITE, path);
    if (refused(what)) return -1;
    int whole = !what || !strcmp(what, "kill-after") || is_signal(what);
    BEGIN;
    ssize_t done = REAL(write)(fd, from, whole ? size : (size + 1) / 2);
    note_write(fd, from, done);
    END;
    if (!what || is_signal(what)) return done;
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

/* A change and its line in the journal, if it succeeds. */
#define NOTED(call, ...)                                               \
    ({                                                                 \
        BEGIN;                                                         \
        int done = call;                                               \
        if (!done) NOTE(__VA_ARGS__);                                  \
        END;                                                           \
        done;                                                          \
    })

int fsync(int fd) { ON_DESCRIPTOR(int, SYNC, fd, NOTED(REAL(fsync)(fd), "sync\t%llu\n", inode(fd))); }
int fdatasync(int fd) { ON_DESCRIPTOR(int, SYNC, fd, NOTED(REAL(fdatasync)(fd), "sync\t%llu\n", inode(fd))); }
int ftruncate(int fd, off_t size) {
    ON_DESCRIPTOR(int, TRUNCATE, fd, NOTED(REAL(ftruncate)(fd, size), "truncate\t%llu\t%lld\n", inode(fd), (long long)size));
}
int ftruncate64(int fd, off64_t size) {
    ON_DESCRIPTOR(int, TRUNCATE, fd, NOTED(REAL(ftruncate64)(fd, size), "truncate\t%llu\t%lld\n", inode(fd), (long long)size));
}

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

/* Updates the names of open files, so that closing one does not note the renaming again. */
static int renamed(int done, const char *from, const char *to) {
    for (int fd = 0; !done && fd < DESCRIPTORS; fd++)
        if (paths[fd] && !strcmp(paths[fd], from)) opened(fd, to);
    return done;
}

int rename(const char *from, const char *to) {
    ON_PATH(int, RENAME, to, renamed(NOTED(REAL(rename)(from, to), "rename\t%s\t%s\n", from, to), from, to));
}
int unlink(const char *path) { ON_PATH(int, UNLINK, path, NOTED(REAL(unlink)(path), "remove\t%s\n", path)); }
int rmdir(const char *path) { ON_PATH(int, UNLINK, path, NOTED(REAL(rmdir)(path), "remove\t%s\n", path)); }
int mkdir(const char *path, mode_t mode) {
    ON_PATH(int, MKDIR, path, NOTED(REAL(mkdir)(path, mode), "mkdir\t%llu\t%s\n", inode_at(path), path));
}

/* Calls by name count separately: Rust's read functions query the size of an open file as a hint. */
int statx(int at, const char *path, int flags, unsigned int mask, struct statx *found) {
    if (flags & AT_EMPTY_PATH) ON_DESCRIPTOR(int, FSTAT, at, REAL(statx)(at, path, flags, mask, found));
    ON_PATH(int, STAT, path, REAL(statx)(at, path, flags, mask, found));
}

ssize_t readlink(const char *path, char *to, size_t size) {
    ON_PATH(ssize_t, LINK, path, REAL(readlink)(path, to, size));
}
char *realpath(const char *path, char *to) {
    const char *what = is_below(path) ? strike(LINK, path) : NULL;
    return refused(what) ? NULL : REAL(realpath)(path, to);
}

/* Some libraries list folders and rename files without the C library. Therefore, a filter turns these system calls into
 * a signal, whose handler makes the call. The last argument, which none of them has, is the pass. */
#define PASS 0x6d616368
#if defined __x86_64__
#define REGISTER(context, x86, arm) ((context)->uc_mcontext.gregs[x86])
#else
#define REGISTER(context, x86, arm) ((context)->uc_mcontext.regs[arm])
#endif

static void make_call(int number, siginfo_t *info, void *of) {
    ucontext_t *context = of;
    long first = REGISTER(context, REG_RDI, 0), second = REGISTER(context, REG_RSI, 1);
    long third = REGISTER(context, REG_RDX, 2), fourth = REGISTER(context, REG_R10, 3);
    int kept = errno, lists = info->si_syscall == SYS_getdents64;
    const char *path = lists ? path_of(first) : (const char *)fourth;
    const char *what = path && (lists || is_below(path)) ? strike(lists ? NAMES : RENAME, path) : NULL;
    (void)number;
    if (lists && what && !strcmp(what, "short")) third /= 2;
    long done = refused(what) ? -1
        : syscall(info->si_syscall, first, second, third, fourth, REGISTER(context, REG_R8, 4), PASS);
    REGISTER(context, REG_RAX, 0) = done < 0 ? -errno : done;
    if (what && !strcmp(what, "kill-after")) die();
    errno = kept;
}

static void watch_calls(void) {
    struct sigaction action = {.sa_sigaction = make_call, .sa_flags = SA_SIGINFO | SA_RESTART};
    struct sock_filter filter[] = {
        BPF_STMT(BPF_LD | BPF_W | BPF_ABS, offsetof(struct seccomp_data, nr)),
        BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, SYS_getdents64, 2, 0),
        BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, SYS_renameat, 1, 0),
        BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, SYS_renameat2, 0, 3),
        BPF_STMT(BPF_LD | BPF_W | BPF_ABS, offsetof(struct seccomp_data, args[5])),
        BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, PASS, 1, 0),
        BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_TRAP),
        BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_ALLOW),
    };
    struct sock_fprog program = {sizeof filter / sizeof *filter, filter};
    sigaction(SIGSYS, &action, NULL);
    if (prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) || prctl(PR_SET_SECCOMP, SECCOMP_MODE_FILTER, &program)) abort();
}

int clock_gettime(clockid_t id, struct timespec *now) {
    static const char *set;
    int done = REAL(clock_gettime)(id, now);
    if (done || id != CLOCK_REALTIME) return done;
    const char *what = strike(CLOCK, "-");
    if (what) set = what;
    if (set && !strcmp(set, "back")) now->tv_sec -= 3600;
    if (set && !strcmp(set, "far")) now->tv_sec = 316515000000;
    if (set && !strcmp(set, "ancient")) now->tv_sec = -125281000000;
    if (set && !strcmp(set, "still")) *now = (struct timespec){1700000000, 0};
    return done;
}

int pthread_create(pthread_t *thread, const pthread_attr_t *how, void *(*run)(void *), void *with) {
    const char *what = strike(THREAD, "-");
    return refused(what) ? errno : REAL(pthread_create)(thread, how, run, with);
}

/* Allocations. glibc exports its own under these names, which are needed because dlsym allocates. */
extern void *__libc_malloc(size_t), *__libc_calloc(size_t, size_t), *__libc_realloc(void *, size_t);
static int out_of_memory(void) { return begun && refused(strike(ALLOC, "-")); }
void *malloc(size_t size) { return out_of_memory() ? NULL : __libc_malloc(size); }
void *calloc(size_t n, size_t size) { return out_of_memory() ? NULL : __libc_calloc(n, size); }
void *realloc(void *from, size_t size) { return out_of_memory() ? NULL : __libc_realloc(from, size); }
