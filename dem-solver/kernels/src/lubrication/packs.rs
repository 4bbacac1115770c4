//! Films that act, eight to a pack: no two of a pack share a grain that can move, so that a vector may visit
//! them at once.
//!
//! Films go through the order of the lists, each into the first of 64 classes that holds neither of its
//! grains; a class is cut into packs. So the packs follow from the films that act and from nothing else.

use crate::lubrication::film_list::{FilmList, Key};
use crate::lubrication::rows::Rows;

/// Classes; what finds none gets a pack of its own.
const CLASSES: usize = 64;

/// Eight films that act: what sweeps read and change.
#[derive(Clone, Copy, Debug, Default)]
#[repr(C, align(64))]
pub(super) struct FilmPack {
    /// Normals, from the second to the first, as [`crate::vector::rows::pairs`]; zeros behind.
    pub(super) normal: [[f64; 8]; 4],
    /// Inverse masses of the partners.
    pub(super) weight: [[f64; 8]; 2],
    /// … and of both along the normal.
    pub(super) inverse_mass: [f64; 8],
    /// path = c₁ y + c₂ y² + c₃ y³ + c₄ y⁴, N s ([`crate::lubrication::visit`]).
    pub(super) c: [[f64; 8]; 4],
    /// y per unit of gap rate, s/m.
    pub(super) inverse: [f64; 8],
    /// Largest |y| that it is good for.
    pub(super) limit: [f64; 8],
    /// N s.
    pub(super) impulse: [f64; 8],
    /// Rows of the partners.
    pub(super) i: [u32; 8],
    pub(super) j: [u32; 8],
    /// Impulse at the end of the sub-step before.
    pub(super) former: [f64; 8],
    /// Gap, m.
    pub(super) gap: [f64; 8],
    /// What does not change while the pack stays.
    pub(super) law: PackLaw,
    /// Lanes that hold a film.
    filled: u8,
    /// Lanes whose film acted in the sub-step before.
    pub(super) seen: u8,
    /// … and in that before it.
    pub(super) twice: u8,
}

/// What does not change of eight films.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct PackLaw {
    /// Entries of the list.
    pub(super) entry: [u32; 8],
    /// c, η, δ_c, shift of [`crate::lubrication::law::LubricationLaw`].
    pub(super) normal: [[f64; 8]; 4],
    /// Film of sliding surfaces, and L_t.
    pub(super) film: [[f64; 8]; 4],
    /// Radii of both, and the part of the gap by which each lever arm is longer.
    pub(super) body: [[f64; 8]; 4],
}

impl FilmPack {
    fn empty(list: &FilmList) -> Self {
        let mut pack = Self::default();
        (0..8).for_each(|lane| pack.put(lane, list, list.none() as usize));
        pack
    }

    /// Puts entry `at` of the list into a lane.
    fn put(&mut self, lane: usize, list: &FilmList, at: usize) {
        (self.i[lane], self.j[lane], self.law.entry[lane]) = (list.first[at], list.second[at], at as u32);
        let PackLaw { normal, film, body, .. } = &mut self.law;
        for (columns, rows) in [(normal, &list.law), (film, &list.film), (body, &list.body)] {
            for (column, value) in columns.iter_mut().zip(rows[at]) {
                column[lane] = value;
            }
        }
    }

    /// Lanes that hold a film.
    fn lanes(&self) -> impl Iterator<Item = usize> + use<> {
        let filled = self.filled;
        (0..8).filter(move |lane| filled >> lane & 1 == 1)
    }
}

/// What one film brings along from the sub-step before.
#[derive(Clone, Copy, Debug)]
struct Carried {
    key: Key,
    impulse: f64,
    former: f64,
    seen: bool,
    twice: bool,
}

/// The packs, and the room to make them anew.
#[derive(Clone, Debug, Default)]
pub(super) struct Packs {
    pub(super) packs: Vec<FilmPack>,
    /// Films in them.
    pub(super) films: usize,
    /// Which entries they hold.
    acts: Vec<u8>,
    /// Whether the entries are those of the present lists.
    valid: bool,
    /// Rows that a class holds, a bit for each class.
    used: Vec<u64>,
    /// Class of each film, or [`CLASSES`].
    class: Vec<(u32, u8)>,
    carried: Vec<Carried>,
}

