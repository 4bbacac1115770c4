#!/usr/bin/env python3
"""What run.sh compares. Python's standard library only.

    check.py facts DT < FACTS.json        the facts of the fluid: no cells, this dt
    check.py settles SCHEME DIR DIR...    runs of settling-stokes.toml, the next with half the dt of the one before
    check.py same DIR DIR                 two runs: the same series, the same states of the solvers at their end
    check.py history                      prints the velocity over v_inf with the history force (Basset 1888), too
"""

import csv
import json
import math
import pathlib
import sys

TAU, V_INF = 1 / 16, 5 / 96  # settling-stokes.toml


def velocities(folder):
    """Time and downward velocity after each window."""
    with open(pathlib.Path(folder) / "series.csv", newline="") as file:
        return [(float(row["t"]), -float(row["velocity_z[0]"])) for row in csv.DictReader(file)]


def exact(t):
    return -math.expm1(-t / TAU)


# For each scheme, over v_inf: the velocities of the difference equation it solves, and a bound of their distance to the
# exact ones. README.md, "Why these tolerances".


def euler(h, steps):
    v = [0.0]
    for _ in range(steps):
        v.append(v[-1] + h * (1 - v[-1]))
    return v[1:]


def trapezoidal(h, steps):
    v = [0.0]
    for _ in range(steps):
        v.append((v[-1] * (1 - h / 2) + h) / (1 + h / 2))
    return v[1:]


SCHEMES = {  # difference equation, distance to it, order, bound
    "semi-implicit": (euler, 1e-13, 1, lambda h: h / 2 * math.exp(h) / math.e),
    "iterated": (trapezoidal, 1e-11, 2, lambda h: (2 * math.atanh(h / 2) - h) / (h * math.e)),
}


def settles(scheme, *folders):
    equation, near, order, bound = SCHEMES[scheme]
    good, before = True, None
    for folder in folders:
        rows = velocities(folder)
        h = rows[0][0] / TAU
        solution = equation(h, len(rows))
        off = max(abs(v / V_INF - own) for (_, v), own in zip(rows, solution))
        error = max(abs(v / V_INF - exact(t)) for t, v in rows)
        observed = math.log2(before / error) if before else None
        fine = off <= near and error <= bound(h) and (observed is None or abs(observed - order) <= 0.2)
        good, before = good and fine, error
        print(
            f"  {scheme:13}  dt/tau 1/{1 / h:<3.0f} error {error:.3e} (allowed {bound(h):.3e})  order "
            f"{'-' if observed is None else f'{observed:.2f}':4}  from its own equation {off:.1e}"
            f"{'' if fine else '  WRONG'}"
        )
    return good


def facts(dt):
    told = json.load(sys.stdin)
    print(f"  cells {told['cells']}, dt {told['dt']}, schemes {told['schemes']}")
    return told["cells"] == 0 and told["dt"] == float(dt) and told["schemes"] == ["semi-implicit", "iterated"]


def state_of(file):
    """A checkpoint of ours without its head, or the whole of another's."""
    data = file.read_bytes()
    return data[56:] if data.startswith(b"BEDLOAD\n") else data


def same(a, b):
    a, b = pathlib.Path(a), pathlib.Path(b)
    ends = [max((run / "checkpoint").iterdir()) for run in (a, b)]
    pairs = [(a / "series.csv", b / "series.csv")]
    pairs += [tuple(end / f"{role}.checkpoint" for end in ends) for role in ("fluid", "dem")]
    differ = [str(x) for x, y in pairs if state_of(x) != state_of(y)]
    print(f"  {len(velocities(b))} windows: {'DIFFER: ' + ', '.join(differ) if differ else 'the same bits'}")
    return not differ


def history():
    """dv/dt = 1 - v - beta integral of v'(s) (t - s)^-1/2 ds, in tau and v_inf.

    v is linear within each step of tau/256.
    """
    a, nu, steps_per_tau = 0.5, 8.0, 256  # settling-stokes.toml
    beta, h = a / math.sqrt(math.pi * nu * TAU), 1 / steps_per_tau
    root = [2 * math.sqrt(k * h) for k in range(20 * steps_per_tau + 1)]
    v, slopes = 0.0, []
    for n in range(20 * steps_per_tau):
        past = sum(slope * (root[n + 1 - k] - root[n - k]) for k, slope in enumerate(slopes))
        slopes.append((1 - v - beta * past) / (1 + h + beta * root[1]))
        v += h * slopes[-1]
        if (n + 1) * h in (0.125, 0.25, 1, 5, 20):
            print(f"  t/tau {(n + 1) * h:<5g}  v/v_inf {v:.4f}")
    return True


if __name__ == "__main__":
    verb = {"facts": facts, "settles": settles, "same": same, "history": history}[sys.argv[1]]
    sys.exit(0 if verb(*sys.argv[2:]) else 1)
