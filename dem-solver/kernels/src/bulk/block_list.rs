//! The lists of one block: which contacts it has, and the springs of these contacts.
//!
//! A list holds every pair whose gap is below the skin; it is taken from the candidates. Contacts stand in
//! the order (i, j) of the engine, and those out of reach add nothing, so sums do not depend on when a list
//! was built.

use crate::bulk::block::Block;
use crate::bulk::block_search::Scratch;
use crate::bulk::records::{ContactPack, GrainRecord, History, SIZE, SavedSpring};
use crate::bulk::skins::{Listed, Skin};
use crate::laws::walls::Plane;
use crate::motion::Vec3;
use crate::periods::Periods;

/// Memory for building lists.
#[derive(Clone, Debug, Default)]
pub(super) struct ListScratch {
    history: History,
    /// Rows of other blocks.
    pub(super) halo: Vec<GrainRecord>,
    /// Half the skins of their blocks, m.
    halves: Vec<f64>,
    pub(super) search: Scratch,
}

/// Appends contacts to packs.
struct PackWriter<'a> {
    packs: &'a mut Vec<ContactPack>,
    none: (u16, u32),
    lane: usize,
    history: std::iter::Peekable<std::slice::Iter<'a, SavedSpring>>,
}

impl<'a> PackWriter<'a> {
    fn new(packs: &'a mut Vec<ContactPack>, none: (u16, u32), history: &'a [SavedSpring]) -> Self {
        packs.clear();
        Self { packs, none, lane: 8, history: history.iter().peekable() }
    }

    /// Ends the list. Packs are taken by twos.
    fn end(self) {
        if self.packs.len() % 2 == 1 {
            self.packs.push(ContactPack::empty(self.none.0, self.none.1, 0));
        }
    }

    /// Appends contact (i, j), which is `key` in the history; returns whether it touches.
    #[inline]
    fn put(&mut self, (i, j): (u16, u32), wall: u16, key: (u32, u32)) -> bool {
        if self.lane == 8 {
            // not twice the room: packs are a good part of all memory
            if self.packs.len() == self.packs.capacity() {
                self.packs.reserve_exact(self.packs.len() / 8 + 8);
            }
            self.packs.push(ContactPack::empty(self.none.0, self.none.1, wall));
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
    pub(super) fn history(&self, all: bool, history: &mut History) {
        let [pairs, cross, walls] = &self.packs;
        let touching = |packs: &[ContactPack],
                        to: &mut Vec<SavedSpring>,
                        number: &dyn Fn(&ContactPack, usize) -> u32| {
            to.clear();
            for pack in packs {
                let mut rest = if all { pack.filled(self.len()) } else { pack.touching };
                while rest != 0 {
                    let lane = rest.trailing_zeros() as usize;
                    rest &= rest - 1;
                    let (i, j) = (u32::from(pack.i[lane]), number(pack, lane));
                    to.push(SavedSpring { i, j, spring: pack.spring(lane) });
                }
            }
        };
        touching(pairs, &mut history[0], &|pack, lane| self.first + pack.j[lane]);
        touching(cross, &mut history[1], &|pack, lane| self.halo_number(pack.j[lane]));
        touching(walls, &mut history[2], &|pack, _| u32::from(pack.wall));
        history[2].sort_unstable_by_key(|kept| (kept.j, kept.i));
    }

    /// Keeps the contacts of the lists for the next ones, before what they are named by changes.
    pub(super) fn save_history(&mut self) {
        if self.pending.is_none() {
            let mut history = Box::default();
            self.history(false, &mut history);
            self.pending = Some(history);
        }
    }

    /// Empties all lists.
    pub(super) fn forget(&mut self) {
        self.candidates = Default::default();
        self.packs = Default::default();
        (self.halo, self.segments) = (Vec::new(), Vec::new());
        self.observed.clear(0, 0);
    }

    /// Number in the order of the engine of row `slot` of the halo.
    pub(super) fn halo_number(&self, slot: u32) -> u32 {
        let segment = self.segments.partition_point(|segment| segment.end <= slot);
        self.segments[segment].block * SIZE as u32 + u32::from(self.halo[slot as usize])
    }

    /// Builds all lists of the block from the candidates: `scratch.halo` holds the rows of other
    /// blocks.
    pub(super) fn build(
        &mut self,
        reach: &ListReach<'_>,
        rows: &[GrainRecord],
        scratch: &mut ListScratch,
    ) -> Listed {
        let mut history = std::mem::take(&mut scratch.history);
        match self.pending.take() {
            Some(pending) => history = *pending,
            None => self.history(false, &mut history),
        }
        let mut halves = std::mem::take(&mut scratch.halves);
        halves.clear();
        for segment in &self.segments {
            halves.resize(segment.end as usize, 0.5 * reach.skins[segment.block as usize].width);
        }
        let mut packs = std::mem::take(&mut self.packs);
        let skin = reach.skins[self.first as usize / SIZE].width;
        let (build, [pairs, cross, walls]) = (ListBuild { block: self, reach, skin, rows }, &mut packs);
        let mut listed = Listed::default();
        build.pairs(pairs, &history[0], &mut listed);
        build.cross(cross, (&scratch.halo, &halves), &history[1], &mut listed);
        build.walls(walls, &history[2]);
        (scratch.history, scratch.halves, self.packs) = (history, halves, packs);
        listed
    }
}

/// What the lists of a block are made of.
struct ListBuild<'a> {
    block: &'a Block,
    reach: &'a ListReach<'a>,
    /// Skin of the block, m.
    skin: f64,
    rows: &'a [GrainRecord],
}

impl ListBuild<'_> {
    /// Pairs within the block.
    fn pairs(&self, packs: &mut Vec<ContactPack>, history: &[SavedSpring], listed: &mut Listed) {
        let (n, rows) = (self.block.len(), self.rows);
        let mut writer = PackWriter::new(packs, (n as u16, n as u32), history);
        for &(i, j) in &self.block.candidates.pairs {
            if self.reach.is_near(self.skin, &rows[usize::from(i)], &rows[usize::from(j)]) {
                let key = (u32::from(i), self.block.first + u32::from(j));
                listed.pairs += 2;
                listed.touching += 2 * usize::from(writer.put((i, u32::from(j)), 0, key));
            }
        }
        writer.end();
    }

