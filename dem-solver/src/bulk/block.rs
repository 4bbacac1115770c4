//! A block: some five hundred grains that follow one another in the order of the engine, their
//! contacts, and one sub-step of them.

use super::advance::{self, Drive};
use super::duo::Duo;
use super::lanes::{Eight, Plain};
use super::law::LawLanes;
use super::list::History;
use super::near::Nearby;
use super::pair::{Images, pair_forces};
use super::row::{Pack, Push, Row};
use super::seen::Seen;
use super::wall::{Wall, wall_forces};
use crate::laws::linear::LinearPair;
use crate::spec::Motion;
use pulp::{Simd, WithSimd};

/// What is the same for all blocks.
#[derive(Clone, Debug)]
pub(super) struct Common {
    /// Walls with their laws.
    pub(super) walls: Vec<Wall>,
    /// Lengths of the periods, m; 0 where there is none.
    pub(super) length: [f64; 3],
    /// Law between grains.
    pub(super) law: LinearPair,
    /// Leave the widest vectors unused (tests).
    pub(super) plain: bool,
}

/// Rows of another block that a block reads.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Segment {
    /// The other block.
    pub(super) block: u32,
    /// End of its part of the halo.
    pub(super) end: u32,
}

/// A block without its rows, which other blocks read.
#[derive(Clone, Debug, Default)]
pub(super) struct Block {
    /// Number of its first grain in the order of the engine.
    pub(super) first: u32,
    /// Contacts within the block.
    pub(super) pairs: Vec<Pack>,
    /// Contacts with grains of other blocks, which have their own copy.
    pub(super) cross: Vec<Pack>,
    /// Contacts with walls.
    pub(super) walls: Vec<Pack>,
    /// What may come into these lists.
    pub(super) near: Nearby,
    /// Contacts to take instead of those in the lists: these are of another order, or of what was near before.
    pub(super) seed: Option<Box<History>>,
    /// Where the grains were when what is near was searched, m.
    pub(super) origin: Vec<[f64; 3]>,
    /// Largest number of blocks between the partners of a pair that is near.
    pub(super) reach: usize,
    /// Rows of other blocks that it reads, as numbers within those blocks, block by block.
    pub(super) halo: Vec<u16>,
    /// Whose they are.
    pub(super) segments: Vec<Segment>,
    /// Inverse moments of inertia, 1/(kg m²); one per grain.
    pub(super) inverse_inertia: Vec<f64>,
    /// What acts on the grains: one entry for all, or one each.
    pub(super) drive: Vec<Drive>,
    /// Grains that forces do not move, ascending.
    pub(super) given: Vec<(u16, Motion)>,
    /// Orientations (w, x, y, z); empty if not asked for.
    pub(super) orientation: Vec<[f64; 4]>,
    /// Observations.
    pub(super) seen: Seen,
    /// Square of the largest speed after each sub-step of the present stretch, m²/s².
    pub(super) speed2: Vec<f64>,
    /// State at the start of the stretch.
    pub(super) before: Before,
}

/// What a stretch may have to go back to.
#[derive(Clone, Debug, Default)]
pub(super) struct Before {
    rows: Vec<Row>,
    pairs: Vec<Pack>,
    cross: Vec<Pack>,
    walls: Vec<Pack>,
    orientation: Vec<[f64; 4]>,
    seen: Seen,
}

/// Memory that a thread works in.
#[derive(Clone, Debug, Default)]
pub(super) struct Bench {
    push: Vec<Push>,
    pub(super) halo: Vec<Row>,
}

impl Block {
    /// Number of its grains.
    pub(super) fn len(&self) -> usize {
        self.inverse_inertia.len()
    }

    /// What a sub-step costs, ns or so.
    pub(super) fn work(&self) -> usize {
        15 * self.len() + 120 * (self.pairs.len() + self.cross.len()) + 60 * self.walls.len()
    }

    /// Keeps the state that `rows` hold.
    pub(super) fn keep(&mut self, rows: &[Row]) {
        let before = &mut self.before;
        before.rows.clear();
        before.rows.extend_from_slice(rows);
        for (to, from) in [
            (&mut before.pairs, &self.pairs),
            (&mut before.cross, &self.cross),
            (&mut before.walls, &self.walls),
        ] {
            to.clear();
            to.reserve_exact(from.len());
            to.extend_from_slice(from);
        }
        before.orientation.clone_from(&self.orientation);
        before.seen.clone_from(&self.seen);
    }

