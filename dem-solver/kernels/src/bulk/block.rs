//! A block: some five hundred grains that follow one another in the order of the engine, their
//! contacts, and one sub-step of them.

use crate::bulk::integrate::{self, BodyForce};
use crate::bulk::law::LawLanes;
use crate::bulk::observed::Observed;
use crate::bulk::pair::pair_forces;
use crate::bulk::records::{ContactPack, ForceTorque, GrainRecord, History};
use crate::bulk::wall::wall_forces;
use crate::laws::coefficients::LinearPair;
use crate::laws::walls::Plane;
use crate::motion::Motion;
use crate::vector::images::Images;
use crate::vector::kernel::{Kernel, dispatch};
use crate::vector::lane_pair::LanePair;
use crate::vector::lanes::Lanes8;
use bedload_over_time::{OverTime, Quantity};

/// What is the same for all blocks.
#[derive(Clone, Debug, Default)]
pub(super) struct Common {
    pub(super) walls: Vec<Plane>,
    /// Lengths of the periods, m; 0 where there is none.
    pub(super) length: [f64; 3],
    pub(super) law: LinearPair,
    /// Leave the widest vectors unused (tests).
    pub(super) plain: bool,
    /// Gravity, where it changes over time.
    pub(super) gravity: Option<OverTime<[f64; 3]>>,
}

/// Pairs that may come into the lists of a block until the next search, ascending.
#[derive(Clone, Debug, Default)]
pub(super) struct Candidates {
    /// Both rows of the block.
    pub(super) pairs: Vec<(u16, u16)>,
    /// Row of the block, row of the halo.
    pub(super) cross: Vec<(u16, u32)>,
    /// Wall, row of the block.
    pub(super) walls: Vec<(u16, u16)>,
}

/// Rows of another block that a block reads.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Segment {
    pub(super) block: u32,
    /// End of its part of the halo.
    pub(super) end: u32,
}

/// A block without its rows, which other blocks read.
#[derive(Clone, Debug, Default)]
pub(super) struct Block {
    /// Number of its first grain in the order of the engine.
    pub(super) first: u32,
    /// Contacts within the block, with grains of other blocks, which have their own copy, and with walls.
    pub(super) packs: [Vec<ContactPack>; 3],
    /// What may come into these lists.
    pub(super) candidates: Candidates,
    /// Contacts to take instead of those in the lists: these are of another order, or of earlier candidates.
    pub(super) pending: Option<Box<History>>,
    /// Where the grains were when the candidates were searched, m.
    pub(super) origin: Vec<[f64; 3]>,
    /// Largest number of blocks between the partners of a candidate.
    pub(super) reach: usize,
    /// Rows of other blocks that it reads, as numbers within those blocks, block by block.
    pub(super) halo: Vec<u16>,
    /// Whose they are.
    pub(super) segments: Vec<Segment>,
    /// Inverse moments of inertia, 1/(kg m²); one per grain.
    pub(super) inverse_inertia: Vec<f64>,
    /// Masses, kg, where gravity changes over time.
    pub(super) mass: Vec<f64>,
    /// What acts on the grains: one entry for all, or one each.
    pub(super) drive: Vec<BodyForce>,
    /// Grains that forces do not move, ascending.
    pub(super) prescribed: Vec<(u16, Motion)>,
    /// Orientations (w, x, y, z); empty if not asked for.
    pub(super) orientation: Vec<[f64; 4]>,
    pub(super) observed: Observed,
    /// Square of the largest speed after each sub-step of the present batch, m²/s².
    pub(super) speed2: Vec<f64>,
    /// State at the start of the batch.
    pub(super) before: Snapshot,
}

/// What a batch may have to go back to.
#[derive(Clone, Debug, Default)]
pub(super) struct Snapshot {
    rows: Vec<GrainRecord>,
    packs: [Vec<ContactPack>; 3],
    orientation: Vec<[f64; 4]>,
    observed: Observed,
}

/// Memory that a thread works in.
#[derive(Clone, Debug, Default)]
pub(super) struct StepScratch {
    push: Vec<ForceTorque>,
    pub(super) halo: Vec<GrainRecord>,
}

impl Block {
    pub(super) fn len(&self) -> usize {
        self.inverse_inertia.len()
    }

