//! The staggered grid: geometry as data, the number of axes as a type.
//!
//! # Axes
//! Plane: (x, z), per unit depth. Axisymmetric: (r, z), volumes over the full turn 2π.
//! Space: (x, y, z). Axis 0 runs fastest in memory.
//!
//! # Where values live (marker-and-cell, Harlow & Welch 1965)
//! Cell `i` of an axis lies between faces `i` and `i + 1`. Pressure sits at cell centres. Velocity
//! component `d` sits on the faces of axis `d` and at the centres of the other axes: its value with
//! index `i` along axis `d` is on the **lower** face of cell `i`, at `faces[i]`.
//!
//! # Which values are unknown
//! Along its own axis, component `d` has the faces `0..n` on a periodic axis (face `n` repeats face
//! 0) and `1..n` between walls (faces 0 and `n` are the walls, or r = 0, and hold the wall's normal
//! velocity, zero, or that of an open face). Along the other axes it has `0..n`. See [`Grid::unknowns`].
//!
//! # Memory
//! Every field (each velocity component, pressure, forces, masks) has the same layout: a flat
//! `Vec<f64>` of [`Grid::len`] values with one halo layer on each side of each axis. The value with
//! indices `(i, j, k)`, each from −1 to `n` inclusive, is at
//! `index = 6 + i + (j + 1)·stride(1) + (k + 1)·stride(2)` (the last term in space only).
//! The row stride is padded, so the left halo of a row is the last pad of the row before.
//! [`Grid::new_field`] makes a field of zeros; [`Grid::row`] gives the place of `(0, j, k)`.

pub use crate::axis::GridError;
use crate::axis::{Axis, AxisSpec};
use crate::boundary::Boundary;
use crate::division::{Division, DivisionError};
use crate::ranks::Ranks;
use std::ops::Range;

/// Values before the first row, so that its left halo exists and rows start on a cache line: the
/// large blocks that glibc hands out begin 16 bytes after a page.
const LEAD: usize = 6;

/// Geometry of a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Geometry {
    /// Two axes (x, z), everything per unit depth.
    Plane,
    /// Two axes (r, z) without swirl, integrals over the full turn.
    Axisymmetric,
    /// Three axes (x, y, z).
    Space,
}

impl Geometry {
    /// Number of axes of a grain: 3 for a sphere, 2 for a disc.
    pub fn grain_dimensions(self) -> i32 {
        if self == Self::Plane { 2 } else { 3 }
    }
}

/// Description of a grid, to be checked by [`Grid::new`].
#[derive(Clone, Debug, PartialEq)]
pub struct GridSpec<const D: usize> {
    /// Geometry; its number of axes must be `D`.
    pub geometry: Geometry,
    /// Division of each axis.
    pub axes: [AxisSpec; D],
    /// Conditions on the lower and upper face of each axis.
    pub boundaries: [[Boundary<D>; 2]; D],
}

/// A staggered grid with `D` axes. See the module for positions and memory layout.
#[derive(Clone, Debug)]
pub struct Grid<const D: usize> {
    /// Plane, axisymmetric or space.
    pub geometry: Geometry,
    /// The axes.
    pub axes: [Axis; D],
    /// Number of cells along each axis.
    pub cells: [usize; D],
    /// Conditions on the lower and upper face of each axis.
    pub boundaries: [[Boundary<D>; 2]; D],
    /// Who works on which of its planes.
    pub division: Division,
    strides: [usize; D],
    len: usize,
}

impl<const D: usize> Grid<D> {
    /// Checks a description and builds the grid.
    ///
    /// # Errors
    /// See [`GridError`].
    pub fn new(spec: &GridSpec<D>) -> Result<Self, GridError> {
        let needed = if spec.geometry == Geometry::Space { 3 } else { 2 };
        if needed != D {
            let geometry = spec.geometry;
            return Err(GridError(format!(
                "{geometry:?} geometry has {needed} axes, but the grid was given {D}"
            )));
        }
        check_boundaries(spec)?;
        let mut axes = Vec::with_capacity(D);
        for (a, axis) in spec.axes.iter().enumerate() {
            let periodic = spec.boundaries[a][0].is_periodic();
            let radial = a == 0 && spec.geometry == Geometry::Axisymmetric;
            axes.push(Axis::new(a, axis, periodic, radial)?);
        }
        check_axes(spec, &axes)?;
        let cells = std::array::from_fn(|a| axes[a].cells());
        let (strides, len) = layout(&cells);
        let axes = axes.try_into().expect("one axis was pushed for each of D");
        let division = Division::whole(cells[D - 1]);
        Ok(Self { geometry: spec.geometry, axes, cells, boundaries: spec.boundaries, division, strides, len })
    }

