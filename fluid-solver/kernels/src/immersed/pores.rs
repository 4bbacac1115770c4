//! The radius that a mask needs for the flow to feel a sphere or disc of radius R
//! (docs/equations-immersed.md, section 8).
//!
//! The mask puts the wall right for a linear profile. Where the profile is curved the wall stands too far
//! inside, by a length of order Δx² times the curvature: 1/R beside a sphere alone, 1/R + 1/r_h in a pore of
//! hydraulic radius r_h = R (1 − φ)/(3φ):
//! ```text
//! δR = [(π²/12) w̄² + 0.0047 Δx²] (1/R + 1/r_h) + Δx²/(24 r_h),   w̄ = 0.6 f Δx
//! ```
//! The second term is that of the wave in the mask's distance. The wave puts the wall right for a shear
//! beyond the band of the mask, two cells wide: in pores it has the part 1 − (2Δx/r_h)², none below two
//! cells, and so has this term. That is for spheres in space; for discs in the plane, whose mask has another
//! shape,
//! ```text
//! δR = (7/48) Δx² (1/R + 1/r_h),   r_h = R (1 − φ)/(2φ), at least Δx
//! ```
//! φ is the solid fraction about the grain: the volumes of all grains, weighed with a cubic B-spline of the
//! distance along each axis, two diameters of the largest grain between its knots, over the part of it that
//! lies in the box. The grain's own share counts as far as others, or its own images, do as much: a grain
//! alone is in no pore. Sums over pairs depend on distances alone, not on units, nor on where the box begins.

use super::body::{Motion, Shape, along_axes};
use super::mask_model::{Mask, MaskModel};
use crate::grid::{Geometry, Grid};
use crate::lanes::{Kernel, dispatch};
use crate::threads::{Chunks, most, share};
use pulp::Simd;
use std::f64::consts::PI;
use std::ops::RangeInclusive;

/// Distance of the knots, in diameters of the largest grain. With 2 the fraction of a cubic array is exact
/// where spheres touch, and 1.3 % off at most down to φ = 0.06; with 1.5 it was 1.2 and up to 9 % off.
const KNOTS: f64 = 2.0;

/// Mean of w over all directions, over f Δx.
const MEAN_WIDTH: f64 = 0.6;

/// What the wave in the mask's distance adds to (π²/12) w̄², in Δx²: 0.0121 where the surface is parallel to
/// the nodes, in exact one-dimensional discrete solutions, times the mean of N² over all directions, 0.390.
const WAVE_BEND: f64 = 0.0047;

/// Largest solid fraction that is believed: random close packing.
const PACKED: f64 = 0.64;

/// Grains that are taken together.
const TOGETHER: usize = 32;

/// Solid fraction about every grain.
#[derive(Clone, Debug)]
pub struct Pores<const D: usize> {
    start: [f64; D],
    length: [f64; D],
    periodic: [bool; D],
    /// Distance of the knots, m.
    knots: f64,
    /// Smallest cell of the grid, m.
    spacing: f64,
    /// Cells in which grains are looked for, along each axis; none where there are no pores.
    count: [usize; D],
    /// Of each cell and one more: how many grains stand before its first one in the order of cells.
    begins: Vec<u32>,
    /// Cell of each grain.
    cells: Vec<u32>,
    /// Centres of all grains, m.
    centres: Vec<[f64; D]>,
    /// In the order of cells, in each from the last grain to the first: number, centre by axis, m, and
    /// volume, m³ (in the plane m²).
    order: Vec<u32>,
    places: [Vec<f64>; D],
    volumes: Vec<f64>,
    /// Solid fractions about all grains.
    fractions: Vec<f64>,
}

impl<const D: usize> Pores<D> {
    /// For grains in the box of `grid`. On an axis of symmetry there are no pores: φ is zero.
    pub fn new(grid: &Grid<D>, shapes: &[Shape]) -> Self {
        let largest = shapes.iter().map(|shape| shape.radius).fold(0.0, f64::max);
        let knots = 2.0 * KNOTS * largest;
        let length: [f64; D] = std::array::from_fn(|a| grid.axes[a].length());
        let count = length.map(|length| ((length / (2.0 * knots)) as usize).max(1));
        let grains = if grid.geometry == Geometry::Axisymmetric { 0 } else { shapes.len() };
        // More cells than grains find nothing faster.
        let most = ((8 * grains) as f64).powf(1.0 / D as f64).ceil().max(1.0) as usize;
        let count = count.map(|count| count.min(most));
        Self {
            start: std::array::from_fn(|a| grid.axes[a].faces[0]),
            length,
            periodic: std::array::from_fn(|a| grid.periodic(a)),
            knots,
            spacing: grid.smallest_width(),
            count,
            begins: vec![0; if grains > 0 { count.iter().product::<usize>() + 1 } else { 0 }],
            cells: vec![0; grains],
            centres: vec![[0.0; D]; grains],
            order: vec![0; grains],
            places: std::array::from_fn(|_| vec![0.0; grains]),
            volumes: vec![0.0; grains],
            fractions: vec![0.0; grains],
        }
    }

