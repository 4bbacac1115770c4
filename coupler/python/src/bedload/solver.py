"""A DEM of one's own in Python: this end of a coupled run, written from docs/coupling.md alone.

A solver is a sub-class of `Dem` and ends in `start`:

    class Mine(Dem):
        def contact(self, h):
            ...what acts between grains and at walls...

    start(Mine)

The scene names it: `[dem] command = ["python", "mine.py"]`. `bedload conformance -- python mine.py` tests it.
"""

from __future__ import annotations

import copy
import ctypes
import fcntl
import glob
import json
import math
import os
import resource
import shutil
import signal
import sys
import time
from collections.abc import Iterator
from typing import Any, Callable

import numpy as np
from numpy.typing import NDArray

from ._scene import read, value_of

try:
    import iceoryx2 as iox
except ImportError as error:
    raise ImportError(f"{error}; remedy: pip install 'bedload[iceoryx2]'") from error

__all__ = ["Command", "Dem", "Floats", "LAW", "Leave", "is_wall", "start"]

PROTOCOL, LAYOUT = 1, "31cfbed10181097c"
ADVANCE, REPEAT, ACCEPT, CHECKPOINT, STOP = range(1, 6)
READY, DONE, SAVED, STOPPED, FAILED = range(1, 6)

#: Law and form of a contact with k_n and gamma_n of Izard et al. 2014, eqs 17 and 18.
LAW = ("linear-spring-dashpot", "izard-2014")
Floats = NDArray[np.float64]


class Leave(Exception):
    """The way out of a solver: an exit code (2: the scene is not for it), and what to say."""

    def __init__(self, code: int, text: str) -> None:
        super().__init__(code, text)
        self.code, self.text = code, text


def is_wall(domain: dict[str, Any], axis: str, end: str) -> bool:
    """Do grains touch this side of the box? As `serve` is given a scene, each side says so: `x`, or `x_lower`
    and `x_upper`."""
    sides = domain.get("boundary", {})
    side = sides.get(f"{axis}_{end}", sides.get(axis))
    return isinstance(side, dict) and bool(side.get("contact", False))


