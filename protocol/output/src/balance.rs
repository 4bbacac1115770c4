//! The whole stress on a plane by a balance of forces, and the weight that makes a Shields number of it.

use bedload_scene::{Axis, CheckedScene, Grain, Medium, Motion, OverTime, WallKind};

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

/// (ρ_p − ρ) g D of the free grains with the largest gravity of the run, Pa: what makes a stress a Shields
/// number. D of a body is that of the round one of its volume.
pub(crate) fn weight_per_area(scene: &CheckedScene) -> f64 {
    excess_density(scene) * scene.scene.largest_gravity() * mean_of(scene, Grain::equivalent_diameter)
}

/// What makes the whole shear stress on a plane, of fluid and grains together, in steady flow: that of the
/// lid, and the forces on all that is between. What the scene changes over time is that of the time asked
/// for; under a mean its mean over the same samples.
#[derive(Clone, Debug)]
pub(crate) struct StressBalance {
    /// Component across the planes.
    across: usize,
    /// Which components lie along periodic axes.
    periodic: [bool; 3],
    /// Viscosity, Pa s, and velocity of the lid, m/s; none where it is free of shear.
    lid: Option<(f64, OverTime<[f64; 3]>)>,
    /// Density of the fluid, and that of the grains less this one, kg/m³.
    density: f64,
    excess: f64,
    /// Gravity and body force, m/s², and the pressure gradient, Pa/m.
    gravity: OverTime<[f64; 3]>,
    body_force: OverTime<[f64; 3]>,
    pressure_gradient: OverTime<[f64; 3]>,
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
        let mut periodic = [false; 3];
        for along in (0..domain.dimensions()).filter(|along| domain.is_periodic(*along)) {
            periodic[domain.geometry.component(along)] = true;
        }
        let of = |value: fn(&Medium) -> &OverTime<[f64; 3]>| medium.map(value).cloned().unwrap_or_default();
        Self {
            across: domain.geometry.component(axis),
            periodic,
            lid: face.zip(medium).map(|(face, medium)| (medium.viscosity, face.velocity.clone())),
            density: medium.map_or(0.0, |medium| medium.density),
            excess: excess_density(scene),
            gravity: scene.scene.gravity.clone(),
            body_force: of(|medium| &medium.body_force),
            pressure_gradient: of(|medium| &medium.pressure_gradient),
        }
    }

    /// Force on the mixture along periodic axes at time `t` where there is fluid alone, and how much more
    /// where there is solid, N/m³.
    pub(crate) fn drive(&self, t: f64) -> [[f64; 3]; 2] {
        let [gravity, body_force, gradient] =
            [&self.gravity, &self.body_force, &self.pressure_gradient].map(|value| value.at(t));
        let along = |c: usize, force: f64| if self.periodic[c] { force } else { 0.0 };
        let fluid = |c: usize| along(c, self.density * (gravity[c] + body_force[c]) - gradient[c]);
        let solid = |c: usize| along(c, self.excess * gravity[c]);
        [std::array::from_fn(fluid), std::array::from_fn(solid)]
    }

    /// Stress where the solid fraction falls below `fraction` for the last time, Pa.
    pub(crate) fn at_surface(&self, planes: &Planes, fraction: f64) -> Option<f64> {
        let above = planes.above_surface(fraction)?;
        let top = above.last()?;
        let mean = |of: &dyn Fn(f64) -> [f64; 3]| {
            planes.times.iter().fold([0.0; 3], |sum, (t, part)| {
                let here = of(*t);
                std::array::from_fn(|c| sum[c] + part * here[c])
            })
        };
        let [fluid, solid] = [0, 1].map(|phase| mean(&|t| self.drive(t)[phase]));
        let lid = self.lid.as_ref().map(|(viscosity, velocity)| (viscosity, mean(&|t| velocity.at(t))));
        let square = (0..3).filter(|c| *c != self.across).map(|c| {
            let lid = lid.map_or(0.0, |(viscosity, velocity)| {
                viscosity * (velocity[c] - top.fluid_velocity[c]) / (0.5 * top.width)
            });
            let force = |p: &Plane| p.width * (fluid[c] + p.solid_fraction * solid[c]);
            (lid + above.iter().map(force).sum::<f64>()).powi(2)
        });
        Some(square.sum::<f64>().sqrt())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use bedload_scene::Sine;

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
        Planes { times: vec![(0.0, 1.0)], planes: (0..8).map(plane).collect() }
    }

    /// Under gravity in a fluid of density 1, without a lid.
    fn of(gravity: [f64; 3], excess: f64) -> StressBalance {
        let still = || OverTime::Constant([0.0; 3]);
        StressBalance {
            across: 2,
            periodic: [true, true, false],
            lid: None,
            density: 1.0,
            excess,
            gravity: OverTime::Constant(gravity),
            body_force: still(),
            pressure_gradient: still(),
        }
    }

    #[test]
    fn under_a_lid_the_whole_stress_is_the_lids_wherever_grains_carry_it() {
        // Grains carry so much above z = 2 that the fluid there is sheared at 1 where it is sheared at 3 by
        // the lid.
        let velocity = |z: f64| if z < 3.0 { z } else { 3.0 * (z - 3.0) + 3.0 };
        let lid = Some((0.7, OverTime::table(vec![(0.0, [6.0, 0.0, 0.0]), (1.0, [9.0, 0.0, 0.0])])));
        let balance = StressBalance { lid, ..of([0.0; 3], 0.0) };
        let stress = balance.at_surface(&planes(velocity), 0.3).unwrap();
        assert!((stress - 0.7 * 3.0).abs() < 1e-12, "{stress}");
        assert_eq!(planes(velocity).shear_at_surface(0.3), Some(1.0));
        assert_eq!(balance.at_surface(&planes(velocity), 0.6), None);
    }

    /// A lid that swings about 6 m/s over a flow that is held: the mean over a period is that of 6 m/s.
    #[test]
    fn under_a_lid_that_swings_the_mean_stress_is_that_of_its_mean() {
        let swing = Sine { amplitude: [5.0, 0.0, 0.0], frequency: 1.0, phase: 0.3, offset: [6.0, 0.0, 0.0] };
        let balance = StressBalance { lid: Some((0.7, OverTime::sine(swing))), ..of([0.0; 3], 0.0) };
        let velocity = |z: f64| if z < 3.0 { z } else { 3.0 * (z - 3.0) + 3.0 };
        let sample = |k: usize| Planes { times: vec![(0.125 * k as f64, 1.0)], ..planes(velocity) };
        let samples: Vec<Planes> = (0..=8).map(sample).collect();
        let stress = balance.at_surface(&Planes::mean(&samples, 0.0).unwrap(), 0.3).unwrap();
        assert!((stress - 0.7 * 3.0).abs() < 1e-12, "{stress}");
        assert!(balance.at_surface(&samples[8], 0.3).unwrap() > 1.2 * stress);
    }

    #[test]
    fn under_a_free_surface_the_stress_is_the_weight_along_the_slope() {
        let balance = of([0.4, 0.0, 0.0], 1.5);
        // The surface at 0.5 is that of the last plane of the bed; 2 of clear fluid stand above it.
        let stress = balance.at_surface(&planes(|_| 0.0), 0.5).unwrap();
        assert!((stress - 0.4 * 2.0).abs() < 1e-12, "{stress}");
    }
}
