//! Kick and drift of a block (symplectic Euler): v ← v + dt (a + W F), x ← x + dt v, likewise the spin.

use super::row::{Push, Row};
use crate::Vec3;
use crate::integrate::rotate;
use crate::spec::Motion;
use nalgebra::{Quaternion, UnitQuaternion};

/// What besides contacts acts on a grain over a window. The fourth numbers are zero.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[repr(C, align(32))]
pub(super) struct Drive {
    /// Acceleration by gravity, fluid and virtual mass along free axes, m/s².
    pub(super) acceleration: [f64; 4],
    /// Angular acceleration about free axes, rad/s².
    pub(super) spin_acceleration: [f64; 4],
    /// 1 along free axes.
    pub(super) free: [f64; 4],
    /// 1 about free axes.
    pub(super) turns: [f64; 4],
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
    #[inline(always)]
    pub(super) fn note(&mut self, v: &[f64; 4], w: &[f64; 4]) {
        let speed2 = v[0] * v[0] + v[1] * v[1] + v[2] * v[2];
        let spin2 = w[0] * w[0] + w[1] * w[1] + w[2] * w[2];
        self.speed2 = self.speed2.max(speed2.to_bits());
        self.spin2 = self.spin2.max(spin2.to_bits());
    }
}

/// Moves the grains of a block from `old` to `new`. `drive` holds one entry for all or one per grain.
#[inline(always)]
pub(super) fn advance(
    dt: f64,
    old: &[Row],
    push: &[Push],
    inverse_inertia: &[f64],
    drive: &[Drive],
    new: &mut [Row],
) -> Fastest {
    let n = inverse_inertia.len();
    let stride = usize::from(drive.len() > 1);
    let (old, new, push) = (&old[..n], &mut new[..n], &push[..n]);
    let drift = [dt, dt, dt, 0.0];
    let mut fastest = Fastest::default();
    for i in 0..n {
        let (row, Push(p), drive) = (&old[i], &push[i], &drive[i * stride]);
        let (weight, turning) = (row.a[7], inverse_inertia[i]);
        let (mut x, mut v, mut w) = ([0.0; 4], [0.0; 4], [0.0; 4]);
        for k in 0..4 {
            v[k] = row.a[4 + k] + (drive.acceleration[k] + drive.free[k] * weight * p[k]) * dt;
            w[k] = row.b[k] + (drive.spin_acceleration[k] + drive.turns[k] * turning * p[4 + k]) * dt;
        }
        for k in 0..4 {
            x[k] = row.a[k] + v[k] * drift[k];
        }
        fastest.note(&v, &w);
        let to = &mut new[i];
        to.a[..4].copy_from_slice(&x);
        to.a[4..].copy_from_slice(&v);
        to.b = w;
    }
    fastest
}

/// Grains that forces do not move: their path is a function of time.
pub(super) fn follow(
    (t, dt): (f64, f64),
    given: &[(u16, Motion)],
    old: &[Row],
    new: &mut [Row],
    fastest: &mut Fastest,
) {
    for (i, motion) in given {
        let (row, to) = (&old[*i as usize], &mut new[*i as usize]);
        let (mean, _) = motion.mean_velocity(t, dt);
        let (velocity, spin) = motion.velocity_at(t + dt);
        *to = *row;
        for k in 0..3 {
            to.a[k] = row.a[k] + mean[k] * dt;
            to.a[4 + k] = velocity[k];
            to.b[k] = spin[k];
        }
        fastest.note(&[mean.x, mean.y, mean.z, 0.0], &[0.0; 4]);
        fastest.note(&[velocity.x, velocity.y, velocity.z, 0.0], &[spin.x, spin.y, spin.z, 0.0]);
    }
}

/// Turns the grains by the spins they have now; `given` ones by their mean spin from `t` on.
pub(super) fn turn((t, dt): (f64, f64), given: &[(u16, Motion)], rows: &[Row], orientation: &mut [[f64; 4]]) {
    let mut given = given.iter().peekable();
    for (i, (row, q)) in rows.iter().zip(orientation).enumerate() {
        let spin = match given.next_if(|(k, _)| *k as usize == i) {
            Some((_, motion)) => motion.mean_velocity(t, dt).1,
            None => Vec3::from(row.spin()),
        };
        let [w, x, y, z] = *q;
        let mut turned = UnitQuaternion::new_unchecked(Quaternion::new(w, x, y, z));
        rotate(&mut turned, &spin, dt);
        *q = [turned.w, turned.i, turned.j, turned.k];
    }
}
