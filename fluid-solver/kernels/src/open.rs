//! Faces that let fluid through: what enters is given, what leaves goes on as it came.
//!
//! Both are velocities on the face, for all components. An inflow keeps them. On an outflow they
//! follow the convective condition of Orlanski (1976), as of Pauley, Moin & Reynolds (1990)
//! ```text
//! ∂u/∂t + U_c ∂u/∂n = 0,   U_c = U max(1, (⟨|u_n|⟩/10U)²),   U = ⟨u_n⟩ over all outflow,
//! ```
//! the mean velocity. Where hardly anything leaves the face becomes as the fluid inside: what was on it when
//! an inflow stopped would else stay there, and drive a flow for ever. The condition is taken
//! upwind and implicit, u' = (u + C u_inside)/(1 + C) with C = U_c Δt/Δn: any Δt, never a new extreme.
//! A uniform shift of the normal component then makes what leaves equal what enters, to round-off,
//! so that the equation of the pressure has a solution with zero slope on every face and the direct
//! solvers of [`crate::helmholtz`] stay exact. In a steady flow that does not change along the
//! normal neither does anything.
//!
//! The values of a face stand for the whole stage that begins: the increments that the solvers see
//! are zero there.

use crate::boundary::{Boundary, Profile};
use crate::grid::{Geometry, Grid};

/// Mean velocity of an outflow over that of its size, below which hardly anything leaves.
const LITTLE: f64 = 0.1;

/// One open face and the velocity on it.
#[derive(Clone, Debug, PartialEq)]
pub struct OpenFace<const D: usize> {
    /// Axis that it stands across.
    pub axis: usize,
    /// 0 lower, 1 upper.
    pub side: usize,
    /// Whether fluid leaves here.
    pub outflow: bool,
    /// Velocity on the face, m/s: each component at its own nodes, indices `0..n` of the other axes,
    /// the first of them fastest.
    pub values: [Vec<f64>; D],
    /// Normal velocity of an inflow where its mean is 1; of an outflow none.
    shape: Vec<f64>,
}

/// All open faces of a grid: none for most.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct OpenFaces<const D: usize> {
    faces: Vec<OpenFace<D>>,
}

impl<const D: usize> OpenFaces<D> {
    /// The open faces of `grid`: inflow as it is described, outflow uniform.
    pub fn new(grid: &Grid<D>) -> Self {
        let mut faces = Vec::new();
        for axis in 0..D {
            for (side, boundary) in grid.boundaries[axis].iter().enumerate() {
                let len = grid.cell_count() / grid.cells[axis];
                let (values, shape) = match boundary {
                    Boundary::Inflow { velocity, profile } => {
                        let shape = std::mem::take(&mut inflow(grid, axis, &[1.0; D], *profile)[axis]);
                        (inflow(grid, axis, velocity, *profile), shape)
                    }
                    Boundary::Outflow => (std::array::from_fn(|_| vec![0.0; len]), Vec::new()),
                    _ => continue,
                };
                faces.push(OpenFace { axis, side, outflow: *boundary == Boundary::Outflow, values, shape });
            }
        }
        let mut open = Self { faces };
        open.balance(grid);
        open
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.faces.is_empty()
    }

    /// The faces, lower before upper, axis after axis.
    pub fn faces(&self) -> &[OpenFace<D>] {
        &self.faces
    }

    /// All values, field after field, for a checkpoint.
    pub fn fields(&self) -> impl Iterator<Item = &Vec<f64>> {
        self.faces.iter().flat_map(|face| &face.values)
    }

    /// The same, to be replaced.
    pub fn fields_mut(&mut self) -> impl Iterator<Item = &mut Vec<f64>> {
        self.faces.iter_mut().flat_map(|face| &mut face.values)
    }

    /// Gives an inflow face the mean velocity `mean`, m/s, in its own shape.
    pub(crate) fn enter(&mut self, axis: usize, side: usize, mean: [f64; D]) {
        let Some(face) = self.faces.iter_mut().find(|f| (f.axis, f.side) == (axis, side)) else { return };
        for (d, (values, mean)) in face.values.iter_mut().zip(mean).enumerate() {
            if d == axis {
                values.iter_mut().zip(&face.shape).for_each(|(value, shape)| *value = mean * shape);
            } else {
                values.fill(mean);
            }
        }
    }

