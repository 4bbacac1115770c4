//! Beginning and end of a window: checks, virtual mass, gaps, report.

use super::{Dem, EXACT_GAPS, OVERFLOW};
use crate::bulk::Wanted;
use crate::error::AdvanceError;
use crate::general::integrate::Speed;
use crate::grains::Response;
use crate::report::{GrainLoad, NonFinite, WindowReport};

impl Dem {
    pub(super) fn check(&self, dt: f64, n_sub: u32, loads: &[GrainLoad]) -> Result<(), AdvanceError> {
        if !(dt > 0.0 && dt.is_finite()) || n_sub == 0 {
            return Err(AdvanceError::Window { dt, n_sub });
        }
        if !loads.is_empty() && loads.len() != self.grains.len() {
            return Err(AdvanceError::LoadCount { given: loads.len(), grains: self.grains.len() });
        }
        for (grain, load) in loads.iter().enumerate() {
            for (quantity, vector) in [("force", &load.force), ("torque", &load.torque)] {
                if let Some(&value) = vector.iter().find(|c| !c.is_finite()) {
                    return Err(AdvanceError::Load { grain, quantity, value });
                }
            }
            for (quantity, value) in [("added mass", load.added_mass), ("added inertia", load.added_inertia)]
            {
                if !(value >= 0.0 && value.is_finite()) {
                    return Err(AdvanceError::Load { grain, quantity, value });
                }
            }
        }
        Ok(())
    }

    /// A window with the bulk engine.
    pub(super) fn advance_bulk(&mut self, dt_window: f64, n_sub: u32, loads: &[GrainLoad]) -> WindowReport {
        let Some(mut bulk) = self.bulk.take() else { return self.report(0, None) };
        let loaded = loads.iter().any(|load| *load != GrainLoad::default());
        if loaded {
            if self.response.inverse_mass.len() != self.grains.len() {
                self.response = Response::new(self.grains.len());
            }
            self.response.set(&self.grains, &self.gravity, loads);
        }
        let observations = !self.seen.gap_end.is_empty();
        let wanted = Wanted { observations, orientation: self.orientation };
        let dt = dt_window / f64::from(n_sub);
        bulk.begin(&self.grains, loaded.then_some(&self.response), &self.gravity, wanted);
        // the old velocities wait where the new accelerations will stand
        let grains = &mut self.grains;
        grains.acceleration.copy_from_slice(&grains.velocity);
        grains.spin_acceleration.copy_from_slice(&grains.spin);
        let outcome = bulk.advance(self.time, dt, n_sub);
        bulk.end(grains);
        bulk.note_travel(grains, dt_window);
        let rate = 1.0 / dt_window;
        for i in 0..grains.len() {
            grains.acceleration[i] = (grains.velocity[i] - grains.acceleration[i]) * rate;
            grains.spin_acceleration[i] = (grains.spin[i] - grains.spin_acceleration[i]) * rate;
        }
        self.time += dt_window;
        self.windows += 1;
        self.substeps += u64::from(n_sub);
        self.max_speed2 = outcome.speed2;
        (self.forces.contacts, self.forces.overlap) = bulk.met();
        self.seen.clear();
        if observations {
            bulk.observe(&mut self.seen, (self.time, dt));
            let share = 1.0 / f64::from(n_sub);
            self.seen.mean_contact.iter_mut().for_each(|mean| *mean *= share);
            self.gaps_to_walls();
        }
        self.bulk = Some(bulk);
        let failed = if outcome.finite { None } else { Some(self.first_non_finite().unwrap_or(OVERFLOW)) };
        let mut report = self.report(outcome.done, failed);
        if self.forces.overlap > 0.0 {
            report.smallest_gap = report.smallest_gap.min(-self.forces.overlap);
        }
        report
    }

    pub(crate) fn begin(&mut self, loads: &[GrainLoad]) {
        self.response.set(&self.grains, &self.gravity, loads);
        self.start.0.copy_from_slice(&self.grains.velocity);
        self.start.1.copy_from_slice(&self.grains.spin);
        self.seen.clear();
        self.films.forget();
        self.forces.overlap = 0.0;
        let speed = self.speed();
        self.max_speed2 = speed.largest2;
        // the first evaluation comes before the first kick: the lists must hold here
        self.refresh(&speed, self.time, 0.0);
    }

