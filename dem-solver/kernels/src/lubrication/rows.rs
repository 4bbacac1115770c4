//! What films read and change of the grains, as rows of four numbers that a vector kernel loads at once.
//!
//! Rows of grains come first, then one for each wall, which nothing moves, and one for lanes that hold no
//! film.

use crate::grains::{Grains, Response};
use crate::laws::walls::Plane;
use crate::motion::Vec3;
use crate::vector::rows::Row;

/// Rows of all grains and walls.
#[derive(Clone, Debug, Default)]
pub(super) struct Rows {
    /// Centre and radius.
    pub(super) place: Vec<Row>,
    /// Velocity and inverse mass.
    pub(super) motion: Vec<Row>,
    /// Spin and inverse moment of inertia.
    pub(super) turning: Vec<Row>,
    /// 1 along free axes, 0 along locked ones; empty unless a grain is locked along or about some axes only.
    pub(super) free: Vec<Row>,
    /// The same for rotation.
    pub(super) turns: Vec<Row>,
    /// Mean forces of the films over the sub-step, N.
    pub(super) push: Vec<Row>,
    /// Largest speed, m/s.
    pub(super) fastest: f64,
}

impl Rows {
    /// Number of the row of wall `w`.
    pub(super) fn of_wall(grains: usize, w: u32) -> u32 {
        grains as u32 + w
    }

    /// Takes the present state; `spins` where surfaces that slide have a film.
    pub(super) fn load(
        &mut self,
        grains: &Grains,
        response: &Response,
        (walls, t): (&[Plane], f64),
        spins: bool,
    ) {
        let row = |v: &Vec3, last: f64| [v.x, v.y, v.z, last];
        let even = |v: &Vec3| v.x == v.y && v.y == v.z;
        let mut fastest2 = walls.iter().map(|wall| wall.velocity_at(t).norm_squared()).fold(0.0, f64::max);
        self.place.clear();
        self.motion.clear();
        let mut locked = false;
        for i in 0..grains.len() {
            let (v, weight) = (&grains.velocity[i], &response.inverse_mass[i]);
            fastest2 = v.norm_squared().max(fastest2);
            locked |= !(even(weight) && even(&response.inverse_inertia[i]));
            self.place.push(row(&grains.position[i], grains.radius[i]));
            self.motion.push(row(v, weight.max()));
        }
        self.fastest = fastest2.sqrt();
        self.motion.extend(walls.iter().map(|wall| row(&wall.velocity_at(t), 0.0)));
        self.motion.push([0.0; 4]);
        self.place.resize(self.motion.len(), [0.0; 4]);
        self.push.clear();
        self.push.resize(self.motion.len(), [0.0; 4]);
        self.turning.clear();
        if spins {
            let inertia = response.inverse_inertia.iter();
            self.turning
                .extend(grains.spin.iter().zip(inertia).map(|(spin, inverse)| row(spin, inverse.max())));
            self.turning.resize(self.motion.len(), [0.0; 4]);
        }
        self.free.clear();
        self.turns.clear();
        if locked {
            self.free.extend(grains.translation.iter().map(|free| row(free, 0.0)));
            self.turns.extend(grains.rotation.iter().map(|free| row(free, 0.0)));
            self.free.resize(self.motion.len(), [0.0; 4]);
            self.turns.resize(self.motion.len(), [0.0; 4]);
        }
    }

    /// Whether films may change the motion of a row.
    pub(super) fn moves(&self, row: u32) -> bool {
        let row = row as usize;
        self.motion[row][3] > 0.0 || self.turning.get(row).is_some_and(|turning| turning[3] > 0.0)
    }

    /// Hands velocities, spins and the mean forces on grains and walls back.
    pub(super) fn store(&self, grains: &mut Grains, force: &mut [Vec3], on_walls: &mut [Vec3]) {
        let take = |(to, [x, y, z, _]): (&mut Vec3, &Row)| *to = Vec3::new(*x, *y, *z);
        force.iter_mut().chain(on_walls).zip(&self.push).for_each(take);
        grains.velocity.iter_mut().zip(&self.motion).for_each(take);
        grains.spin.iter_mut().zip(&self.turning).for_each(take);
    }
}
