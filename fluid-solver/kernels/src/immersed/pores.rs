//! The radius that a mask needs for the flow to feel a sphere of radius R (docs/equations-immersed.md,
//! section 8).
//!
//! The mask puts the wall right for a linear profile. Where the profile is curved the wall stands too far
//! inside, by a length of order Δx² times the curvature: 1/R beside a sphere alone, 1/R + 1/r_h in a pore of
//! hydraulic radius r_h = R (1 − φ)/(3φ):
//! ```text
//! δR = (π²/12) w̄² (1/R + 1/r_h) + Δx²/(24 r_h),   w̄ = 0.6 f Δx
//! ```
//! φ is the solid fraction about the grain: volumes are shared among coarse cells, 1.5 diameters wide, and
//! read back with the same weights. The grain's own share counts as far as others, or its own images, do as
//! much: a grain alone is in no pore.

use super::body::{Motion, Shape, along_axes};
use super::mask_model::MaskModel;
use crate::grid::{Geometry, Grid};
use std::f64::consts::PI;

/// Width of the coarse cells, in diameters of the largest grain.
const SIZE: f64 = 1.5;

/// Mean of w over all directions, over f Δx.
const MEAN_WIDTH: f64 = 0.6;

/// Largest solid fraction that is believed: random close packing.
const PACKED: f64 = 0.64;

/// Solid fraction about every grain.
#[derive(Clone, Debug)]
pub struct Pores<const D: usize> {
    start: [f64; D],
    size: [f64; D],
    /// Width that they are to have, m.
    wanted: f64,
    count: [usize; D],
    periodic: [bool; D],
    /// Smallest cell of the grid, m.
    spacing: f64,
    solid: Vec<f64>,
}

/// Cells and weights along one axis.
type Shares = [(usize, f64); 2];

impl<const D: usize> Pores<D> {
    /// For spheres in the box of `grid`. On an axis of symmetry there are no pores: φ is zero.
    pub fn new(grid: &Grid<D>, shapes: &[Shape]) -> Self {
        let largest = shapes.iter().map(|shape| shape.radius).fold(0.0, f64::max);
        let length = |a: usize| grid.axes[a].length();
        let count: [usize; D] =
            std::array::from_fn(|a| ((length(a) / (2.0 * SIZE * largest)) as usize).clamp(1, grid.cells[a]));
        let has_pores = grid.geometry == Geometry::Space;
        Self {
            start: std::array::from_fn(|a| grid.axes[a].faces[0]),
            size: std::array::from_fn(|a| length(a) / count[a] as f64),
            wanted: 2.0 * SIZE * largest,
            count,
            periodic: std::array::from_fn(|a| grid.periodic(a)),
            spacing: grid.smallest_width(),
            solid: vec![0.0; if has_pores { count.iter().product() } else { 0 }],
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
        self.solid.fill(0.0);
        let volume: f64 = self.size.iter().product();
        if !self.solid.is_empty() {
            for (shape, motion) in shapes.iter().zip(motions) {
                let at = self.shares(along_axes(geometry, motion.centre));
                self.each_cell(&at, |solid, weight| *solid += weight * shape.volume / volume);
            }
        }
        for (shape, motion) in shapes.iter_mut().zip(motions) {
            let mut fraction = 0.0;
            if !self.solid.is_empty() {
                let at = self.shares(along_axes(geometry, motion.centre));
                self.each_cell(&at, |solid, weight| fraction += weight * *solid);
                let others = (fraction - self.own(&at, shape)).max(0.0);
                fraction = fraction.min(2.0 * others);
            }
            shape.mask_radius = shape.radius + excess(model.width, self.spacing, shape.radius, fraction);
        }
    }

    /// The coarse cells about a place, along every axis. Beyond a wall there is none.
    fn shares(&self, at: [f64; D]) -> [Shares; D] {
        std::array::from_fn(|a| {
            let (n, place) = (self.count[a] as isize, (at[a] - self.start[a]) / self.size[a] - 0.5);
            let low = place.floor();
            let part = place - low;
            let cell =
                |i: isize| (if self.periodic[a] { i.rem_euclid(n) } else { i.clamp(0, n - 1) }) as usize;
            [(cell(low as isize), 1.0 - part), (cell(low as isize + 1), part)]
        })
    }

    /// What a grain reads of itself; in a box of one coarse cell as in a wide one, on average.
    fn own(&self, at: &[Shares; D], shape: &Shape) -> f64 {
        let share = |a: usize| {
            let [(_, low), (_, high)] = at[a];
            if self.count[a] > 1 { (low * low + high * high) / self.size[a] } else { 2.0 / 3.0 / self.wanted }
        };
        (0..D).map(share).product::<f64>() * shape.volume
    }

    fn each_cell(&mut self, at: &[Shares; D], mut work: impl FnMut(&mut f64, f64)) {
        for corner in 0..1 << D {
            let (mut cell, mut weight, mut stride) = (0, 1.0, 1);
            for a in 0..D {
                let (i, share) = at[a][corner >> a & 1];
                cell += i * stride;
                weight *= share;
                stride *= self.count[a];
            }
            work(&mut self.solid[cell], weight);
        }
    }
}

/// δR of a sphere of radius `radius` in a packing of solid fraction `fraction`, m; `width`: the factor f.
pub fn excess(width: f64, spacing: f64, radius: f64, fraction: f64) -> f64 {
    let fraction = fraction.clamp(0.0, PACKED);
    let pore = 3.0 * fraction / (radius * (1.0 - fraction));
    let mean = MEAN_WIDTH * width * spacing;
    PI * PI / 12.0 * mean * mean * (1.0 / radius + pore) + spacing * spacing / 24.0 * pore
}