    /// Goes back to the state kept last.
    pub(super) fn go_back(&mut self, rows: &mut [Row]) {
        rows.copy_from_slice(&self.before.rows);
        std::mem::swap(&mut self.pairs, &mut self.before.pairs);
        std::mem::swap(&mut self.cross, &mut self.before.cross);
        std::mem::swap(&mut self.walls, &mut self.before.walls);
        std::mem::swap(&mut self.orientation, &mut self.before.orientation);
        std::mem::swap(&mut self.seen, &mut self.before.seen);
    }

    /// One sub-step from `old` to `new`; `bench.halo` holds the rows of other blocks.
    pub(super) fn step(
        &mut self,
        common: &Common,
        (t, dt): (f64, f64),
        old: &[Row],
        new: &mut [Row],
        bench: &mut Bench,
    ) {
        // all empty: the sub-step before has left them so
        bench.push.resize(self.len() + 1, Push::default());
        bench.halo.push(Row::NONE);
        self.seen.contacts = 0;
        let mut fastest = Step { block: self, common, t, dt, old, new, bench }.dispatch();
        advance::follow((t, dt), &self.given, old, new, &mut fastest);
        if !self.orientation.is_empty() {
            advance::turn((t, dt), &self.given, new, &mut self.orientation);
        }
        self.speed2.push(fastest.speed2());
    }
}

/// The hot part of a sub-step, compiled for every vector width.
struct Step<'a> {
    block: &'a mut Block,
    common: &'a Common,
    t: f64,
    dt: f64,
    old: &'a [Row],
    new: &'a mut [Row],
    bench: &'a mut Bench,
}

impl Step<'_> {
    fn dispatch(self) -> advance::Fastest {
        #[cfg(target_arch = "x86_64")]
        if !self.common.plain
            && let Some(simd) = pulp::x86::V4::try_new()
        {
            return Simd::vectorize(simd, OnWide(self, simd));
        }
        #[cfg(target_arch = "x86_64")]
        if let Some(simd) = pulp::x86::V3::try_new() {
            return Simd::vectorize(simd, OnPlain(self));
        }
        #[cfg(target_arch = "x86_64")]
        return OnPlain(self).with_simd(pulp::Scalar);
        #[cfg(not(target_arch = "x86_64"))]
        pulp::Arch::new().dispatch(OnPlain(self))
    }

    /// One sub-step. With `ALWAYS`, nearest images are looked for where there is no period, too: they are
    /// where they were, and one kernel less is compiled.
    #[inline(always)]
    fn run<L: Eight, const ALWAYS: bool>(self, token: L::Token) -> advance::Fastest {
        let Self { block, common, t, dt, old, new, bench } = self;
        let law = LawLanes::<Duo<L>>::new(token, &common.law, dt);
        let images = Images::<Duo<L>>::new(token, common.length);
        let (push, halo, seen) = (&mut bench.push[..], &bench.halo[..], &mut block.seen);
        if !ALWAYS && common.length == [0.0; 3] {
            pair_forces::<L, false, false>(token, &law, &images, &mut block.pairs, old, old, push, seen);
            pair_forces::<L, false, true>(token, &law, &images, &mut block.cross, old, halo, push, seen);
        } else {
            pair_forces::<L, true, false>(token, &law, &images, &mut block.pairs, old, old, push, seen);
            pair_forces::<L, true, true>(token, &law, &images, &mut block.cross, old, halo, push, seen);
        }
        wall_forces::<L>(token, &common.walls, (t, dt), &mut block.walls, old, push, seen);
        for (sum, Push(p)) in seen.force.iter_mut().zip(&*push) {
            for k in 0..4 {
                sum[k] += p[k];
            }
        }
        let n = block.inverse_inertia.len();
        push[n] = Push::default(); // where lanes without a grain add their nothing
        advance::advance::<L>(token, dt, old, push, &block.inverse_inertia, &block.drive, new)
    }
}

#[cfg(target_arch = "x86_64")]
struct OnWide<'a>(Step<'a>, pulp::x86::V4);

#[cfg(target_arch = "x86_64")]
impl WithSimd for OnWide<'_> {
    type Output = advance::Fastest;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> Self::Output {
        self.0.run::<super::wide::Wide, false>(self.1)
    }
}

struct OnPlain<'a>(Step<'a>);

impl WithSimd for OnPlain<'_> {
    type Output = advance::Fastest;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> Self::Output {
        self.0.run::<Plain, true>(())
    }
}
