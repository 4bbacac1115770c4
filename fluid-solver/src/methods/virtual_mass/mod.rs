//! Virtual mass C_v m_f of the messages: one number for all grains, or by the gap to what is nearest.
//!
//! A DEM finds the impulse of a contact with m_p + C_v m_f. Where the contact lasts no longer than a window,
//! U_out/U_in = (1 + e)(ρ_r + C_v)/(ρ_r + C) − 1, C the true coefficient: with C_v = C the bounce is that of
//! the solids, whatever dt (docs/equations-immersed.md, Virtual mass). Normal motion only: the mass of a
//! message has no direction.

pub mod images;
mod neighbours;
mod rest;

use crate::boundary::Boundary;
use crate::grid::{Geometry, Grid};
use crate::immersed::body::{Motion, Shape, laboratory};
use images::{at_a_wall, beside, touching_a_wall};
use neighbours::{Near, Neighbours};

/// C_v where nothing is near, and in a crowd. A disc alone has 1, but nothing depends on it.
pub const ALONE: f64 = 0.5;

/// Gaps above this many radii, of the smaller grain of a pair, count as infinite: C is within 5 % of that of
/// a sphere alone by then.
const REACH: f64 = 1.0;

/// Gaps below this many radii count as contacts where it is asked how many a grain has.
const TOUCH: f64 = 0.1;

/// A face of the box that nothing flows through.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Wall {
    /// Axis, in the laboratory frame.
    axis: usize,
    /// Place, m.
    at: f64,
    /// 1 on a lower face, −1 on an upper one.
    inward: f64,
    slips: bool,
}

impl Wall {
    /// Gap between it and a round body, m.
    fn gap(&self, shape: &Shape, motion: &Motion) -> f64 {
        self.inward * (motion.centre[self.axis] - self.at) - shape.radius
    }

    /// It and the round `grain`.
    fn near(&self, grain: usize, shape: &Shape, motion: &Motion) -> Near {
        let normal = std::array::from_fn(|c| if c == self.axis { -self.inward } else { 0.0 });
        Near { grains: [grain; 2], normal, gap: self.gap(shape, motion), round: shape.radius }
    }
}

/// What is added to the virtual mass of grains alone, by the gap to walls and neighbours.
#[derive(Clone, Debug)]
pub struct ByGap {
    dimensions: i32,
    walls: Vec<Wall>,
    /// Which grains the fluid can move, and which are not fixed.
    free: Vec<bool>,
    moves: Vec<bool>,
    neighbours: Neighbours,
    then: Vec<Motion>,
    /// Pairs within reach, and their gaps.
    pairs: Vec<(usize, usize, f64)>,
    /// Contacts of each grain.
    contacts: Vec<u32>,
    /// Part of the window at which each grain first touches something; 1 where it does not.
    touches: Vec<f64>,
    excess: Vec<f64>,
    /// What is near in films or at rest, and which grains something bears.
    near: Vec<Near>,
    borne: Vec<bool>,
}

/// Part of a window at which a gap that goes from the first to the last of `gaps` closes; 1 if it does not.
fn closes([first, last]: [f64; 2]) -> f64 {
    if first <= 0.0 {
        0.0
    } else if last < 0.0 {
        first / (first - last)
    } else {
        1.0
    }
}

impl ByGap {
    /// For grains of which `free` says whether the fluid moves them, and `moves` whether anything does.
    pub fn new<const D: usize>(grid: &Grid<D>, shapes: &[Shape], [free, moves]: [Vec<bool>; 2]) -> Self {
        let mut walls = Vec::new();
        for (a, faces) in grid.boundaries.iter().enumerate() {
            // On the axis of symmetry no grain comes nearer to the mantle.
            if grid.geometry == Geometry::Axisymmetric && a == 0 {
                continue;
            }
            let (first, last) = (grid.axes[a].faces[0], grid.axes[a].faces[grid.cells[a]]);
            for (face, at, inward) in [(faces[0], first, 1.0), (faces[1], last, -1.0)] {
                if matches!(face, Boundary::NoSlip { .. } | Boundary::FreeSlip) {
                    let (axis, slips) = (laboratory(grid.geometry, a), face == Boundary::FreeSlip);
                    walls.push(Wall { axis, at, inward, slips });
                }
            }
        }
        Self {
            dimensions: grid.geometry.grain_dimensions(),
            walls,
            free,
            moves,
            neighbours: Neighbours::new(grid, shapes, REACH),
            then: vec![Motion::default(); shapes.len()],
            pairs: Vec::new(),
            contacts: vec![0; shapes.len()],
            touches: vec![1.0; shapes.len()],
            excess: vec![0.0; shapes.len()],
            near: Vec::new(),
            borne: vec![false; shapes.len()],
        }
    }

