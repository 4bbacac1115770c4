//! Grains that are inserted while the run goes.
//!
//! The solver holds the grains that are there; the others wait outside of it, in order of their times.
//! A batch comes when it is due and worth the rebuilding: a 200th of the grains there, or all that
//! are left. Each grain of a batch takes the first of a hundred random places that is free; where none
//! is, it and those after it wait for the next window.

use std::collections::BTreeSet;

use crate::grain::Grain;
use crate::grains::Grains;
use crate::motion::Vec3;
use crate::periods::Periods;
use crate::solver::Dem;
use bedload_scene::{CheckedScene, Domain, Geometry, Inserted, Insertion};

/// Tries for a place, per grain and window.
const TRIES: u64 = 100;

/// Overlap with a wall, over the radius, that is a remainder of rounding: regions may end at walls.
const ROUNDING: f64 = 1e-9;

/// What waits to be inserted.
#[derive(Clone, Debug)]
pub struct Insertions {
    insertions: Vec<Insertion>,
    inserted: Vec<Inserted>,
    domain: Domain,
    /// Grains that are there from the start.
    present: usize,
}

impl Insertions {
    /// As the scene has it.
    pub fn new(scene: &CheckedScene) -> Self {
        Self {
            insertions: scene.scene.insertions.clone(),
            inserted: scene.inserted.clone(),
            domain: scene.scene.domain.clone(),
            present: scene.present(),
        }
    }

    /// Places of the grains to add to those there now, in window `step` that begins at `time`, clear of them
    /// and of walls; `all` holds every grain of the scene.
    pub fn places(&self, dem: &Dem, all: &[Grain], step: u64, time: f64) -> Vec<Vec3> {
        let (grains, periods) = (&dem.grains, dem.periods());
        let there = grains.len();
        let waiting = &self.inserted[there.min(all.len()) - self.present..];
        let due = waiting.iter().take_while(|inserted| inserted.time <= time).count();
        if due == 0 || (due < waiting.len() && due < (there - self.present) / 200) {
            return Vec::new();
        }
        let mut near = self.near(grains, all, periods, &waiting[..due], time);
        let mut places = Vec::new();
        for (number, inserted) in waiting[..due].iter().enumerate() {
            let (insertion, radius) = (&self.insertions[inserted.insertion], all[there + number].radius);
            let clear = |place: &Vec3| {
                let apart2 = |x: &Vec3| periods.nearest(place - x).norm_squared();
                near.iter().all(|(x, r)| apart2(x) >= (radius + r).powi(2))
                    && dem.gap_to_walls(place, radius) >= -ROUNDING * radius
            };
            let grain = (there + number) as u64;
            let place = (0..TRIES)
                .map(|attempt| Vec3::from(insertion.place(&self.domain, radius, grain, step, attempt)))
                .map(|place| place + Vec3::from(insertion.shift(time)))
                .find(clear);
            let Some(place) = place else { break };
            near.push((place, radius));
            places.push(place);
        }
        places
    }

    /// Grains that can stand in the way.
    fn near(
        &self,
        grains: &Grains,
        all: &[Grain],
        periods: &Periods,
        due: &[Inserted],
        time: f64,
    ) -> Vec<(Vec3, f64)> {
        let largest = all.iter().map(|grain| grain.radius).fold(0.0, f64::max);
        let used: BTreeSet<usize> = due.iter().map(|inserted| inserted.insertion).collect();
        let reaches = |x: &Vec3| {
            used.iter().any(|&insertion| {
                let Insertion { lower, upper, .. } = &self.insertions[insertion];
                let shift = self.insertions[insertion].shift(time);
                (0..3).all(|c| {
                    let (low, high) = (lower[c] + shift[c], upper[c] + shift[c]);
                    (self.domain.geometry == Geometry::Plane && c == 1)
                        || periods.is_periodic(c)
                        || (low - 2.0 * largest..=high + 2.0 * largest).contains(&x[c])
                })
            })
        };
        let there = grains.position.iter().zip(&grains.radius);
        there.filter(|(x, _)| reaches(x)).map(|(x, r)| (*x, *r)).collect()
    }
}