    /// Gives every inflow face the velocities that it has in `other`.
    pub fn enter_as(&mut self, grid: &Grid<D>, other: &Self) {
        let mut changes = false;
        for (face, other) in self.faces.iter_mut().zip(&other.faces).filter(|(face, _)| !face.outflow) {
            if face.values != other.values {
                face.values.clone_from(&other.values);
                changes = true;
            }
        }
        if changes {
            self.balance(grid);
        }
    }

    /// Lets the outflow go on for `time` (s) with the velocity inside, halos of other faces aside.
    pub fn convect(&mut self, grid: &Grid<D>, velocity: &[Vec<f64>; D], time: f64) {
        let speed = self.outflow_speed(grid);
        for face in self.faces.iter_mut().filter(|face| face.outflow) {
            let cell = if face.side == 0 { 0 } else { grid.cells[face.axis] - 1 };
            let width = grid.axes[face.axis].widths[cell];
            for (d, values) in face.values.iter_mut().enumerate() {
                let distance = if d == face.axis { width } else { 0.5 * width };
                let courant = speed * time / distance;
                let keep = 1.0 / (1.0 + courant);
                let take = if courant < f64::INFINITY { courant / (1.0 + courant) } else { 1.0 };
                let layer = inside(grid, face.axis, face.side, d);
                for_each(grid, face.axis, layer, |entry, index| {
                    values[entry] = keep * values[entry] + take * velocity[d][index];
                });
            }
        }
        self.balance(grid);
    }

    /// Outflow as if it had always been like the velocity inside (initial conditions).
    pub fn follow(&mut self, grid: &Grid<D>, velocity: &[Vec<f64>; D]) {
        for face in self.faces.iter_mut().filter(|face| face.outflow) {
            for (d, values) in face.values.iter_mut().enumerate() {
                let layer = inside(grid, face.axis, face.side, d);
                for_each(grid, face.axis, layer, |entry, index| values[entry] = velocity[d][index]);
            }
        }
        self.balance(grid);
    }

    /// U_c, m/s; infinite where nothing enters and something moves on the faces.
    fn outflow_speed(&self, grid: &Grid<D>) -> f64 {
        let total = self.outflow_area(grid);
        if total == 0.0 {
            return 0.0;
        }
        let mean = (self.flow(grid, false) / total).max(0.0);
        let sizes = |face: &OpenFace<D>| -> f64 {
            let normal = face.values[face.axis].iter().enumerate();
            normal.map(|(entry, u)| area(grid, face, entry) * u.abs()).sum()
        };
        let size = self.faces.iter().filter(|face| face.outflow).map(sizes).sum::<f64>() / total;
        if LITTLE * size > mean { (LITTLE * size).powi(2) / mean } else { mean }
    }

    /// Area of the outflow faces.
    fn outflow_area(&self, grid: &Grid<D>) -> f64 {
        let areas = |face: &OpenFace<D>| -> f64 {
            (0..face.values[face.axis].len()).map(|entry| area(grid, face, entry)).sum()
        };
        self.faces.iter().filter(|face| face.outflow).map(areas).sum()
    }

    /// Flow in the sense of the faces, into the box for inflow, out of it for outflow, m³/s (plane: per metre
    /// of depth).
    pub fn flow(&self, grid: &Grid<D>, outflow: bool) -> f64 {
        let mut sum = 0.0;
        for face in self.faces.iter().filter(|face| face.outflow == outflow) {
            let normal = face.values[face.axis].iter().enumerate();
            let upward: f64 = normal.map(|(entry, u)| area(grid, face, entry) * u).sum();
            sum += if (face.side == 0) == outflow { -upward } else { upward };
        }
        sum
    }

    /// Shifts the outflow so that as much leaves as enters.
    fn balance(&mut self, grid: &Grid<D>) {
        let total = self.outflow_area(grid);
        if total == 0.0 {
            return;
        }
        let lacking = (self.flow(grid, false) - self.flow(grid, true)) / total;
        for face in self.faces.iter_mut().filter(|face| face.outflow) {
            let shift = if face.side == 0 { -lacking } else { lacking };
            face.values[face.axis].iter_mut().for_each(|u| *u += shift);
        }
    }

    /// Writes the faces across `axis` to component `d`: the face itself and its halo.
    ///
    /// Whole layers are then completed by the walls of the other axes.
    pub fn fill_across(&self, grid: &Grid<D>, d: usize, axis: usize, u: &mut [f64]) {
        for face in self.faces.iter().filter(|face| face.axis == axis) {
            let (values, stride) = (&face.values[d], grid.stride(axis));
            let n = grid.cells[axis] as isize;
            let at = if face.side == 1 {
                n
            } else if d == axis {
                0
            } else {
                -1
            };
            for_each(grid, axis, at, |entry, index| {
                let value = values[entry];
                match (d == axis, face.side) {
                    (true, 1) => u[index] = value,
                    (true, _) => {
                        u[index] = value;
                        u[index - stride] = 2.0 * value - u[index + stride];
                    }
                    (false, 1) => u[index] = 2.0 * value - u[index - stride],
                    (false, _) => u[index] = 2.0 * value - u[index + stride],
                }
            });
        }
    }
}

