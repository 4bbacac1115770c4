"""A DEM in Python: spheres with soft contacts, friction and a film. How it takes part in a run: bedload.solver."""
import math
import numpy as np
from bedload.solver import LAW, Dem, Leave, start


class Spheres(Dem):
    state = (*Dem.state, "springs")

    def __init__(self, scene):
        grains, domain, dem = scene.get("grains", []), scene["domain"], scene.get("dem", {})
        law, film = dem.get("contact", {}), dem.get("lubrication", {})
        known = grains and all((g.get("shape", "sphere"), g.get("motion", "free")) == ("sphere", "free") for g in grains)
        if not (known and (law.get("law"), law.get("form")) == LAW and "contact_time" in law and "groups" not in scene
                and film.get("form") in ("none", "as-printed", "complement") and "periodic" not in str(domain)
                and (film["form"] != "complement" or not film.get("tangential", domain["geometry"] != "axisymmetric"))):
            raise Leave(2, "not for this DEM; remedy: free spheres in [[grains]], a box without periodic sides, [dem.contact] "
                           "linear-spring-dashpot with form = \"izard-2014\" and contact_time, a form of dem.lubrication, and if that is complement, "
                           "outside axisymmetric scenes, dem.lubrication.tangential = false")
        super().__init__(scene)
        self.film, self.springs = film, {}
        log_e = math.log(law["restitution"])
        self.k, self.c = (math.pi**2 + log_e**2) / self.t_c**2, -2 * log_e / self.t_c  # over m*: Izard et al. 2014, eqs 17, 18
        self.reach = film.get("cut_off", 0.5) if film["form"] != "none" else 0.0  # of the film, over the radius
        self.length = film.get("resolved_length", (domain["upper"][-1] - domain["lower"][-1]) / domain["cells"][-1])
        self.viscous = 6 * math.pi * scene["medium"]["viscosity"] if self.reach else 0.0

    def squeezed(self, u, gap, rate, h, radius):
        """u after h in the film: u' + rate (P(gap + h u') − P(gap)) = u, P the integral of its law over 0 ≤ gap ≤ reach."""
        rough, reach, form = self.film["roughness"] * radius, self.reach * radius, self.film["form"]
        def law(gap):
            gap = min(max(gap, 0.0), reach)
            x = (gap + rough) / self.length
            rest = {"as-printed": 0.0, "complement": math.log(1 + 2 * x + 2 * x * x) / 2 + math.atan(1 + 2 * x)}
            return math.log(x) - rest[form]
        low, high = min(u, 0.0), max(u, 0.0)
        for _ in range(60):
            middle = (low + high) / 2
            low, high = (middle, high) if middle + rate * (law(gap + h * middle) - law(gap)) < u else (low, middle)
        return high

    def window(self, of, loads):
        """The sub-steps of a window under its loads; returns the kinematics and the smallest gap."""
        h, signs, x, v, w = of.dt / of.substeps, (1, -1), self.x, self.v, self.w
        light, turns = 1 / (self.m + loads[:, 6]), 1 / (self.inertia + loads[:, 7])  # with the virtual mass
        pull = self.m[:, None] * self.g + loads[:, :3] + loads[:, 6:7] * self.a
        twist = loads[:, 3:6] + loads[:, 7:] * self.alpha
        start, seen, least = (v.copy(), w.copy()), np.zeros((len(x), 9)), math.inf  # seen: Kinematics from byte 104 on
        for _ in range(of.substeps):
            force, torque, touching = pull.copy(), twist.copy(), {}
            films = []
            for who, name, n, gap in self.gaps(max(self.reach * self.r.max(), 1e-300)):
                mass, arms, radius = 1 / light[who].sum(), self.r[who] + gap / 2, 1 / (1 / self.r[who]).sum()
                if self.viscous:
                    films.append((who, n, gap, mass, radius))
                if gap >= 0:
                    continue
                u = sum(sign * v[k] for sign, k in zip(signs, who)) - np.cross(arms @ w[who], n)
                un, slide, part, dash = u @ n, u - (u @ n) * n, 1.0, 1.0
                if name not in self.springs:  # it touches for a part of its first sub-step
                    part, seen[who, 7] = min(1.0, gap / (un * h)) if un < 0 else 1.0, -un
                    dash = part + 0.5
                k, c, mu = mass * self.k, mass * dash * self.c, self.law.get("friction", 0.0)
                normal, kt, ct = max(0.0, -k * gap - c * un), k * self.law.get("stiffness_ratio", 0.2), c * self.law.get("damping_ratio", 1.0)
                spring = np.array(self.springs.get(name, [[0.0] * 3])[0])
                spring += slide * h * part - (spring @ n) * n
                drag = -kt * spring - ct * slide
                if (size := math.hypot(*drag)) > mu * normal:
                    drag *= mu * normal / size
                    spring = -(drag + ct * slide) / kt
                push, least, touching[name] = normal * n + drag, min(least, gap), [spring.tolist(), n.tolist(), [int(k) for k in who], bool(normal > 0)]
                for sign, arm, k in zip(signs, arms, who):
                    force[k] += sign * push
                    torque[k] -= arm * np.cross(n, push)
                    seen[k, :3] += sign * push / of.substeps
            for name, (_, n, who, bears) in self.springs.items():  # a contact ends with its force, before its overlap
                if bears and not (name in touching and touching[name][-1]):
                    seen[who, 8] = sum(sign * v[k] for sign, k in zip(signs, who)) @ n
            self.springs = touching
            x += (v if not touching and not films else 0.0) * h / 2  # a flight is exact under a constant force
            v += h * light[:, None] * force
            for who, n, gap, mass, radius in films:
                u = sum(sign * v[k] for sign, k in zip(signs, who)) @ n
                push = mass * (self.squeezed(u, gap, self.viscous * radius**2 / mass, h, radius * len(who)) - u) * n
                for sign, k in zip(signs, who):
                    v[k] += sign * light[k] * push
                    seen[k, 3:6] += sign * push / of.dt
            w += h * turns[:, None] * torque
            x += h * v / (1 if touching or films else 2)
            self.turn(h)
        self.a, self.alpha, seen[:, 6] = (v - start[0]) / of.dt, (w - start[1]) / of.dt, math.inf
        for who, _, _, gap in self.gaps(math.inf):
            seen[who, 6] = np.minimum(seen[who, 6], gap)
        return np.hstack([x, self.q, v, w, seen]), min(least, seen[:, 6].min())

    def facts(self):
        return {**super().facts(), "interaction_range": self.reach * self.r.max()}


start(Spheres)
