//! Half lists of near pairs with their contact history, kept through rebuilds.
//!
//! A list holds every pair whose gap is below range + skin. It is built again when the grains may
//! have come nearer by the skin: Σ dt·v_max > skin/2, without stored positions. Rows are ascending in
//! both partners, and pairs out of reach add nothing, so sums do not depend on when a list was built.

use crate::grains::Grains;
use crate::laws::walls::Plane;
use crate::periods::Periods;
use crate::search::contact_list::ContactList;
use crate::search::pairs::PairSearch;

/// The two lists of a run and what is needed to build them again.
#[derive(Clone, Debug, Default)]
pub(crate) struct Neighbours {
    pub(crate) pairs: ContactList,
    pub(crate) walls: ContactList,
    /// Pairs of which one is not round, ascending, and bodies that are not round near walls: their history is
    /// kept where their contacts are.
    pub(crate) body_pairs: Vec<[u32; 2]>,
    pub(crate) body_walls: Vec<[u32; 2]>,
    spare: ContactList,
    search: PairSearch,
    found: Vec<u32>,
    range: f64,
    skin: f64,
    /// Skin of the present lists, m.
    built: f64,
    /// How far a grain may have moved since the lists were built, m.
    travel: f64,
    valid: bool,
    pub(crate) builds: u64,
}

impl Neighbours {
    /// Lists for forces that reach `range`.
    pub(crate) fn new(range: f64, skin: f64, grains: usize) -> Self {
        let mut lists = Self { range, skin, ..Self::default() };
        lists.restart(grains);
        lists
    }

    /// Drops all pairs and their history; the next [`Self::refresh`] builds.
    pub(crate) fn restart(&mut self, grains: usize) {
        self.pairs.restore(&[], &[], grains);
        self.walls.restore(&[], &[], grains);
        self.body_pairs.clear();
        self.body_walls.clear();
        self.valid = false;
    }

    /// Makes sure that the lists are good for one more step in which nothing moves further than `step`.
    /// Returns whether they were built again.
    pub(crate) fn refresh(
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
        let reach = self.range + self.built;
        let Self { pairs, walls, body_pairs, body_walls, spare, search, found, .. } = self;
        body_pairs.clear();
        body_walls.clear();
        search.prepare(&grains.position, &grains.radius, reach, periods);
        rebuild(pairs, spare, found, grains.len(), |i, found| {
            search.partners(i, &grains.position, &grains.radius, reach, periods, found);
            if !grains.responds(i) {
                found.retain(|&j| grains.responds(j as usize));
            }
            take(found, i, body_pairs, |j| grains.is_round(i) && grains.is_round(j as usize));
        });
        rebuild(walls, spare, found, grains.len(), |i, found| {
            // A wall that turns comes from afar: it has all grains.
            let near = |plane: &Plane| {
                let gap = || plane.gap(&grains.position[i], grains.radius[i], t);
                plane.stands(t) && (plane.turns.is_some() || gap() < reach)
            };
            let planes = (0u32..).zip(planes).filter(|(_, plane)| grains.responds(i) && near(plane));
            found.extend(planes.map(|(w, _)| w));
            take(found, i, body_walls, |_| grains.is_round(i));
        });
        true
    }
}

/// Moves the partners of `i` that do not `stay` from `found` to `others`.
fn take(found: &mut Vec<u32>, i: usize, others: &mut Vec<[u32; 2]>, stay: impl Fn(u32) -> bool) {
    found.retain(|&other| {
        let stays = stay(other);
        if !stays {
            others.push([i as u32, other]);
        }
        stays
    });
}

/// Fills `list` by rows of partners, ascending, that `find` names; histories stay.
fn rebuild(
    list: &mut ContactList,
    spare: &mut ContactList,
    found: &mut Vec<u32>,
    rows: usize,
    mut find: impl FnMut(usize, &mut Vec<u32>),
) {
    std::mem::swap(list, spare);
    list.clear();
    for i in 0..rows {
        found.clear();
        find(i, found);
        list.push_row(i, found, spare);
    }
}