    /// Pairs with other blocks, whose rows and half skins are those of the halo.
    fn cross(
        &self,
        packs: &mut Vec<ContactPack>,
        (halo, halves): (&[GrainRecord], &[f64]),
        history: &[SavedSpring],
        listed: &mut Listed,
    ) {
        let block = self.block;
        let mut writer = PackWriter::new(packs, (block.len() as u16, block.halo.len() as u32), history);
        for &(i, slot) in &block.candidates.cross {
            let skin = 0.5 * self.skin + halves[slot as usize];
            if self.reach.is_near(skin, &self.rows[usize::from(i)], &halo[slot as usize]) {
                let key = (u32::from(i), block.halo_number(slot));
                listed.pairs += 1;
                listed.touching += usize::from(writer.put((i, slot), 0, key));
            }
        }
        writer.end();
    }

    /// Grains at walls, wall by wall.
    fn walls(&self, packs: &mut Vec<ContactPack>, history: &[SavedSpring]) {
        let mut writer = PackWriter::new(packs, (self.block.len() as u16, 0), &[]);
        let mut at = u16::MAX;
        for &(w, i) in &self.block.candidates.walls {
            let plane = &self.reach.walls[usize::from(w)];
            if w != at {
                at = w;
                writer.lane = 8;
                let from = history.partition_point(|kept| kept.j < u32::from(w));
                let to = history.partition_point(|kept| kept.j <= u32::from(w));
                writer.history = history[from..to].iter().peekable();
            }
            let near = self.rows[usize::from(i)].gap(plane, self.reach.t) < self.skin;
            if plane.stands(self.reach.t) && near {
                writer.put((i, 0), w, (u32::from(i), u32::from(w)));
            }
        }
    }
}

/// What is listed: gaps below a skin.
pub(super) struct ListReach<'a> {
    pub(super) skins: &'a [Skin],
    pub(super) periods: Periods,
    /// Time, s.
    pub(super) t: f64,
    pub(super) walls: &'a [Plane],
}

impl ListReach<'_> {
    #[inline]
    fn is_near(&self, skin: f64, a: &GrainRecord, b: &GrainRecord) -> bool {
        let apart = self.periods.nearest(Vec3::from(a.position()) - Vec3::from(b.position()));
        let limit = a.radius() + b.radius() + skin;
        apart.norm_squared() < limit * limit
    }
}
