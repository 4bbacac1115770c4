//! The lists of one block: which contacts it has, and the springs of these contacts.
//!
//! A list holds every pair whose gap is below the skin; it is taken from the candidates. Contacts stand in the order (i, j) of the engine,
//! and those out of reach add nothing, so sums do not depend on when a list was built.

use crate::bulk::block::Block;
use crate::bulk::block_search::Scratch;
use crate::bulk::records::{ContactPack, GrainRecord, History, SavedSpring};
use crate::bulk::skins::{Listed, Skin};
use crate::bulk::wall::Wall;
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
    fn put(&mut self, i: u16, j: u32, wall: u16, key: (u32, u32)) -> bool {
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
    pub(super) fn history(&self, size: u32, all: bool, history: &mut History) {
        let [pairs, cross, walls] = history;
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
        touching(&self.pairs, pairs, &|pack, lane| self.first + pack.j[lane]);
        touching(&self.cross, cross, &|pack, lane| self.halo_number(pack.j[lane], size));
        touching(&self.walls, walls, &|pack, _| u32::from(pack.wall));
        walls.sort_unstable_by_key(|kept| (kept.j, kept.i));
    }

    /// Keeps the contacts of the lists for the next ones, before what they are named by changes.
    pub(super) fn save_history(&mut self, size: u32) {
        if self.pending.is_none() {
            let mut history = Box::default();
            self.history(size, false, &mut history);
            self.pending = Some(history);
        }
    }

    /// Contacts that bear a force with grains of the blocks before `end`.
    pub(super) fn touching_any_below(&self, end: u32) -> usize {
        let below = self.segments.partition_point(|segment| segment.block < end);
        let Some(last) = self.segments[..below].last() else { return 0 };
        let of = |pack: &ContactPack| {
            (0..8).filter(|&k| pack.touching >> k & 1 == 1 && pack.j[k] < last.end).count()
        };
        self.cross.iter().map(of).sum()
    }

    /// Empties all lists.
    pub(super) fn forget(&mut self) {
        self.candidates = Default::default();
        for packs in [&mut self.pairs, &mut self.cross, &mut self.walls] {
            *packs = Vec::new();
        }
        (self.halo, self.segments) = (Vec::new(), Vec::new());
        self.observed.clear(0);
    }

    /// Number in the order of the engine of row `slot` of the halo.
    pub(super) fn halo_number(&self, slot: u32, size: u32) -> u32 {
        let segment = self.segments.partition_point(|segment| segment.end <= slot);
        self.segments[segment].block * size + u32::from(self.halo[slot as usize])
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
            None => self.history(reach.size, false, &mut history),
        }
        let mut halves = std::mem::take(&mut scratch.halves);
        halves.clear();
        for segment in &self.segments {
            halves.resize(segment.end as usize, 0.5 * reach.skins[segment.block as usize].width);
        }
        let skin = reach.skins[(self.first / reach.size) as usize].width;
        let mut listed = Listed::default();
        self.build_pairs(reach, skin, rows, &history[0], &mut listed);
        self.build_cross(reach, skin, rows, (&scratch.halo, &halves), &history[1], &mut listed);
        self.build_walls(reach, skin, rows, &history[2]);
        (scratch.history, scratch.halves) = (history, halves);
        listed
    }

    /// Pairs within the block.
    fn build_pairs(
        &mut self,
        reach: &ListReach<'_>,
        skin: f64,
        rows: &[GrainRecord],
        history: &[SavedSpring],
        listed: &mut Listed,
    ) {
        let n = self.len();
        let mut writer = PackWriter::new(&mut self.pairs, (n as u16, n as u32), history);
        for &(i, j) in &self.candidates.pairs {
            if reach.is_near(skin, &rows[usize::from(i)], &rows[usize::from(j)]) {
                let key = (u32::from(i), self.first + u32::from(j));
                listed.pairs += 2;
                listed.touching += 2 * usize::from(writer.put(i, u32::from(j), 0, key));
            }
        }
        writer.end();
    }

    /// Pairs with other blocks.
    fn build_cross(
        &mut self,
        reach: &ListReach<'_>,
        skin: f64,
        rows: &[GrainRecord],
        (halo, halves): (&[GrainRecord], &[f64]),
        history: &[SavedSpring],
        listed: &mut Listed,
    ) {
        let mut packs = std::mem::take(&mut self.cross);
        let none = (self.len() as u16, self.halo.len() as u32);
        let mut writer = PackWriter::new(&mut packs, none, history);
        for &(i, slot) in &self.candidates.cross {
            let skin = 0.5 * skin + halves[slot as usize];
            if reach.is_near(skin, &rows[usize::from(i)], &halo[slot as usize]) {
                let key = (u32::from(i), self.halo_number(slot, reach.size));
                listed.pairs += 1;
                listed.touching += usize::from(writer.put(i, slot, 0, key));
            }
        }
        writer.end();
        self.cross = packs;
    }

    /// Grains at walls, wall by wall.
    fn build_walls(
        &mut self,
        reach: &ListReach<'_>,
        skin: f64,
        rows: &[GrainRecord],
        history: &[SavedSpring],
    ) {
        let none = (self.len() as u16, 0);
        let mut writer = PackWriter::new(&mut self.walls, none, &[]);
        let mut at = u16::MAX;
        for &(w, i) in &self.candidates.walls {
            let plane = &reach.walls[usize::from(w)].plane;
            if w != at {
                at = w;
                writer.lane = 8;
                let from = history.partition_point(|kept| kept.j < u32::from(w));
                let to = history.partition_point(|kept| kept.j <= u32::from(w));
                writer.history = history[from..to].iter().peekable();
            }
            if plane.stands(reach.t) && rows[usize::from(i)].gap(plane, reach.t) < skin {
                writer.put(i, 0, w, (u32::from(i), u32::from(w)));
            }
        }
    }
}

/// What is listed: gaps below a skin.
pub(super) struct ListReach<'a> {
    /// Skins of the blocks.
    pub(super) skins: &'a [Skin],
    /// Periodic directions.
    pub(super) periods: Periods,
    /// Time, s.
    pub(super) t: f64,
    /// Grains per block.
    pub(super) size: u32,
    /// Walls.
    pub(super) walls: &'a [Wall],
}

impl ListReach<'_> {
    #[inline]
    fn is_near(&self, skin: f64, a: &GrainRecord, b: &GrainRecord) -> bool {
        let apart = self.periods.nearest(Vec3::from(a.position()) - Vec3::from(b.position()));
        let limit = a.radius() + b.radius() + skin;
        apart.norm_squared() < limit * limit
    }
}
