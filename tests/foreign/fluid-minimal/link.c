#define _GNU_SOURCE
#include "link.h"

#include <dirent.h>
#include <fcntl.h>
#include <ftw.h>
#include <signal.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/file.h>
#include <sys/resource.h>
#include <time.h>
#include <unistd.h>

#include "door.h"

#define PROTOCOL "1"
#define LAYOUT "31cfbed10181097c"
#define TYPE(record) "protocol::message::" #record
#define SHARED_MEMORY "/dev/shm"

static Door *door; /* NULL: not in a run */
static int lock = -1, commands, motion, loads, status, bell, coupler, dem;
static char prefix[64], root[256];
static double join_s, deadline_s;
static bool repeatable;
static Command backlog[64];
static int waiting;
static Status said; /* what was said last; its state is 0 before Ready */

static void say(int state, const char *text);

void fail(int code, const char *format, ...)
{
    static int first; /* what fails while it says so is not said, and its code does not count */
    char text[512];
    va_list values;
    va_start(values, format);
    vsnprintf(text, sizeof text, format, values);
    va_end(values);
    fprintf(stderr, "fluid-minimal: %s\n", text);
    if (!first) {
        first = code;
        if (said.state)
            say(FAILED, text);
    }
    leave_run();
    exit(first);
}

/* The result of a call of the door that must not fail. */
static int must(int result)
{
    if (result < 0)
        fail(1, "%s", door_error());
    return result;
}

double seconds(int clock)
{
    struct timespec now;
    clock_gettime(clock, &now);
    return now.tv_sec + 1e-9 * now.tv_nsec;
}

bool is_repeatable(void) { return repeatable; }

/* ---- Joining and leaving ---- */

/* The value of a key of the token, an object in one line, whose strings have no escapes. */
static const char *value_of(const char *token, const char *key)
{
    char quoted[32];
    snprintf(quoted, sizeof quoted, "\"%s\":", key);
    const char *found = strstr(token, quoted);
    if (!found)
        fail(1, "the token has no %s", key);
    return found + strlen(quoted);
}

static void text_of(const char *token, const char *key, char *text, size_t room)
{
    const char *value = value_of(token, key);
    size_t length = *value == '"' ? strcspn(value + 1, "\"\\") : 0;
    if (length == 0 || length >= room || value[length + 1] != '"')
        fail(1, "%s in the token is no text that fits", key);
    snprintf(text, room, "%.*s", (int)length, value + 1);
}

static int remove_one(const char *path, const struct stat *about, int type, struct FTW *where)
{
    (void)about, (void)type, (void)where;
    return remove(path);
}

void leave_run(void)
{
    if (door)
        door_close(door);
    door = NULL;
    if (lock < 0)
        return;
    flock(lock, LOCK_UN);
    DIR *segments;
    if (!flock(lock, LOCK_EX | LOCK_NB) && (segments = opendir(SHARED_MEMORY))) {
        for (struct dirent *entry; (entry = readdir(segments));)
            if (!strncmp(entry->d_name, prefix, strlen(prefix)))
                unlinkat(dirfd(segments), entry->d_name, 0);
        closedir(segments);
        nftw(root, remove_one, 8, FTW_DEPTH | FTW_PHYS);
    }
    close(lock);
    lock = -1;
}

static void compare(const char *service, const char *key, const char *ours)
{
    char theirs[64];
    must(door_attribute(door, service, key, theirs, sizeof theirs));
    if (strcmp(theirs, ours))
        fail(1, "%s of %s is %s, and %s here", key, service, theirs, ours);
}

static Topic topic(const char *service, const char *type, size_t size, bool slice, const char *grains)
{
    compare(service, "bedload.protocol", PROTOCOL);
    compare(service, "bedload.layout", LAYOUT);
    compare(service, "bedload.grains", grains);
    return (Topic){service, type, size, slice, slice ? TYPE(Header) : NULL, slice ? sizeof(Header) : 0};
}

/* A wait: for how long, since when, and when it was looked last whether the others live. */
typedef struct { double limit, start, looked; int missed; } Wait;

static Wait wait_for(double limit)
{
    double now = seconds(CLOCK_MONOTONIC);
    return (Wait){.limit = limit, .start = now, .looked = now};
}

/* Waits for a moment. Fails at the limit, and when a process was missed twice, so that what it sent before it left
 * is taken. */
static void moment(Wait *w, const char *from)
{
    double now = seconds(CLOCK_MONOTONIC);
    if (now - w->start > w->limit)
        fail(3, "nothing has come from the %s in %g s", from, w->limit);
    if (now - w->looked >= 0.05) {
        w->looked = now;
        bool there = must(door_process(door, from)) && must(door_process(door, "coupler"));
        w->missed = there ? 0 : w->missed + 1;
        if (w->missed == 2)
            fail(3, "the %s or the coupler has left", from);
    }
    must(door_wait(door, bell, 10000));
}

