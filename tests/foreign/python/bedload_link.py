"""A DEM's end of a run, written from docs/coupling.md alone: the messages, joining, waiting, the loop of orders.

A DEM is an object with grains, window(command, loads), save(folder), keep() and back(); see dem.py.
"""
import ctypes, fcntl, glob, json, math, os, resource, shutil, signal, sys, time, tomllib
import iceoryx2 as iox
import numpy as np

PROTOCOL, LAYOUT = 1, "31cfbed10181097c"
ADVANCE, REPEAT, ACCEPT, CHECKPOINT, STOP = range(1, 6)
READY, DONE, SAVED, STOPPED, FAILED = range(1, 6)


# ---- Messages: words of 8 bytes, `u:name` (u64) or `name` (f64). iceoryx2 compares name, size and alignment ----
def record(name, words):
    fields = [(w[2:], ctypes.c_uint64) if w.startswith("u:") else (w, ctypes.c_double) for w in words.split()]
    of = {"_fields_": fields, "type_name": staticmethod(lambda: f"protocol::message::{name}")}
    return type(name, (ctypes.Structure,), of)

Loads = record("Loads", "fx fy fz tx ty tz added_mass added_inertia")
Kinematics = record("Kinematics", " ".join(f"word{n}" for n in range(22)))  # written by columns, at the end of window()
Header = record("Header", "u:step u:attempt time dt u:substeps smallest_gap largest_overlap")
Command = record("Command", "u:order u:step u:attempt time dt u:substeps u:output")
Status = record("Status", "u:state u:step u:attempt dt_limit solver_s exchange_s residual u:peak_rss u:process "
                "u:grains u:substeps pressure_gradient " + " ".join(f"u:text{n}" for n in range(64)))

def rows(sample, count, words):
    """The slice of a sample: a row for each grain."""
    return np.ctypeslib.as_array(ctypes.cast(sample.payload_ptr, ctypes.POINTER(ctypes.c_double)), (count, words))

class Leave(Exception):
    """The way out: an exit code, and what to say."""


