//! All gaps of the neighbour lists: what does not change while the lists stay, and their geometry in a
//! sub-step.

use crate::grains::Grains;
use crate::laws::walls::Plane;
use crate::lubrication::law::LubricationModel;
use crate::lubrication::rows::Rows;
use crate::lubrication::sliding::{Film, reach_at};
use crate::search::contact_list::ContactList;
use crate::vector::images::Images;
use crate::vector::kernel::Kernel;
use crate::vector::lanes::Lanes8;
use crate::vector::rows::{EACH, Row, pairs, rows_minus, write_pairs};

/// Place of a gap in the order: pairs of grains before walls.
pub(super) type Key = (bool, u32, u32);

/// The gaps of the lists, in their order: pairs, lanes without a gap up to the next eight, walls, and again.
#[derive(Clone, Debug, Default)]
pub(super) struct FilmList {
    /// Rows of the first partners.
    pub(super) first: Vec<u32>,
    /// Rows of the second partners.
    pub(super) second: Vec<u32>,
    cut_off: Vec<f64>,
    /// Sums of the radii.
    reach: Vec<f64>,
    /// c, η, δ_c, shift of [`crate::lubrication::law::LubricationLaw`].
    pub(super) law: Vec<Row>,
    /// Film of sliding surfaces at unit viscosity, and L_t.
    pub(super) film: Vec<Row>,
    /// Radii of both, and the part of the gap by which each lever arm is longer than its radius.
    pub(super) body: Vec<Row>,
    /// Normal and gap.
    pub(super) near: Vec<Row>,
    /// Gaps that act in this sub-step: a bit each.
    pub(super) acts: Vec<u8>,
    /// Entries of pairs, a multiple of eight.
    pairs: usize,
}

impl FilmList {
    pub(super) fn build(
        &mut self,
        model: &LubricationModel,
        grains: &Grains,
        walls: usize,
        (pairs, at_walls): (&ContactList, &ContactList),
    ) {
        self.clear();
        let none = Rows::of_wall(grains.len(), walls as u32);
        for (i, k) in pairs.entries() {
            let j = pairs.other[k];
            self.push(model, (i as u32, j), (grains.radius[i], grains.radius[j as usize]));
        }
        self.fill_up(none);
        self.pairs = self.first.len();
        for (i, k) in at_walls.entries() {
            let wall = Rows::of_wall(grains.len(), at_walls.other[k]);
            self.push(model, (i as u32, wall), (grains.radius[i], f64::INFINITY));
        }
        // the last is always one without a gap
        self.push_none(none);
        self.fill_up(none);
        self.near.resize(self.first.len(), [0.0, 0.0, 0.0, 1.0]);
        self.acts.resize(self.first.len() / 8, 0);
    }

    fn clear(&mut self) {
        self.first.clear();
        self.second.clear();
        self.cut_off.clear();
        self.reach.clear();
        for rows in [&mut self.law, &mut self.film, &mut self.body, &mut self.near] {
            rows.clear();
        }
        self.acts.clear();
    }

    fn push(&mut self, model: &LubricationModel, (first, second): (u32, u32), (a, b): (f64, f64)) {
        let law = model.law(a, b);
        let at_wall = b.is_infinite();
        self.first.push(first);
        self.second.push(second);
        self.cut_off.push(law.cut_off);
        self.reach.push(a + b);
        self.law.push([law.coefficient, law.roughness, law.cut_off, law.shift]);
        self.film.push(Film::new(model.shape, model.viscosity, a, b).row(reach_at(model, at_wall)));
        self.body.push(if at_wall { [a, 0.0, 0.0, 0.0] } else { [a, b, 0.5, 0.0] });
    }

    /// A lane that never acts.
    fn push_none(&mut self, none: u32) {
        self.first.push(none);
        self.second.push(none);
        self.cut_off.push(f64::NEG_INFINITY);
        self.reach.push(0.0);
        self.law.push([0.0, 1.0, -1.0, 0.0]);
        self.film.push([0.0; 4]);
        self.body.push([0.0; 4]);
    }