    /// C_v of each grain over [`ALONE`], for a window of length `dt` that begins with the motion `now`: that
    /// of the smaller of the gaps at its start and at its foreseen end, hence constant while grains touch.
    ///
    /// Too large a value gives energy in a contact, too small a one takes it. So a grain with two contacts or
    /// more has none: what moves together drags less fluid along than head-on; and a partner with other
    /// contacts counts as held.
    pub fn excess(&mut self, shapes: &[Shape], density: f64, now: &[Motion], dt: f64) -> &[f64] {
        let Self { dimensions, walls, free, neighbours, then, pairs, contacts, touches, excess, .. } = self;
        let dimensions = *dimensions;
        then.iter_mut().zip(now).for_each(|(then, now)| *then = now.predicted(dt));
        excess.fill(0.0);
        contacts.fill(0);
        touches.fill(1.0);
        if !free.contains(&true) {
            return excess;
        }
        // The gaps are those of round bodies; others are as if alone.
        for (grain, shape) in shapes.iter().enumerate().filter(|(_, shape)| shape.outline.is_none()) {
            for wall in &*walls {
                let gaps = [&now[grain], &then[grain]].map(|motion| wall.gap(shape, motion));
                touches[grain] = touches[grain].min(closes(gaps));
                let gap = gaps[0].min(gaps[1]);
                if gap < REACH * shape.radius {
                    excess[grain] = excess[grain].max(at_a_wall(dimensions, shape.radius, gap) - ALONE);
                    contacts[grain] += u32::from(gap < TOUCH * shape.radius);
                }
            }
        }
        pairs.clear();
        neighbours.each_pair(shapes, now, then, |i, j, gaps| {
            if shapes[i].outline.is_some() || shapes[j].outline.is_some() {
                return;
            }
            let gap = gaps[0].min(gaps[1]);
            pairs.push((i, j, gap));
            let near = u32::from(gap < TOUCH * shapes[i].radius.min(shapes[j].radius));
            for grain in [i, j] {
                contacts[grain] += near;
                touches[grain] = touches[grain].min(closes(gaps));
            }
        });
        for &(i, j, gap) in &*pairs {
            let moves = [i, j].map(|grain| free[grain] && contacts[grain] < 2);
            let here = of_a_pair(dimensions, density, [&shapes[i], &shapes[j]], moves, gap);
            for (grain, here) in [i, j].into_iter().zip(here) {
                excess[grain] = excess[grain].max(here - ALONE);
            }
        }
        for (excess, contacts) in excess.iter_mut().zip(contacts) {
            if *contacts > 1 {
                *excess = 0.0;
            }
        }
        excess
    }

    /// Time, s, until the first free grain touches a wall or another grain that it nears faster than `fast`,
    /// m/s, if all go on as they move `now`; `dt` if that is longer.
    pub fn until_touch(&mut self, shapes: &[Shape], now: &[Motion], dt: f64, fast: f64) -> f64 {
        let Self { walls, free, neighbours, then, .. } = self;
        then.iter_mut().zip(now).for_each(|(then, now)| *then = now.predicted(dt));
        let mut part = 1.0_f64;
        let mut take = |gaps: [f64; 2]| {
            if gaps[0] > 0.0 && gaps[0] - gaps[1] > fast * dt {
                part = part.min(closes(gaps));
            }
        };
        let round = |grain: usize| shapes[grain].outline.is_none();
        for grain in (0..shapes.len()).filter(|grain| free[*grain] && round(*grain)) {
            let motions = [&now[grain], &then[grain]];
            walls.iter().for_each(|wall| take(motions.map(|motion| wall.gap(&shapes[grain], motion))));
        }
        neighbours.each_pair(shapes, now, then, |i, j, gaps| {
            if (free[i] || free[j]) && round(i) && round(j) {
                take(gaps);
            }
        });
        part * dt
    }

    /// Part of the window of the last [`ByGap::excess`] at which each grain first touches a wall or another
    /// grain; 1 where it does not.
    pub fn touches(&self) -> &[f64] {
        &self.touches
    }
}

/// C_v of two grains that hit each other, of which some are `free`: with it, a grain's own impulse balance
/// (m + C_v m_f) ΔU = J is that of the pair, whose masses are coupled by M. A held grain has that of a grain
/// alone.
///
/// Never less than beside a held grain and never more than at a wall: a grain much larger or much heavier
/// than its neighbour would be given the inertia of the fluid that the small one pushes.
fn of_a_pair(dimensions: i32, density: f64, pair: [&Shape; 2], free: [bool; 2], gap: f64) -> [f64; 2] {
    let [one, two] = pair;
    let of = |a: &Shape, b: &Shape| beside(dimensions, a.radius, b.radius, gap);
    match free {
        [false, false] => return [ALONE; 2],
        [true, false] => return [of(one, two).own, ALONE],
        [false, true] => return [ALONE, of(two, one).own],
        [true, true] => {}
    }
    let here = of(one, two);
    let there = if one.radius == two.radius { here } else { of(two, one) };
    let mass = |shape: &Shape, own: f64| (shape.density + density * own) * shape.volume;
    let mutual = density * one.volume * here.mutual;
    let (this, that) = (mass(one, here.own) - mutual, mass(two, there.own) - mutual);
    let wall = touching_a_wall(dimensions);
    // −ΔU_other/ΔU of equal and opposite impulses.
    let with = |c: images::Coefficients, mine: f64, other: f64| {
        let answer = if other > 0.0 { (mine / other).max(0.0) } else { f64::INFINITY };
        (c.own + c.mutual * answer).min(wall.max(c.own))
    };
    [with(here, this, that), with(there, that, this)]
}

#[cfg(test)]
mod tests;
