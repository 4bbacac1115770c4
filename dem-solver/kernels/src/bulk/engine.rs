//! The engine: the grains in blocks, their lists, and what is known of them.

use crate::bulk::batch::Blocks;
use crate::bulk::block::{Common, StepScratch};
use crate::bulk::block_list::ListScratch;
use crate::bulk::candidates::CandidateStatus;
use crate::bulk::records::SIZE;
use crate::bulk::skins::Lists;
use crate::laws::table::PairLaw;
use crate::laws::walls::Plane;
use crate::motion::Motion;
use crate::periods::Periods;
use crate::search::cells::Cells;
use crate::spec::{BulkSettings, DemSpec};

#[derive(Clone, Debug, Default)]
pub(crate) struct Bulk {
    pub(super) settings: BulkSettings,
    pub(super) common: Common,
    pub(super) periods: Periods,
    pub(super) n: usize,
    pub(super) moving: usize,
    pub(super) diameter: f64,
    pub(super) largest: f64,
    pub(super) wall_speed: f64,
    /// Number of the grain at each place of the order; empty before the first window.
    pub(super) order: Vec<u32>,
    /// Σ Δt v̄ of the grains that move since the order was made, m.
    pub(super) order_travel: f64,
    pub(super) blocks: Blocks,
    /// Whether forces on grains were asked for last.
    pub(super) observed: bool,
    /// Which rows hold the state.
    pub(super) now: usize,
    pub(super) cells: Cells,
    pub(super) step_scratch: Vec<StepScratch>,
    pub(super) list_scratch: Vec<ListScratch>,
    /// What is near, and the lists taken from that.
    pub(super) candidates: CandidateStatus,
    pub(super) lists: Lists,
    /// Whether the candidates belong to the present order and places.
    pub(super) valid: bool,
    /// Whether the lists were taken from them.
    pub(super) listed: bool,
    /// Largest speed, m/s.
    pub(super) speed: f64,
    /// Largest distance that walls have gone, m.
    pub(super) wall_path: f64,
    /// Largest number of blocks between the partners of a pair.
    pub(super) reach: usize,
    pub(super) loaded: bool,
    pub(crate) builds: u64,
}

impl Bulk {
    /// The engine for a checked spec that nothing [`prevents`](crate::bulk::requirements::prevents).
    pub(crate) fn new(spec: &DemSpec) -> Option<Self> {
        let n = spec.grains.len();
        let moving = spec.grains.iter().filter(|grain| grain.motion != Motion::Fixed).count();
        let PairLaw::Linear(law) = spec.contact.pair() else { return None };
        let walls: Vec<Plane> = spec.walls.iter().map(Plane::from).collect();
        let periods = Periods::new(spec.periods);
        let settings = spec.bulk;
        let threads = useful_threads(settings.threads, moving);
        let radii: Vec<f64> = spec.grains.iter().map(|grain| grain.radius).collect();
        let wall_speed = walls.iter().map(Plane::approach).fold(0.0, f64::max);
        Some(Self {
            settings,
            common: Common {
                walls,
                length: periods.length,
                law,
                plain: settings.plain,
                gravity: Some(&spec.gravity).filter(|gravity| gravity.varies()).cloned(),
            },
            periods,
            n,
            moving,
            diameter: mean_diameter(&radii),
            largest: spec.largest_radius(),
            wall_speed,
            step_scratch: vec![StepScratch::default(); threads],
            list_scratch: vec![ListScratch::default(); threads],
            ..Self::default()
        })
    }

    pub(crate) fn threads(&self) -> usize {
        self.step_scratch.len()
    }

    pub(crate) fn set_threads(&mut self, threads: usize) {
        self.settings.threads = threads;
        let threads = useful_threads(threads, self.moving);
        self.step_scratch.resize(threads, StepScratch::default());
        self.list_scratch.resize(threads, ListScratch::default());
    }
}

/// Mean diameter, m: the order goes by it, so that inserted grains must lead to the same bits as a restart
/// with them.
pub(super) fn mean_diameter(radii: &[f64]) -> f64 {
    2.0 * (radii.iter().sum::<f64>() / radii.len() as f64)
}

/// At most one thread per four blocks: below that they wait for one another.
fn useful_threads(threads: usize, n: usize) -> usize {
    threads.clamp(1, (n / (4 * SIZE)).max(1))
}