    /// The same grid, its planes in blocks that `ranks` share (see [`crate::division`]).
    ///
    /// # Errors
    /// If it has two axes, too few planes, or faces that fluid passes through while there are several ranks.
    pub fn divided(mut self, ranks: Ranks) -> Result<Self, DivisionError> {
        if D < 3 {
            return Err(DivisionError::Axes);
        }
        if self.is_open() && !ranks.is_alone() {
            return Err(DivisionError::Open);
        }
        self.division = Division::new(self.cells[D - 1], ranks)?;
        Ok(self)
    }

    /// The same grid as one process has it.
    pub fn undivided(&self) -> Self {
        Self { division: Division::whole(self.cells[D - 1]), ..self.clone() }
    }

    /// Length of every field, halo and padding included.
    #[allow(clippy::len_without_is_empty, reason = "a grid is never empty")]
    pub fn len(&self) -> usize {
        self.len
    }

    /// A field of zeros.
    pub fn new_field(&self) -> Vec<f64> {
        vec![0.0; self.len]
    }

    /// One field of zeros per velocity component.
    pub fn new_vector(&self) -> [Vec<f64>; D] {
        std::array::from_fn(|_| self.new_field())
    }

    /// Number of cells.
    pub fn cell_count(&self) -> usize {
        self.cells.iter().product()
    }

    /// Distance in memory between neighbours along `axis`.
    pub fn stride(&self, axis: usize) -> usize {
        self.strides[axis]
    }

    /// Place of the value with indices `at`, each from −1 (halo) to `n` inclusive.
    pub fn index(&self, at: [isize; D]) -> usize {
        let mut index = LEAD as isize + at[0];
        for (i, stride) in at.iter().zip(&self.strides).skip(1) {
            index += (i + 1) * *stride as isize;
        }
        index as usize
    }

    /// Number of interior rows along axis 0 (cells of all other axes).
    pub fn rows(&self) -> usize {
        self.cells[1..].iter().product()
    }

    /// The interior rows on the planes that this process works on.
    pub fn own_rows(&self) -> Range<usize> {
        let (own, each) = (self.division.own(), self.rows() / self.cells[D - 1]);
        own.start * each..own.end * each
    }

    /// Where planes `from..to` of a grid in space lie in a field, from −1 to `n` inclusive; all but the left
    /// halo of the row −1 of the first, which nothing asks for.
    pub fn planes(&self, from: isize, to: isize) -> Range<usize> {
        let at = |k: isize| LEAD + (k + 1) as usize * self.strides[D - 1];
        at(from)..at(to)
    }

    /// Place of the value `i = 0` of interior row `row`, with `row = j + n₁ k`.
    pub fn row(&self, row: usize) -> usize {
        if D == 2 {
            LEAD + (row + 1) * self.strides[1]
        } else {
            let (j, k) = (row % self.cells[1], row / self.cells[1]);
            LEAD + (j + 1) * self.strides[1] + (k + 1) * self.strides[D - 1]
        }
    }

    /// Whether fluid passes through any face.
    pub fn is_open(&self) -> bool {
        self.boundaries.iter().flatten().any(Boundary::is_open)
    }

    /// Whether the field goes on periodically along `axis`.
    pub fn periodic(&self, axis: usize) -> bool {
        self.boundaries[axis][0].is_periodic()
    }

    /// Indices along each axis of the values of component `d` that the solver computes.
    pub fn unknowns(&self, d: usize) -> [Range<usize>; D] {
        std::array::from_fn(|a| {
            let first = usize::from(a == d && !self.periodic(a));
            first..self.cells[a]
        })
    }

    /// The same with those on faces through which fluid passes: all values that fill the volume.
    pub fn values(&self, d: usize) -> [Range<usize>; D] {
        let mut ranges = self.unknowns(d);
        if let Some(range) = ranges.get_mut(d) {
            let [lower, upper] = &self.boundaries[d];
            range.start -= usize::from(lower.is_open());
            range.end += usize::from(upper.is_open());
        }
        ranges
    }

    /// Positions along `axis` of the values of component `d`, m; entry `i` belongs to index `i`.
    ///
    /// Faces (`n + 1` entries) along the component's own axis, else centres (`n`).
    pub fn nodes(&self, d: usize, axis: usize) -> &[f64] {
        if d == axis { &self.axes[axis].faces } else { &self.axes[axis].centres }
    }

    /// Factor along `axis` of the control volumes of component `d`; entries as in [`Grid::nodes`].
    pub fn volumes(&self, d: usize, axis: usize) -> &[f64] {
        if d == axis { &self.axes[axis].face_volume } else { &self.axes[axis].cell_volume }
    }