# ---- This end of a run ----
class Run:
    def __init__(self, token, grains):
        self.token, self.grains, self.backlog, self.said = token, grains, [], Status(dt_limit=math.inf)
        if (token["protocol"], token["layout"], token["grains"]) != (PROTOCOL, LAYOUT, grains):
            raise Leave(1, f"{token['grains']} grains of layout {token['layout']}: here are {grains} of {LAYOUT}")
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
        self.loads, self.commands = (topic.subscriber_builder().create() for topic in (loads, self.topic("command", Command)))
        self.motion = motion.publisher_builder().initial_max_slice_len(grains).create()
        self.status = self.topic("status/dem", Status).publisher_builder().create()
        self.bell = self.event("dem").listener_builder().create()
        self.coupler, self.fluid = (self.event(owner).notifier_builder().create() for owner in ("coupler", "fluid"))
        joined = lambda: loads.dynamic_config.number_of_publishers >= 1 and motion.dynamic_config.number_of_subscribers >= 2
        self.wait(lambda: joined() or None, "coupler", token["join_s"])
        self.motion.update_connections(), self.status.update_connections(), self.fluid.notify()
        self.said.process, self.said.grains = os.getpid(), grains
        self.say(READY, Command(), f"bedload {PROTOCOL} {LAYOUT}")

    def topic(self, name, record):
        wanted = iox.AttributeVerifier.new()
        for key, value in (("protocol", PROTOCOL), ("layout", LAYOUT), ("grains", self.grains)):
            wanted = wanted.require(iox.AttributeKey.new(f"bedload.{key}"), iox.AttributeValue.new(str(value)))
        service = self.node.service_builder(iox.ServiceName.new(f"bedload/{name}")).publish_subscribe(record)
        return (service.user_header(Header) if name in ("loads", "kinematics") else service).open_with_attributes(wanted)

    def event(self, owner):
        return self.node.service_builder(iox.ServiceName.new(f"bedload/wake/{owner}")).event().open()

    def wait(self, ready, peer, limit):
        """Until `ready` returns something; never without a limit, nor without a look at who lives."""
        start, look, missed = time.monotonic(), time.monotonic(), 0
        while (result := ready()) is None:
            if time.monotonic() > start + limit:
                raise Leave(3, f"nothing has come from the {peer} in {limit:g} s")
            if time.monotonic() > look + 0.05:
                nodes = iox.Node.list(iox.ServiceType.Ipc, self.config)
                names = {node[0].details.name.as_str() for node in nodes if isinstance(node, iox.NodeState.Alive)}
                look, missed = time.monotonic(), 0 if {"coupler", peer} <= names else missed + 1
                if missed == 2:  # twice, so that what was sent last is taken
                    raise Leave(3, f"the {peer} or the coupler has left")
            self.bell.timed_wait(iox.Duration.from_millis(10))
        return result

    def send(self, sample, *notifiers):
        if sample.assume_init().send() < len(notifiers):
            raise Leave(3, "a receiver has left")
        for notifier in notifiers:
            notifier.notify()

    def say(self, state, about, text=""):
        said, words, sample = self.said, text.encode()[:511], self.status.loan_uninit()
        said.state, said.step, said.attempt, said.solver_s = state, about.step, about.attempt, time.process_time()
        said.peak_rss = 1024 * resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
        ctypes.memmove(ctypes.byref(said, Status.text0.offset), words.ljust(512, b"\0"), 512)
        ctypes.memmove(sample.payload_ptr, ctypes.byref(said), ctypes.sizeof(said))
        self.send(sample, self.coupler)

    def command(self):
        if sample := self.commands.receive():
            self.backlog.append(Command.from_buffer_copy(ctypes.string_at(sample.payload_ptr, ctypes.sizeof(Command))))
        return self.backlog or None

    def receive_loads(self, of):
        def ready():
            if self.command() and self.backlog[-1].order == STOP:
                raise Leave(0, "stopped")
            return self.loads.receive()
        sample = self.wait(ready, "fluid", 2 * self.token["deadline_s"] + 1)
        head, loads = sample.user_header().contents, rows(sample, self.grains, 8).copy()
        if (head.step, head.attempt) != (of.step, of.attempt) or not np.isfinite(loads).all():
            raise Leave(1, f"loads of window {of.step}.{of.attempt} are those of {head.step}.{head.attempt}, or not finite")
        return loads

    def send_motion(self, of, motion, gap):
        sample = self.motion.loan_slice_uninit(self.grains)
        rows(sample, self.grains, 22)[:] = motion
        sample.user_header().contents.__init__(of.step, of.attempt, of.time, of.dt, of.substeps, gap, max(-gap, 0.0))
        self.send(sample, self.fluid, self.coupler)

    def close(self):
        self.loads = self.commands = self.motion = self.status = self.bell = self.coupler = self.fluid = self.node = None
        try:
            fcntl.flock(self.lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError:
            return  # somebody is still there
        for segment in glob.glob(f"/dev/shm/{self.token['prefix']}*"):
            os.unlink(segment)
        shutil.rmtree(self.token["root"], ignore_errors=True)

    def serve(self, dem, out):
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


# ---- What a DEM reads of a scene ----
LAW = ("linear-spring-dashpot", "izard-2014")  # law and form: k_n and gamma_n of Izard et al. 2014, eqs 17 and 18

def is_wall(domain, axis, end):
    """Do grains touch this side of the box? As `serve` is given a scene, each side says so: `x`, or `x_lower` and `x_upper`."""
    sides = domain.get("boundary", {})
    side = sides.get(f"{axis}_{end}", sides.get(axis))
    return isinstance(side, dict) and side.get("contact", False)


# ---- The commands `check` and `serve` ----
def main(dem_of, what, path, *words):
    after = lambda name: [value for key, value in zip(words, words[1:]) if key == name]
    with open(path, "rb") as file:
        scene = tomllib.load(file)
    for key, value in (text.split("=", 1) for text in after("--set")):
        *tables, last = key.split(".")
        table = scene
        for name in tables:
            table = table.setdefault(name, {})
        table[last] = tomllib.loads(f"value = {value}")["value"]
    dem = dem_of(scene)
    if what == "check":
        return print(json.dumps(dem.facts()))
    for folder in after("--checkpoint"):
        dem.load(folder)
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is the coupler's: it orders us to stop
    run = Run(json.loads((after("--connect") or [os.environ["BEDLOAD_CONNECT"]])[0]), dem.grains)
    try:
        run.serve(dem, after("--out")[0])
    except Exception as error:
        code, text = error.args if isinstance(error, Leave) else (1, f"{type(error).__name__}: {error}")
        run.say(FAILED if code else STOPPED, run.backlog[-1] if run.backlog else Command(), text)
        raise
    finally:
        run.close()


def start(dem_of):
    """The program: `dem_of` makes a DEM of a scene, or raises Leave(2, why) if it cannot."""
    try:
        main(dem_of, *sys.argv[1:])
    except Leave as leave:
        print(f"{os.path.basename(sys.argv[0])}: {leave.args[1]}", file=sys.stderr)
        sys.exit(leave.args[0])
