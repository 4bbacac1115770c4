/* A fluid without a grid for Bedload: spheres in a viscous fluid at rest, each as if it were alone.
 *
 *   force on a sphere   -rho V g - 6 pi eta a v - m_a dv/dt, m_a = rho V/2
 *   torque on a sphere  -8 pi eta a^3 omega
 *
 * Buoyancy, Stokes's drag (1851) and added mass. docs/coupling.md says what is exchanged, and when. */
#define _GNU_SOURCE
#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <time.h>

#include "link.h"
#include "scene.h"

typedef struct {
    double radius, density;
    double moved[6]; /* velocity and spin at the end of the last attempt */
} Sphere;

/* What a checkpoint holds of a grain. Force and torque are those without added mass that were formed last. */
typedef struct {
    double motion[6], acceleration[3], force[3], torque[3];
} State;

static double gravity[3], density, viscosity, dt;
static size_t count;
static Sphere *sphere;
static State *now, *saved; /* at the start of the next window, and of the last one */
static uint64_t next;      /* the window after the last one */
static double worked;      /* CPU time, s */

/* ---- The scene ---- */

static void add_grain(void)
{
    sphere = realloc(sphere, (count + 1) * sizeof *sphere);
    now = realloc(now, (count + 1) * sizeof *now);
    saved = realloc(saved, (count + 1) * sizeof *saved);
    if (!sphere || !now || !saved)
        fail(1, "no memory for %zu grains", count + 1);
    sphere[count] = (Sphere){0};
    now[count++] = (State){0};
}

static void take(const char *key, const char *value)
{
    if (!value) {
        static const char *const others[] = {"groups", "grain_files", "rough_walls", "insertions"};
        for (size_t k = 0; k < sizeof others / sizeof *others; k++)
            if (!strcmp(key, others[k]))
                fail(2, "[[%s]] is not read here\n  remedy: write the grains one by one, as [[grains]]", key);
        if (!strcmp(key, "grains"))
            add_grain();
        return;
    }
    double set[3] = {0};
    sscanf(value + strspn(value, "[ "), "%lf , %lf , %lf", &set[0], &set[1], &set[2]);
    const char *of_grain = count && !strncmp(key, "grains.", 7) ? key + 7 : "";
    if (!strcmp(key, "gravity"))
        memcpy(gravity, set, sizeof set);
    else if (!strcmp(key, "medium.density"))
        density = set[0];
    else if (!strcmp(key, "medium.viscosity"))
        viscosity = set[0];
    else if (!strcmp(key, "fluid.time.dt"))
        dt = set[0];
    else if (!strcmp(of_grain, "radius"))
        sphere[count - 1].radius = set[0];
    else if (!strcmp(of_grain, "density"))
        sphere[count - 1].density = set[0];
    else if (!strcmp(of_grain, "velocity"))
        memcpy(now[count - 1].motion, set, sizeof set);
    else if (!strcmp(of_grain, "spin"))
        memcpy(now[count - 1].motion + 3, set, sizeof set);
    else if ((!strcmp(of_grain, "shape") && !strstr(value, "sphere")) ||
             (!strcmp(key, "medium.initial.type") && !strstr(value, "rest")) ||
             ((!strcmp(key, "medium.body_force") || !strcmp(key, "medium.pressure_gradient")) &&
              (set[0] != 0 || set[1] != 0 || set[2] != 0)))
        fail(2, "%s = %s: this fluid is at rest and knows spheres only\n  remedy: leave the key out", key, value);
}

static void read_or_refuse(const char *path)
{
    size_t length;
    char *text = read_file(path, &length);
    if (!text)
        fail(2, "%s: %s\n  remedy: name a scene that can be read", path, strerror(errno));
    read_scene(text, take);
    free(text);
}

/* The fastest rate at which drag slows a grain down, 1/s. */
static double fastest_rate(void)
{
    double rate = 0;
    for (size_t i = 0; i < count; i++) {
        double squared = sphere[i].radius * sphere[i].radius, dry = sphere[i].density;
        rate = fmax(rate, 4.5 * viscosity / squared / (dry + density / 2));
        rate = fmax(rate, 15 * viscosity / squared / dry);
    }
    return rate;
}

/* A step of Euler is stable up to rate dt = 2. */
static const double LIMIT_OF_RATE = 2;

/* What the coupler plans with (FluidFacts in protocol/src/facts.rs). */
static void print_facts(void)
{
    if (!(dt > 0))
        fail(2, "fluid.time.dt is missing\n  remedy: add [fluid.time] with dt = ..., in seconds");
    printf("{\"cells\": 0, \"dt\": %.17g, \"schemes\": [\"semi-implicit\", \"iterated\"], "
           "\"memory\": %zu, \"bounds\": [{\"name\": \"explicit-drag\", \"quantity\": \"dt/τ\", "
           "\"measure\": \"window\", \"factor\": %.17g, \"side\": \"at-most\", \"limit\": %g, "
           "\"level\": \"refuse\", \"why\": \"velocity or spin of the smallest or lightest grain would grow from window to window\", "
           "\"source\": \"tests/foreign/fluid-minimal/README.md\", \"remedy\": \"a smaller fluid.time.dt\"}]}\n",
           dt, count * (sizeof *sphere + 2 * sizeof *now), fastest_rate(), LIMIT_OF_RATE);
}

/* ---- The fluid ---- */