    /// Sets the radius of every mask for grains at `motions`.
    pub fn set_radii(
        &mut self,
        geometry: Geometry,
        model: &MaskModel,
        shapes: &mut [Shape],
        motions: &[Motion],
    ) {
        if !self.cells.is_empty() {
            self.sort(geometry, motions, shapes);
            let mut fractions = std::mem::take(&mut self.fractions);
            let parts = fractions.len().div_ceil(TOGETHER);
            let most = most(parts, rayon::current_num_threads());
            let chunks = Chunks { fields: [&mut fractions[..]], size: TOGETHER };
            share(chunks, 0..parts, most, &|parts, chunks| {
                chunks.each(parts, &|part, [fractions]| {
                    dispatch(Fractions { pores: self, shapes, first: part * TOGETHER, fractions });
                });
            });
            self.fractions = fractions;
        }
        for (grain, shape) in shapes.iter_mut().enumerate() {
            let fraction = self.fractions.get(grain).copied().unwrap_or(0.0);
            let excess = match model.mask {
                Mask::ExactShear => excess_of_disc(self.spacing, shape.radius, fraction),
                Mask::ParameterFree | Mask::Izard2014 => {
                    let pore = inverse_pore(shape.radius, fraction);
                    shape.wave = (1.0 - (2.0 * self.spacing * pore).powi(2)).max(0.0);
                    excess(&MaskModel { wave: shape.wave, ..*model }, self.spacing, shape.radius, pore)
                }
            };
            shape.mask_radius = shape.radius + excess;
        }
    }

    /// Puts every grain into its cell; those beyond a wall into the last one.
    fn sort(&mut self, geometry: Geometry, motions: &[Motion], shapes: &[Shape]) {
        self.begins.fill(0);
        for (grain, motion) in motions.iter().enumerate() {
            let at: [f64; D] = along_axes(geometry, motion.centre);
            let (mut cell, mut stride) = (0, 1);
            for (a, at) in at.into_iter().enumerate() {
                let (n, from) = (self.count[a], (at - self.start[a]) / self.length[a]);
                let from = if self.periodic[a] { from - from.floor() } else { from };
                self.centres[grain][a] = self.start[a] + from * self.length[a];
                cell += stride * ((from * n as f64).max(0.0) as usize).min(n - 1);
                stride *= n;
            }
            self.cells[grain] = cell as u32;
            self.begins[cell] += 1;
        }
        let mut end = 0;
        for begin in &mut self.begins {
            end += *begin;
            *begin = end;
        }
        for (grain, cell) in self.cells.iter().enumerate() {
            let place = &mut self.begins[*cell as usize];
            *place -= 1;
            let place = *place as usize;
            self.order[place] = grain as u32;
            self.volumes[place] = shapes[grain].volume;
            for (places, centre) in self.places.iter_mut().zip(self.centres[grain]) {
                places[place] = centre;
            }
        }
    }

    /// Cells along axis `a` with all grains, or images of them, that can be near `at`; along a periodic axis
    /// they are counted on beyond the box.
    fn near(&self, a: usize, at: f64) -> RangeInclusive<isize> {
        let n = self.count[a] as isize;
        let cell = |x: f64| ((x - self.start[a]) / self.length[a] * n as f64).floor() as isize;
        let (low, high) = (cell(at - 2.0 * self.knots), cell(at + 2.0 * self.knots));
        if self.periodic[a] { low..=high } else { low.clamp(0, n - 1)..=high.clamp(0, n - 1) }
    }