class Dem:
    """The grains of a scene, free spheres or discs. A sub-class says in `contact` what acts on them, or has a
    `window` of its own. One row a grain: `x` position, `q` orientation (w, x, y, z), `v` velocity, `w` spin,
    `a` and `alpha` mean accelerations of the last window, `r` radius, `m` mass, `inertia`; `g` gravity, `dt`
    sub-step, `t_c` contact time, `law` the section `[dem.contact]`, `walls` (axis, sign of the normal,
    place), `periods` of the box, 0 where it has none."""

    #: Attributes that are the state: kept for a window that is done again, and written to checkpoints.
    state: tuple[str, ...] = ("x", "q", "v", "w", "a", "alpha")
    #: Name of the checkpoint.
    file = "dem.checkpoint"

    def __init__(self, scene: dict[str, Any]) -> None:
        grains, domain, dem, zero = scene.get("grains", []), scene["domain"], scene.get("dem", {}), [0.0] * 3
        disc = "disc" if domain["geometry"] == "plane" else "sphere"
        if (
            not grains
            or "groups" in scene
            or any(
                grain.get("shape", disc) not in ("sphere", "disc") or grain.get("motion", "free") != "free"
                for grain in grains
            )
        ):
            raise Leave(2, "not for this DEM; remedy: free spheres or discs in [[grains]]")
        if scene.get("walls") or any(grain.get("locked") for grain in grains):
            raise Leave(2, "[[walls]] and `locked` are not for this DEM; remedy: faces of the box, and leave it out")
        if np.shape(gravity := scene["gravity"]) != (3,):
            raise Leave(2, f"gravity: {gravity} is not for this DEM; remedy: three numbers")

        def column(key: str, default: Any) -> Floats:
            return np.array([grain.get(key, default) for grain in grains], float)

        self.grains, self.r, self.g = len(grains), column("radius", 0.0), np.array(gravity, float)
        is_disc = np.array([grain.get("shape", disc) == "disc" for grain in grains])
        rho, r = column("density", 0.0), self.r
        self.m = np.where(is_disc, rho * math.pi * r**2, rho * 4 / 3 * math.pi * r**3)
        self.inertia = np.where(is_disc, 0.5, 0.4) * self.m * self.r**2
        self.x, self.v, self.w = column("position", zero), column("velocity", zero), column("spin", zero)
        self.q, self.a, self.alpha = column("orientation", [1.0, 0, 0, 0]), column("", zero), column("", zero)
        self.law = dem.get("contact", {})
        self.t_c = self.law.get("contact_time", math.inf)
        self.dt = dem.get("dt", self.t_c / dem.get("steps_per_contact", 50))
        sides, axes = domain.get("boundary", {}), "xyz" if domain["geometry"] == "space" else "xz"
        self.walls = [
            ("xyz".index(axis), sign, place)
            for end, sign in (("lower", 1), ("upper", -1))
            for axis, place in zip(axes, domain[end])
            if is_wall(domain, axis, end)
        ]
        self.periods = np.zeros(3)
        for axis, low, high in zip(axes, domain["lower"], domain["upper"]):
            if "periodic" in str(sides.get(axis, sides.get(f"{axis}_lower"))):
                self.periods["xyz".index(axis)] = high - low

    def facts(self) -> dict[str, Any]:
        """What `check` answers (docs/coupling.md)."""
        return {"grains": self.grains, "dt": self.dt, "contact_time": self.t_c, "interaction_range": 0.0}

    def gaps(self, below: float) -> Iterator[tuple[list[Any], str, Floats, float]]:
        """Grains (two, or one at a wall), name of the pair, normal towards the first, and gap of those whose
        gap is below a limit. Looks at all pairs."""
        x, r = self.x, self.r
        for axis, sign, place in self.walls:
            for i in map(int, np.flatnonzero(sign * (x[:, axis] - place) - r < below)):
                yield [i], f"{i} {axis} {sign}", sign * np.eye(3)[axis], sign * (x[i, axis] - place) - r[i]
        apart = x[:, None] - x
        for axis in map(int, np.flatnonzero(self.periods)):
            apart[:, :, axis] -= self.periods[axis] * np.round(apart[:, :, axis] / self.periods[axis])
        for i, j in np.argwhere(np.triu(np.linalg.norm(apart, axis=2) - r[:, None] - r < below, 1)):
            distance = math.hypot(*apart[i, j])
            yield [i, j], f"{i} {j}", apart[i, j] / distance, distance - r[i] - r[j]

    def contact(self, h: float) -> tuple[Floats, Floats]:
        """Force and torque on each grain, a row each, in a sub-step of length `h`: for a sub-class to say."""
        raise NotImplementedError(f"{type(self).__name__} has neither `contact` nor `window`")

    def window(self, of: Any, loads: Floats) -> tuple[Floats, float]:
        """The sub-steps of a window under its loads, held constant, with the virtual mass; returns the
        kinematics (22 words a grain) and the smallest gap. Half a drift, kick, half a drift: a flight is
        exact."""
        h, mass, inertia = of.dt / of.substeps, self.m + loads[:, 6], self.inertia + loads[:, 7]
        pull = self.m[:, None] * self.g + loads[:, :3] + loads[:, 6:7] * self.a
        twist = loads[:, 3:6] + loads[:, 7:] * self.alpha
        v, w, mean, least = self.v.copy(), self.w.copy(), np.zeros((self.grains, 3)), math.inf
        for _ in range(of.substeps):
            self.x += h / 2 * self.v
            force, torque = map(self._rows, self.contact(h), ("force", "torque"))
            self.v += h * (pull + force) / mass[:, None]
            self.w += h * (twist + torque) / inertia[:, None]
            self.x += h / 2 * self.v
            self.turn(h)
            mean += force / of.substeps
            least = min([least, *(gap for *_, gap in self.gaps(0.0))])
        self.a, self.alpha = (self.v - v) / of.dt, (self.w - w) / of.dt
        seen = np.zeros((self.grains, 9))
        seen[:, :3], seen[:, 6] = mean, math.inf
        for who, _, _, gap in self.gaps(math.inf):
            seen[who, 6] = np.minimum(seen[who, 6], gap)
        return np.hstack([self.x, self.q, self.v, self.w, seen]), min(least, seen[:, 6].min())

    def _rows(self, values: Floats, what: str) -> Floats:
        """One row of each grain: a single row would act on all."""
        if np.shape(values) != self.x.shape:
            shapes = f"{np.shape(values)}; needed: {self.x.shape}, a row a grain"
            raise ValueError(f"`contact` gave a {what} of shape {shapes}")
        return values

    def turn(self, h: float) -> None:
        """Turns the grains by their spin."""
        for q, turn in zip(self.q, h * self.w):
            q[:] = [q[0] - turn @ q[1:] / 2, *(q[1:] + (q[0] * turn + np.cross(turn, q[1:])) / 2)]
            q /= math.hypot(*q)

    def keep(self) -> None:
        """Keeps the state at the start of a window that may be done again."""
        self.kept = {name: copy.deepcopy(getattr(self, name)) for name in self.state}

    def back(self) -> None:
        """Goes back to the state that was kept."""
        for name, value in self.kept.items():
            setattr(self, name, copy.deepcopy(value))

    def save(self, folder: str) -> None:
        """Writes a checkpoint; floats as text that reads back to the same bits."""
        state = {name: getattr(self, name) for name in self.state}
        state = {
            name: value.tolist() if isinstance(value, np.ndarray) else value for name, value in state.items()
        }
        with open(f"{folder}/{self.file}.partial", "w", encoding="utf-8") as file:
            json.dump(state, file)
            file.flush()
            os.fsync(file.fileno())
        os.rename(file.name, f"{folder}/{self.file}")

    def load(self, folder: str) -> None:
        """Goes on from a checkpoint."""
        try:
            with open(f"{folder}/{self.file}", encoding="utf-8") as file:
                state = json.load(file)
            for name in self.state:
                now = getattr(self, name)
                setattr(self, name, np.array(state[name]) if isinstance(now, np.ndarray) else state[name])
        except (OSError, ValueError, KeyError) as error:
            raise Leave(
                2, f"{folder}/{self.file}: {error}; remedy: resume from another checkpoint"
            ) from error


