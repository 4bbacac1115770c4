//! Infinite planes, which may move, turn, follow a pressure, and vanish (a gate).

use crate::error::SpecError;
use crate::motion::Vec3;
use bedload_over_time::OverTime;

/// A plane. It bounds the half space that `normal` points into.
#[derive(Clone, Debug, PartialEq)]
pub struct Wall {
    /// A point of the plane at time zero, m.
    pub point: [f64; 3],
    /// Normal towards the grains at time zero; any length but zero.
    pub normal: [f64; 3],
    /// Velocity, m/s: the normal part moves the plane, the tangential part drags grains along.
    pub velocity: OverTime<[f64; 3]>,
    /// Angular velocity about an axis that keeps its direction, rad/s: the plane turns, and its surface with
    /// it.
    pub spin: OverTime<[f64; 3]>,
    /// A point of the axis at time zero, m, which moves with `velocity`; `point` if absent.
    pub about: Option<[f64; 3]>,
    /// What it follows along its normal, if anything.
    pub servo: Option<Servo>,
    /// Time from which the wall is there, s; it moves from time zero on all the same, a servo from this time.
    pub from: f64,
    /// Time at which the wall vanishes, s; never if absent.
    pub until: Option<f64>,
}

/// A wall that comes to a pressure of the grains: m dV/dt = p A (1 − V/V_max) − F, |V| ≤ V_max, along its
/// normal, F the normal force of contacts on it. docs/equations.md
#[derive(Clone, Debug, PartialEq)]
pub struct Servo {
    /// p, Pa (discs: N/m per unit length).
    pub pressure: OverTime<f64>,
    /// A, m² (discs: m).
    pub area: f64,
    /// V_max, m/s.
    pub largest_speed: f64,
    /// m, kg (discs: per unit length).
    pub mass: f64,
}

impl Wall {
    /// A wall at rest that stays.
    #[must_use]
    pub fn new(point: [f64; 3], normal: [f64; 3]) -> Self {
        let (velocity, spin) = (OverTime::default(), OverTime::default());
        Self { point, normal, velocity, spin, about: None, servo: None, from: 0.0, until: None }
    }

    /// Checks values and directions; a wall may not cut a periodic direction obliquely, now or when it has
    /// turned.
    pub fn validate(&self, wall: usize, periodic: [bool; 3]) -> Result<(), SpecError> {
        let bad = |quantity, value, allowed| Err(SpecError::Wall { wall, quantity, value, allowed });
        let velocities = self.velocity.extremes().map(|velocity| ("velocity", velocity));
        let spins = self.spin.extremes().map(|spin| ("spin", spin));
        let points = [("point", self.point), ("normal", self.normal), ("about", self.axis_point())];
        for (quantity, vector) in points.into_iter().chain(velocities).chain(spins) {
            if let Some(value) = vector.into_iter().find(|c| !c.is_finite()) {
                return bad(quantity, value, "finite");
            }
        }
        let length = Vec3::from(self.normal).norm();
        if !(length > 0.0 && length.is_finite()) {
            return bad("length of the normal", length, "positive and finite");
        }
        let across = periodic.into_iter().zip(self.normal).find(|(periodic, n)| *periodic && *n != 0.0);
        if let Some((_, value)) = across {
            return bad("component of the normal along a periodic axis", value, "zero");
        }
        if !self.spin.is_along_one_line() {
            return bad("spin", self.spin.largest(f64::INFINITY), "about an axis that keeps its direction");
        }
        let turned = Vec3::from(self.spin.longest(f64::INFINITY));
        let tilts = |c: usize| turned[(c + 1) % 3] != 0.0 || turned[(c + 2) % 3] != 0.0;
        if (0..3).any(|c| periodic[c] && tilts(c)) {
            return bad("spin", turned.norm(), "along every periodic axis");
        }
        if let Some(servo) = &self.servo {
            let Servo { area, largest_speed, mass, pressure } = servo;
            let positive = [("area", area), ("largest speed", largest_speed), ("mass", mass)];
            if let Some((quantity, value)) = positive.into_iter().find(|(_, v)| !(**v > 0.0 && v.is_finite()))
            {
                return bad(quantity, *value, "positive and finite");
            }
            if let Some(value) = pressure.extremes().find(|p| !(*p >= 0.0 && p.is_finite())) {
                return bad("pressure", value, "zero or positive, and finite");
            }
            if turned.cross(&Vec3::from(self.normal)).norm() > 1e-12 * length * turned.norm() {
                return bad("spin", turned.norm(), "along the normal of a wall with a servo");
            }
        }
        if self.from.is_nan() {
            return bad("from", self.from, "a time");
        }
        match self.until {
            Some(time) if time.is_nan() => bad("until", time, "a time"),
            _ => Ok(()),
        }
    }

