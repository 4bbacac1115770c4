//! Sums over all grains: energy, momentum.

use crate::Vec3;
use crate::contact::{LinearPair, PairLaw};
use crate::step::Dem;

impl Dem {
    /// Kinetic energy of translation and rotation, J (per unit length for discs); dry masses.
    #[must_use]
    pub fn kinetic_energy(&self) -> f64 {
        let g = &self.grains;
        (0..g.len())
            .map(|i| {
                0.5 * (g.mass[i] * g.velocity[i].norm_squared() + g.inertia[i] * g.spin[i].norm_squared())
            })
            .sum()
    }

    /// Energy in the springs of all contacts but those of Wan & Turek, J; not in their rolling.
    #[must_use]
    pub fn elastic_energy(&self) -> f64 {
        let (g, mut energy) = (&self.grains, 0.0);
        for i in 0..g.len() {
            for k in self.lists.pairs.row(i) {
                let j = self.lists.pairs.other[k] as usize;
                let gap = self.scene().periods.nearest(g.position[i] - g.position[j]).norm()
                    - g.radius[i]
                    - g.radius[j];
                let mass = self.response.effective_mass(g, i, j);
                let radius = g.radius[i] * g.radius[j] / (g.radius[i] + g.radius[j]);
                energy += stored(
                    self.scene().laws.between(g.material[i], g.material[j]),
                    (mass, radius),
                    gap,
                    &self.lists.pairs.spring[k],
                );
            }
            for k in self.lists.walls.row(i) {
                let wall = &self.scene().walls[self.lists.walls.other[k] as usize];
                if wall.stands(self.time) {
                    let gap = wall.gap(&g.position[i], g.radius[i], self.time);
                    let law = self.scene().laws.between(g.material[i], wall.material);
                    let size = (self.response.wall_mass(g, i), g.radius[i]);
                    energy += stored(law, size, gap, &self.lists.walls.spring[k]);
                }
            }
        }
        energy
    }

    /// Momentum, kg m/s; dry masses.
    #[must_use]
    pub fn momentum(&self) -> Vec3 {
        let g = &self.grains;
        (0..g.len()).map(|i| g.velocity[i] * g.mass[i]).sum()
    }

    /// Angular momentum about the origin, kg m²/s; dry masses, positions within the period.
    #[must_use]
    pub fn angular_momentum(&self) -> Vec3 {
        let g = &self.grains;
        (0..g.len()).map(|i| g.position[i].cross(&g.velocity[i]) * g.mass[i] + g.spin[i] * g.inertia[i]).sum()
    }
}

/// Energy of one contact; `size` holds m* and R*.
fn stored(law: &PairLaw, (mass, radius): (f64, f64), gap: f64, spring: &Vec3) -> f64 {
    if gap >= 0.0 {
        return 0.0;
    }
    let linear = |law: &LinearPair| 0.5 * mass * law.stiffness * gap * gap;
    let shear = |law: &LinearPair| 0.5 * mass * law.tangential_stiffness * spring.norm_squared();
    match law {
        PairLaw::Linear(law) => linear(law) + shear(law),
        PairLaw::Stiff(law) => linear(&law.at(mass)) + shear(&law.at(mass)),
        PairLaw::Hertz(law) => law.normal_energy(radius, gap) + shear(&law.at(mass, radius, gap)),
        PairLaw::WanTurek(_) => 0.0,
    }
}
