//! Divergence and gradient: the two halves of the projection (Chorin 1968).

use crate::grid::Grid;

/// Inverse lengths of each axis, ready for the kernels.
#[derive(Clone, Debug)]
pub struct Projection<const D: usize> {
    /// `A_i / V_i` per cell: weight of the lower face in the divergence, 1/m.
    low: [Vec<f64>; D],
    /// `A_{i+1} / V_i` per cell: weight of the upper face, 1/m.
    high: [Vec<f64>; D],
    /// 1 / distance between centres, per face, 1/m.
    slope: [Vec<f64>; D],
}

impl<const D: usize> Projection<D> {
    /// Gathers the inverse lengths.
    pub fn new(grid: &Grid<D>) -> Self {
        let weights = |a: usize, o: usize| {
            let axis = &grid.axes[a];
            (0..axis.cells()).map(|i| axis.face_area[i + o] / axis.cell_volume[i]).collect()
        };
        Self {
            low: std::array::from_fn(|a| weights(a, 0)),
            high: std::array::from_fn(|a| weights(a, 1)),
            slope: std::array::from_fn(|a| grid.axes[a].distances.iter().map(|h| 1.0 / h).collect()),
        }
    }

    /// ∇·u = (1/V) Σ_faces ± A u on interior row `row`, stored in `out` (values `0..n`), 1/s.
    #[inline(always)]
    pub fn divergence_row(&self, grid: &Grid<D>, velocity: &[Vec<f64>; D], row: usize, out: &mut [f64]) {
        let n = out.len();
        let start = grid.row(row);
        let (low, high) = (&self.low[0][..n], &self.high[0][..n]);
        let (below, above) = (&velocity[0][start..][..n], &velocity[0][start + 1..][..n]);
        for i in 0..n {
            out[i] = high[i] * above[i] - low[i] * below[i];
        }
        let at = [0, row % grid.cells[1], row / grid.cells[1]];
        for a in 1..D {
            let (low, high) = (self.low[a][at[a]], self.high[a][at[a]]);
            let u = &velocity[a];
            let (below, above) = (&u[start..][..n], &u[start + grid.stride(a)..][..n]);
            for i in 0..n {
                out[i] += high * above[i] - low * below[i];
            }
        }
    }

    /// Adds `weight ∂p/∂x_d` at the nodes of component `d` on row `row` to `out` (values `0..n`).
    #[inline(always)]
    pub fn add_gradient_row(
        &self,
        grid: &Grid<D>,
        d: usize,
        weight: f64,
        p: &[f64],
        row: usize,
        out: &mut [f64],
    ) {
        let n = out.len();
        let start = grid.row(row);
        let here = &p[start..][..n];
        let below = &p[start - grid.stride(d)..][..n];
        if d == 0 {
            let slope = &self.slope[0][..n];
            for i in 0..n {
                out[i] += weight * slope[i] * (here[i] - below[i]);
            }
        } else {
            let at = if d == 1 { row % grid.cells[1] } else { row / grid.cells[1] };
            let weight = weight * self.slope[d][at];
            for i in 0..n {
                out[i] += weight * (here[i] - below[i]);
            }
        }
    }
}