# ---- Messages: words of 8 bytes, `u:name` (u64) or `name` (f64). iceoryx2 compares name, size and alignment
# ----
def _record(name: str, words: str) -> Any:
    fields = [(w[2:], ctypes.c_uint64) if w.startswith("u:") else (w, ctypes.c_double) for w in words.split()]
    of = {"_fields_": fields, "type_name": staticmethod(lambda: f"protocol::message::{name}")}
    return type(name, (ctypes.Structure,), of)


Loads = _record("Loads", "fx fy fz tx ty tz added_mass added_inertia")
Kinematics = _record(
    "Kinematics", " ".join(f"word{n}" for n in range(22))
)  # by columns: the end of Dem.window
Header = _record("Header", "u:step u:attempt time dt u:substeps smallest_gap largest_overlap")
Command = _record("Command", "u:order u:step u:attempt time dt u:substeps u:output")
Status = _record(
    "Status",
    "u:state u:step u:attempt dt_limit solver_s exchange_s residual u:peak_rss u:process "
    "u:grains u:substeps pressure_gradient " + " ".join(f"u:text{n}" for n in range(64)),
)


def _rows(sample: Any, count: int, words: int) -> Floats:
    """The slice of a sample: a row for each grain."""
    return np.ctypeslib.as_array(
        ctypes.cast(sample.payload_ptr, ctypes.POINTER(ctypes.c_double)), (count, words)
    )