    fn fill_up(&mut self, none: u32) {
        while !self.first.len().is_multiple_of(8) {
            self.push_none(none);
        }
    }

    /// The entry without a gap.
    pub(super) fn none(&self) -> u32 {
        self.first.len() as u32 - 1
    }

    /// Entry `at` in the order of all.
    pub(super) fn key(&self, at: usize) -> Key {
        (at >= self.pairs, self.first[at], self.second[at])
    }

    /// Geometry and activity of the walls at time `t`, in a sub-step of `dt`; those of pairs are
    /// [`Geometry`]'s.
    pub(super) fn meet_walls(&mut self, rows: &Rows, walls: &[Plane], (t, dt): (f64, f64)) {
        let none = self.first.len() as u32 - 1;
        let grains = self.first[none as usize] - walls.len() as u32;
        self.acts[self.pairs / 8..].fill(0);
        for at in self.pairs..self.first.len() {
            let (i, second) = (self.first[at] as usize, self.second[at]);
            if self.first[at] >= grains {
                continue;
            }
            let wall = &walls[(second - grains) as usize];
            let [x, y, z, r] = rows.place[i];
            let stand = wall.at(t);
            let (n, gap) = (stand.normal, stand.gap(&[x, y, z].into(), r));
            self.near[at] = [n.x, n.y, n.z, gap];
            if wall.acts(t) && self.reaches(rows, at, dt) {
                self.acts[at / 8] |= 1 << (at % 8);
            }
        }
    }

    /// Whether the gap can act within the sub-step: if the grain could reach it even at twice its present
    /// rate, as another gap may speed it up.
    fn reaches(&self, rows: &Rows, at: usize, dt: f64) -> bool {
        let [x, y, z, gap] = self.near[at];
        let (v, w) = (&rows.motion[self.first[at] as usize], &rows.motion[self.second[at] as usize]);
        let rate = (v[0] - w[0]) * x + (v[1] - w[1]) * y + (v[2] - w[2]) * z;
        gap - 2.0 * dt * rate.abs() <= self.cut_off[at]
    }
}

/// Geometry and activity of all pairs of grains.
pub(super) struct Geometry<'a> {
    pub(super) list: &'a mut FilmList,
    pub(super) rows: &'a Rows,
    /// Lengths of the periods, m; 0 where there is none.
    pub(super) length: [f64; 3],
    pub(super) dt: f64,
}

impl Kernel for Geometry<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes8>(self, token: L::Token) {
        let Self { list, rows, length, dt } = self;
        let images = Images::<L>::new(token, length);
        let one = L::splat(token, 1.0);
        // two grains come nearer by twice the largest speed at most, and that twice
        let margin = L::splat(token, 4.0 * dt * rows.fastest);
        for at in (0..list.pairs).step_by(8) {
            let (Some(first), Some(second)) =
                (list.first[at..].first_chunk(), list.second[at..].first_chunk())
            else {
                continue;
            };
            let Some(reach) = list.reach[at..].first_chunk() else { continue };
            let apart = rows_minus(pairs::<L>(token, &rows.place, first), pairs(token, &rows.place, second));
            let [x, y, z, _] = L::columns_of(apart);
            let (x, y, z) = (images.nearest(0, x), images.nearest(1, y), images.nearest(2, z));
            let distance = (x * x + y * y + z * z).sqrt();
            let gap = distance - L::load(token, reach);
            let inverse = one / distance;
            let near = L::rows_of([x * inverse, y * inverse, z * inverse, gap]);
            write_pairs(near, &mut list.near[at..], &EACH);
            let Some(cut_off) = list.cut_off[at..].first_chunk() else { continue };
            let cut_off = L::load(token, cut_off);
            let beyond: u8 = cut_off.lt(gap);
            let mut acts = !beyond;
            let mut near = beyond & !(cut_off + margin).lt(gap);
            while near != 0 {
                let lane = near.trailing_zeros();
                near &= near - 1;
                acts |= u8::from(list.reaches(rows, at + lane as usize, dt)) << lane;
            }
            list.acts[at / 8] = acts;
        }
    }
}
