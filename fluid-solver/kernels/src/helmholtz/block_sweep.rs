//! A column whole, or cut into blocks, each swept by itself (Laszlo, Giles & Appleyard 2016; Kim et al. 2021,
//! PaScaL_TDMA). Pivots are computed on the way: a division takes no longer than fetching the result of an
//! earlier one from memory, and needs none.
//!
//! With x₋ the value below a block and x₊ the one above, elimination leaves in each of its rows
//! ```text
//! x_i = g_i + f_i x₋ + s_i x_{i+1}
//! ```
//! and so, for its first and last value, its [`Edge`]
//! ```text
//! x_last = g + f x₋ + s x₊,    x_first = Σ w_i (g_i + f_i x₋) + w_last s_last x₊,    w_i = s_0 … s_{i−1}.
//! ```
//! The edges of all blocks are joined, see [`super::block_tree`]. With x₋ and x₊ known a second pass
//! substitutes. Of a whole column there is nothing beside, and no f.
//!
//! Operations and their order depend on the blocks alone, not on who does which.

use super::blocks::SIDE;
use crate::lanes::{Kernel, Lanes};
use crate::tridiagonal::Sweep;
use pulp::Simd;
use std::ops::Range;

/// Modes that are worked on side by side.
pub(super) const GROUP: usize = 8 * SIDE;

/// One value of each mode of a group.
pub(super) type Wide = [f64; GROUP];

/// g, f, s of the last row; the constant of the first value, and what it takes of x₋ and x₊.
pub(super) type Edge = [Wide; 6];

/// x₋ and x₊.
pub(super) type Beside = [Wide; 2];

/// g, s and, of a block, f of a row.
pub(super) type Row<const N: usize> = [[Lanes; SIDE]; N];

/// Values in a row of a block.
pub(super) const BLOCK: usize = 3;

/// Values in a row of a whole column.
pub(super) const WHOLE: usize = 2;

/// What all blocks of a group share.
#[derive(Clone, Copy)]
pub(super) struct Group<'a> {
    pub(super) sweep: &'a Sweep,
    pub(super) operator: [f64; 2],
    pub(super) scale: f64,
    pub(super) lambda: &'a Wide,
}

/// The first pass over a block, straight from the planes.
pub(super) struct Eliminate<'a, 'b, const N: usize> {
    pub(super) group: Group<'a>,
    /// Unknowns of the block.
    pub(super) block: Range<usize>,
    /// Where the group stands in each plane.
    pub(super) at: Range<usize>,
    /// The planes of the block.
    pub(super) source: &'a [&'b mut [f64]],
    /// What each row leaves.
    pub(super) rows: &'a mut [Row<N>],
    /// Of one of several blocks.
    pub(super) edge: Option<&'a mut Edge>,
}