class _Link:
    """This end of a run: token, lock, node, services, waiting, the loop of orders."""

    def __init__(self, token: dict[str, Any], grains: int) -> None:
        self.token, self.grains, self.said = token, grains, Status(dt_limit=math.inf)
        self.backlog: list[Any] = []
        if (token["protocol"], token["layout"], token["grains"]) != (PROTOCOL, LAYOUT, grains):
            raise Leave(
                1, f"{token['grains']} grains of layout {token['layout']}: here are {grains} of {LAYOUT}"
            )
        self.lock = open(f"{token['root']}/run.lock", "r+")  # held while we live: the last one sweeps
        fcntl.flock(self.lock, fcntl.LOCK_SH | fcntl.LOCK_NB)
        self.config = iox.config.default()
        every = self.config.global_cfg
        every.root_path, every.prefix = iox.Path.new(token["root"]), iox.FileName.new(token["prefix"])
        every.node.cleanup_dead_nodes_on_creation = every.node.cleanup_dead_nodes_on_destruction = False
        every.service.cleanup_dead_nodes_on_open = False
        node = iox.NodeBuilder.new().name(iox.NodeName.new("dem")).config(self.config)
        self.node = node.signal_handling_mode(iox.SignalHandlingMode.Disabled).create(iox.ServiceType.Ipc)
        loads, motion = self.topic("loads", iox.Slice[Loads]), self.topic("kinematics", iox.Slice[Kinematics])
        command = self.topic("command", Command)
        self.loads, self.commands = (topic.subscriber_builder().create() for topic in (loads, command))
        self.motion = motion.publisher_builder().initial_max_slice_len(grains).create()
        self.status = self.topic("status/dem", Status).publisher_builder().create()
        self.bell = self.event("dem").listener_builder().create()
        self.coupler, self.fluid = (
            self.event(owner).notifier_builder().create() for owner in ("coupler", "fluid")
        )

        def joined() -> bool:
            of_loads, of_motion = loads.dynamic_config, motion.dynamic_config
            return bool(of_loads.number_of_publishers >= 1 and of_motion.number_of_subscribers >= 2)

        self.wait(lambda: joined() or None, "coupler", token["join_s"])
        self.motion.update_connections()
        self.status.update_connections()
        self.fluid.notify()
        self.said.process, self.said.grains = os.getpid(), grains
        self.say(READY, Command(), f"bedload {PROTOCOL} {LAYOUT}")

    def topic(self, name: str, record: Any) -> Any:
        wanted = iox.AttributeVerifier.new()
        for key, value in (("protocol", PROTOCOL), ("layout", LAYOUT), ("grains", self.grains)):
            wanted = wanted.require(
                iox.AttributeKey.new(f"bedload.{key}"), iox.AttributeValue.new(str(value))
            )
        service = self.node.service_builder(iox.ServiceName.new(f"bedload/{name}")).publish_subscribe(record)
        if name in ("loads", "kinematics"):
            service = service.user_header(Header)
        return service.open_with_attributes(wanted)

    def event(self, owner: str) -> Any:
        return self.node.service_builder(iox.ServiceName.new(f"bedload/wake/{owner}")).event().open()

    def wait(self, ready: Callable[[], Any], peer: str, limit: float) -> Any:
        """Until `ready` returns something; never without a limit, nor without a look at who lives."""
        start, look, missed = time.monotonic(), time.monotonic(), 0
        while (result := ready()) is None:
            if time.monotonic() > start + limit:
                raise Leave(3, f"nothing has come from the {peer} in {limit:g} s")
            if time.monotonic() > look + 0.05:
                nodes = iox.Node.list(iox.ServiceType.Ipc, self.config)
                names = {
                    node[0].details.name.as_str() for node in nodes if isinstance(node, iox.NodeState.Alive)
                }
                look, missed = time.monotonic(), 0 if {"coupler", peer} <= names else missed + 1
                if missed == 2:  # twice, so that what was sent last is taken
                    raise Leave(3, f"the {peer} or the coupler has left")
            self.bell.timed_wait(iox.Duration.from_millis(10))
        return result

    def send(self, sample: Any, *notifiers: Any) -> None:
        if sample.assume_init().send() < len(notifiers):
            raise Leave(3, "a receiver has left")
        for notifier in notifiers:
            notifier.notify()

    def say(self, state: int, about: Any, text: str = "") -> None:
        said, words, sample = self.said, text.encode()[:511], self.status.loan_uninit()
        said.state, said.step, said.attempt, said.solver_s = (
            state,
            about.step,
            about.attempt,
            time.process_time(),
        )
        said.peak_rss = 1024 * resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
        ctypes.memmove(ctypes.byref(said, Status.text0.offset), words.ljust(512, b"\0"), 512)
        ctypes.memmove(sample.payload_ptr, ctypes.byref(said), ctypes.sizeof(said))
        self.send(sample, self.coupler)

    def command(self) -> list[Any] | None:
        if sample := self.commands.receive():
            words = ctypes.string_at(sample.payload_ptr, ctypes.sizeof(Command))
            self.backlog.append(Command.from_buffer_copy(words))
        return self.backlog or None

    def receive_loads(self, of: Any) -> Floats:
        def ready() -> Any:
            if self.command() and self.backlog[-1].order == STOP:
                raise Leave(0, "stopped")
            return self.loads.receive()

        sample = self.wait(ready, "fluid", 2 * self.token["deadline_s"] + 1)
        head = sample.user_header().contents
        loads: Floats = _rows(sample, self.grains, 8).copy()
        if (head.step, head.attempt) != (of.step, of.attempt) or not np.isfinite(loads).all():
            raise Leave(
                1,
                f"loads of window {of.step}.{of.attempt} are those of {head.step}.{head.attempt}, or not "
                "finite",
            )
        return loads

    def send_motion(self, of: Any, motion: Floats, gap: float) -> None:
        sample = self.motion.loan_slice_uninit(self.grains)
        _rows(sample, self.grains, 22)[:] = motion
        head = sample.user_header().contents
        head.__init__(of.step, of.attempt, of.time, of.dt, of.substeps, gap, max(-gap, 0.0))
        self.send(sample, self.fluid, self.coupler)

    def close(self) -> None:
        self.loads = self.commands = self.motion = self.status = self.bell = None
        self.coupler = self.fluid = self.node = None
        try:
            fcntl.flock(self.lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError:
            return  # somebody is still there
        for segment in glob.glob(f"/dev/shm/{self.token['prefix']}*"):
            os.unlink(segment)
        shutil.rmtree(self.token["root"], ignore_errors=True)

    def serve(self, dem: Dem, out: str) -> None:
        """The loop of orders."""
        while self.wait(self.command, "coupler", 2 * (self.token["join_s"] + self.token["deadline_s"])):
            of = self.backlog.pop(0)
            if of.order in (ADVANCE, REPEAT):
                if of.order == REPEAT:
                    dem.back()
                elif self.token["repeatable"]:
                    dem.keep()
                motion, gap = dem.window(of, self.receive_loads(of))
                self.send_motion(of, motion, gap)
                self.said.substeps += of.substeps
                self.say(DONE, of)
            elif of.order == CHECKPOINT:
                folder = f"{out}/checkpoint/{of.step:010}"
                os.makedirs(folder, exist_ok=True)
                dem.save(folder)
                self.say(SAVED, of)
            elif of.order == STOP:
                return self.say(STOPPED, of)
            elif of.order != ACCEPT:
                raise Leave(1, f"order {of.order} is not known")


def _main(dem_of: Callable[[dict[str, Any]], Dem], what: str, path: str, *words: str) -> None:
    """The commands `check` and `serve`."""

    def after(name: str) -> list[str]:
        return [value for key, value in zip(words, words[1:]) if key == name]

    scene = read(path)
    for key, value in (text.split("=", 1) for text in after("--set")):
        *tables, last = key.split(".")
        table = scene
        for name in tables:
            table = table.setdefault(name, {})
        table[last] = value_of(value)
    dem = dem_of(scene)
    if what == "check":
        return print(json.dumps(dem.facts()))
    for folder in after("--checkpoint"):
        dem.load(folder)
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is the coupler's: it orders us to stop
    link = _Link(json.loads((after("--connect") or [os.environ["BEDLOAD_CONNECT"]])[0]), dem.grains)
    try:
        link.serve(dem, after("--out")[0])
    except Exception as error:
        code, text = error.args if isinstance(error, Leave) else (1, f"{type(error).__name__}: {error}")
        link.say(FAILED if code else STOPPED, link.backlog[-1] if link.backlog else Command(), text)
        raise
    finally:
        link.close()


def start(dem_of: Callable[[dict[str, Any]], Dem]) -> None:
    """The program: `dem_of` makes a DEM of a scene, or raises Leave(2, why) if it cannot.

    Ends the process with the code of a Leave."""
    if len(sys.argv) < 3 or sys.argv[1] not in ("check", "serve"):
        name = os.path.basename(sys.argv[0])
        print(
            f'{name}: `bedload` starts this, where the scene has [dem] command = ["python", "{name}"]',
            file=sys.stderr,
        )
        sys.exit(2)
    try:
        _main(dem_of, *sys.argv[1:])
    except Leave as leave:
        print(f"{os.path.basename(sys.argv[0])}: {leave.text}", file=sys.stderr)
        sys.exit(leave.code)
