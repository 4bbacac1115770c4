//! Sums over all grains: energy.

use crate::grains::Response;
use crate::motion::Vec3;
use crate::solver::Dem;
use crate::state::SavedContact;

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

    /// Energy in the springs of all contacts that bear a force, J, but for those of Wan & Turek; not in their
    /// rolling. An overlap whose force is clipped at zero has none left, and one that no sub-step has met yet
    /// none so far. A tangential spring counts as far as friction can hold it.
    #[must_use]
    pub fn elastic_energy(&self) -> f64 {
        self.spring_energy().0
    }

    /// [`Self::elastic_energy`], and what is in tangential springs beyond it: the counterpart of the dashpots
    /// of contacts that slide.
    pub(crate) fn spring_energy(&self) -> (f64, f64) {
        let g = &self.grains;
        let (pairs, walls) = self.bearing_contacts();
        let known = self.response.inverse_mass.len() == g.len();
        let response = if known { &self.response } else { &Response::new(g, &Vec3::zeros(), &[]) };
        let (mut energy, mut beyond) = (0.0, 0.0);
        let mut add = |contact: &SavedContact, second: Option<usize>, gap: f64| {
            let mass = response.effective_mass(g, contact.first as usize, second);
            let Some(law) = self.around.law.at(mass).filter(|_| gap < 0.0) else { return };
            let (k_n, k_t) = (mass * law.stiffness, mass * law.tangential_stiffness);
            let spring = 0.5 * k_t * Vec3::from(contact.spring).norm_squared();
            let limit = law.friction * k_n * gap;
            let held = if k_t > 0.0 { spring.min(0.5 * limit * limit / k_t) } else { 0.0 };
            energy += 0.5 * k_n * gap * gap + held;
            beyond += spring - held;
        };
        for contact in &pairs {
            let (i, j) = (contact.first as usize, contact.second as usize);
            let apart = self.around.periods.nearest(g.position[i] - g.position[j]).norm();
            add(contact, Some(j), apart - g.radius[i] - g.radius[j]);
        }
        for contact in &walls {
            let (i, wall) = (contact.first as usize, &self.around.walls[contact.second as usize]);
            add(contact, None, wall.gap(&g.position[i], g.radius[i], self.time));
        }
        (energy, beyond)
    }

    /// Energy of gravity, J: −Σ m g·x over the grains that forces move, with x followed through periodic
    /// faces; zero at the origin.
    #[must_use]
    pub fn potential_energy(&self) -> f64 {
        let g = &self.grains;
        let gravity = Vec3::from(self.gravity.at(self.time));
        let fall = |i: usize| {
            let x = self.around.periods.unwrap(&g.position[i], &g.image[i]);
            -g.mass[i] * gravity.dot(&x)
        };
        (0..g.len()).filter(|&i| g.responds(i)).map(fall).sum()
    }
}