    /// What multiplies the product of the axes' factors: 2π for the full turn, else 1.
    pub fn turn(&self) -> f64 {
        if self.geometry == Geometry::Axisymmetric { std::f64::consts::TAU } else { 1.0 }
    }

    /// Control volume of the value of component `d` at indices `at`: m³ (plane: m³ per metre of
    /// depth, axisymmetric: the full turn). At a wall face, the half that lies in the fluid.
    pub fn control_volume(&self, d: usize, at: [usize; D]) -> f64 {
        (0..D).fold(self.turn(), |v, a| v * self.volumes(d, a)[at[a]])
    }

    /// Volume of the cell at indices `at`, in the unit of [`Grid::control_volume`].
    pub fn cell_volume(&self, at: [usize; D]) -> f64 {
        (0..D).fold(self.turn(), |v, a| v * self.axes[a].cell_volume[at[a]])
    }

    /// The axis with unequal cells or a metric, where the direct solver must sweep.
    pub fn swept_axis(&self) -> Option<usize> {
        (0..D).find(|&a| !self.axes[a].is_transformable())
    }

    /// Smallest cell width of the whole grid, m.
    pub fn smallest_width(&self) -> f64 {
        self.axes.iter().flat_map(|a| &a.widths).fold(f64::INFINITY, |m, &w| m.min(w))
    }
}

/// Strides and length of a field: rows padded to whole cache lines, away from powers of two.
fn layout<const D: usize>(cells: &[usize; D]) -> ([usize; D], usize) {
    let mut strides = [1; D];
    let mut stride = (cells[0] + 2).next_multiple_of(8);
    if stride.is_multiple_of(64) {
        stride += 8;
    }
    for a in 1..D {
        strides[a] = stride;
        stride *= cells[a] + 2;
        if stride.is_multiple_of(512) {
            stride += 8;
        }
    }
    (strides, LEAD + stride)
}

/// Refuses conditions that contradict each other.
fn check_boundaries<const D: usize>(spec: &GridSpec<D>) -> Result<(), GridError> {
    for (axis, faces) in spec.boundaries.iter().enumerate() {
        if faces[0].is_periodic() != faces[1].is_periodic() {
            return Err(GridError(format!(
                "axis {axis} is periodic on one face only: make both faces periodic, or neither"
            )));
        }
        for (side, face) in faces.iter().enumerate() {
            let radial = axis == 0 && side == 0 && spec.geometry == Geometry::Axisymmetric;
            if matches!(face, Boundary::Axis) && !radial {
                return Err(misplaced_axis(axis, side));
            }
            if face.is_open() && axis == 0 && spec.geometry == Geometry::Axisymmetric {
                return Err(GridError(format!(
                    "face {side} of axis {axis} is radial: fluid enters and leaves along z only"
                )));
            }
            let velocity = face.velocity(axis);
            if velocity != 0.0 {
                return Err(GridError(format!(
                    "the wall on face {side} of axis {axis} has the normal velocity {velocity}: walls move \
                     in their own plane only, set it to 0"
                )));
            }
        }
    }
    Ok(())
}

fn misplaced_axis(axis: usize, side: usize) -> GridError {
    GridError(format!(
        "face {side} of axis {axis}: the axis of symmetry belongs on the lower face of axis 0 of an \
         axisymmetric grid that starts at r = 0, and nothing else can stand there"
    ))
}

/// Refuses axes that the direct solver cannot treat.
fn check_axes<const D: usize>(spec: &GridSpec<D>, axes: &[Axis]) -> Result<(), GridError> {
    let mut swept = (0..D).filter(|&a| !axes[a].is_transformable());
    if let (Some(first), Some(second)) = (swept.next(), swept.next()) {
        return Err(GridError(format!(
            "axes {first} and {second} are both stretched or radial: the direct solver allows one; make the \
             other uniform"
        )));
    }
    if let Some(axis) = (0..D - 1).find(|&a| D == 3 && !axes[a].is_transformable()) {
        return Err(GridError(format!(
            "axis {axis} is stretched: in space only the last axis (z) may be; rename the axes of the scene"
        )));
    }
    for (a, axis) in axes.iter().enumerate() {
        if spec.boundaries[a][0].is_periodic() && !axis.is_transformable() {
            return Err(GridError(format!(
                "axis {a} is periodic: its cells must be equal and it cannot be radial"
            )));
        }
        let on_axis = matches!(spec.boundaries[a][0], Boundary::Axis);
        if axis.radial && on_axis != (axis.faces[0] == 0.0) {
            return Err(misplaced_axis(a, 0));
        }
    }
    Ok(())
}
