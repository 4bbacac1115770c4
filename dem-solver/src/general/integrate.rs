//! Kick, drift and rotation, and the choice of integrator.

use crate::Vec3;
use crate::grains::{Grains, Response};
use crate::spec::Motion;
use nalgebra::{Quaternion, UnitQuaternion};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Time integration of the sub-step.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Integrator {
    /// v ← v + dt a(x), x ← x + dt v: one force evaluation, first order, no energy drift.
    #[default]
    SymplecticEuler,
    /// Half kick, drift, half kick: second order; one evaluation, and one more per window.
    VelocityVerlet,
    /// Runge–Kutta of third order (Shu & Osher 1988): for smooth problems; three evaluations.
    Rk3,
}

/// What a kick saw.
#[derive(Clone, Copy, Debug)]
pub struct Speed {
    /// Largest square of a speed, m²/s².
    pub largest2: f64,
    /// Whether all velocities and spins are finite.
    pub finite: bool,
}

/// v ← v + h (a + W F), ω ← ω + h (α + J T): gravity, fluid and virtual mass in a, α; `film` are
/// explicit film forces, if there are any.
pub fn kick(
    h: f64,
    grains: &mut Grains,
    response: &Response,
    contact: &[Vec3],
    torque: &[Vec3],
    film: Option<&[Vec3]>,
) -> Speed {
    let n = grains.len();
    let (velocity, spin) = (&mut grains.velocity[..n], &mut grains.spin[..n]);
    let (a, alpha) = (&response.acceleration[..n], &response.spin_acceleration[..n]);
    let (weight, turn) = (&response.inverse_mass[..n], &response.inverse_inertia[..n]);
    let (contact, torque) = (&contact[..n], &torque[..n]);
    let mut speed = Speed { largest2: 0.0, finite: true };
    for i in 0..n {
        let force = film.map_or(contact[i], |film| contact[i] + film[i]);
        velocity[i] += (a[i] + weight[i].component_mul(&force)) * h;
        spin[i] += (alpha[i] + turn[i].component_mul(&torque[i])) * h;
        let speed2 = velocity[i].norm_squared();
        speed.largest2 = speed.largest2.max(speed2);
        speed.finite &= (speed2 + spin[i].norm_squared()).is_finite();
    }
    speed
}

/// x ← x + dt v, and orientations by the exponential map of dt ω. Prescribed motion follows its exact
/// path from `t` to `t + dt`.
pub fn drift(dt: f64, t: f64, grains: &mut Grains, prescribed: &[u32]) {
    for &i in prescribed {
        let (velocity, spin) = grains.motion[i as usize].mean_velocity(t, dt);
        grains.velocity[i as usize] = velocity;
        grains.spin[i as usize] = spin;
    }
    let n = grains.len();
    let (position, orientation) = (&mut grains.position[..n], &mut grains.orientation[..n]);
    let (velocity, spin) = (&grains.velocity[..n], &grains.spin[..n]);
    for i in 0..n {
        position[i] += velocity[i] * dt;
        rotate(&mut orientation[i], &spin[i], dt);
    }
    for &i in prescribed {
        let (velocity, spin) = grains.motion[i as usize].velocity_at(t + dt);
        grains.velocity[i as usize] = velocity;
        grains.spin[i as usize] = spin;
    }
}

/// Grains whose velocity is a function of time.
#[must_use]
pub fn prescribed(grains: &Grains) -> Vec<u32> {
    (0u32..)
        .zip(&grains.motion)
        .filter(|(_, motion)| matches!(motion, Motion::Oscillating { .. }))
        .map(|(i, _)| i)
        .collect()
}

/// q ← exp(dt ω/2) q: exact for a constant spin; unit length is kept to round-off.
#[inline(always)]
pub fn rotate(q: &mut UnitQuaternion<f64>, spin: &Vec3, dt: f64) {
    let half = spin * (0.5 * dt);
    let angle2 = half.norm_squared();
    if angle2 == 0.0 {
        return;
    }
    let (cos, sinc) = if angle2 < 1e-4 {
        // series to 1e-17 of the value: cheaper than sine and cosine at the angles of a sub-step
        let cos = 1.0 - angle2 * (0.5 - angle2 * (1.0 / 24.0 - angle2 * (1.0 / 720.0 - angle2 / 40320.0)));
        let sinc = 1.0
            - angle2 * (1.0 / 6.0 - angle2 * (1.0 / 120.0 - angle2 * (1.0 / 5040.0 - angle2 / 362_880.0)));
        (cos, sinc)
    } else {
        let angle = angle2.sqrt();
        (angle.cos(), angle.sin() / angle)
    };
    let turned = Quaternion::new(cos, half.x * sinc, half.y * sinc, half.z * sinc) * q.quaternion();
    // one Newton step of 1/√|q|² at |q| ≈ 1: keeps the length without a square root
    let scale = 1.5 - 0.5 * turned.norm_squared();
    *q = UnitQuaternion::new_unchecked(turned * scale);
}