    /// Solid fraction about a grain.
    #[inline(always)]
    fn fraction(&self, grain: usize, shapes: &[Shape]) -> f64 {
        let at = self.centres[grain];
        let near: [RangeInclusive<isize>; D] = std::array::from_fn(|a| self.near(a, at[a]));
        let mut others = 0.0;
        let mut cell: [isize; D] = std::array::from_fn(|a| *near[a].start());
        loop {
            let (mut place, mut stride, mut shift) = (0, 1, [0.0; D]);
            for a in 0..D {
                let n = self.count[a] as isize;
                place += stride * cell[a].rem_euclid(n) as usize;
                stride *= n as usize;
                shift[a] = cell[a].div_euclid(n) as f64 * self.length[a];
            }
            let own = if shift == [0.0; D] { grain as u32 } else { u32::MAX };
            let (mut first, end) = (self.begins[place] as usize, self.begins[place + 1] as usize);
            while first < end {
                let grains = first..end.min(first + TOGETHER);
                first = grains.end;
                let mut weights = [1.0; TOGETHER];
                for a in 0..D {
                    for (weight, place) in weights.iter_mut().zip(&self.places[a][grains.clone()]) {
                        *weight *= spline((place + shift[a] - at[a]) / self.knots);
                    }
                }
                let grains = self.order[grains.clone()].iter().zip(&self.volumes[grains]);
                for (weight, (number, volume)) in weights.iter().zip(grains) {
                    others += if *number == own { 0.0 } else { weight * volume };
                }
            }
            // The next cell.
            let Some(axis) = (0..D).find(|a| cell[*a] < *near[*a].end()) else { break };
            cell[axis] += 1;
            (0..axis).for_each(|a| cell[a] = *near[a].start());
        }
        let own = spline(0.0).powi(D as i32) * shapes[grain].volume;
        let inside = |a: usize| {
            let [low, high] = [0.0, self.length[a]].map(|end| (self.start[a] + end - at[a]) / self.knots);
            if self.periodic[a] { 1.0 } else { below(high) - below(low) }
        };
        let volume: f64 = (0..D).map(|a| self.knots * inside(a)).product();
        // A grain that has left the box is in no pore.
        if volume > 0.0 { (own + others).min(2.0 * others) / volume } else { 0.0 }
    }
}

/// [`Pores::fraction`] of some grains.
struct Fractions<'a, const D: usize> {
    pores: &'a Pores<D>,
    shapes: &'a [Shape],
    /// The first of them.
    first: usize,
    fractions: &'a mut [f64],
}

impl<const D: usize> Kernel for Fractions<'_, D> {
    #[inline(always)]
    fn run<S: Simd>(self, _: S) {
        for (n, fraction) in self.fractions.iter_mut().enumerate() {
            *fraction = self.pores.fraction(self.first + n, self.shapes);
        }
    }
}

/// Cubic B-spline with knots at −2, −1, 0, 1, 2.
#[inline(always)]
fn spline(x: f64) -> f64 {
    let x = x.abs();
    let (middle, rest) = (2.0 / 3.0 - x * x + 0.5 * x * x * x, (2.0 - x).max(0.0));
    // No branch, so that whole vectors go together.
    if x < 1.0 { middle } else { rest * rest * rest / 6.0 }
}

/// Its integral from −∞ to `x`.
fn below(x: f64) -> f64 {
    let left = |x: f64| match x {
        x if x <= -2.0 => 0.0,
        x if x < -1.0 => (2.0 + x).powi(4) / 24.0,
        x => 0.5 + 2.0 * x / 3.0 - x * x * x / 3.0 - x * x * x * x / 8.0,
    };
    if x <= 0.0 { left(x) } else { 1.0 - left(-x) }
}

/// 1/r_h of a packing of spheres of radius `radius` with solid fraction `fraction`, 1/m.
fn inverse_pore(radius: f64, fraction: f64) -> f64 {
    let fraction = fraction.clamp(0.0, PACKED);
    3.0 * fraction / (radius * (1.0 - fraction))
}

/// δR of a sphere of radius `radius` in pores of 1/r_h = `pore`, m.
fn excess(model: &MaskModel, spacing: f64, radius: f64, pore: f64) -> f64 {
    let (mean, square) = (MEAN_WIDTH * model.width, spacing * spacing);
    let mask = PI * PI / 12.0 * mean * mean + WAVE_BEND * model.wave;
    square * (mask * (1.0 / radius + pore) + pore / 24.0)
}

/// The same of a disc with the mask of exact shear.
fn excess_of_disc(spacing: f64, radius: f64, fraction: f64) -> f64 {
    let pore = radius * (1.0 - fraction).max(0.0) / (2.0 * fraction);
    7.0 / 48.0 * spacing * spacing * (1.0 / radius + 1.0 / pore.max(spacing))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_spline_is_one_in_sum_and_its_integral_its_own() {
        for x in [-0.3, 0.0, 0.45, 0.99] {
            let sum: f64 = (-3..=3).map(|k| spline(x + f64::from(k))).sum();
            assert!((sum - 1.0).abs() < 1e-15, "{x}: {sum}");
        }
        for x in [-1.7, -1.0, -0.2, 0.0, 0.6, 1.0, 1.9] {
            let rise = (below(x + 1e-5) - below(x - 1e-5)) / 2e-5;
            assert!((rise - spline(x)).abs() < 1e-9, "{x}: {rise}");
        }
        assert_eq!([below(-2.0), below(0.0), below(2.0)], [0.0, 0.5, 1.0]);
    }
}
