//! The engine for many grains: linear contacts, symplectic Euler, no films.
//!
//! | file | what it holds |
//! |---|---|
//! | `fits` | which scenes it takes |
//! | `row` | a grain is a row of 12 numbers, eight contacts are a pack |
//! | `order`, `bins`, `near`, `list` | the order of the grains, cells, the lists of a block |
//! | `lanes`, `wide`, `duo`, `law`, `pair`, `wall` | many contacts at once |
//! | `advance`, `block` | kick and drift; one sub-step of a block |
//! | `skin`, `afar` | how wide the lists are, when they are built; when what is near is searched |
//! | `stretch` | sub-steps between two looks at the lists: wavefront and threads |
//! | `contacts`, `window`, `join` | springs in and out; start and end of a window; grains that join |
//!
//! Grains stand in an order of cells and are cut into blocks of [`SIZE`], by their number alone. Each block
//! has its own list; a contact between two blocks stands in both, each with its own spring, and since every
//! expression changes sign or stays when the partners change places, the copies stay equal. Sums run in the
//! order of the contacts, so the bits depend on the order of the grains and on nothing else: not on skins,
//! moments of building lists, threads or the depth of the wavefront. The order is part of the saved state.
//! Fixed grains come first in it: their blocks sleep unless the forces on them are asked for, and a contact with
//! one of them then stands in the other block alone.

mod advance;
mod afar;
mod bins;
mod block;
mod contacts;
mod duo;
mod fits;
mod join;
mod lanes;
mod law;
mod list;
mod near;
mod order;
mod pair;
mod row;
mod seen;
mod skin;
mod stretch;
mod wall;
#[cfg(target_arch = "x86_64")]
mod wide;
mod window;

use crate::laws::table::{LawTable, PairLaw};
use crate::laws::walls::Plane;
use crate::search::cells::Periods;
use crate::spec::{DemSpec, Motion};
use afar::Afar;
use bins::Bins;
use block::{Bench, Common};
use list::Builder;
use skin::Lists;
use stretch::{Blocks, Plan, lock, mine, only, read};
use wall::Wall;

pub use fits::{FROM, prevents};
pub(crate) use window::Wanted;

/// Grains of a block.
pub const SIZE: usize = 512;

/// Sub-steps of a stretch at most.
const LONGEST: u32 = 256;

/// How the engine does its work: nothing here changes a bit of the result.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Settings {
    /// Threads; 0: one.
    pub threads: usize,
    /// Sub-steps that follow one another through the blocks; 0: chosen by the size of the run.
    pub depth: u32,
    /// Width of the lists beyond contact, m; none: chosen from the motion.
    pub skin: Option<f64>,
    /// Leave the widest vectors of the machine unused.
    pub plain: bool,
}

/// Outcome of a window.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Outcome {
    /// Sub-steps done.
    pub(crate) done: u32,
    /// Square of the largest speed, m²/s².
    pub(crate) speed2: f64,
    /// Whether the state stayed finite.
    pub(crate) finite: bool,
}

/// The engine.
#[derive(Debug)]
pub(crate) struct Bulk {
    settings: Settings,
    common: Common,
    periods: ([f64; 3], [f64; 3]),
    n: usize,
    /// Grains that move.
    moving: usize,
    diameter: f64,
    largest: f64,
    wall_speed: f64,
    /// Number of the grain at each place of the order; empty before the first window.
    order: Vec<u32>,
    /// Σ Δt v̄ of the grains that move since the order was made, m.
    order_travel: f64,
    blocks: Blocks,
    /// Whether forces on grains were asked for last.
    observed: bool,
    /// Which rows hold the state.
    now: usize,
    bins: Bins,
    benches: Vec<Bench>,
    builders: Vec<Builder>,
    /// What is near, and the lists that were taken from it.
    afar: Afar,
    lists: Lists,
    /// Whether what is near belongs to the present order and places.
    valid: bool,
    /// Whether the lists were taken from it.
    listed: bool,
    /// Largest speed, m/s.
    speed: f64,
    /// Largest distance that walls have gone, m.
    wall_path: f64,
    /// Largest number of blocks between the partners of a pair.
    reach: usize,
    loaded: bool,
    pub(crate) builds: u64,
}

impl Clone for Bulk {
    fn clone(&self) -> Self {
        let rows = self.blocks.rows.iter().map(|both| {
            let [a, b] = both;
            [read(a).clone().into(), read(b).clone().into()]
        });
        let block = self.blocks.block.iter().map(|block| lock(block).clone().into());
        Self {
            settings: self.settings,
            common: self.common.clone(),
            periods: self.periods,
            order: self.order.clone(),
            blocks: Blocks::new(rows.collect(), block.collect(), self.blocks.asleep()),
            bins: self.bins.clone(),
            afar: self.afar.clone(),
            lists: self.lists.clone(),
            benches: self.benches.clone(),
            builders: self.builders.clone(),
            ..*self
        }
    }
}

