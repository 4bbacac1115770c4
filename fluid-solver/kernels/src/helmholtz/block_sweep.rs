//! A column cut into blocks, each swept by itself (Laszlo, Giles & Appleyard 2016; Kim et al. 2021,
//! PaScaL_TDMA).
//!
//! With x₋ the value below a block and x₊ the one above, elimination leaves in each of its rows
//! ```text
//! x_i = g_i + f_i x₋ + s_i x_{i+1}
//! ```
//! and so, for its first and last value, its [`Edge`]
//! ```text
//! x_last = g + f x₋ + s x₊,    x_first = Σ w_i (g_i + f_i x₋) + w_last s_last x₊,    w_i = s_0 … s_{i−1}.
//! ```
//! The edges of all blocks are a small system, see [`super::reduced`]. With x₋ and x₊ known a second pass
//! substitutes.
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

/// g, f and s of a row.
pub(super) type Row = [[Lanes; SIDE]; 3];

/// What all blocks of a group share.
#[derive(Clone, Copy)]
pub(super) struct Group<'a> {
    pub(super) sweep: &'a Sweep,
    pub(super) operator: [f64; 2],
    pub(super) scale: f64,
    pub(super) lambda: &'a Wide,
}

/// The first pass over a block.
pub(super) struct EliminateBlock<'a, 'b> {
    pub(super) group: Group<'a>,
    /// Unknowns of the block.
    pub(super) block: Range<usize>,
    /// Where the group stands in each plane.
    pub(super) at: Range<usize>,
    /// The planes of the block.
    pub(super) source: &'a [&'b mut [f64]],
    /// What each row leaves.
    pub(super) rows: &'a mut [Row],
    pub(super) edge: &'a mut Edge,
}

impl Kernel for EliminateBlock<'_, '_> {
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
            let [g, f, s] = &mut rows[row];
            let g = &mut S::as_mut_simd_f64s(g.as_flattened_mut()).0[..per];
            let f = &mut S::as_mut_simd_f64s(f.as_flattened_mut()).0[..per];
            let s = &mut S::as_mut_simd_f64s(s.as_flattened_mut()).0[..per];
            for t in 0..per {
                let d = simd.sub_f64s(diagonal, shift[t]);
                pivot[t] = simd.div_f64s(one, simd.sub_f64s(d, simd.mul_f64s(off, pivot[t])));
                let sum = simd.add_f64s(simd.mul_f64s(scale, right[t]), simd.mul_f64s(lower, carried[t]));
                carried[t] = simd.mul_f64s(pivot[t], sum);
                from[t] = simd.mul_f64s(simd.mul_f64s(lower, pivot[t]), from[t]);
                first[t] = simd.add_f64s(first[t], simd.mul_f64s(product[t], carried[t]));
                taken[t] = simd.add_f64s(taken[t], simd.mul_f64s(product[t], from[t]));
                (g[t], f[t], s[t]) = (carried[t], from[t], simd.mul_f64s(upper, pivot[t]));
                product[t] = simd.mul_f64s(product[t], s[t]);
            }
        }
        let [_, _, last] = &rows[block.len() - 1];
        edge[2].copy_from_slice(last.as_flattened());
        for (to, from) in [(0, &carried), (1, &from), (3, &first), (4, &taken), (5, &product)] {
            S::as_mut_simd_f64s(&mut edge[to]).0[..per].copy_from_slice(&from[..per]);
        }
    }
}

/// The second pass, straight into the planes.
pub(super) struct SubstituteBlock<'a, 'b> {
    pub(super) rows: &'a [Row],
    pub(super) beside: &'a Beside,
    pub(super) at: Range<usize>,
    pub(super) target: &'a mut [&'b mut [f64]],
}

impl Kernel for SubstituteBlock<'_, '_> {
    #[inline(always)]
    fn run<S: Simd>(self, simd: S) {
        let Self { rows, beside: [below, above], at, target } = self;
        let per = GROUP / S::F64_LANES;
        let below = &S::as_simd_f64s(below).0[..per];
        let mut carried = [simd.splat_f64s(0.0); GROUP];
        carried[..per].copy_from_slice(&S::as_simd_f64s(above).0[..per]);
        for ([g, f, s], target) in rows.iter().zip(target).rev() {
            let g = &S::as_simd_f64s(g.as_flattened()).0[..per];
            let f = &S::as_simd_f64s(f.as_flattened()).0[..per];
            let s = &S::as_simd_f64s(s.as_flattened()).0[..per];
            for t in 0..per {
                let own = simd.add_f64s(g[t], simd.mul_f64s(f[t], below[t]));
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