/// Index along `axis` of the first value of component `d` inside face `side`.
fn inside<const D: usize>(grid: &Grid<D>, axis: usize, side: usize, d: usize) -> isize {
    match side {
        0 => isize::from(d == axis),
        _ => grid.cells[axis] as isize - 1,
    }
}

/// Indices of entry `entry` of a layer across `axis`; 0 along `axis`.
fn across<const D: usize>(grid: &Grid<D>, axis: usize, mut entry: usize) -> [usize; D] {
    std::array::from_fn(|a| {
        if a == axis {
            return 0;
        }
        let at = entry % grid.cells[a];
        entry /= grid.cells[a];
        at
    })
}

/// Visits the layer `at` across `axis`: number of the entry and its place in a field.
fn for_each<const D: usize>(grid: &Grid<D>, axis: usize, at: isize, mut visit: impl FnMut(usize, usize)) {
    let inner = usize::from(axis == 0);
    let outer = (0..D).find(|a| *a != axis && *a != inner);
    let (count, stride) = (grid.cells[inner], grid.stride(inner));
    for k in 0..outer.map_or(1, |outer| grid.cells[outer]) {
        let mut first = [0; D];
        first[axis] = at;
        if let Some(outer) = outer {
            first[outer] = k as isize;
        }
        let start = grid.index(first);
        for j in 0..count {
            visit(k * count + j, start + j * stride);
        }
    }
}

/// Area of entry `entry` of a face, m² (plane: per metre of depth; axisymmetric: the full turn).
fn area<const D: usize>(grid: &Grid<D>, face: &OpenFace<D>, entry: usize) -> f64 {
    let at = across(grid, face.axis, entry);
    let own = grid.axes[face.axis].face_area[face.side * grid.cells[face.axis]];
    let others = (0..D).filter(|a| *a != face.axis);
    others.fold(grid.turn() * own, |area, a| area * grid.axes[a].cell_volume[at[a]])
}

/// Velocity of an inflow: the mean `velocity`, its normal component in the shape of `profile`.
fn inflow<const D: usize>(
    grid: &Grid<D>,
    axis: usize,
    velocity: &[f64; D],
    profile: Profile,
) -> [Vec<f64>; D] {
    let shapes: [Vec<f64>; D] = std::array::from_fn(|a| match profile {
        Profile::Parabolic if a != axis => shape(grid, a),
        _ => vec![1.0; grid.cells[a]],
    });
    let len = grid.cell_count() / grid.cells[axis];
    std::array::from_fn(|d| {
        let value = |entry| {
            let at = across(grid, axis, entry);
            let normal = d == axis;
            (0..D).filter(|a| normal && *a != axis).fold(velocity[d], |u, a| u * shapes[a][at[a]])
        };
        (0..len).map(value).collect()
    })
}

/// The laminar profile along `axis` that its walls make, mean over each cell, mean 1 over all.
fn shape<const D: usize>(grid: &Grid<D>, axis: usize) -> Vec<f64> {
    let [low, high] = grid.boundaries[axis].map(|face| face.is_odd());
    let a = &grid.axes[axis];
    let (n, length) = (a.cells(), a.length());
    // ∫ of the profile (times r on a radial axis) from the lower end to s, 0 ≤ s ≤ 1.
    let radial = a.radial && grid.geometry == Geometry::Axisymmetric;
    let integral = |s: f64| match (low, high) {
        (true, true) => s * s * (0.5 - s / 3.0),
        (false, true) if radial => s * s * (0.5 - 0.25 * s * s),
        (false, true) => s - s.powi(3) / 3.0,
        (true, false) => s * s * (1.0 - s / 3.0),
        (false, false) if radial => 0.5 * s * s,
        (false, false) => s,
    };
    let at = |i: usize| integral((a.faces[i] - a.faces[0]) / length);
    let mean = at(n) / a.cell_volume.iter().sum::<f64>();
    (0..n).map(|i| (at(i + 1) - at(i)) / (a.cell_volume[i] * mean)).collect()
}
