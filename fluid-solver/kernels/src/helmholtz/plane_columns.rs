//! The last axis of a separable solve: eight modes at once, by a sweep or by one more transform.

use super::tiles::{Eliminate, Gather, Scatter, Substitute, Tiles, remove_mean};
use super::unknown::LastAxis;
use crate::lanes::{Kernel, Lanes, ZERO, dispatch};
use crate::threads::for_chunks;
use crate::transform::Scratch;
use crate::tridiagonal::Sweep;
use pulp::Simd;

/// Sets of pivots kept: the three stages of a Runge–Kutta step.
const KEPT: usize = 3;

/// Pivots, or inverse eigenvalues, for one operator `σ − c L`.
struct Factors {
    operator: [f64; 2],
    values: Vec<Lanes>,
}

/// All columns of a solve: column `q` holds eight modes of the other axes.
pub(super) struct PlaneColumns {
    pub(super) across: LastAxis,
    lambda: Vec<Lanes>,
    scale: f64,
    factors: Vec<Factors>,
    next: usize,
}

impl PlaneColumns {
    /// `lambda` are the eigenvalues of the transformed axes per column and lane, `scale` the
    /// normalisation of their transforms. Lane 0 of column 0 is the constant mode.
    pub(super) fn new(across: LastAxis, lambda: Vec<Lanes>, scale: f64) -> Self {
        Self { across, lambda, scale, factors: Vec::new(), next: 0 }
    }

    pub(super) fn count(&self) -> usize {
        self.lambda.len()
    }

    /// Makes sure the pivots of `σ − c L` are at hand and returns their number for [`Self::solve`].
    pub(super) fn prepare(&mut self, sigma: f64, c: f64) -> usize {
        let operator = [sigma, c];
        if let Some(at) = self.factors.iter().position(|f| f.operator == operator) {
            return at;
        }
        if self.factors.len() < KEPT {
            let values = vec![[0.0; 8]; self.count() * self.across.len()];
            self.factors.push(Factors { operator, values });
            self.next = self.factors.len() - 1;
        }
        let at = self.next;
        self.next = (at + 1) % KEPT;
        let mut values = std::mem::take(&mut self.factors[at].values);
        for_chunks(&mut values, self.across.len(), |q, column| {
            self.factor_column(q, operator, column);
        });
        self.factors[at] = Factors { operator, values };
        at
    }

    /// Computes the pivots of column `q`.
    fn factor_column(&self, q: usize, [sigma, c]: [f64; 2], values: &mut [Lanes]) {
        let (lambda, singular) = (&self.lambda[q], self.singular(q, sigma));
        match &self.across {
            LastAxis::Sweep(sweep) => {
                dispatch(Factor { sweep, operator: [sigma, c], lambda, singular, pivots: values });
            }
            LastAxis::Transform(transform, width2) => {
                let (kind, cells) = (transform.kind, transform.cells);
                let scale = self.scale * kind.scale(cells);
                for (k, value) in values.iter_mut().enumerate() {
                    let own = kind.eigenvalue(k, cells) / width2;
                    *value = lambda.map(|l| scale / (sigma - c * (own + l)));
                    if singular && k == 0 {
                        value[0] = 0.0;
                    }
                }
            }
        }
    }

