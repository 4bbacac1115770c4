//! The lists of one block: which contacts it has, and the springs that they bring along.
//!
//! A list holds every pair whose gap is below the skin. Contacts stand in the order (i, j) of the engine,
//! and those out of reach add nothing, so sums do not depend on when a list was built.

use super::bins::Bins;
use super::block::{Block, Common, Segment};
use super::near::Near;
use super::row::{Kept, Pack, Row};

/// Contacts with their history: within the block, with other blocks, with walls; by (i, j) ascending.
pub(super) type History = [Vec<Kept>; 3];

/// Memory for building lists.
#[derive(Clone, Debug, Default)]
pub(super) struct Builder {
    history: History,
    pub(super) found: Vec<u32>,
    /// Pairs within the block: row, and number in the order of the engine.
    pub(super) inner: Vec<(u16, u32)>,
    /// Pairs with other blocks.
    pub(super) cross: Vec<(u16, u32)>,
    halo: Vec<u32>,
    /// Place of a grain in the halo, where it has one.
    slot: Vec<u32>,
}

/// What a build goes by.
pub(super) struct Search<'a> {
    pub(super) bins: &'a Bins,
    /// Gap below which a pair is listed, m.
    pub(super) skin: f64,
    /// Lengths of the periods, m; 0 where there is none.
    pub(super) length: [f64; 3],
    /// Time, s.
    pub(super) t: f64,
    /// Grains per block.
    pub(super) size: u32,
    /// Grains.
    pub(super) grains: usize,
}

/// What a build found.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Listed {
    /// Contacts listed.
    pub(super) pairs: usize,
    /// Of these, with a force.
    pub(super) touching: usize,
    /// Largest number of blocks between the partners of a contact.
    pub(super) reach: usize,
}

impl Listed {
    /// Adds another block's.
    pub(super) fn add(&mut self, other: &Self) {
        self.pairs += other.pairs;
        self.touching += other.touching;
        self.reach = self.reach.max(other.reach);
    }
}

/// Appends contacts to packs.
struct Filling<'a> {
    packs: &'a mut Vec<Pack>,
    none: (u16, u32),
    lane: usize,
    history: std::iter::Peekable<std::slice::Iter<'a, Kept>>,
}

impl<'a> Filling<'a> {
    fn new(packs: &'a mut Vec<Pack>, none: (u16, u32), history: &'a [Kept]) -> Self {
        packs.clear();
        Self { packs, none, lane: 8, history: history.iter().peekable() }
    }

    /// Ends the list. Packs are taken by twos.
    fn end(self) {
        if self.packs.len() % 2 == 1 {
            self.packs.push(Pack::empty(self.none.0, self.none.1, 0));
        }
    }

    /// Appends contact (i, j), which is `key` in the history; returns whether it touches.
    #[inline]
    fn put(&mut self, i: u16, j: u32, wall: u16, key: (u32, u32)) -> bool {
        if self.lane == 8 {
            self.packs.push(Pack::empty(self.none.0, self.none.1, wall));
            self.lane = 0;
        }
        while self.history.next_if(|kept| (kept.i, kept.j) < key).is_some() {}
        let lane = self.lane;
        self.lane += 1;
        let Some(pack) = self.packs.last_mut() else { return false };
        (pack.i[lane], pack.j[lane]) = (i, j);
        let Some(kept) = self.history.next_if(|kept| (kept.i, kept.j) == key) else { return false };
        for axis in 0..3 {
            pack.spring[axis][lane] = kept.spring[axis];
        }
        pack.touching |= 1 << lane;
        true
    }
}

impl Block {
    /// Contacts with their springs: those that bear a force, or `all` that are listed.
    pub(super) fn history(&self, size: u32, all: bool, history: &mut History) {
        let [pairs, cross, walls] = history;
        let touching = |packs: &[Pack], to: &mut Vec<Kept>, number: &dyn Fn(&Pack, usize) -> u32| {
            to.clear();
            for pack in packs {
                let mut rest = if all { pack.filled(self.len()) } else { pack.touching };
                while rest != 0 {
                    let lane = rest.trailing_zeros() as usize;
                    rest &= rest - 1;
                    let (i, j) = (u32::from(pack.i[lane]), number(pack, lane));
                    to.push(Kept { i, j, spring: pack.spring(lane) });
                }
            }
        };
        touching(&self.pairs, pairs, &|pack, lane| self.first + pack.j[lane]);
        touching(&self.cross, cross, &|pack, lane| self.halo_number(pack.j[lane], size));
        touching(&self.walls, walls, &|pack, _| u32::from(pack.wall));
        walls.sort_unstable_by_key(|kept| (kept.j, kept.i));
    }

