//! Half lists of near pairs with their contact history, kept through rebuilds.
//!
//! A list holds every pair whose gap is below range + skin. It is built again when the grains may
//! have come nearer by the skin: Σ dt·v_max > skin/2, without stored positions. Rows are ascending in
//! both partners, and pairs out of reach add nothing, so sums do not depend on when a list was built.

use crate::Vec3;
use crate::grains::Grains;
use crate::laws::walls::Plane;
use crate::search::cells::{Periods, Search};
use crate::state::SavedContact;

/// Pairs by first partner: row `i` holds the partners of grain `i`, ascending.
#[derive(Clone, Debug, Default)]
pub struct ContactList {
    start: Vec<u32>,
    /// Second partners: grains j > i, or walls.
    pub other: Vec<u32>,
    /// Tangential springs δ_t, m; zero where nothing touches.
    pub spring: Vec<Vec3>,
    /// Rolling angles θ, rad; zero where nothing touches or rolling is free.
    pub rolling: Vec<Vec3>,
    /// Whether the contact bears a force.
    pub touching: Vec<bool>,
}

impl ContactList {
    /// Range of entries of grain `i`.
    #[inline(always)]
    #[must_use]
    pub fn row(&self, i: usize) -> std::ops::Range<usize> {
        self.start[i] as usize..self.start[i + 1] as usize
    }

    /// Number of entries.
    #[must_use]
    pub fn len(&self) -> usize {
        self.other.len()
    }

    /// Whether there are none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.other.is_empty()
    }

    /// The entries that bear a force, with their springs.
    #[must_use]
    pub fn bearing(&self) -> Vec<SavedContact> {
        let rows = (0u32..).zip(self.start.windows(2));
        rows.flat_map(|(first, row)| (row[0]..row[1]).map(move |k| (first, k as usize)))
            .filter(|(_, k)| self.touching[*k])
            .map(|(first, k)| SavedContact { first, second: self.other[k], spring: self.spring[k].into() })
            .collect()
    }

    /// Empties the list and opens the first row.
    pub fn clear(&mut self) {
        self.start.clear();
        self.start.push(0);
        self.other.clear();
        self.spring.clear();
        self.rolling.clear();
        self.touching.clear();
    }

    /// Appends an entry to the open row.
    pub fn push(&mut self, other: u32, spring: Vec3, rolling: Vec3, touching: bool) {
        self.other.push(other);
        self.spring.push(spring);
        self.rolling.push(rolling);
        self.touching.push(touching);
    }

    /// Closes the open row.
    pub fn close_row(&mut self) {
        self.start.push(self.other.len() as u32);
    }

    /// Appends `partners` (ascending) as row `i`, with the history that `old` has of them.
    fn push_row(&mut self, i: usize, partners: &[u32], old: &Self) {
        let mut history = if i + 1 < old.start.len() { old.row(i) } else { 0..0 };
        for &other in partners {
            while history.start < history.end && old.other[history.start] < other {
                history.start += 1;
            }
            if history.start < history.end && old.other[history.start] == other {
                let k = history.start;
                self.push(other, old.spring[k], old.rolling[k], old.touching[k]);
            } else {
                self.push(other, Vec3::zeros(), Vec3::zeros(), false);
            }
        }
        self.close_row();
    }
}

/// The two lists of a run and what is needed to build them again.
#[derive(Clone, Debug, Default)]
pub struct Neighbours {
    /// Pairs of grains.
    pub pairs: ContactList,
    /// Grains near walls.
    pub walls: ContactList,
    spare: ContactList,
    search: Search,
    found: Vec<u32>,
    range: f64,
    skin: f64,
    /// Skin of the present lists, m.
    built: f64,
    /// How far a grain may have moved since the lists were built, m.
    travel: f64,
    valid: bool,
    /// Number of builds so far.
    pub builds: u64,
}

impl Neighbours {
    /// Lists for forces that reach `range`.
    #[must_use]
    pub fn new(range: f64, skin: f64, grains: usize) -> Self {
        let mut lists = Self { range, skin, ..Self::default() };
        lists.restart(grains);
        lists
    }

    /// Drops all pairs and their history; the next [`Self::refresh`] builds.
    pub fn restart(&mut self, grains: usize) {
        for list in [&mut self.pairs, &mut self.walls] {
            list.clear();
            (0..grains).for_each(|_| list.close_row());
        }
        self.valid = false;
    }

    /// Makes sure that the lists hold for one more step in which nothing moves further than `step`.
    /// Returns whether they were built again.
    pub fn refresh(
        &mut self,
        step: f64,
        grains: &Grains,
        planes: &[Plane],
        periods: &Periods,
        t: f64,
    ) -> bool {
        self.travel += step;
        if self.valid && self.travel <= 0.5 * self.built {
            return false;
        }
        self.travel = step;
        // a skin of a few steps at least: fast grains must not force a build in every sub-step
        self.built = self.skin.max(16.0 * step);
        self.valid = true;
        self.builds += 1;
        self.build_pairs(grains, periods);
        self.build_walls(grains, planes, t);
        true
    }

    fn build_pairs(&mut self, grains: &Grains, periods: &Periods) {
        let reach = self.range + self.built;
        std::mem::swap(&mut self.pairs, &mut self.spare);
        self.pairs.clear();
        self.search.prepare(&grains.position, &grains.radius, reach, periods);
        for i in 0..grains.len() {
            self.found.clear();
            self.search.partners(i, &grains.position, &grains.radius, reach, periods, &mut self.found);
            if !grains.responds(i) {
                self.found.retain(|&j| grains.responds(j as usize));
            }
            self.pairs.push_row(i, &self.found, &self.spare);
        }
    }

    fn build_walls(&mut self, grains: &Grains, planes: &[Plane], t: f64) {
        let reach = self.range + self.built;
        std::mem::swap(&mut self.walls, &mut self.spare);
        self.walls.clear();
        for i in 0..grains.len() {
            self.found.clear();
            if grains.responds(i) {
                let near = |plane: &Plane| {
                    plane.stands(t) && plane.gap(&grains.position[i], grains.radius[i], t) < reach
                };
                self.found.extend((0u32..).zip(planes).filter(|(_, plane)| near(plane)).map(|(w, _)| w));
            }
            self.walls.push_row(i, &self.found, &self.spare);
        }
    }
}
