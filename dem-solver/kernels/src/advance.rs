//! One window of the solver: checks, the engine's sub-steps, gaps, report.

use crate::bulk::engine::Bulk;
use crate::bulk::window::Wanted;
use crate::error::AdvanceError;
use crate::general::bodies::{BodyContacts, gap_between, gap_to_wall};
use crate::general::engine::{EXACT_GAPS, General};
use crate::general::evaluation::Window;
use crate::grains::Grains;
use crate::motion::Vec3;
use crate::report::{GrainLoad, NonFinite, Observations, Outcome, WindowReport};
use crate::search::cells::extent;
use crate::solver::{Dem, Running};
use crate::surroundings::Surroundings;

/// Named when a square overflows before any value does.
const OVERFLOW: NonFinite = NonFinite { grain: 0, quantity: "velocity" };

/// What an engine says of a window.
struct Done {
    outcome: Outcome,
    first_non_finite: Option<NonFinite>,
    /// Largest overlap, m.
    overlap: f64,
}

impl Dem {
    /// Advances by `dt_window` in `n_sub` sub-steps under constant `loads` (one per grain; none at all
    /// for a dry run). A state that stops being finite ends the window early and is named in the
    /// report.
    ///
    /// # Errors
    /// [`AdvanceError`]; the state is untouched.
    pub fn advance(
        &mut self,
        dt_window: f64,
        n_sub: u32,
        loads: &[GrainLoad],
    ) -> Result<WindowReport, AdvanceError> {
        check(self.grains.len(), dt_window, n_sub, loads)?;
        let Self { grains, engine, around, response, observed, gravity, .. } = self;
        let (time, dt) = (self.time, dt_window / f64::from(n_sub));
        // Where gravity changes, each sub-step adds its difference from this one.
        let first = Vec3::from(gravity.start());
        let gravity = Some(&*gravity).filter(|gravity| gravity.varies());
        for servo in around.walls.iter_mut().filter_map(|wall| wall.servo.as_mut()) {
            servo.window = Default::default();
        }
        self.time += dt_window;
        self.windows += 1;
        self.substeps += u64::from(n_sub);
        let done = match engine {
            Running::General(general) => {
                response.set(grains, &first, loads);
                let loaded = !loads.is_empty();
                let mut window = Window { grains, around, response, observed, gravity, loaded };
                let done = advance_general(general, &mut window, time, dt_window, n_sub);
                gaps_to_walls(grains, around, general.evaluation.bodies.as_deref(), observed, self.time);
                done
            }
            Running::Bulk(bulk) => {
                let loaded = loads.iter().any(|load| *load != GrainLoad::default());
                if loaded {
                    response.set(grains, &first, loads);
                }
                let wanted =
                    Wanted { observations: !observed.gap_end.is_empty(), orientation: self.orientation };
                bulk.begin(grains, loaded.then_some(&*response), &first, wanted);
                let done = advance_bulk(bulk, grains, time, dt_window, n_sub);
                observed.begin(around.walls.len());
                let each = 1.0 / f64::from(n_sub);
                bulk.add_wall_forces(&mut observed.wall_contact);
                observed.wall_contact.iter_mut().for_each(|mean| *mean *= each);
                if wanted.observations {
                    bulk.observe(observed, (self.time, dt));
                    observed.mean_contact.iter_mut().for_each(|mean| *mean *= each);
                    gaps_to_walls(grains, around, None, observed, self.time);
                }
                done
            }
        };
        Ok(self.report(&done))
    }

    fn report(&mut self, done: &Done) -> WindowReport {
        let mut smallest_gap = self.observed.smallest_gap.iter().copied().fold(f64::INFINITY, f64::min);
        if self.is_bulk() && done.overlap > 0.0 {
            smallest_gap = smallest_gap.min(-done.overlap);
        }
        let exact = !self.is_bulk() && self.grains.len() <= EXACT_GAPS;
        if smallest_gap > self.around.range && !exact && done.outcome.finite {
            smallest_gap = self.nearest_gap(smallest_gap);
        }
        WindowReport {
            n_sub_done: done.outcome.done,
            smallest_gap,
            largest_overlap: done.overlap,
            first_non_finite: done.first_non_finite,
            lost: first_lost(&self.grains, &self.around, self.time),
        }
    }
}

fn advance_general(
    general: &mut General,
    window: &mut Window<'_>,
    time: f64,
    dt_window: f64,
    n_sub: u32,
) -> Done {
    let outcome = general.advance(window, time, dt_window / f64::from(n_sub), n_sub);
    let found = first_non_finite(window.grains);
    general.finish(window, dt_window, n_sub);
    window.grains.wrap(&window.around.periods);
    general.observe_gaps(window);
    let first_non_finite = found.or((!outcome.finite).then_some(OVERFLOW));
    Done { outcome, first_non_finite, overlap: general.evaluation.forces.overlap }
}

fn advance_bulk(bulk: &mut Bulk, grains: &mut Grains, time: f64, dt_window: f64, n_sub: u32) -> Done {
    // the old velocities wait where the new accelerations will stand
    grains.acceleration.copy_from_slice(&grains.velocity);
    grains.spin_acceleration.copy_from_slice(&grains.spin);
    let outcome = bulk.advance(time, dt_window / f64::from(n_sub), n_sub);
    bulk.end(grains);
    bulk.note_travel(grains, dt_window);
    let rate = 1.0 / dt_window;
    for i in 0..grains.len() {
        grains.acceleration[i] = (grains.velocity[i] - grains.acceleration[i]) * rate;
        grains.spin_acceleration[i] = (grains.spin[i] - grains.spin_acceleration[i]) * rate;
    }
    let found = || first_non_finite(grains).unwrap_or(OVERFLOW);
    Done { outcome, first_non_finite: (!outcome.finite).then(found), overlap: bulk.largest_overlap() }
}

