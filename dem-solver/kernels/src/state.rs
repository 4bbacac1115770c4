//! Everything that decides the next step.
//!
//! Neighbour lists are not part of it: sums run in an order that does not depend on them. The bulk engine's
//! order of the grains is, since its sums follow it.

use crate::report::Dissipated;
use serde::{Deserialize, Serialize};

/// A contact that bears a force, with its history.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct SavedContact {
    /// Grain.
    pub first: u32,
    /// Other grain, or wall.
    pub second: u32,
    /// Tangential spring δ_t, m.
    pub spring: [f64; 3],
}

/// A point of contact of a body that is not round, with its history.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct SavedPoint {
    /// Grain.
    pub first: u32,
    /// Other grain, or wall.
    pub second: u32,
    /// Which point of the two it is.
    pub feature: u32,
    /// Tangential spring along the tangent (−n_z, n_x), m.
    pub spring: f64,
    /// Effective mass of the point at the first touch, kg.
    pub mass: f64,
}

/// State of a run between two windows: restoring it and repeating gives identical bits.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct State {
    /// Time, s.
    pub time: f64,
    /// Sub-steps done.
    pub substeps: u64,
    /// Windows done.
    pub windows: u64,
    /// Centres, m, inside the period.
    pub position: Vec<[f64; 3]>,
    /// Turns around the period.
    pub image: Vec<[i32; 3]>,
    /// Orientations, unit quaternions (w, x, y, z).
    pub orientation: Vec<[f64; 4]>,
    /// Velocities, m/s.
    pub velocity: Vec<[f64; 3]>,
    /// Angular velocities, rad/s.
    pub spin: Vec<[f64; 3]>,
    /// Mean acceleration over the last window (A_prev), m/s².
    pub acceleration: Vec<[f64; 3]>,
    /// Mean angular acceleration over the last window, rad/s².
    pub spin_acceleration: Vec<[f64; 3]>,
    /// Contacts between grains, ascending.
    pub contacts: Vec<SavedContact>,
    /// Contacts with walls, ascending.
    pub wall_contacts: Vec<SavedContact>,
    /// Rolling angles of `contacts`, then of `wall_contacts`, rad; empty where rolling is free.
    pub rolling: Vec<[f64; 3]>,
    /// Order of the grains in the bulk engine; empty before its first window and in the general engine.
    pub order: Vec<u32>,
    /// How far grains may have moved since that order was made, m.
    pub order_travel: f64,
    /// Way, m, and speed, m/s, of each servo, and the time, s, at which it had that way.
    pub servos: Vec<[f64; 3]>,
    /// Energy that contacts have taken; zero where no account is kept.
    pub dissipated: Dissipated,
    /// Points of contact between grains of which one is not round, ascending by the two grains.
    pub body_contacts: Vec<SavedPoint>,
    /// Points of contact of bodies that are not round with walls, ascending by both.
    pub body_wall_contacts: Vec<SavedPoint>,
}

impl State {
    /// The state of the grains `kept` (ascending), numbered anew, with the contacts between them; without
    /// contacts with walls.
    #[must_use]
    pub fn of_grains(&self, kept: &[usize]) -> Self {
        fn select<T: Copy>(kept: &[usize], all: &[T]) -> Vec<T> {
            kept.iter().filter_map(|i| all.get(*i).copied()).collect()
        }
        let mut numbers = vec![None; self.position.len()];
        for (new, old) in kept.iter().enumerate().filter(|(_, old)| **old < self.position.len()) {
            numbers[*old] = Some(new as u32);
        }
        let number = |old: u32| numbers.get(old as usize).copied().flatten();
        let mut state = Self {
            position: select(kept, &self.position),
            image: select(kept, &self.image),
            orientation: select(kept, &self.orientation),
            velocity: select(kept, &self.velocity),
            spin: select(kept, &self.spin),
            acceleration: select(kept, &self.acceleration),
            spin_acceleration: select(kept, &self.spin_acceleration),
            ..Self { time: self.time, dissipated: self.dissipated, ..Self::default() }
        };
        for (place, contact) in self.contacts.iter().enumerate() {
            if let (Some(first), Some(second)) = (number(contact.first), number(contact.second)) {
                state.contacts.push(SavedContact { first, second, ..*contact });
                state.rolling.extend(self.rolling.get(place));
            }
        }
        for point in &self.body_contacts {
            if let (Some(first), Some(second)) = (number(point.first), number(point.second)) {
                state.body_contacts.push(SavedPoint { first, second, ..*point });
            }
        }
        state
    }
}