/* Force and torque without added mass; halfway: of the mean motion over the last attempt. */
static void form_loads(bool halfway)
{
    for (size_t i = 0; i < count; i++) {
        double a = sphere[i].radius, displaced = density * 4 / 3 * M_PI * a * a * a;
        for (int k = 0; k < 3; k++) {
            double v = now[i].motion[k], w = now[i].motion[3 + k];
            if (halfway) {
                v = 0.5 * (v + sphere[i].moved[k]);
                w = 0.5 * (w + sphere[i].moved[3 + k]);
            }
            now[i].force[k] = -displaced * gravity[k] - 6 * M_PI * viscosity * a * v;
            now[i].torque[k] = -8 * M_PI * viscosity * a * a * a * w;
        }
    }
}

/* The DEM adds m_a to the mass, and m_a A to the force, where A is the mean acceleration in the window before. With
 * that m_a A taken off here, what is left is the added mass in the motion to come. */
static void fill(Loads *out)
{
    for (size_t i = 0; i < count; i++) {
        double a = sphere[i].radius, added = density * 2 / 3 * M_PI * a * a * a;
        out[i] = (Loads){.added_mass = added};
        for (int k = 0; k < 3; k++) {
            out[i].force[k] = now[i].force[k] - added * now[i].acceleration[k];
            out[i].torque[k] = now[i].torque[k];
        }
    }
}

static void take_motion(const Kinematics *from, double length)
{
    for (size_t i = 0; i < count; i++) {
        double *moved = sphere[i].moved;
        memcpy(moved, from[i].velocity, sizeof from[i].velocity);
        memcpy(moved + 3, from[i].spin, sizeof from[i].spin);
        for (int k = 0; k < 6; k++)
            if (!isfinite(moved[k]))
                fail(1, "the motion of grain %zu is not finite", i);
        for (int k = 0; k < 3; k++)
            now[i].acceleration[k] = (moved[k] - now[i].motion[k]) / length;
        memcpy(now[i].motion, moved, sizeof now[i].motion);
    }
}

static void window(const Command *c)
{
    bool again = c->order == REPEAT;
    if (again && (!is_repeatable() || c->step + 1 != next))
        fail(1, "Repeat of window %lu, which was not the last one, or cannot be repeated", c->step);
    double start = seconds(CLOCK_THREAD_CPUTIME_ID);
    memcpy(again ? now : saved, again ? saved : now, count * sizeof *now);
    form_loads(again);
    fill(loan_loads(c));
    send_loads();
    worked += seconds(CLOCK_THREAD_CPUTIME_ID) - start;
    const Kinematics *motion = receive_motion(c);
    start = seconds(CLOCK_THREAD_CPUTIME_ID);
    take_motion(motion, c->dt);
    worked += seconds(CLOCK_THREAD_CPUTIME_ID) - start;
    next = c->step + 1;
}

/* ---- Checkpoints: the states, in the order of the grains ---- */

static void write_checkpoint(const char *out, uint64_t step)
{
    char folder[3900], path[4096], part[4110];
    snprintf(folder, sizeof folder, "%s/checkpoint", out);
    mkdir(folder, 0777);
    snprintf(folder, sizeof folder, "%s/checkpoint/%010lu", out, step);
    mkdir(folder, 0777);
    snprintf(path, sizeof path, "%s/fluid.checkpoint", folder);
    snprintf(part, sizeof part, "%s.part", path);
    FILE *file = fopen(part, "wb");
    bool written = file && fwrite(now, sizeof *now, count, file) == count;
    if (!file || fclose(file) || !written || rename(part, path))
        fail(1, "%s cannot be written: %s", path, strerror(errno));
}

static void read_checkpoint(const char *folder)
{
    char path[4096];
    size_t length;
    snprintf(path, sizeof path, "%s/fluid.checkpoint", folder);
    char *state = read_file(path, &length);
    if (!state || length != count * sizeof *now)
        fail(2, "%s is no checkpoint of %zu grains", path, count);
    memcpy(now, state, length);
    free(state);
}

/* ---- The commands check and serve ---- */

static _Noreturn void serve(const char *token, const char *out)
{
    double limit = LIMIT_OF_RATE / fastest_rate();
    join_run(token, count);
    for (;;) {
        Command c = next_command();
        if (c.order == ADVANCE || c.order == REPEAT)
            window(&c);
        else if (c.order == CHECKPOINT)
            write_checkpoint(out, c.step);
        else if (c.order != STOP && c.order != ACCEPT)
            fail(1, "order %lu is not known", c.order);
        static const int answers[] = {[ADVANCE] = DONE, [REPEAT] = DONE, [CHECKPOINT] = SAVED, [STOP] = STOPPED};
        if (c.order != ACCEPT)
            answer(answers[c.order], &c, limit, worked);
        if (c.order == STOP) {
            leave_run();
            exit(0);
        }
    }
}

int main(int words, char **word)
{
    const char *verb = words > 2 ? word[1] : "", *token = getenv("BEDLOAD_CONNECT"), *out = ".", *checkpoint = NULL;
    bool checks = !strcmp(verb, "check");
    if (!checks && strcmp(verb, "serve"))
        fail(2, "is started by bedload, with: check SCENE --json, or serve SCENE --connect TOKEN --out DIR");
    read_or_refuse(word[2]);
    for (int i = 3; i + 1 < words; i++) {
        char *equals = strchr(word[i + 1], '=');
        if (!strcmp(word[i], "--set") && equals) {
            *equals = 0;
            take(word[i + 1], equals + 1);
        } else if (!strcmp(word[i], "--connect")) {
            token = word[i + 1];
        } else if (!strcmp(word[i], "--out")) {
            out = word[i + 1];
        } else if (!strcmp(word[i], "--checkpoint")) {
            checkpoint = word[i + 1];
        }
    }
    if (checks) {
        print_facts();
        return 0;
    }
    if (!token)
        fail(2, "there is no token");
    form_loads(false);
    if (checkpoint)
        read_checkpoint(checkpoint);
    serve(token, out);
}
