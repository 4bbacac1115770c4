//! State of the solver: save, restore, repeat.

use crate::error::RestoreError;
use crate::motion::Vec3;
use crate::solver::{Dem, Running};
use crate::state::{SavedContact, SavedPoint, State};
use nalgebra::{Quaternion, UnitQuaternion};

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
        state.dissipated = self.account().unwrap_or_default();
        state.servos.clear();
        state.servos.extend(self.servos().map(|(_, servo)| [servo.way, servo.speed, servo.since]));
        state.rolling.clear();
        state.body_contacts.clear();
        state.body_wall_contacts.clear();
        let (lists, bodies) = match &self.engine {
            Running::Bulk(bulk) => return bulk.save_into(state),
            Running::General(general) => (&general.evaluation.lists, &general.evaluation.bodies),
        };
        if let Some(bodies) = bodies {
            state.body_contacts.extend_from_slice(&bodies.pairs.now);
            state.body_wall_contacts.extend_from_slice(&bodies.walls.now);
        }
        state.order.clear();
        state.order_travel = 0.0;
        state.contacts.clear();
        state.contacts.extend(lists.pairs.bearing());
        state.wall_contacts.clear();
        state.wall_contacts.extend(lists.walls.bearing());
        if self.around.rolling.is_some() {
            for list in [&lists.pairs, &lists.walls] {
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
        let servos = self.around.walls.iter_mut().filter_map(|wall| wall.servo.as_mut());
        // A state of another run has none: its walls may have been others.
        let start = std::iter::repeat(&[0.0; 3]);
        for (servo, [way, speed, since]) in servos.zip(state.servos.iter().chain(start)) {
            (servo.way, servo.speed, servo.since) = (*way, *speed, *since);
        }
        match &mut self.engine {
            Running::Bulk(bulk) => bulk.restore(grains, state),
            Running::General(general) => {
                let evaluation = &mut general.evaluation;
                if let Some(account) = &mut evaluation.account {
                    account.lost = state.dissipated;
                }
                if let Some(bodies) = &mut evaluation.bodies {
                    bodies.pairs.now.clone_from(&state.body_contacts);
                    bodies.walls.now.clone_from(&state.body_wall_contacts);
                }
                let (lists, n) = (&mut evaluation.lists, grains.len());
                lists.restart(n);
                let of_pairs = state.contacts.len().min(state.rolling.len());
                let (pairs, walls) = state.rolling.split_at(of_pairs);
                lists.pairs.restore(&state.contacts, pairs, n);
                lists.walls.restore(&state.wall_contacts, walls, n);
            }
        }
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
        let (needed_servos, found) = (self.servos().count(), state.servos.len());
        if found != needed_servos && found > 0 {
            return Err(RestoreError::Length { quantity: "servos", found, needed: needed_servos });
        }
        if let Some(index) = state.servos.iter().position(|v| v.iter().any(|c| !c.is_finite())) {
            return Err(RestoreError::NotFinite {
                quantity: "servo of wall, of those with one",
                grain: index,
            });
        }
        let contacts = state.contacts.len() + state.wall_contacts.len();
        let needed_rolling = if self.around.rolling.is_some() { contacts } else { 0 };
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
        check_list(&state.wall_contacts, needed, |contact| {
            (contact.second as usize) < self.around.walls.len()
        })?;
        let is_round = |i: u32| self.grains.is_round(i as usize);
        check_points(&state.body_contacts, needed, |point| {
            point.second > point.first
                && (point.second as usize) < needed
                && !(is_round(point.first) && is_round(point.second))
        })?;
        check_points(&state.body_wall_contacts, needed, |point| {
            (point.second as usize) < self.around.walls.len() && !is_round(point.first)
        })
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

fn check_points(
    saved: &[SavedPoint],
    grains: usize,
    fits: impl Fn(&SavedPoint) -> bool,
) -> Result<(), RestoreError> {
    for (index, point) in saved.iter().enumerate() {
        let ordered =
            index == 0 || (saved[index - 1].first, saved[index - 1].second) <= (point.first, point.second);
        let sound = point.spring.is_finite() && point.mass > 0.0 && point.mass.is_finite();
        if !ordered || !sound || point.first as usize >= grains || !fits(point) {
            return Err(RestoreError::Contact { index, first: point.first, second: point.second });
        }
    }
    Ok(())
}