fn check(grains: usize, dt: f64, n_sub: u32, loads: &[GrainLoad]) -> Result<(), AdvanceError> {
    if !(dt > 0.0 && dt.is_finite()) || n_sub == 0 {
        return Err(AdvanceError::Window { dt, n_sub });
    }
    if !loads.is_empty() && loads.len() != grains {
        return Err(AdvanceError::LoadCount { given: loads.len(), grains });
    }
    for (grain, load) in loads.iter().enumerate() {
        for (quantity, vector) in [("force", &load.force), ("torque", &load.torque)] {
            if let Some(&value) = vector.iter().find(|c| !c.is_finite()) {
                return Err(AdvanceError::Load { grain, quantity, value });
            }
        }
        for (quantity, value) in [("added mass", load.added_mass), ("added inertia", load.added_inertia)] {
            if !(value >= 0.0 && value.is_finite()) {
                return Err(AdvanceError::Load { grain, quantity, value });
            }
        }
    }
    Ok(())
}

/// Gaps to walls at the end of a window, and with them the smallest.
fn gaps_to_walls(
    grains: &Grains,
    around: &Surroundings,
    bodies: Option<&BodyContacts>,
    observed: &mut Observations,
    time: f64,
) {
    for (i, nearest) in observed.gap_end.iter_mut().enumerate() {
        for wall in around.walls.iter().filter(|wall| wall.acts(time)) {
            *nearest = nearest.min(gap_to_wall((grains, bodies), i, wall, time));
        }
        observed.smallest_gap[i] = observed.smallest_gap[i].min(*nearest);
    }
}

impl Dem {
    /// The smallest gap between two grains or to a wall, m, no larger than `least`: for grains of which none
    /// is within the watched range.
    fn nearest_gap(&mut self, mut least: f64) -> f64 {
        let Self { grains, around, search, engine, time, .. } = self;
        let bodies = match engine {
            Running::General(general) => general.evaluation.bodies.as_deref(),
            Running::Bulk(_) => None,
        };
        let Surroundings { periods, walls, range, .. } = &*around;
        for wall in walls.iter().filter(|wall| wall.acts(*time)) {
            least = (0..grains.len())
                .map(|i| gap_to_wall((grains, bodies), i, wall, *time))
                .fold(least, f64::min);
        }
        // As far as the ends of all there is, unless something is nearer.
        let (low, high) = extent(grains.position.iter().map(|x| (*x).into()));
        let farthest = (Vec3::from(high) - Vec3::from(low)).norm();
        let mut reach = grains.radius.iter().copied().fold(*range, f64::max);
        loop {
            search.0.prepare(&grains.position, &grains.radius, reach, periods);
            for i in 0..grains.len() {
                search.1.clear();
                search.0.partners(i, &grains.position, &grains.radius, reach, periods, &mut search.1);
                for &j in &search.1 {
                    least = least.min(gap_between((grains, bodies), periods, [i, j as usize], least));
                }
            }
            if least <= reach || reach >= farthest {
                return least;
            }
            reach *= 2.0;
        }
    }

    /// Gap of a grain to the nearest other one or wall, m, however far away; infinite if there is none.
    #[must_use]
    pub fn gap_of(&self, grain: usize) -> f64 {
        let (grains, around, time) = (&self.grains, &self.around, self.time);
        let bodies = self.general().and_then(|general| general.evaluation.bodies.as_deref());
        let walls = around.walls.iter().filter(|wall| wall.acts(time));
        let walls = walls.map(|wall| gap_to_wall((grains, bodies), grain, wall, time));
        let others = (0..grains.len()).filter(|other| *other != grain);
        others.fold(walls.fold(f64::INFINITY, f64::min), |nearest, other| {
            let pair = [grain.min(other), grain.max(other)];
            nearest.min(gap_between((grains, bodies), &around.periods, pair, nearest))
        })
    }
}

/// First free grain that is behind a wall by more than its diameter.
fn first_lost(grains: &Grains, around: &Surroundings, time: f64) -> Option<usize> {
    let behind = |&i: &usize| {
        let (x, r) = (&grains.position[i], grains.radius[i]);
        around.walls.iter().any(|wall| wall.acts(time) && wall.gap(x, r, time) < -3.0 * r)
    };
    (0..grains.len()).filter(|&i| grains.responds(i)).find(behind)
}

/// First grain whose state is not finite; a square that overflows counts.
fn first_non_finite(grains: &Grains) -> Option<NonFinite> {
    (0..grains.len()).find_map(|grain| {
        let values = [
            ("position", grains.position[grain].norm_squared()),
            ("velocity", grains.velocity[grain].norm_squared()),
            ("spin", grains.spin[grain].norm_squared()),
            ("orientation", grains.orientation[grain].quaternion().norm_squared()),
        ];
        let bad = values.iter().find(|(_, value)| !value.is_finite());
        bad.map(|&(quantity, _)| NonFinite { grain, quantity })
    })
}
