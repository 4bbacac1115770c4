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
        let turned = state.orientation.iter().map(|&[w, x, y, z]| Quaternion::new(w, x, y, z));
        grains.orientation.extend(turned.map(UnitQuaternion::new_unchecked));
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
        let (needed, walls) = (self.grains.len(), self.around.walls.len());
        for (quantity, found) in [
            ("position", state.position.len()),
            ("image", state.image.len()),
            ("orientation", state.orientation.len()),
            ("velocity", state.velocity.len()),
            ("spin", state.spin.len()),
            ("acceleration", state.acceleration.len()),
            ("spin_acceleration", state.spin_acceleration.len()),
        ] {
            check_length(quantity, found, needed)?;
        }
        check_finite("position", &state.position)?;
        check_finite("velocity", &state.velocity)?;
        check_finite("spin", &state.spin)?;
        check_finite("acceleration", &state.acceleration)?;
        check_finite("spin acceleration", &state.spin_acceleration)?;
        check_finite("orientation", &state.orientation)?;
        if !state.servos.is_empty() {
            check_length("servos", state.servos.len(), self.servos().count())?;
        }
        check_finite("servo of wall, of those with one", &state.servos)?;
        let contacts = state.contacts.len() + state.wall_contacts.len();
        let angles = if self.around.rolling.is_some() { contacts } else { 0 };
        check_length("rolling angles", state.rolling.len(), angles)?;
        check_finite("rolling angle, of contact", &state.rolling)?;
        let mut places = state.order.clone();
        places.sort_unstable();
        if !places.is_empty() && !places.into_iter().eq(0..needed as u32) {
            return Err(RestoreError::Order { grains: needed });
        }
        let grain = |number: u32| (number as usize) < needed;
        let wall = |number: u32| (number as usize) < walls;
        let is_round = |i: u32| self.grains.is_round(i as usize);
        let sound = |it: &SavedContact| grain(it.first) && it.spring.iter().all(|c| c.is_finite());
        let is_point = |it: &SavedPoint| {
            grain(it.first) && it.spring.is_finite() && it.mass > 0.0 && it.mass.is_finite()
        };
        let is_pair = |i: u32, j: u32| j > i && grain(j);
        let fits = |it: &SavedContact| sound(it) && is_pair(it.first, it.second);
        check_contacts(state.contacts.iter().map(|it| (it.first, it.second, fits(it))), PartialOrd::lt)?;
        let fits = |it: &SavedContact| sound(it) && wall(it.second);
        check_contacts(state.wall_contacts.iter().map(|it| (it.first, it.second, fits(it))), PartialOrd::lt)?;
        let are_round = |it: &SavedPoint| is_round(it.first) && is_round(it.second);
        let fits = |it: &SavedPoint| is_point(it) && is_pair(it.first, it.second) && !are_round(it);
        check_contacts(state.body_contacts.iter().map(|it| (it.first, it.second, fits(it))), PartialOrd::le)?;
        let fits = |it: &SavedPoint| is_point(it) && wall(it.second) && !is_round(it.first);
        let points = state.body_wall_contacts.iter();
        check_contacts(points.map(|it| (it.first, it.second, fits(it))), PartialOrd::le)
    }
}

fn check_length(quantity: &'static str, found: usize, needed: usize) -> Result<(), RestoreError> {
    if found == needed { Ok(()) } else { Err(RestoreError::Length { quantity, found, needed }) }
}

fn check_finite<const N: usize>(quantity: &'static str, values: &[[f64; N]]) -> Result<(), RestoreError> {
    let bad = values.iter().position(|v| v.iter().any(|c| !c.is_finite()));
    bad.map_or(Ok(()), |grain| Err(RestoreError::NotFinite { quantity, grain }))
}

/// Of contacts the partners, and whether what else they hold fits; each must come after the one before it.
fn check_contacts(
    contacts: impl Iterator<Item = (u32, u32, bool)>,
    in_order: fn(&(u32, u32), &(u32, u32)) -> bool,
) -> Result<(), RestoreError> {
    let mut before = None;
    for (index, (first, second, fits)) in contacts.enumerate() {
        let now = (first, second);
        if !fits || before.is_some_and(|before| !in_order(&before, &now)) {
            return Err(RestoreError::Contact { index, first, second });
        }
        before = Some(now);
    }
    Ok(())
}
