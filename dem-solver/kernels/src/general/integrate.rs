//! Kick and drift.

use crate::grains::{Grains, Response};
use crate::laws::walls::Plane;
use crate::motion::{Motion, Vec3, rotate};

/// A grain that forces do not move, and the wall with a servo that it goes with.
#[derive(Clone, Copy, Debug)]
pub(super) struct Led {
    pub(super) grain: u32,
    pub(super) wall: Option<u32>,
}

impl Led {
    /// Sets velocity and spin: those `of` its motion, and what the wall adds.
    pub(super) fn set(&self, grains: &mut Grains, walls: &[Plane], of: impl Fn(&Motion) -> (Vec3, Vec3)) {
        let i = self.grain as usize;
        let (velocity, spin) = of(&grains.motion[i]);
        let push = self.wall.and_then(|wall| walls[wall as usize].push()).unwrap_or_default();
        (grains.velocity[i], grains.spin[i]) = (velocity + push, spin);
    }
}

/// What a kick saw.
#[derive(Clone, Copy, Debug)]
pub(super) struct Speed {
    /// Largest square of a speed, m²/s².
    pub(super) largest2: f64,
    /// Whether all velocities and spins are finite.
    pub(super) finite: bool,
}

impl Speed {
    /// Of the present velocities.
    pub(super) fn of(grains: &Grains) -> Self {
        let mut speed = Self { largest2: 0.0, finite: true };
        grains.velocity.iter().zip(&grains.spin).for_each(|(velocity, spin)| speed.note(velocity, spin));
        speed
    }

    #[inline(always)]
    fn note(&mut self, velocity: &Vec3, spin: &Vec3) {
        let speed2 = velocity.norm_squared();
        self.largest2 = self.largest2.max(speed2);
        self.finite &= (speed2 + spin.norm_squared()).is_finite();
    }
}

/// v ← v + h (a + W F), ω ← ω + h (α + J T): gravity, fluid and virtual mass in a, α.
pub(super) fn kick(
    h: f64,
    (velocity, spin): (&mut [Vec3], &mut [Vec3]),
    response: &Response,
    contact: &[Vec3],
    torque: &[Vec3],
) -> Speed {
    let n = velocity.len();
    let (velocity, spin) = (&mut velocity[..n], &mut spin[..n]);
    let (a, alpha) = (&response.acceleration[..n], &response.spin_acceleration[..n]);
    let (weight, turn) = (&response.inverse_mass[..n], &response.inverse_inertia[..n]);
    let (contact, torque) = (&contact[..n], &torque[..n]);
    let mut speed = Speed { largest2: 0.0, finite: true };
    for i in 0..n {
        velocity[i] += (a[i] + weight[i].component_mul(&contact[i])) * h;
        spin[i] += (alpha[i] + turn[i].component_mul(&torque[i])) * h;
        speed.note(&velocity[i], &spin[i]);
    }
    speed
}

/// x ← x + dt v, and orientations by the exponential map of dt ω. Prescribed motion follows its exact
/// path from `t` to `t + dt`.
pub(super) fn drift(dt: f64, t: f64, grains: &mut Grains, (prescribed, walls): (&[Led], &[Plane])) {
    for led in prescribed {
        led.set(grains, walls, |motion| motion.mean_velocity(t, dt));
    }
    let n = grains.len();
    let (position, orientation) = (&mut grains.position[..n], &mut grains.orientation[..n]);
    let (velocity, spin) = (&grains.velocity[..n], &grains.spin[..n]);
    for i in 0..n {
        position[i] += velocity[i] * dt;
        rotate(&mut orientation[i], &spin[i], dt);
    }
}