    fn axis_point(&self) -> [f64; 3] {
        self.about.unwrap_or(self.point)
    }
}

/// A wall as the loops use it.
#[derive(Clone, Debug)]
pub struct Plane {
    /// Point at time zero, m.
    pub point: Vec3,
    /// Unit normal towards the grains at time zero.
    pub normal: Vec3,
    /// Velocity, m/s; without that of a servo.
    pub velocity: OverTime<[f64; 3]>,
    /// Its part along the normal, m/s.
    pub along: OverTime<f64>,
    /// Angular velocity, rad/s, and a point of the axis at time zero, m; none where it does not turn.
    pub turns: Option<Box<(OverTime<[f64; 3]>, Vec3)>>,
    /// What it follows along its normal, and where that has brought it.
    pub servo: Option<Box<Follower>>,
    /// Time of appearing, s.
    pub from: f64,
    /// Time of vanishing, s; infinite if it stays.
    pub until: f64,
}

/// A wall at an instant.
#[derive(Clone, Copy, Debug)]
pub struct Stand {
    /// A point of the plane but for `moved`, m.
    point: Vec3,
    /// Unit normal towards the grains.
    pub normal: Vec3,
    /// Way of the plane along its normal, m.
    moved: f64,
    /// Velocity at the axis, m/s.
    velocity: Vec3,
    /// Angular velocity, rad/s.
    pub spin: Vec3,
    /// A point of the axis, m.
    about: Vec3,
}

impl Stand {
    /// Gap between the plane and a grain, m.
    #[inline(always)]
    #[must_use]
    pub fn gap(&self, position: &Vec3, radius: f64) -> f64 {
        (position - self.point).dot(&self.normal) - self.moved - radius
    }

    /// Velocity of the surface at `x`, m/s.
    #[inline(always)]
    #[must_use]
    pub fn velocity_at(&self, x: &Vec3) -> Vec3 {
        self.velocity + self.spin.cross(&(x - self.about))
    }
}

/// A servo and its state.
#[derive(Clone, Debug)]
pub struct Follower {
    servo: Servo,
    /// Way along the normal at time `since`, m.
    pub way: f64,
    /// Speed from then on, m/s.
    pub speed: f64,
    /// Time, s.
    pub since: f64,
    /// Sum over the sub-steps of the window of the force on the wall, N, and their number.
    pub window: (Vec3, f64),
}

impl From<&Wall> for Plane {
    fn from(wall: &Wall) -> Self {
        let normal = Vec3::from(wall.normal).normalize();
        let follower = |servo: &Servo| {
            let (servo, window) = (servo.clone(), Default::default());
            Box::new(Follower { servo, way: 0.0, speed: 0.0, since: 0.0, window })
        };
        Self {
            point: wall.point.into(),
            normal,
            velocity: wall.velocity.clone(),
            along: wall.velocity.map(|velocity| Vec3::from(*velocity).dot(&normal)),
            turns: (!wall.spin.is_zero()).then(|| Box::new((wall.spin.clone(), wall.axis_point().into()))),
            servo: wall.servo.as_ref().map(follower),
            from: wall.from,
            until: wall.until.unwrap_or(f64::INFINITY),
        }
    }
}

