//! Everything that decides the next step.
//!
//! Neighbour lists are not part of it: sums run in an order that does not depend on them. The bulk engine's
//! order of the grains is, since its sums follow it.

use crate::Vec3;
use crate::error::RestoreError;
use crate::general::energy::Dissipated;
use crate::general::lists::ContactList;
use crate::solver::Dem;
use nalgebra::{Quaternion, UnitQuaternion};
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
    /// Energy that contacts have taken; zero where no account is kept.
    pub dissipated: Dissipated,
}

impl Dem {
    /// The state now.
    #[must_use]
    pub fn save(&self) -> State {
        let mut state = State::default();
        self.save_into(&mut state);
        state
    }

    /// The state now, into memory that is used again.
    pub fn save_into(&self, state: &mut State) {
        let grains = &self.grains;
        (state.time, state.substeps, state.windows) = (self.time, self.substeps, self.windows);
        let copy = |to: &mut Vec<[f64; 3]>, from: &[Vec3]| {
            to.clear();
            to.extend(from.iter().map(|v| <[f64; 3]>::from(*v)));
        };
        copy(&mut state.position, &grains.position);
        copy(&mut state.velocity, &grains.velocity);
        copy(&mut state.spin, &grains.spin);
        copy(&mut state.acceleration, &grains.acceleration);
        copy(&mut state.spin_acceleration, &grains.spin_acceleration);
        state.image.clone_from(&grains.image);
        state.orientation.clear();
        state.orientation.extend(grains.orientation.iter().map(|q| [q.w, q.i, q.j, q.k]));
        state.dissipated = self.dissipated().unwrap_or_default();
        state.rolling.clear();
        if let Some(bulk) = &self.bulk {
            return bulk.save_into(state);
        }
        state.order.clear();
        state.order_travel = 0.0;
        save_list(&self.lists.pairs, grains.len(), &mut state.contacts);
        save_list(&self.lists.walls, grains.len(), &mut state.wall_contacts);
        if self.scene().laws.any_rolling() {
            for list in [&self.lists.pairs, &self.lists.walls] {
                let touching = (0..list.len()).filter(|&k| list.touching[k]);
                state.rolling.extend(touching.map(|k| <[f64; 3]>::from(list.rolling[k])));
            }
        }
    }

    /// Goes (back) to `state`; on an error nothing changes.
    pub fn restore(&mut self, state: &State) -> Result<(), RestoreError> {
        self.check_state(state)?;
        let copy = |to: &mut Vec<Vec3>, from: &[[f64; 3]]| {
            to.clear();
            to.extend(from.iter().map(|v| Vec3::from(*v)));
        };
        let grains = &mut self.grains;
        copy(&mut grains.position, &state.position);
        copy(&mut grains.velocity, &state.velocity);
        copy(&mut grains.spin, &state.spin);
        copy(&mut grains.acceleration, &state.acceleration);
        copy(&mut grains.spin_acceleration, &state.spin_acceleration);
        grains.image.clone_from(&state.image);
        grains.orientation.clear();
        grains.orientation.extend(
            state
                .orientation
                .iter()
                .map(|&[w, x, y, z]| UnitQuaternion::new_unchecked(Quaternion::new(w, x, y, z))),
        );
        (self.time, self.substeps, self.windows) = (state.time, state.substeps, state.windows);
        if let Some(account) = &mut self.account {
            account.lost = state.dissipated;
        }
        if let Some(bulk) = &mut self.bulk {
            bulk.restore(grains, state);
            return Ok(());
        }
        let n = grains.len();
        self.lists.restart(n);
        let of_pairs = state.contacts.len().min(state.rolling.len());
        let (pairs, walls) = state.rolling.split_at(of_pairs);
        restore_list(&state.contacts, pairs, n, &mut self.lists.pairs);
        restore_list(&state.wall_contacts, walls, n, &mut self.lists.walls);
        Ok(())
    }

    fn check_state(&self, state: &State) -> Result<(), RestoreError> {
        let needed = self.grains.len();
        for (quantity, found) in [
            ("position", state.position.len()),
            ("image", state.image.len()),
            ("orientation", state.orientation.len()),
            ("velocity", state.velocity.len()),
            ("spin", state.spin.len()),
            ("acceleration", state.acceleration.len()),
            ("spin_acceleration", state.spin_acceleration.len()),
        ] {
            if found != needed {
                return Err(RestoreError::Length { quantity, found, needed });
            }
        }
        for (quantity, values) in [
            ("position", &state.position),
            ("velocity", &state.velocity),
            ("spin", &state.spin),
            ("acceleration", &state.acceleration),
            ("spin acceleration", &state.spin_acceleration),
        ] {
            if let Some(grain) = values.iter().position(|v| v.iter().any(|c| !c.is_finite())) {
                return Err(RestoreError::NotFinite { quantity, grain });
            }
        }
        if let Some(grain) = state.orientation.iter().position(|q| q.iter().any(|c| !c.is_finite())) {
            return Err(RestoreError::NotFinite { quantity: "orientation", grain });
        }
        let contacts = state.contacts.len() + state.wall_contacts.len();
        let needed_rolling = if self.scene().laws.any_rolling() { contacts } else { 0 };
        if state.rolling.len() != needed_rolling {
            let found = state.rolling.len();
            return Err(RestoreError::Length { quantity: "rolling angles", found, needed: needed_rolling });
        }
        if let Some(index) = state.rolling.iter().position(|v| v.iter().any(|c| !c.is_finite())) {
            return Err(RestoreError::NotFinite { quantity: "rolling angle, of contact", grain: index });
        }
        let mut places = state.order.clone();
        places.sort_unstable();
        if !places.is_empty() && !places.into_iter().eq(0..needed as u32) {
            return Err(RestoreError::Order { grains: needed });
        }
        check_list(&state.contacts, needed, |contact| {
            contact.second > contact.first && (contact.second as usize) < needed
        })?;
        check_list(&state.wall_contacts, needed, |contact| (contact.second as usize) < self.wall_count())
    }
}

fn save_list(list: &ContactList, grains: usize, saved: &mut Vec<SavedContact>) {
    saved.clear();
    for i in 0..grains {
        let touching = list.row(i).filter(|&k| list.touching[k]);
        saved.extend(touching.map(|k| SavedContact {
            first: i as u32,
            second: list.other[k],
            spring: list.spring[k].into(),
        }));
    }
}

fn restore_list(saved: &[SavedContact], rolling: &[[f64; 3]], grains: usize, list: &mut ContactList) {
    list.clear();
    let mut rest = saved.iter().enumerate().peekable();
    for i in 0..grains as u32 {
        while let Some((k, contact)) = rest.next_if(|(_, contact)| contact.first == i) {
            let angle = rolling.get(k).copied().unwrap_or_default();
            list.push(contact.second, contact.spring.into(), angle.into(), true);
        }
        list.close_row();
    }
}

fn check_list(
    saved: &[SavedContact],
    grains: usize,
    fits: impl Fn(&SavedContact) -> bool,
) -> Result<(), RestoreError> {
    for (index, contact) in saved.iter().enumerate() {
        let ordered =
            index == 0 || (saved[index - 1].first, saved[index - 1].second) < (contact.first, contact.second);
        let finite = contact.spring.iter().all(|c| c.is_finite());
        if !ordered || !finite || contact.first as usize >= grains || !fits(contact) {
            return Err(RestoreError::Contact { index, first: contact.first, second: contact.second });
        }
    }
    Ok(())
}
