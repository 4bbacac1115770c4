//! The whole stress on a plane by a balance of forces, and the weight that makes a Shields number of it.

use bedload_scene::{Axis, CheckedScene, Grain, Motion, WallKind};

use crate::planes::{Plane, Planes};

fn free_grains(scene: &CheckedScene) -> impl Iterator<Item = &Grain> {
    scene.grains.iter().filter(|grain| grain.motion == Motion::Free)
}

/// Mean over the free grains.
fn mean_of(scene: &CheckedScene, value: impl Fn(&Grain) -> f64) -> f64 {
    free_grains(scene).map(value).sum::<f64>() / free_grains(scene).count().max(1) as f64
}

/// ρ_p − ρ of the free grains, kg/m³.
fn excess_density(scene: &CheckedScene) -> f64 {
    mean_of(scene, |grain| grain.density) - scene.scene.medium.as_ref().map_or(0.0, |medium| medium.density)
}

/// (ρ_p − ρ) g D of the free grains, Pa: what makes a stress a Shields number.
pub(crate) fn weight_per_area(scene: &CheckedScene) -> f64 {
    excess_density(scene)
        * scene.scene.gravity.iter().map(|g| g * g).sum::<f64>().sqrt()
        * mean_of(scene, |grain| 2.0 * grain.radius)
}

/// What makes the whole shear stress on a plane, of fluid and grains together, in steady flow: that of the
/// lid, and the forces on all that is between.
pub(crate) struct StressBalance {
    /// Component across the planes.
    across: usize,
    /// Viscosity, Pa s, and velocity of the lid, m/s; none where it is free of shear.
    lid: Option<(f64, [f64; 3])>,
    /// Force on the mixture along periodic axes, N/m³: where there is fluid alone, and more where there is
    /// solid.
    pub(crate) drive: [f64; 3],
    excess: [f64; 3],
}

impl StressBalance {
    /// Across `planes`.
    pub(crate) fn of(scene: &CheckedScene, planes: Axis) -> Self {
        let domain = &scene.scene.domain;
        let axes = domain.geometry.axes();
        let axis = axes.iter().position(|axis| *axis == planes).unwrap_or(0);
        let medium = scene.scene.medium.as_ref();
        let face =
            domain.boundary(axis).map(|faces| faces.upper).filter(|face| face.kind == WallKind::NoSlip);
        let (mut drive, mut excess) = ([0.0; 3], [0.0; 3]);
        for along in (0..domain.dimensions()).filter(|along| domain.is_periodic(*along)) {
            let c = domain.geometry.component(along);
            let gravity = scene.scene.gravity[c];
            drive[c] = medium.map_or(0.0, |medium| {
                medium.density * (gravity + medium.body_force[c]) - medium.pressure_gradient[c]
            });
            excess[c] = excess_density(scene) * gravity;
        }
        Self {
            across: domain.geometry.component(axis),
            lid: face.zip(medium).map(|(face, medium)| (medium.viscosity, face.velocity)),
            drive,
            excess,
        }
    }

    /// Stress where the solid fraction falls below `fraction` for the last time, Pa.
    pub(crate) fn at_surface(&self, planes: &Planes, fraction: f64) -> Option<f64> {
        let above = planes.above_surface(fraction)?;
        let top = above.last()?;
        let square = (0..3).filter(|c| *c != self.across).map(|c| {
            let lid = self.lid.map_or(0.0, |(viscosity, velocity)| {
                viscosity * (velocity[c] - top.fluid_velocity[c]) / (0.5 * top.width)
            });
            let force = |p: &Plane| p.width * (self.drive[c] + p.solid_fraction * self.excess[c]);
            (lid + above.iter().map(force).sum::<f64>()).powi(2)
        });
        Some(square.sum::<f64>().sqrt())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A bed up to z = 2 in a channel of height 4, whose fluid is at `velocity` on each plane.
    fn planes(velocity: impl Fn(f64) -> f64) -> Planes {
        let plane = |k: usize| {
            let at = 0.25 + 0.5 * k as f64;
            let solid_fraction = if at < 2.0 { 0.5 } else { 0.0 };
            Plane {
                at,
                width: 0.5,
                solid_fraction,
                fluid_velocity: [velocity(at), 0.0, 0.0],
                ..Plane::default()
            }
        };
        Planes { time: 0.0, planes: (0..8).map(plane).collect() }
    }

    #[test]
    fn under_a_lid_the_whole_stress_is_the_lids_wherever_grains_carry_it() {
        // Grains carry so much above z = 2 that the fluid there is sheared at 1 where it is sheared at 3 by
        // the lid.
        let velocity = |z: f64| if z < 3.0 { z } else { 3.0 * (z - 3.0) + 3.0 };
        let balance =
            StressBalance { across: 2, lid: Some((0.7, [6.0, 0.0, 0.0])), drive: [0.0; 3], excess: [0.0; 3] };
        let stress = balance.at_surface(&planes(velocity), 0.3).unwrap();
        assert!((stress - 0.7 * 3.0).abs() < 1e-12, "{stress}");
        assert_eq!(planes(velocity).shear_at_surface(0.3), Some(1.0));
        assert_eq!(balance.at_surface(&planes(velocity), 0.6), None);
    }

    #[test]
    fn under_a_free_surface_the_stress_is_the_weight_along_the_slope() {
        let balance = StressBalance { across: 2, lid: None, drive: [0.4, 0.0, 0.0], excess: [0.6, 0.0, 0.0] };
        // The surface at 0.5 is that of the last plane of the bed; 2 of clear fluid stand above it.
        let stress = balance.at_surface(&planes(|_| 0.0), 0.5).unwrap();
        assert!((stress - 0.4 * 2.0).abs() < 1e-12, "{stress}");
    }
}