    /// A_prev, means, gaps, counters; positions back into the period.
    pub(super) fn finish(&mut self, dt_window: f64, n_sub: u32) {
        let share = 1.0 / f64::from(n_sub);
        for i in 0..self.grains.len() {
            self.grains.acceleration[i] = (self.grains.velocity[i] - self.start.0[i]) / dt_window;
            self.grains.spin_acceleration[i] = (self.grains.spin[i] - self.start.1[i]) / dt_window;
            self.seen.mean_contact[i] *= share;
            self.seen.mean_lubrication[i] *= share;
        }
        self.time += dt_window;
        self.windows += 1;
        self.substeps += u64::from(n_sub);
        self.wrap();
        self.gaps_at_end();
    }

    /// Puts all centres back into the period.
    pub(crate) fn wrap(&mut self) {
        for (x, image) in self.grains.position.iter_mut().zip(&mut self.grains.image) {
            self.scene.periods.wrap(x, image);
        }
    }

    fn gaps_at_end(&mut self) {
        let grains = &self.grains;
        let range = if grains.len() <= EXACT_GAPS { f64::INFINITY } else { self.scene.range };
        let gap_end = &mut self.seen.gap_end;
        let mut note = |i: usize, j: usize| {
            let apart = self.scene.periods.nearest(grains.position[i] - grains.position[j]);
            let gap = apart.norm() - grains.radius[i] - grains.radius[j];
            if gap <= range {
                gap_end[i] = gap_end[i].min(gap);
                gap_end[j] = gap_end[j].min(gap);
            }
        };
        if range.is_infinite() {
            (0..grains.len()).for_each(|i| (i + 1..grains.len()).for_each(|j| note(i, j)));
        } else {
            for i in 0..grains.len() {
                self.lists.pairs.row(i).for_each(|k| note(i, self.lists.pairs.other[k] as usize));
            }
        }
        self.gaps_to_walls();
    }

    /// Gaps to walls at the end of a window, and with them the smallest.
    fn gaps_to_walls(&mut self) {
        let grains = &self.grains;
        for (i, nearest) in self.seen.gap_end.iter_mut().enumerate() {
            for wall in self.scene.walls.iter().filter(|wall| wall.acts(self.time)) {
                *nearest = nearest.min(wall.gap(&grains.position[i], grains.radius[i], self.time));
            }
            self.seen.smallest_gap[i] = self.seen.smallest_gap[i].min(*nearest);
        }
    }

    pub(super) fn report(&self, n_sub_done: u32, first_non_finite: Option<NonFinite>) -> WindowReport {
        WindowReport {
            n_sub_done,
            smallest_gap: self.seen.smallest_gap.iter().copied().fold(f64::INFINITY, f64::min),
            largest_overlap: self.forces.overlap,
            max_speed: self.max_speed2.sqrt(),
            contacts: self.forces.contacts,
            first_non_finite,
            lost: self.first_lost(),
        }
    }

    /// First free grain that is behind a wall by more than its diameter.
    fn first_lost(&self) -> Option<usize> {
        let grains = &self.grains;
        let behind = |&i: &usize| {
            let stands = self.scene.walls.iter().filter(|wall| wall.acts(self.time));
            let mut gaps = stands.map(|wall| wall.gap(&grains.position[i], grains.radius[i], self.time));
            gaps.any(|gap| gap < -3.0 * grains.radius[i])
        };
        (0..grains.len()).filter(|&i| grains.responds(i)).find(behind)
    }

    /// Largest speed now.
    pub(crate) fn speed(&self) -> Speed {
        let mut speed = Speed { largest2: 0.0, finite: true };
        for (velocity, spin) in self.grains.velocity.iter().zip(&self.grains.spin) {
            let speed2 = velocity.norm_squared();
            speed.largest2 = speed.largest2.max(speed2);
            speed.finite &= (speed2 + spin.norm_squared()).is_finite();
        }
        speed
    }

    /// First grain whose state is not finite; a square that overflows counts.
    pub(crate) fn first_non_finite(&self) -> Option<NonFinite> {
        let grains = &self.grains;
        (0..grains.len()).find_map(|grain| {
            let values = [
                ("position", grains.position[grain].norm_squared()),
                ("velocity", grains.velocity[grain].norm_squared()),
                ("spin", grains.spin[grain].norm_squared()),
                ("orientation", grains.orientation[grain].quaternion().norm_squared()),
            ];
            values
                .iter()
                .find(|(_, value)| !value.is_finite())
                .map(|&(quantity, _)| NonFinite { grain, quantity })
        })
    }
}
