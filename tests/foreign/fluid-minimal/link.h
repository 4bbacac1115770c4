/* A solver's end of a run of Bedload, in C: what docs/coupling.md says of messages, joining and waiting. This one
 * joins as the fluid; a DEM would send Kinematics and receive Loads. */
#ifndef LINK_H
#define LINK_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

typedef struct { double force[3], torque[3], added_mass, added_inertia; } Loads;
typedef struct { double position[3], orientation[4], velocity[3], spin[3], observed[9]; } Kinematics;
typedef struct { uint64_t step, attempt; double time, dt; uint64_t substeps; double smallest_gap, largest_overlap; } Header;
typedef struct { uint64_t order, step, attempt; double time, dt; uint64_t substeps, output; } Command;
typedef struct {
    uint64_t state, step, attempt;
    double dt_limit, solver_s, exchange_s, residual;
    uint64_t peak_rss, process, grains, substeps;
    double pressure_gradient;
    char text[512];
} Status;
_Static_assert(sizeof(Loads) == 64 && sizeof(Kinematics) == 176 && sizeof(Header) == 56, "docs/coupling.md");
_Static_assert(sizeof(Command) == 56 && sizeof(Status) == 608, "docs/coupling.md");

enum { ADVANCE = 1, REPEAT, ACCEPT, CHECKPOINT, STOP };
enum { READY = 1, DONE, SAVED, STOPPED, FAILED };

/* Ends the program: tells the coupler, if the run was joined, leaves the run, and exits with code. */
_Noreturn void fail(int code, const char *format, ...) __attribute__((format(printf, 2, 3)));
double seconds(int clock);

/* Joins the run of a token with this number of grains, and says Ready once the DEM is there. */
void join_run(const char *token, size_t grains);
/* Leaves it; the last one removes it. */
void leave_run(void);
/* May windows be ordered again? */
bool is_repeatable(void);
Command next_command(void);
/* Answers a command. dt_limit: the longest next window, solver_s: CPU time of the solver's work. */
void answer(int state, const Command *about, double dt_limit, double solver_s);
/* Room for the loads of a window, to be filled and sent. */
Loads *loan_loads(const Command *of);
void send_loads(void);
/* The motion after a window, valid until the next call. Obeys Stop while it waits. */
const Kinematics *receive_motion(const Command *of);

#endif
