//! Grains that are inserted while the run goes.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::domain::{Domain, Geometry};
use crate::grains::Grain;
use crate::random::SplitMix64;

/// Grains that appear one after the other at random places of a region, where there is room.
///
/// Every inserted grain has its place in the messages from the start, after all others and in order of
/// its time; until it appears its orientation is zero.
#[derive(Clone, Debug, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Insertion {
    /// How many in all.
    pub count: usize,
    /// Lower corner (x, y, z) of the region that holds them whole as they appear, m; along a periodic axis
    /// that it spans it holds their centres.
    pub lower: [f64; 3],
    /// Upper corner, m.
    pub upper: [f64; 3],
    /// Mean radius, m.
    pub radius: f64,
    /// Half-width of the uniform spread of radii, relative to the mean.
    #[serde(default)]
    pub radius_spread: f64,
    /// Density, kg/m³.
    pub density: f64,
    /// Velocity as they appear, m/s.
    #[serde(default)]
    pub velocity: [f64; 3],
    /// Grains per second; fewer come where the region is full.
    pub rate: f64,
    /// Time of the first, s.
    #[serde(default)]
    pub start: f64,
    /// Velocity of the region until the last grain is due, m/s: let it rise with the bed.
    #[serde(default)]
    pub rise: [f64; 3],
    /// Seed of the random numbers.
    pub seed: u64,
}

/// When and from which insertion a grain comes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Inserted {
    /// Earliest time, s.
    pub time: f64,
    /// Index of the insertion.
    pub insertion: usize,
}

impl Insertion {
    /// How far the region has moved at `time`, m.
    pub fn shift(&self, time: f64) -> [f64; 3] {
        let moving = (time - self.start).clamp(0.0, self.count as f64 / self.rate);
        self.rise.map(|speed| speed * moving)
    }

    /// Place in the region as it was at t = 0 for `grain` at `attempt` in window `step`: the same
    /// numbers, the same place.
    pub fn place(&self, domain: &Domain, radius: f64, grain: u64, step: u64, attempt: u64) -> [f64; 3] {
        let mut mixed = SplitMix64(self.seed);
        for number in [grain, step, attempt] {
            mixed.0 = mixed.next() ^ number;
        }
        let spanned = domain.spanned(&self.lower, &self.upper);
        mixed.place(domain.geometry, &spanned, &self.lower, &self.upper, radius)
    }

    /// The grains, waiting in the middle of the region.
    fn grains(&self, geometry: Geometry) -> impl Iterator<Item = Grain> + '_ {
        let mut random = SplitMix64(self.seed);
        let mut middle = std::array::from_fn(|axis| 0.5 * (self.lower[axis] + self.upper[axis]));
        if geometry == Geometry::Plane {
            middle[1] = 0.0;
        }
        (0..self.count).map(move |_| {
            let radius = random.about(self.radius, self.radius_spread);
            Grain { velocity: self.velocity.into(), ..Grain::at(middle, radius, self.density) }
        })
    }
}

/// All inserted grains in order of their times.
pub(crate) fn lay_out(insertions: &[Insertion], geometry: Geometry) -> (Vec<Grain>, Vec<Inserted>) {
    let mut all: Vec<(Inserted, Grain)> = Vec::new();
    for (index, insertion) in insertions.iter().enumerate() {
        let time = |number: usize| insertion.start + number as f64 / insertion.rate;
        let grains = insertion.grains(geometry).enumerate();
        all.extend(grains.map(|(number, grain)| (Inserted { time: time(number), insertion: index }, grain)));
    }
    all.sort_by(|a, b| a.0.time.total_cmp(&b.0.time).then(a.0.insertion.cmp(&b.0.insertion)));
    let (inserted, grains) = all.into_iter().unzip();
    (grains, inserted)
}