void join_run(const char *token, size_t count)
{
    signal(SIGPIPE, SIG_IGN); /* stderr is a pipe of the coupler, and last words to a dead one must not end this */
    char layout[32], protocol[32], run[48], file[300], grains[32];
    text_of(token, "layout", layout, sizeof layout);
    snprintf(protocol, sizeof protocol, "%lu", strtoul(value_of(token, "protocol"), NULL, 10));
    if (strcmp(protocol, PROTOCOL) || strcmp(layout, LAYOUT))
        fail(1, "protocol %s with layout %s is not that of this fluid, %s with " LAYOUT, protocol, layout, PROTOCOL);
    size_t theirs = strtoul(value_of(token, "grains"), NULL, 10);
    if (theirs != count)
        fail(1, "the run has %zu grains, the scene %zu", theirs, count);
    text_of(token, "run", run, sizeof run);
    text_of(token, "prefix", prefix, sizeof prefix);
    text_of(token, "root", root, sizeof root);
    snprintf(file, sizeof file, "bl%s_", run);
    if (strcmp(prefix, file) || !strrchr(root, '/') || strcmp(strrchr(root, '/') + 1, run))
        fail(1, "prefix %s and root %s are not those of run %s", prefix, root, run);
    join_s = strtod(value_of(token, "join_s"), NULL);
    deadline_s = strtod(value_of(token, "deadline_s"), NULL);
    repeatable = *value_of(token, "repeatable") == 't';

    snprintf(file, sizeof file, "%s/run.lock", root);
    lock = open(file, O_RDWR | O_CLOEXEC);
    if (lock < 0 || flock(lock, LOCK_SH | LOCK_NB))
        fail(1, "the run of %s is over", file);
    door = door_open(root, prefix, "fluid");
    if (!door)
        fail(1, "%s", door_error());
    snprintf(grains, sizeof grains, "%zu", count);
    Topic sent = topic("bedload/loads", TYPE(Loads), sizeof(Loads), true, grains);
    Topic received = topic("bedload/kinematics", TYPE(Kinematics), sizeof(Kinematics), true, grains);
    Topic orders = topic("bedload/command", TYPE(Command), sizeof(Command), false, grains);
    Topic answers = topic("bedload/status/fluid", TYPE(Status), sizeof(Status), false, grains);
    loads = must(door_publisher(door, &sent, count));
    motion = must(door_subscriber(door, &received));
    commands = must(door_subscriber(door, &orders));
    status = must(door_publisher(door, &answers, 1));
    bell = must(door_listener(door, "bedload/wake/fluid"));
    coupler = must(door_notifier(door, "bedload/wake/coupler"));
    dem = must(door_notifier(door, "bedload/wake/dem"));

    Wait w = wait_for(join_s);
    while (must(door_publishers(door, motion)) < 1 || must(door_subscribers(door, loads)) < 2)
        moment(&w, "coupler");
    must(door_notify(door, dem));
    must(door_connect(door));
    said.process = getpid();
    said.grains = count;
    say(READY, "bedload " PROTOCOL " " LAYOUT);
}

/* ---- Messages ---- */

static void say(int state, const char *text)
{
    struct rusage used;
    getrusage(RUSAGE_SELF, &used);
    said.state = state;
    said.peak_rss = 1024 * (uint64_t)used.ru_maxrss;
    memset(said.text, 0, sizeof said.text);
    snprintf(said.text, sizeof said.text, "%s", text);
    double start = seconds(CLOCK_MONOTONIC);
    Status *out = door_loan(door, status, 1, NULL);
    if (!out)
        fail(1, "%s", door_error());
    *out = said;
    if (must(door_send(door, status)) != 1)
        fail(3, "the coupler has left");
    must(door_notify(door, coupler));
    said.exchange_s += seconds(CLOCK_MONOTONIC) - start;
}

void answer(int state, const Command *about, double dt_limit, double solver_s)
{
    said.step = about->step;
    said.attempt = about->attempt;
    said.dt_limit = dt_limit;
    said.solver_s = solver_s;
    say(state, "");
}

static bool take_command(void)
{
    const void *from, *header;
    size_t count;
    if (!must(door_receive(door, commands, &from, &count, &header)))
        return false;
    if (waiting == sizeof backlog / sizeof *backlog)
        fail(1, "%d commands wait, more than may be ordered ahead", waiting);
    backlog[waiting++] = *(const Command *)from;
    return true;
}

Command next_command(void)
{
    for (Wait w = wait_for(2 * (join_s + deadline_s)); !waiting && !take_command();)
        moment(&w, "coupler");
    Command first = backlog[0];
    memmove(backlog, backlog + 1, --waiting * sizeof *backlog);
    return first;
}

Loads *loan_loads(const Command *of)
{
    void *header;
    Loads *out = door_loan(door, loads, said.grains, &header);
    if (!out)
        fail(1, "%s", door_error());
    *(Header *)header = (Header){.step = of->step, .attempt = of->attempt, .time = of->time, .dt = of->dt};
    return out;
}

void send_loads(void)
{
    double start = seconds(CLOCK_MONOTONIC);
    if (must(door_send(door, loads)) != 2)
        fail(3, "the DEM or the coupler has left");
    must(door_notify(door, dem));
    said.exchange_s += seconds(CLOCK_MONOTONIC) - start;
}

const Kinematics *receive_motion(const Command *of)
{
    const void *from, *about;
    size_t count;
    for (Wait w = wait_for(2 * deadline_s + 1); !must(door_receive(door, motion, &from, &count, &about));) {
        if (take_command() && backlog[waiting - 1].order == STOP) {
            answer(STOPPED, &backlog[waiting - 1], said.dt_limit, said.solver_s);
            leave_run();
            exit(0);
        }
        moment(&w, "dem");
    }
    const Header *header = about;
    if (header->step != of->step || header->attempt != of->attempt || count != said.grains)
        fail(1, "%zu grains of window %lu.%lu came in window %lu.%lu", count, header->step, header->attempt,
             of->step, of->attempt);
    return from;
}
