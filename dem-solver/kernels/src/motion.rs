//! Vectors; who moves a grain, and along which axes; how an orientation turns.

use bedload_over_time::OverTime;
use nalgebra::{Quaternion, UnitQuaternion};

/// Three components in the laboratory frame.
pub type Vec3 = nalgebra::Vector3<f64>;

/// Who moves a grain.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum Motion {
    /// Forces do.
    #[default]
    Free,
    /// Nothing does.
    Fixed,
    /// Velocity and spin are given.
    Prescribed {
        /// Velocity, m/s.
        velocity: OverTime<[f64; 3]>,
        /// Angular velocity about an axis that does not turn, rad/s.
        spin: OverTime<[f64; 3]>,
    },
}

impl Motion {
    /// Velocity and spin at time `t` of a grain that forces do not move.
    #[must_use]
    pub fn velocity_at(&self, t: f64) -> (Vec3, Vec3) {
        let Self::Prescribed { velocity, spin } = self else { return Default::default() };
        (velocity.at(t).into(), spin.at(t).into())
    }

    /// Mean velocity and spin between `t` and `t + dt`: times `dt` they give the exact path.
    #[must_use]
    pub fn mean_velocity(&self, t: f64, dt: f64) -> (Vec3, Vec3) {
        let Self::Prescribed { velocity, spin } = self else { return Default::default() };
        (velocity.mean(t, t + dt).into(), spin.mean(t, t + dt).into())
    }

    /// Whether velocity or spin change over time.
    #[must_use]
    pub fn varies(&self) -> bool {
        matches!(self, Self::Prescribed { velocity, spin } if velocity.varies() || spin.varies())
    }

    /// All its numbers.
    pub(crate) fn values(&self) -> Vec<f64> {
        let Self::Prescribed { velocity, spin } = self else { return Vec::new() };
        velocity.extremes().chain(spin.extremes()).flatten().collect()
    }
}

/// Which motions of a free grain are left to the forces, in the laboratory frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Freedom {
    /// Translation along x, y, z.
    pub translation: [bool; 3],
    /// Rotation about x, y, z.
    pub rotation: [bool; 3],
}

impl Freedom {
    /// All six.
    pub const SPACE: Self = Self { translation: [true; 3], rotation: [true; 3] };
    /// Plane scenes (x, z): y locked, rotation about y only.
    pub const PLANE: Self = Self { translation: [true, false, true], rotation: [false, true, false] };
    /// Axisymmetric scenes: along z only.
    pub const AXIS: Self = Self { translation: [false, false, true], rotation: [false; 3] };

    /// 1 along free axes.
    #[must_use]
    pub fn translation(&self) -> Vec3 {
        self.translation.map(|free| f64::from(u8::from(free))).into()
    }

    /// 1 about free axes.
    #[must_use]
    pub fn rotation(&self) -> Vec3 {
        self.rotation.map(|free| f64::from(u8::from(free))).into()
    }
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