    /// Number in the order of the engine of row `slot` of the halo.
    pub(super) fn halo_number(&self, slot: u32, size: u32) -> u32 {
        let segment = self.segments.partition_point(|segment| segment.end <= slot);
        self.segments[segment].block * size + u32::from(self.halo[slot as usize])
    }

    /// Builds all lists of the block. `seed` replaces the history that the present lists hold.
    pub(super) fn build(
        &mut self,
        search: &Search<'_>,
        common: &Common,
        rows: &[Row],
        builder: &mut Builder,
        seed: Option<&History>,
    ) -> Listed {
        let mut history = std::mem::take(&mut builder.history);
        match seed {
            Some(seed) => history.clone_from(seed),
            None => self.history(search.size, false, &mut history),
        }
        let (rows, mut listed) = (&rows[..self.len()], Listed::default());
        Near { search, first: self.first, rows, builder, plain: common.plain }.find();
        self.build_pairs(builder, &history[0], &mut listed);
        self.build_halo(search, builder, &mut listed);
        self.build_cross(builder, &history[1], &mut listed);
        self.build_walls(search, common, rows, &history[2]);
        builder.history = history;
        listed
    }

    /// Pairs within the block.
    fn build_pairs(&mut self, builder: &Builder, history: &[Kept], listed: &mut Listed) {
        let n = self.len();
        let mut filling = Filling::new(&mut self.pairs, (n as u16, n as u32), history);
        for &(i, j) in &builder.inner {
            let touches = filling.put(i, j - self.first, 0, (u32::from(i), j));
            listed.touching += 2 * usize::from(touches);
        }
        filling.end();
        listed.pairs += 2 * builder.inner.len();
    }

    /// The rows of other blocks that are read.
    fn build_halo(&mut self, search: &Search<'_>, builder: &mut Builder, listed: &mut Listed) {
        let Builder { cross, halo, slot, .. } = builder;
        slot.resize(search.grains, u32::MAX);
        halo.clear();
        for &(_, j) in &*cross {
            if slot[j as usize] == u32::MAX {
                slot[j as usize] = 0;
                halo.push(j);
            }
        }
        halo.sort_unstable();
        self.halo.clear();
        self.segments.clear();
        let here = self.first / search.size;
        for (k, &j) in (0u32..).zip(&*halo) {
            slot[j as usize] = k;
            let block = j / search.size;
            self.halo.push((j - block * search.size) as u16);
            match self.segments.last_mut() {
                Some(segment) if segment.block == block => segment.end = k + 1,
                _ => {
                    self.segments.push(Segment { block, end: k + 1 });
                    listed.reach = listed.reach.max(block.abs_diff(here) as usize);
                }
            }
        }
    }

    /// Pairs with other blocks; leaves `builder.slot` empty.
    fn build_cross(&mut self, builder: &mut Builder, history: &[Kept], listed: &mut Listed) {
        let Builder { cross, halo, slot, .. } = builder;
        let none = (self.len() as u16, halo.len() as u32);
        let mut filling = Filling::new(&mut self.cross, none, history);
        for &(i, j) in &*cross {
            let touches = filling.put(i, slot[j as usize], 0, (u32::from(i), j));
            listed.touching += usize::from(touches);
        }
        filling.end();
        listed.pairs += cross.len();
        for &j in &*halo {
            slot[j as usize] = u32::MAX;
        }
    }

    /// Grains near walls, wall by wall.
    fn build_walls(&mut self, search: &Search<'_>, common: &Common, rows: &[Row], history: &[Kept]) {
        let n = self.len();
        let none = (n as u16, 0);
        let mut filling = Filling::new(&mut self.walls, none, &[]);
        for (w, wall) in (0u16..).zip(&common.walls) {
            let plane = wall.plane();
            filling.lane = 8;
            let from = history.partition_point(|kept| kept.j < u32::from(w));
            let to = history.partition_point(|kept| kept.j <= u32::from(w));
            filling.history = history[from..to].iter().peekable();
            if !plane.stands(search.t) {
                continue;
            }
            let normal: [f64; 3] = plane.normal.into();
            let level = plane.normal.dot(&plane.point) + plane.velocity.dot(&plane.normal) * search.t;
            for (i, row) in rows.iter().enumerate() {
                let [x, y, z] = row.position();
                let gap = x * normal[0] + y * normal[1] + z * normal[2] - level - row.radius();
                if gap < search.skin && row.inverse_mass() > 0.0 {
                    filling.put(i as u16, 0, w, (i as u32, u32::from(w)));
                }
            }
        }
    }
}