impl<const N: usize> Kernel for Eliminate<'_, '_, N> {
    #[inline(always)]
    #[allow(clippy::needless_range_loop, reason = "one index runs over several arrays")]
    fn run<S: Simd>(self, simd: S) {
        let Self { group, block, at, source, rows, edge } = self;
        let Group { sweep, operator: [sigma, c], scale, lambda } = group;
        let per = GROUP / S::F64_LANES;
        let (zero, one) = (simd.splat_f64s(0.0), simd.splat_f64s(1.0));
        let (weight, scale) = (simd.splat_f64s(c), simd.splat_f64s(scale));
        let mut shift = [zero; GROUP];
        for (to, lambda) in shift.iter_mut().zip(S::as_simd_f64s(lambda).0) {
            *to = simd.mul_f64s(weight, *lambda);
        }
        // The row before: pivot, g and f; w of this one, and the sums of the first value.
        let (mut pivot, mut carried, mut from) = ([zero; GROUP], [zero; GROUP], [one; GROUP]);
        let (mut product, mut first, mut taken) = ([one; GROUP], [zero; GROUP], [zero; GROUP]);
        let mut short = [0.0; GROUP];
        for (row, i) in block.clone().enumerate() {
            let mut right = &source[row][at.clone()];
            if right.len() < GROUP {
                short[..right.len()].copy_from_slice(right);
                right = &short;
            }
            let right = &S::as_simd_f64s(right).0[..per];
            let off = if row == 0 { 0.0 } else { c * c * sweep.lower[i] * sweep.upper[i - 1] };
            let off = simd.splat_f64s(off);
            let diagonal = simd.splat_f64s(sigma - c * sweep.diagonal[i]);
            let (lower, upper) = (simd.splat_f64s(c * sweep.lower[i]), simd.splat_f64s(c * sweep.upper[i]));
            let values = S::as_mut_simd_f64s(rows[row].as_flattened_mut().as_flattened_mut()).0;
            let (g, rest) = values.split_at_mut(per);
            let (s, f) = rest.split_at_mut(per);
            for t in 0..per {
                let d = simd.sub_f64s(diagonal, shift[t]);
                pivot[t] = simd.div_f64s(one, simd.sub_f64s(d, simd.mul_f64s(off, pivot[t])));
                let sum = simd.add_f64s(simd.mul_f64s(scale, right[t]), simd.mul_f64s(lower, carried[t]));
                carried[t] = simd.mul_f64s(pivot[t], sum);
                (g[t], s[t]) = (carried[t], simd.mul_f64s(upper, pivot[t]));
                if N == BLOCK {
                    from[t] = simd.mul_f64s(simd.mul_f64s(lower, pivot[t]), from[t]);
                    first[t] = simd.add_f64s(first[t], simd.mul_f64s(product[t], carried[t]));
                    taken[t] = simd.add_f64s(taken[t], simd.mul_f64s(product[t], from[t]));
                    f[t] = from[t];
                    product[t] = simd.mul_f64s(product[t], s[t]);
                }
            }
        }
        let (BLOCK, Some(edge)) = (N, edge) else { return };
        edge[2].copy_from_slice(rows[block.len() - 1][1].as_flattened());
        for (to, from) in [(0, &carried), (1, &from), (3, &first), (4, &taken), (5, &product)] {
            S::as_mut_simd_f64s(&mut edge[to]).0[..per].copy_from_slice(&from[..per]);
        }
    }
}

/// The second pass, straight into the planes.
pub(super) struct Substitute<'a, 'b, const N: usize> {
    pub(super) rows: &'a [Row<N>],
    pub(super) beside: &'a Beside,
    pub(super) at: Range<usize>,
    pub(super) target: &'a mut [&'b mut [f64]],
}

impl<const N: usize> Kernel for Substitute<'_, '_, N> {
    #[inline(always)]
    fn run<S: Simd>(self, simd: S) {
        let Self { rows, beside: [below, above], at, target } = self;
        let per = GROUP / S::F64_LANES;
        let below = &S::as_simd_f64s(below).0[..per];
        let mut carried = [simd.splat_f64s(0.0); GROUP];
        carried[..per].copy_from_slice(&S::as_simd_f64s(above).0[..per]);
        for (row, target) in rows.iter().zip(target).rev() {
            let (g, rest) = S::as_simd_f64s(row.as_flattened().as_flattened()).0.split_at(per);
            let (s, f) = rest.split_at(per);
            for t in 0..per {
                let own = if N == BLOCK { simd.add_f64s(g[t], simd.mul_f64s(f[t], below[t])) } else { g[t] };
                carried[t] = simd.add_f64s(own, simd.mul_f64s(s[t], carried[t]));
            }
            let out = &mut target[at.clone()];
            if let Some(whole) = out.first_chunk_mut::<GROUP>() {
                S::as_mut_simd_f64s(whole).0[..per].copy_from_slice(&carried[..per]);
            } else {
                let mut whole = [0.0; GROUP];
                S::as_mut_simd_f64s(&mut whole).0[..per].copy_from_slice(&carried[..per]);
                out.copy_from_slice(&whole[..out.len()]);
            }
        }
    }
}
