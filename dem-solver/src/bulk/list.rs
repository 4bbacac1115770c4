//! The lists of one block: which contacts it has, and the springs that they bring along.
//!
//! A list holds every pair whose gap is below the skin; it is taken from the pairs that `near` has found. Contacts stand in the order (i, j) of the engine,
//! and those out of reach add nothing, so sums do not depend on when a list was built.

use super::block::Block;
use super::near::Scratch;
use super::row::{Kept, Pack, Row};
use super::skin::Skin;
use super::wall::Wall;
use crate::Vec3;
use crate::laws::walls::Plane;

/// Contacts with their history: within the block, with other blocks, with walls; by (i, j) ascending.
pub(super) type History = [Vec<Kept>; 3];

/// Memory for building lists.
#[derive(Clone, Debug, Default)]
pub(super) struct Builder {
    history: History,
    /// Rows of other blocks.
    pub(super) halo: Vec<Row>,
    /// Half the skins of their blocks, m.
    halves: Vec<f64>,
    pub(super) search: Scratch,
}

/// What a build found.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Listed {
    /// Contacts listed.
    pub(super) pairs: usize,
    /// Of these, with a force.
    pub(super) touching: usize,
}

impl Listed {
    /// Adds another block's.
    pub(super) fn add(&mut self, other: &Self) {
        self.pairs += other.pairs;
        self.touching += other.touching;
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
            // not twice the room: packs are a good part of all memory
            if self.packs.len() == self.packs.capacity() {
                self.packs.reserve_exact(self.packs.len() / 8 + 8);
            }
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

    /// Keeps the contacts of the lists for the next ones, before what they are named by changes.
    pub(super) fn keep_contacts(&mut self, size: u32) {
        if self.seed.is_none() {
            let mut history = Box::default();
            self.history(size, false, &mut history);
            self.seed = Some(history);
        }
    }

    /// Contacts that bear a force with grains of the blocks before `end`.
    pub(super) fn touching_any_below(&self, end: u32) -> usize {
        let below = self.segments.partition_point(|segment| segment.block < end);
        let Some(last) = self.segments[..below].last() else { return 0 };
        let of =
            |pack: &Pack| (0..8).filter(|&k| pack.touching >> k & 1 == 1 && pack.j[k] < last.end).count();
        self.cross.iter().map(of).sum()
    }

    /// Empties all lists.
    pub(super) fn forget(&mut self) {
        self.near = Default::default();
        for packs in [&mut self.pairs, &mut self.cross, &mut self.walls] {
            *packs = Vec::new();
        }
        (self.halo, self.segments) = (Vec::new(), Vec::new());
        self.seen.clear(0);
    }

    /// Number in the order of the engine of row `slot` of the halo.
    pub(super) fn halo_number(&self, slot: u32, size: u32) -> u32 {
        let segment = self.segments.partition_point(|segment| segment.end <= slot);
        self.segments[segment].block * size + u32::from(self.halo[slot as usize])
    }

    /// Builds all lists of the block from the pairs that are near: `builder.halo` holds the rows of other
    /// blocks.
    pub(super) fn build(&mut self, reach: &Reach<'_>, rows: &[Row], builder: &mut Builder) -> Listed {
        let mut history = std::mem::take(&mut builder.history);
        match self.seed.take() {
            Some(seed) => history = *seed,
            None => self.history(reach.size, false, &mut history),
        }
        let mut halves = std::mem::take(&mut builder.halves);
        halves.clear();
        for segment in &self.segments {
            halves.resize(segment.end as usize, 0.5 * reach.skins[segment.block as usize].width);
        }
        let skin = reach.skins[(self.first / reach.size) as usize].width;
        let mut listed = Listed::default();
        self.build_pairs(reach, skin, rows, &history[0], &mut listed);
        self.build_cross(reach, skin, rows, (&builder.halo, &halves), &history[1], &mut listed);
        self.build_walls(reach, skin, rows, &history[2]);
        (builder.history, builder.halves) = (history, halves);
        listed
    }

    /// Pairs within the block.
    fn build_pairs(
        &mut self,
        reach: &Reach<'_>,
        skin: f64,
        rows: &[Row],
        history: &[Kept],
        listed: &mut Listed,
    ) {
        let n = self.len();
        let mut filling = Filling::new(&mut self.pairs, (n as u16, n as u32), history);
        for &(i, j) in &self.near.pairs {
            if reach.holds(skin, &rows[usize::from(i)], &rows[usize::from(j)]) {
                let key = (u32::from(i), self.first + u32::from(j));
                listed.pairs += 2;
                listed.touching += 2 * usize::from(filling.put(i, u32::from(j), 0, key));
            }
        }
        filling.end();
    }

    /// Pairs with other blocks.
    fn build_cross(
        &mut self,
        reach: &Reach<'_>,
        skin: f64,
        rows: &[Row],
        (halo, halves): (&[Row], &[f64]),
        history: &[Kept],
        listed: &mut Listed,
    ) {
        let mut packs = std::mem::take(&mut self.cross);
        let none = (self.len() as u16, self.halo.len() as u32);
        let mut filling = Filling::new(&mut packs, none, history);
        for &(i, slot) in &self.near.cross {
            let skin = 0.5 * skin + halves[slot as usize];
            if reach.holds(skin, &rows[usize::from(i)], &halo[slot as usize]) {
                let key = (u32::from(i), self.halo_number(slot, reach.size));
                listed.pairs += 1;
                listed.touching += usize::from(filling.put(i, slot, 0, key));
            }
        }
        filling.end();
        self.cross = packs;
    }

    /// Grains at walls, wall by wall.
    fn build_walls(&mut self, reach: &Reach<'_>, skin: f64, rows: &[Row], history: &[Kept]) {
        let none = (self.len() as u16, 0);
        let mut filling = Filling::new(&mut self.walls, none, &[]);
        let mut at = u16::MAX;
        for &(w, i) in &self.near.walls {
            let plane = reach.walls[usize::from(w)].plane();
            if w != at {
                at = w;
                filling.lane = 8;
                let from = history.partition_point(|kept| kept.j < u32::from(w));
                let to = history.partition_point(|kept| kept.j <= u32::from(w));
                filling.history = history[from..to].iter().peekable();
            }
            if plane.stands(reach.t) && wall_gap(plane, reach.t, &rows[usize::from(i)]) < skin {
                filling.put(i, 0, w, (u32::from(i), u32::from(w)));
            }
        }
    }
}

/// What is listed: gaps below a skin.
pub(super) struct Reach<'a> {
    /// Skins of the blocks.
    pub(super) skins: &'a [Skin],
    /// Lengths of the periods, m; 0 where there is none.
    pub(super) length: [f64; 3],
    /// Time, s.
    pub(super) t: f64,
    /// Grains per block.
    pub(super) size: u32,
    /// Walls.
    pub(super) walls: &'a [Wall],
}

impl Reach<'_> {
    #[inline]
    fn holds(&self, skin: f64, a: &Row, b: &Row) -> bool {
        let (x, y) = (a.position(), b.position());
        let mut distance2 = 0.0;
        for axis in 0..3 {
            let (mut d, length) = (x[axis] - y[axis], self.length[axis]);
            if length > 0.0 {
                d -= length * (d / length).round();
            }
            distance2 += d * d;
        }
        let limit = a.radius() + b.radius() + skin;
        distance2 < limit * limit
    }
}

/// Gap of a grain to a wall, m.
pub(super) fn wall_gap(plane: &Plane, t: f64, row: &Row) -> f64 {
    let level = plane.normal.dot(&plane.point) + plane.velocity.dot(&plane.normal) * t;
    plane.normal.dot(&Vec3::from(row.position())) - level - row.radius()
}