impl Packs {
    /// Room for `entries` films of `rows` rows.
    pub(super) fn reserve(&mut self, entries: usize, rows: usize) {
        let up_to = |have: usize, want: usize| want.saturating_sub(have);
        self.packs.reserve(up_to(self.packs.len(), entries / 8 + CLASSES));
        self.used.reserve(up_to(self.used.len(), rows));
        self.class.reserve(up_to(self.class.len(), entries));
        self.carried.reserve(up_to(self.carried.len(), entries));
        self.acts.reserve(up_to(self.acts.len(), entries / 8 + 1));
    }

    /// A window begins: no impulse of the last one is known.
    pub(super) fn forget(&mut self) {
        self.packs.iter_mut().for_each(|pack| (pack.seen, pack.twice) = (0, 0));
        self.carried.clear();
    }

    /// The lists are about to change: keeps what the films have, by `list` as it was.
    pub(super) fn keep(&mut self, list: &FilmList) {
        if self.valid {
            self.carry(list);
            self.valid = false;
        }
    }

    fn carry(&mut self, list: &FilmList) {
        self.carried.clear();
        for pack in &self.packs {
            for k in pack.lanes() {
                let (impulse, former) = (pack.impulse[k], pack.former[k]);
                let (seen, twice) = (pack.seen >> k & 1 == 1, pack.twice >> k & 1 == 1);
                let key = list.key(pack.law.entry[k] as usize);
                self.carried.push(Carried { key, impulse, former, seen, twice });
            }
        }
        self.carried.sort_unstable_by_key(|carried| carried.key);
    }

    /// Makes sure that the packs hold what acts.
    pub(super) fn update(&mut self, list: &FilmList, rows: &Rows) {
        if self.valid && self.acts == list.acts {
            return;
        }
        if self.valid {
            self.carry(list);
        }
        self.valid = true;
        self.acts.clone_from(&list.acts);
        self.classify(list, rows);
        self.fill(list);
    }

    /// Gives each film that acts its class.
    fn classify(&mut self, list: &FilmList, rows: &Rows) {
        self.used.clear();
        self.used.resize(rows.motion.len(), 0);
        self.class.clear();
        for (group, acts) in self.acts.iter().enumerate() {
            for lane in (0..8).filter(|lane| acts >> lane & 1 == 1) {
                let at = 8 * group + lane;
                let (i, j) = (list.first[at], list.second[at]);
                let of = |row: u32| if rows.moves(row) { self.used[row as usize] } else { 0 };
                let class = (!(of(i) | of(j))).trailing_zeros();
                if (class as usize) < CLASSES {
                    self.used[i as usize] |= 1 << class;
                    self.used[j as usize] |= 1 << class;
                }
                self.class.push((at as u32, class as u8));
            }
        }
        self.films = self.class.len();
        // within a class by the order of the list
        self.class.sort_unstable_by_key(|(at, class)| (*class, *at));
    }

    /// Puts the films into packs, with what they bring along.
    fn fill(&mut self, list: &FilmList) {
        self.packs.clear();
        let mut last = CLASSES as u8;
        let mut lane = 8;
        for &(at, class) in &self.class {
            if lane == 8 || class != last || class as usize == CLASSES {
                self.packs.push(FilmPack::empty(list));
                (lane, last) = (0, class);
            }
            let Some(pack) = self.packs.last_mut() else { break };
            let at = at as usize;
            pack.put(lane, list, at);
            pack.filled |= 1 << lane;
            let key = list.key(at);
            if let Ok(found) = self.carried.binary_search_by_key(&key, |carried| carried.key) {
                let carried = &self.carried[found];
                (pack.impulse[lane], pack.former[lane]) = (carried.impulse, carried.former);
                pack.seen |= u8::from(carried.seen) << lane;
                pack.twice |= u8::from(carried.twice) << lane;
            }
            lane += 1;
        }
    }
}
