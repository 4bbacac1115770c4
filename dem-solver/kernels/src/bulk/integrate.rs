//! Kick and drift of a block (symplectic Euler): v ← v + dt (a + W F), x ← x + dt v, likewise the spin.

use crate::bulk::records::{ForceTorque, GrainRecord};
use crate::motion::{Motion, Vec3, rotate};
use crate::vector::lanes::Lanes8;
use nalgebra::{Quaternion, UnitQuaternion};

/// What besides contacts acts on a grain over a window. The fourth numbers are zero.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[repr(C, align(64))]
pub(super) struct BodyForce {
    /// Acceleration by gravity, fluid and virtual mass along free axes, m/s²; angular acceleration about
    /// free axes, rad/s².
    pub(super) acceleration: [f64; 8],
    /// 1 along and about free axes.
    pub(super) free: [f64; 8],
}

impl BodyForce {
    /// What acts on a grain, and along and about which axes it is free.
    pub(super) fn new([acceleration, spin_acceleration]: [&Vec3; 2], [free, turns]: [&Vec3; 2]) -> Self {
        let eight = |a: &Vec3, b: &Vec3| [a.x, a.y, a.z, 0.0, b.x, b.y, b.z, 0.0];
        Self { acceleration: eight(acceleration, spin_acceleration), free: eight(free, turns) }
    }
}

/// Squares of the largest speed and spin of a block as bits: order of integers is order of positive
/// numbers, and what is not finite is the largest of all.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Fastest {
    speed2: u64,
    spin2: u64,
}

/// Bits of infinity: larger ones are not finite.
const INFINITE: u64 = f64::INFINITY.to_bits();

impl Fastest {
    /// The largest square of a speed, m²/s²; NaN if a speed or spin is not finite.
    pub(super) fn speed2(&self) -> f64 {
        if self.speed2 >= INFINITE || self.spin2 >= INFINITE { f64::NAN } else { f64::from_bits(self.speed2) }
    }

    /// Takes a grain's motion into account.
    fn note(&mut self, v: &Vec3, w: &Vec3) {
        self.speed2 = self.speed2.max(v.norm_squared().to_bits());
        self.spin2 = self.spin2.max(w.norm_squared().to_bits());
    }
}

/// Moves the grains of a block from `old` to `new` and empties `push`. `drive` holds one entry for all or
/// one per grain.
#[inline(always)]
pub(super) fn advance<L: Lanes8>(
    token: L::Token,
    dt: f64,
    old: &[GrainRecord],
    push: &mut [ForceTorque],
    inverse_inertia: &[f64],
    drive: &[BodyForce],
    new: &mut [GrainRecord],
) -> Fastest {
    let stride = usize::from(drive.len() > 1);
    let zero = L::splat(token, 0.0);
    let (step, three) = (L::splat(token, dt), L::load(token, &[1.0, 1.0, 1.0, 0.0, 1.0, 1.0, 1.0, 0.0]));
    let drift = L::load(token, &[dt, dt, dt, 0.0, 0.0, 0.0, 0.0, 0.0]);
    let mut fastest = zero;
    let grains = old.iter().zip(push).zip(inverse_inertia).zip(new);
    for (i, (((row, push), turning), to)) in grains.enumerate() {
        let drive = &drive[i * stride];
        let GrainRecord { a: [.., vx, vy, vz, weight], b } = row;
        // velocity and spin in one; the fourth of each four is a constant, which free = 0 keeps
        let motion = L::load_halves(token, &[*vx, *vy, *vz, *weight], b);
        let per_force = L::load_halves(token, &[*weight; 4], &[*turning; 4]);
        let prescribed = L::load(token, &drive.acceleration);
        let force = L::load(token, &push.0);
        let gained = (L::load(token, &drive.free) * per_force).times_plus(force, prescribed);
        let motion = gained.times_plus(step, motion);
        zero.store(&mut push.0);
        let place = motion.times_plus(drift, L::load(token, &row.a));
        place.low_halves(motion).store(&mut to.a);
        motion.store_high(&mut to.b);
        let speed = motion * three;
        fastest = fastest.max_bits((speed * speed).sum_halves());
    }
    let mut bits = [0.0; 8];
    fastest.store(&mut bits);
    Fastest { speed2: bits[0].to_bits(), spin2: bits[4].to_bits() }
}

/// Grains that forces do not move: their path is a function of time.
pub(super) fn follow(
    (t, dt): (f64, f64),
    prescribed: &[(u16, Motion)],
    old: &[GrainRecord],
    new: &mut [GrainRecord],
    fastest: &mut Fastest,
) {
    for (i, motion) in prescribed {
        let (row, to) = (&old[*i as usize], &mut new[*i as usize]);
        let (mean, _) = motion.mean_velocity(t, dt);
        let (velocity, spin) = motion.velocity_at(t + dt);
        *to = *row;
        for k in 0..3 {
            to.a[k] = row.a[k] + mean[k] * dt;
            to.a[4 + k] = velocity[k];
            to.b[k] = spin[k];
        }
        fastest.note(&mean, &Vec3::zeros());
        fastest.note(&velocity, &spin);
    }
}

/// Turns the grains by the spins they have now; `prescribed` ones by their mean spin from `t` on.
pub(super) fn turn(
    (t, dt): (f64, f64),
    prescribed: &[(u16, Motion)],
    rows: &[GrainRecord],
    orientation: &mut [[f64; 4]],
) {
    let mut prescribed = prescribed.iter().peekable();
    for (i, (row, q)) in rows.iter().zip(orientation).enumerate() {
        let spin = match prescribed.next_if(|(k, _)| *k as usize == i) {
            Some((_, motion)) => motion.mean_velocity(t, dt).1,
            None => Vec3::from(row.spin()),
        };
        let [w, x, y, z] = *q;
        let mut turned = UnitQuaternion::new_unchecked(Quaternion::new(w, x, y, z));
        rotate(&mut turned, &spin, dt);
        *q = [turned.w, turned.i, turned.j, turned.k];
    }
}