impl Bulk {
    /// The engine for a checked spec that nothing [`prevents`].
    pub(crate) fn new(spec: &DemSpec) -> Option<Self> {
        let n = spec.grains.len();
        let moving = spec.grains.iter().filter(|grain| grain.motion != Motion::Fixed).count();
        let laws = spec.laws();
        let linear = |a: usize, b: usize| linear(&laws, a, b);
        let material = spec.grains.first()?.material;
        let law = linear(material, material)?;
        let planes = spec.walls.iter().map(|wall| (Plane::from(wall), wall.material));
        let walls = planes.map(|(plane, of)| Some(Wall::new(plane, linear(material, of)?)));
        let walls: Vec<Wall> = walls.collect::<Option<_>>()?;
        let (mut start, mut length) = ([0.0; 3], [0.0; 3]);
        for (axis, period) in spec.periods.iter().enumerate() {
            if let Some((from, size)) = *period {
                (start[axis], length[axis]) = (from, size);
            }
        }
        let settings = spec.bulk;
        let threads = useful_threads(settings.threads, moving);
        let radii: Vec<f64> = spec.grains.iter().map(|grain| grain.radius).collect();
        let wall_speed = walls
            .iter()
            .map(|wall| wall.plane().velocity.dot(&wall.plane().normal).abs())
            .fold(0.0, f64::max);
        Some(Self {
            settings,
            common: Common { walls, length, law, plain: settings.plain },
            periods: (start, length),
            n,
            moving,
            diameter: mean_diameter(&radii),
            largest: spec.largest_radius(),
            wall_speed,
            order: Vec::new(),
            order_travel: 0.0,
            blocks: Blocks::default(),
            observed: false,
            now: 0,
            bins: Bins::default(),
            benches: vec![Bench::default(); threads],
            builders: vec![Builder::default(); threads],
            afar: Afar::default(),
            lists: Lists::default(),
            valid: false,
            listed: false,
            speed: 0.0,
            wall_path: 0.0,
            reach: 0,
            loaded: false,
            builds: 0,
        })
    }

    /// Threads at work.
    pub(crate) fn threads(&self) -> usize {
        self.benches.len()
    }

    /// Takes another number of threads.
    pub(crate) fn set_threads(&mut self, threads: usize) {
        self.settings.threads = threads;
        let threads = useful_threads(threads, self.moving);
        self.benches.resize(threads, Bench::default());
        self.builders.resize(threads, Builder::default());
    }

    /// The periods, for wrapping.
    fn wrapping(&self) -> Periods {
        let (start, length) = self.periods;
        Periods::new(std::array::from_fn(|axis| (length[axis] > 0.0).then_some((start[axis], length[axis]))))
    }

    /// `n_sub` sub-steps of `dt` from `t` on.
    pub(crate) fn advance(&mut self, t: f64, dt: f64, n_sub: u32) -> Outcome {
        let mut outcome = Outcome { done: 0, speed2: self.speed * self.speed, finite: true };
        while outcome.done < n_sub && outcome.finite {
            let at = t + f64::from(outcome.done) * dt;
            let steps = self.prepare(at, dt, (n_sub - outcome.done).min(LONGEST));
            self.stretch(t, dt, steps, &mut outcome);
        }
        outcome
    }

    /// One stretch of the window from `t` on. If a grain turns out to have outrun the lists, or to be no longer finite, it is done
    /// again up to the sub-step at which that happened.
    fn stretch(&mut self, t: f64, dt: f64, steps: u32, outcome: &mut Outcome) {
        self.run(t, dt, outcome.done, steps);
        let mut good = 0;
        while good < steps && outcome.finite && self.holds() {
            let fastest2 = self.fastest2(good);
            outcome.finite = fastest2.is_finite();
            if outcome.finite {
                self.speed = fastest2.sqrt();
                outcome.speed2 = outcome.speed2.max(fastest2);
                self.moved(good, dt);
            }
            good += 1;
        }
        if good < steps {
            self.go_back();
            self.run(t, dt, outcome.done, good);
        }
        outcome.done += good;
        self.now = (self.now + good as usize) % 2;
    }

    fn run(&mut self, t: f64, dt: f64, done: u32, steps: u32) {
        let reach = self.reach.max(1);
        let depth = match self.settings.depth {
            0 => depth(self.moving, reach),
            depth => depth,
        };
        let plan = Plan { t, dt, done, steps, now: self.now, depth, reach };
        self.blocks.run(&self.common, &plan, &mut self.benches);
    }

    /// Square of the largest speed after sub-step `s` of the stretch, NaN if not finite.
    fn fastest2(&mut self, s: u32) -> f64 {
        let mut fastest2 = 0.0f64;
        for block in self.blocks.awake_mut() {
            let speed2 = mine(block).speed2[s as usize];
            if speed2.is_nan() {
                return speed2;
            }
            fastest2 = fastest2.max(speed2);
        }
        fastest2
    }

    fn go_back(&mut self) {
        let asleep = self.blocks.asleep();
        let awake = self.blocks.block.iter_mut().zip(&mut self.blocks.rows).skip(asleep);
        for (block, rows) in awake {
            let rows: &mut Vec<_> = only(&mut rows[self.now]);
            mine(block).go_back(rows);
        }
    }
}

/// Mean diameter, m: the order goes by it, so that grains that join must lead to the same bits as a restart with them.
fn mean_diameter(radii: &[f64]) -> f64 {
    2.0 * (radii.iter().sum::<f64>() / radii.len() as f64)
}

/// At most one thread per four blocks: below that they wait for one another.
fn useful_threads(threads: usize, n: usize) -> usize {
    threads.clamp(1, (n / (4 * SIZE)).max(1))
}

/// The linear law between two materials, if they have one.
fn linear(laws: &LawTable, a: usize, b: usize) -> Option<crate::laws::linear::LinearPair> {
    match laws.between(a, b) {
        PairLaw::Linear(law) => Some(*law),
        _ => None,
    }
}

/// Depth of the wavefront: none where the run fits into the cache, or where blocks read so far away
/// that a wavefront would not.
fn depth(n: usize, reach: usize) -> u32 {
    if n < 8 * SIZE || reach > 2 { 1 } else { 4 }
}
