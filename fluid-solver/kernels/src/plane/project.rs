//! Divergence and gradient on two axes: the two halves of the projection (Chorin 1968).

use crate::grid::Grid;

/// Inverse lengths of each axis, ready for the kernels.
#[derive(Clone, Debug)]
pub(super) struct Projection<const D: usize> {
    /// `A_i / V_i` per cell: weight of the lower face in the divergence, 1/m.
    low: [Vec<f64>; D],
    /// `A_{i+1} / V_i` per cell: weight of the upper face, 1/m.
    high: [Vec<f64>; D],
    /// 1 / distance between centres, per face, 1/m.
    pub(super) slope: [Vec<f64>; D],
}

impl<const D: usize> Projection<D> {
    pub(super) fn new(grid: &Grid<D>) -> Self {
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

    /// The end of a projection on interior row `row`, around which φ is given: `u −= weight ∇φ`,
    /// `p += φ − correction ∇²φ`. The results are arguments, which tells that they overlap nothing.
    #[inline(always)]
    pub(super) fn finish(
        &self,
        [weight, correction]: [f64; 2],
        [left, mid, right, under, over]: [&[f64]; 5],
        row: usize,
        u: &mut [f64],
        w: &mut [f64],
        p: &mut [f64],
    ) {
        let n = p.len();
        let (u, w, p) = (&mut u[..n], &mut w[..n], &mut p[..n]);
        let (left, mid, right, under, over) = (&left[..n], &mid[..n], &right[..n], &under[..n], &over[..n]);
        let (low, high) = (&self.low[0][..n], &self.high[0][..n]);
        let (slope, next) = (&self.slope[0][..n], &self.slope[0][1..][..n]);
        let (slope_under, slope_over) = (self.slope[1][row], self.slope[1][row + 1]);
        let (low_across, high_across) = (self.low[1][row], self.high[1][row]);
        for i in 0..n {
            let west = slope[i] * (mid[i] - left[i]);
            let east = next[i] * (right[i] - mid[i]);
            let south = slope_under * (mid[i] - under[i]);
            let north = slope_over * (over[i] - mid[i]);
            let laplacian = (high[i] * east - low[i] * west) + (high_across * north - low_across * south);
            u[i] -= weight * west;
            w[i] -= weight * south;
            p[i] += mid[i] - correction * laplacian;
        }
    }

    /// ∇·u = (1/V) Σ_faces ± A u on interior row `row`, stored in `out`, 1/s; the result is an argument,
    /// which tells that it overlaps nothing.
    #[inline(always)]
    pub(super) fn divergence(
        &self,
        [left, right]: [&[f64]; 2],
        [under, over]: [&[f64]; 2],
        row: usize,
        out: &mut [f64],
    ) {
        let n = out.len();
        let (low, high) = (&self.low[0][..n], &self.high[0][..n]);
        let (left, right, under, over) = (&left[..n], &right[..n], &under[..n], &over[..n]);
        let (low_across, high_across) = (self.low[1][row], self.high[1][row]);
        for i in 0..n {
            out[i] =
                (high[i] * right[i] - low[i] * left[i]) + (high_across * over[i] - low_across * under[i]);
        }
    }

    /// Adds `weight ∂p/∂x_d` at the nodes of component `d` on row `row` to `out` (values `0..n`).
    #[inline(always)]
    pub(super) fn add_gradient_row(
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
            let weight = weight * self.slope[d][row];
            for i in 0..n {
                out[i] += weight * (here[i] - below[i]);
            }
        }
    }
}