impl Plane {
    /// The plane at time `t`.
    #[inline(always)]
    #[must_use]
    pub fn at(&self, t: f64) -> Stand {
        let (velocity, zero) = (self.velocity_at(t), Vec3::zeros());
        match &self.turns {
            None => {
                let (point, normal, moved) = (self.point, self.normal, self.moved(t));
                Stand { point, normal, moved, velocity, spin: zero, about: zero }
            }
            Some(turns) => self.turned(&turns.0, &turns.1, velocity, t),
        }
    }

    #[cold]
    fn turned(&self, spin: &OverTime<[f64; 3]>, about: &Vec3, velocity: Vec3, t: f64) -> Stand {
        let turn = |v: Vec3| Vec3::from(spin.turn(&v.into(), t));
        let now = about + Vec3::from(self.velocity.integral(t));
        // A servo turns about its normal alone.
        let moved = self.servo.as_ref().map_or(0.0, |follower| follower.way_at(t));
        let point = now + turn(self.point - about);
        Stand { point, normal: turn(self.normal), moved, velocity, spin: spin.at(t).into(), about: now }
    }

    /// Gap between the plane and a grain at time `t`, m.
    #[inline(always)]
    #[must_use]
    pub fn gap(&self, position: &Vec3, radius: f64, t: f64) -> f64 {
        self.at(t).gap(position, radius)
    }

    /// Way of the plane along its normal up to time `t`, m, where it does not turn.
    #[inline(always)]
    #[must_use]
    pub fn moved(&self, t: f64) -> f64 {
        let along = match &self.along {
            OverTime::Constant(speed) => speed * t,
            varies => varies.integral(t),
        };
        if let Some(follower) = &self.servo { along + follower.way_at(t) } else { along }
    }

    /// Velocity at time `t`, m/s; where it turns that of the axis.
    #[inline(always)]
    #[must_use]
    pub fn velocity_at(&self, t: f64) -> Vec3 {
        let velocity = Vec3::from(self.velocity.at(t));
        if let Some(push) = self.push() { velocity + push } else { velocity }
    }

    /// Velocity that a servo adds, m/s.
    pub(crate) fn push(&self) -> Option<Vec3> {
        self.servo.as_ref().map(|follower| self.normal * follower.speed)
    }

    /// A servo takes the force of contacts on the wall at time `t`, N, as that of the next `dt`.
    pub(crate) fn follow(&mut self, force: Vec3, t: f64, dt: f64) {
        let (acts, normal) = (self.acts(t), self.normal);
        let Some(follower) = &mut self.servo else { return };
        follower.way = follower.way_at(t);
        follower.since = t;
        follower.window.0 += force;
        follower.window.1 += 1.0;
        let Servo { pressure, area, largest_speed, mass } = &follower.servo;
        let load = pressure.mean(t, t + dt) * area;
        let gained = follower.speed + dt / mass * (load + force.dot(&normal));
        let speed = gained / (1.0 + dt / mass * load / largest_speed);
        follower.speed = if acts { speed.clamp(-largest_speed, *largest_speed) } else { 0.0 };
    }

    /// Largest speed along the normal, m/s, where it does not turn.
    #[must_use]
    pub fn approach(&self) -> f64 {
        let servo = self.servo.as_ref().map_or(0.0, |follower| follower.servo.largest_speed);
        self.along.largest(f64::INFINITY) + servo
    }

    /// Whether grains feel the wall at time `t`.
    #[inline(always)]
    #[must_use]
    pub fn acts(&self, t: f64) -> bool {
        self.from <= t && self.stands(t)
    }

    /// Whether the wall is not gone at time `t`: lists hold it also before it acts.
    #[inline(always)]
    #[must_use]
    pub fn stands(&self, t: f64) -> bool {
        t < self.until
    }
}

impl Follower {
    /// Way along the normal at time `t`, m.
    #[inline(always)]
    #[must_use]
    pub fn way_at(&self, t: f64) -> f64 {
        self.way + self.speed * (t - self.since)
    }

    /// Mean force of contacts over the window, per area, Pa.
    #[must_use]
    pub fn stress(&self) -> Vec3 {
        self.window.0 / (self.window.1.max(1.0) * self.servo.area)
    }
}
