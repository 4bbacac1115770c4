"""YADE as the DEM of a run: its contacts, collider and integrator. dem.sh starts it; the run: bedload.solver."""
import json, math, os, sys
import numpy as np
from yade import *  # YADE's names are made when it starts

sys.argv = ["dem.py", *json.loads(os.environ["BEDLOAD_WORDS"])]
from bedload.solver import LAW, Dem, Leave, is_wall, start

sys.stdout = os.fdopen(3, "w")  # what YADE prints of itself is no answer

STATE = "dem.yade.gz"


class Yade(Dem):
    state = ("a", "alpha", "normal")

    def __init__(self, scene):
        grains, domain, dem = scene.get("grains", []), scene["domain"], scene.get("dem", {})
        law, space = dem.get("contact", {}), domain["geometry"] == "space"
        known = grains and all((g.get("shape", "sphere"), g.get("motion", "free")) == ("sphere", "free") for g in grains)
        if not (known and len({(g["radius"], g["density"]) for g in grains}) == 1 and domain["geometry"] in ("space", "axisymmetric")
                and (law.get("law"), law.get("form")) == LAW and "contact_time" in law and "groups" not in scene
                and dem.get("lubrication", {}).get("form") == "none" and "periodic" not in str(domain.get("boundary"))):
            raise Leave(2, "not for this DEM; remedy: free spheres of one radius and density in [[grains]], in space or on the axis, a box "
                           'without periodic sides, [dem.contact] linear-spring-dashpot with form = "izard-2014" and contact_time, dem.lubrication.form = "none"')
        super().__init__(scene)
        # All of one radius and mass.
        self.r, self.m, self.normal = float(self.r[0]), float(self.m[0]), np.zeros((self.grains, 3))
        self.walls = [("xyz".index(axis), sign, domain[end][n]) for end, sign in (("lower", 1), ("upper", -1))
                      for axis, n in (zip("xyz", range(3)) if space else [("z", 1)]) if is_wall(domain, axis, end)]
        log_e = math.log(law["restitution"])
        k, c = (math.pi**2 + log_e**2) / self.t_c**2, -2 * log_e / self.t_c  # over m*: Izard et al. 2014, eqs 17 and 18
        kt, ct = law.get("stiffness_ratio", 0.2) * k, law.get("damping_ratio", 1.0) * c
        full = self.m * (1 + 0.5 * scene.get("medium", {}).get("density", 0.0) / grains[0]["density"])  # with a virtual mass
        for m in (full, 1e12 * full):  # YADE joins the springs of both partners one behind the other; a wall's is rigid
            O.materials.append(ViscElMat(kn=m * k, cn=m * c, ks=m * kt, cs=m * ct, density=grains[0]["density"],
                                         frictionAngle=math.atan(law.get("friction", 0.0))))
        for g in grains:
            body = utils.sphere(g["position"], self.r, material=0)
            body.state.vel, body.state.angVel = g.get("velocity", [0.0] * 3), g.get("spin", [0.0] * 3)
            w, x, y, z = g.get("orientation", [1.0, 0, 0, 0])
            body.state.ori = Quaternion(w, x, y, z)
            O.bodies.append(body)
        for axis, sign, place in self.walls:
            O.bodies.append(utils.wall(place, axis=axis, sense=sign, material=1))
        self.begin()

    def begin(self):
        O.engines = [ForceResetter(), InsertionSortCollider([Bo1_Sphere_Aabb(), Bo1_Wall_Aabb()]),
                     InteractionLoop([Ig2_Sphere_Sphere_ScGeom(), Ig2_Wall_Sphere_ScGeom()], [Ip2_ViscElMat_ViscElMat_ViscElPhys()],
                                     [Law2_ScGeom_ViscElPhys_Basic()]), NewtonIntegrator(damping=0.0)]

    def read(self, what):
        return np.array([getattr(O.bodies[i].state, what) for i in range(self.grains)], float)

    def window(self, of, loads):
        """The sub-steps of a window under its loads; returns the kinematics and the smallest gap."""
        O.dt, h, inertia = of.dt / of.substeps, of.dt / of.substeps, 0.4 * self.m * self.r**2
        pull = self.m * self.g + loads[:, :3] + loads[:, 6:7] * self.a
        twist, n, seen, least = loads[:, 3:6] + loads[:, 7:] * self.alpha, self.normal, np.zeros((self.grains, 9)), math.inf
        for i in range(self.grains):  # what moves is the mass with the virtual mass
            state = O.bodies[i].state
            state.mass, state.inertia = self.m + loads[i, 6], [inertia + loads[i, 7]] * 3
            O.forces.setPermF(i, pull[i]), O.forces.setPermT(i, twist[i])
        v = start_v = self.read("vel")
        start_w, flown = self.read("angVel"), True
        for _ in range(of.substeps):
            before = v
            O.step()
            force, v = np.zeros((self.grains, 3)), self.read("vel")
            for contact in O.interactions:
                if contact.isReal:
                    push, least = contact.phys.normalForce + contact.phys.shearForce, min(least, -contact.geom.penetrationDepth)
                    for k, sign in ((contact.id1, -1), (contact.id2, 1)):
                        if k < self.grains:
                            force[k] += sign * np.array(push)
            seen[:, :3] += force / of.substeps
            for i in np.flatnonzero(force.any(axis=1) | n.any(axis=1)):
                flown = False
                if not force[i].any():
                    seen[i, 8], n[i] = v[i] @ n[i], 0.0
                    continue
                if not n[i].any():
                    seen[i, 7] = -(before[i] @ force[i]) / math.hypot(*force[i])
                n[i] = force[i] / math.hypot(*force[i])
        if flown:  # under a constant force a flight is known exactly
            for i in range(self.grains):
                O.bodies[i].state.pos -= Vector3(*(h / 2 * (v[i] - start_v[i])))
        x, w = self.read("pos"), self.read("angVel")
        self.a, self.alpha = (v - start_v) / of.dt, (w - start_w) / of.dt
        q = np.array([[o[3], o[0], o[1], o[2]] for o in (O.bodies[i].state.ori for i in range(self.grains))])
        apart = np.linalg.norm(x[:, None] - x[None], axis=2) + np.where(np.eye(self.grains), math.inf, 0.0)
        walls = [sign * (x[:, axis] - place) - self.r for axis, sign, place in self.walls]
        seen[:, 6] = np.minimum(apart.min(axis=1) - 2 * self.r, np.min(walls, axis=0) if walls else math.inf)
        return np.hstack([x, q, v, w, seen]), min(least, seen[:, 6].min())

    def keep(self):
        pass

    def back(self):
        raise Leave(1, "YADE is not asked to do a window again; remedy: coupling.scheme = \"semi-implicit\"")

    def save(self, folder):
        O.save(f"{folder}/{STATE}")
        super().save(folder)

    def load(self, folder):
        super().load(folder)
        try:
            O.load(f"{folder}/{STATE}")
        except Exception as error:
            raise Leave(2, f"{folder}/{STATE}: {error}; remedy: resume from another checkpoint") from error


try:
    start(Yade)
    code = 0
except SystemExit as end:
    code = end.code
sys.stdout.flush()
os._exit(code or 0)  # YADE's own way out waits for its consoles
