//! Averages of both phases over planes of cells: `fields/planes_<step>.csv`, and their mean over time.
//!
//! The phases part a cell by the smooth volume fraction of the grains (Izard et al. 2014, eq. 8), which
//! depends neither on the time step nor on the mask that forces the fluid, of a radius with which it holds
//! the grain's own volume. With α the fraction, u the velocity of the fluid at the centres and v = U + ω × r
//! that of the grains,
//! ```text
//! φ = ⟨α⟩,   ū = ⟨(1 − α) u⟩/⟨1 − α⟩,   v̄ = ⟨α v⟩/⟨α⟩
//! ```
//! Stresses: `crate::stress`.

use crate::grid::{Geometry, Grid};
use crate::immersed::body::{Motion, Shape, laboratory};
use crate::immersed::by_layer::Placed;
use crate::immersed::layer_sums::{first, for_each_layer};
use crate::immersed::mask_model::{Mask, MaskModel};
use crate::solver::Solver;
use crate::stress::stresses;
use bedload_output::planes::{Plane, Planes, Stresses};
use protocol::new_file::write_new;
use protocol::participant::{SolverError, Window};
use std::path::Path;

/// Sums over one plane.
#[derive(Clone, Copy, Default)]
struct Sums {
    solid: f64,
    fluid: f64,
    momentum: [[f64; 3]; 2],
    /// Of the velocities of centres, and of their squares.
    centres: ([f64; 3], f64),
}

impl Sums {
    /// (⟨v²⟩ − ⟨v⟩²)/`axes` of the centres' velocities v, weighed with what is solid, m²/s².
    fn temperature(&self, axes: usize) -> f64 {
        if self.solid == 0.0 {
            return 0.0;
        }
        let mean = self.centres.0.map(|sum| sum / self.solid);
        (self.centres.1 / self.solid - mean.iter().map(|v| v * v).sum::<f64>()).max(0.0) / axes as f64
    }
}

/// Writes the averages after `window`.
pub fn write<const D: usize>(
    solver: &mut Solver<D>,
    axis: usize,
    window: &Window,
    folder: &Path,
) -> Result<(), SolverError> {
    let gathered = solver.gather_force();
    if !solver.show() {
        return Ok(());
    }
    let mut planes = averages(solver, axis);
    if let Some(kept) = &solver.kept {
        let force = gathered.as_ref().or(solver.grains.force());
        for (plane, found) in planes.iter_mut().zip(stresses(solver, axis, force, kept)) {
            plane.stresses = plane.stresses.map(|had| Stresses { temperature: had.temperature, ..found });
        }
    }
    let planes = Planes { times: vec![(window.time + window.dt, 1.0)], planes };
    let path = folder.join(Planes::file_name(window.step));
    let save = || {
        std::fs::create_dir_all(folder)?;
        write_new(&path, planes.to_string().as_bytes())
    };
    save().map_err(|source| SolverError::File { path: path.display().to_string(), source })
}

/// One entry per plane of cells across grid axis `axis`.
pub fn averages<const D: usize>(solver: &Solver<D>, axis: usize) -> Vec<Plane> {
    let grid = solver.grid();
    let mut sums = vec![Sums::default(); grid.cells[axis]];
    let fractions = add_grains(solver, axis, &mut sums);
    add_fluid(solver, axis, &fractions, &mut sums);
    let axis = &grid.axes[axis];
    let plane = |(k, sums): (usize, &Sums)| {
        let mean = |phase: usize, amount: f64| {
            sums.momentum[phase].map(|m| if amount > 0.0 { m / amount } else { 0.0 })
        };
        Plane {
            at: axis.centres[k],
            width: axis.widths[k],
            solid_fraction: sums.solid / (sums.solid + sums.fluid),
            fluid_velocity: mean(0, sums.fluid),
            grain_velocity: mean(1, sums.solid),
            stresses: solver
                .kept
                .as_ref()
                .map(|_| Stresses { temperature: sums.temperature(D), ..Stresses::default() }),
        }
    };
    sums.iter().enumerate().map(plane).collect()
}

/// Mean of (λσ)² of the smooth fraction (Izard et al. 2014, eqs 9, 10) over the normals of a disc and of a
/// sphere.
const THICKNESS: [f64; 2] = [0.195_21, 0.208_45];