    /// What a sub-step costs, ns or so.
    pub(super) fn work(&self) -> usize {
        let [pairs, cross, walls] = &self.packs;
        15 * self.len() + 120 * (pairs.len() + cross.len()) + 60 * walls.len()
    }

    /// Keeps the state that `rows` hold.
    pub(super) fn keep(&mut self, rows: &[GrainRecord]) {
        let before = &mut self.before;
        before.rows.clear();
        before.rows.extend_from_slice(rows);
        for (to, from) in before.packs.iter_mut().zip(&self.packs) {
            to.clear();
            to.reserve_exact(from.len());
            to.extend_from_slice(from);
        }
        before.orientation.clone_from(&self.orientation);
        before.observed.clone_from(&self.observed);
    }

    /// Goes back to the state kept last.
    pub(super) fn roll_back(&mut self, rows: &mut [GrainRecord]) {
        rows.copy_from_slice(&self.before.rows);
        std::mem::swap(&mut self.packs, &mut self.before.packs);
        std::mem::swap(&mut self.orientation, &mut self.before.orientation);
        std::mem::swap(&mut self.observed, &mut self.before.observed);
    }

    /// One sub-step from `old` to `new`; `scratch.halo` holds the rows of other blocks.
    pub(super) fn step(
        &mut self,
        common: &Common,
        (t, dt): (f64, f64),
        old: &[GrainRecord],
        new: &mut [GrainRecord],
        scratch: &mut StepScratch,
    ) {
        // all empty: the sub-step before has left them so
        scratch.push.resize(self.len() + 1, ForceTorque::default());
        scratch.halo.push(GrainRecord::NONE);
        let step = Step { block: self, common, t, dt, old, new, scratch };
        let mut fastest = dispatch(step, common.plain);
        integrate::follow((t, dt), &self.prescribed, old, new, &mut fastest);
        if !self.orientation.is_empty() {
            integrate::turn((t, dt), &self.prescribed, new, &mut self.orientation);
        }
        self.speed2.push(fastest.speed2());
    }
}

/// The hot part of a sub-step.
struct Step<'a> {
    block: &'a mut Block,
    common: &'a Common,
    t: f64,
    dt: f64,
    old: &'a [GrainRecord],
    new: &'a mut [GrainRecord],
    scratch: &'a mut StepScratch,
}

impl Kernel for Step<'_> {
    type Output = integrate::Fastest;

    #[inline(always)]
    fn run<L: Lanes8>(self, token: L::Token) -> integrate::Fastest {
        let Self { block, common, t, dt, old, new, scratch } = self;
        let law = &LawLanes::<LanePair<L>>::new(token, &common.law, dt);
        let images = Images::<LanePair<L>>::new(token, common.length);
        let (push, halo, observed) = (&mut scratch.push[..], &scratch.halo[..], &mut block.observed);
        let [pairs, cross, walls] = &mut block.packs;
        if L::ONE_REGISTER && common.length == [0.0; 3] {
            pair_forces::<L, false, false>(token, law, &images, pairs, old, old, push, observed);
            pair_forces::<L, false, true>(token, law, &images, cross, old, halo, push, observed);
        } else {
            // where there is no period, nearest images are where they were, and one kernel less is compiled
            pair_forces::<L, true, false>(token, law, &images, pairs, old, old, push, observed);
            pair_forces::<L, true, true>(token, law, &images, cross, old, halo, push, observed);
        }
        wall_forces::<L>(token, (&common.law, &common.walls), (t, dt), walls, old, push, observed);
        for (sum, ForceTorque(p)) in observed.force.iter_mut().zip(&*push) {
            for k in 0..4 {
                sum[k] += p[k];
            }
        }
        let n = block.inverse_inertia.len();
        push[n] = ForceTorque::default(); // where lanes without a grain add their nothing
        if let Some(gravity) = &common.gravity {
            let change = gravity.mean(t, t + dt).plus(-1.0, &gravity.start());
            for (ForceTorque(push), mass) in push.iter_mut().zip(&block.mass) {
                push.iter_mut().zip(change).for_each(|(push, change)| *push += mass * change);
            }
        }
        integrate::advance::<L>(token, dt, old, push, &block.inverse_inertia, &block.drive, new)
    }
}