    /// First half of the solution of columns `q` and `q + 1` (if there is one): their tiles are
    /// places 8q and 8q + 8 of the blocks of `lines`, the result goes to `columns`.
    pub(super) fn eliminate(
        &self,
        q: usize,
        at: usize,
        lines: &[Lanes],
        apart: usize,
        columns: &mut [Lanes],
        scratch: &mut Scratch,
    ) {
        let n = self.across.len().next_multiple_of(8);
        let (a, b) = columns[..2 * n].split_at_mut(n);
        let tiles = [8 * q, 8 * q + 8].map(|first| Tiles { first, apart });
        let [_, c] = self.factors[at].operator;
        let scale = self.scale;
        let pair = q + 1 < self.count();
        match &self.across {
            LastAxis::Sweep(sweep) => {
                if pair {
                    let pivots = [self.pivots(q, at), self.pivots(q + 1, at)];
                    dispatch(Eliminate { sweep, c, scale, pivots, lines, tiles, columns: [a, b] });
                } else {
                    let (pivots, tiles) = ([self.pivots(q, at)], [tiles[0]]);
                    dispatch(Eliminate { sweep, c, scale, pivots, lines, tiles, columns: [a] });
                }
            }
            LastAxis::Transform(transform, _) => {
                for (k, column) in [a, b].into_iter().enumerate().take(1 + usize::from(pair)) {
                    dispatch(Gather { lines, tiles: tiles[k], column: &mut *column });
                    let x = &mut column[..self.across.len()];
                    transform.forward(x, scratch);
                    for (x, value) in x.iter_mut().zip(self.pivots(q + k, at)) {
                        for l in 0..8 {
                            x[l] *= value[l];
                        }
                    }
                    transform.inverse(x, scratch);
                }
            }
        }
    }

    /// Second half: from `columns` to the tiles that begin at `places` of `lines`.
    pub(super) fn substitute(
        &self,
        q: usize,
        at: usize,
        columns: &[Lanes],
        lines: &mut [Lanes],
        places: [usize; 2],
        apart: usize,
    ) {
        let n = self.across.len().next_multiple_of(8);
        let (a, b) = columns[..2 * n].split_at(n);
        let tiles = places.map(|first| Tiles { first, apart });
        let ([first, _], c) = (tiles, self.factors[at].operator[1]);
        let pair = q + 1 < self.count();
        match &self.across {
            LastAxis::Sweep(sweep) => {
                if pair {
                    let pivots = [self.pivots(q, at), self.pivots(q + 1, at)];
                    dispatch(Substitute { sweep, c, pivots, columns: [a, b], lines: &mut *lines, tiles });
                } else {
                    let (pivots, tiles) = ([self.pivots(q, at)], [tiles[0]]);
                    dispatch(Substitute { sweep, c, pivots, columns: [a], lines: &mut *lines, tiles });
                }
                if self.singular(q, self.factors[at].operator[0]) {
                    remove_mean(sweep, lines, first);
                }
            }
            LastAxis::Transform(..) => {
                for (k, column) in [a, b].into_iter().enumerate().take(1 + usize::from(pair)) {
                    dispatch(Scatter { column, lines: &mut *lines, tiles: tiles[k] });
                }
            }
        }
    }

    /// Whether the first mode of column `q` is solved up to a constant.
    fn singular(&self, q: usize, sigma: f64) -> bool {
        q == 0 && sigma == 0.0 && self.lambda[0][0] == 0.0
    }

    /// Pivots, or inverse eigenvalues, of column `q`.
    fn pivots(&self, q: usize, at: usize) -> &[Lanes] {
        &self.factors[at].values[q * self.across.len()..(q + 1) * self.across.len()]
    }
}

/// Inverse pivots for eight eigenvalues. Where the first mode is `singular` it gets a zero pivot at the last
/// true unknown: its system is solved up to a constant, with the last value zero.
struct Factor<'a> {
    sweep: &'a Sweep,
    operator: [f64; 2],
    lambda: &'a Lanes,
    singular: bool,
    pivots: &'a mut [Lanes],
}

impl Kernel for Factor<'_> {
    #[inline(always)]
    fn run<S: Simd>(self, _: S) {
        let Self { sweep, operator: [sigma, c], lambda, singular, pivots } = self;
        let mut previous = ZERO;
        for (i, pivot) in pivots[..sweep.len()].iter_mut().enumerate() {
            // Eliminated product of the off-diagonals, (−c l_i)(−c u_{i−1}).
            let off = if i == 0 { 0.0 } else { c * c * sweep.lower[i] * sweep.upper[i - 1] };
            for l in 0..8 {
                let d = sigma - c * (sweep.diagonal[i] + lambda[l]);
                pivot[l] = 1.0 / (d - off * previous[l]);
            }
            if singular && i == sweep.last {
                pivot[0] = 0.0;
            }
            previous = *pivot;
        }
    }
}