/// Radius with which a smooth fraction holds the volume of a round grain. An edge whose slope has the
/// variance s² = π² w²/12 along the normal makes a disc of radius r hold π (r² + s²), a sphere
/// 4π/3 (r³ + 3 r s²).
fn radius<const D: usize>(grid: &Grid<D>, width: f64, shape: &Shape, motion: &Motion) -> f64 {
    let disc = grid.geometry == Geometry::Plane;
    let cell = |a: usize| grid.axes[a].width_at(motion.centre[laboratory(grid.geometry, a)]);
    let square = (0..D).map(cell).product::<f64>().powf(2.0 / D as f64);
    let s2 = std::f64::consts::PI.powi(2) / 6.0 * width.powi(2) * THICKNESS[usize::from(!disc)] * square;
    let whole = shape.radius;
    if shape.outline.is_some() || whole * whole <= 3.0 * s2 {
        whole
    } else if disc {
        (whole * whole - s2).sqrt()
    } else {
        // r (r² + 3 s²) = R³ by Newton's method
        (0..6).fold(whole, |r, _| r - (r * (r * r + 3.0 * s2) - whole.powi(3)) / (3.0 * (r * r + s2)))
    }
}

/// Adds what the grains fill and how it moves; returns the mask ratios of the solid in every cell.
fn add_grains<const D: usize>(solver: &Solver<D>, axis: usize, sums: &mut [Sums]) -> Vec<f64> {
    let grid = solver.grid();
    let model = MaskModel { mask: Mask::Izard2014, ..*solver.mask_model() };
    let pairs = solver.immersed().shapes().iter().zip(solver.motions());
    let shapes: Vec<Shape> = pairs
        .map(|(shape, motion)| Shape {
            mask_radius: radius(grid, model.width, shape, motion),
            ..shape.clone()
        })
        .collect();
    let mut ratios = grid.new_field();
    let placed = Placed { grid, model: &model, shapes: &shapes, motions: solver.motions() };
    for_each_layer(placed, 0..grid.cells[D - 1], |k, layer_sums, grains, nodes| {
        let layer = &mut ratios[first(grid, k)..];
        layer.iter_mut().zip(&layer_sums.totals).for_each(|(sum, total)| *sum += total);
        for (part, spans, mut ratios) in grains.parts() {
            let motion = &solver.motions()[part.grain];
            for span in spans {
                let (row, rest) = ratios.split_at(span.count);
                ratios = rest;
                for (place, q) in row.iter().enumerate().filter(|(_, q)| **q > 0.0) {
                    let i = span.first + place;
                    let arm = [nodes.along(i) + span.shift, span.middle, part.arm];
                    let part = q / (1.0 + layer_sums.totals[span.at + place])
                        * grid.axes[0].cell_volume[i]
                        * span.weight;
                    let plane = [i, span.at / grid.stride(1), k][if axis == D - 1 { 2 } else { axis }];
                    sums[plane].solid += part;
                    sums[plane].centres.1 += part * motion.velocity.iter().map(|v| v * v).sum::<f64>();
                    for c in 0..3 {
                        sums[plane].momentum[1][c] += part * motion.velocity_at(c, arm);
                        sums[plane].centres.0[c] += part * motion.velocity[c];
                    }
                }
            }
        }
    });
    ratios
}

/// Adds the fluid between the grains.
fn add_fluid<const D: usize>(solver: &Solver<D>, axis: usize, ratios: &[f64], sums: &mut [Sums]) {
    let grid: &Grid<D> = solver.grid();
    for row in 0..grid.rows() {
        let start = grid.row(row);
        let rest = [0, row % grid.cells[1], row / grid.cells[1]];
        let across = (1..D).fold(grid.turn(), |v, a| v * grid.axes[a].cell_volume[rest[a]]);
        for (i, volume) in grid.axes[0].cell_volume.iter().enumerate() {
            let index = start + i;
            let part = across * volume / (1.0 + ratios[index]);
            let sums = &mut sums[if axis == 0 { i } else { rest[axis] }];
            sums.fluid += part;
            for (a, u) in solver.stepper().state().velocity.iter().enumerate() {
                let centred = 0.5 * (u[index] + u[index + grid.stride(a)]);
                sums.momentum[0][laboratory(grid.geometry, a)] += part * centred;
            }
        }
    }
}
