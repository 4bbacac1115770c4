//! Points and weights of an interpolation.

use crate::grid::Grid;
use crate::immersed::body::{Motion, laboratory};

/// Points of an interpolation along one axis.
pub(super) const POINTS: usize = 4;

/// Those of them between which the place lies.
pub(super) const INNER: std::ops::RangeInclusive<usize> = 1..=2;

/// Weights of points.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Weights {
    pub(super) cubic: [f64; POINTS],
    pub(super) linear: [f64; POINTS],
}

/// The four points about a place along one axis: how many cells from it the first one is, and their weights.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Interpolation {
    pub(super) low: isize,
    pub(super) weights: Weights,
}

impl Interpolation {
    /// For a grain that moves so for `dt`, along each axis.
    pub(crate) fn of<const D: usize>(grid: &Grid<D>, motion: &Motion, dt: f64) -> [Self; D] {
        std::array::from_fn(|a| {
            let lab = laboratory(grid.geometry, a);
            let width = grid.axes[a].width_at(motion.centre[lab]);
            // whatever it does, it does not leave the numbers of cells
            Self::back((motion.velocity[lab] * dt / width).clamp(-1e9, 1e9))
        })
    }

    /// Whether the place is the same.
    #[inline(always)]
    pub(super) fn stays(&self) -> bool {
        self.low == -1 && self.weights.cubic == [0.0, 1.0, 0.0, 0.0]
    }

    /// For a place `shift` cells back.
    fn back(shift: f64) -> Self {
        let low = (-shift).floor();
        let t = -shift - low;
        // Lagrange's polynomial through -1, 0, 1, 2
        let cubic = [
            -t * (t - 1.0) * (t - 2.0) / 6.0,
            (t + 1.0) * (t - 1.0) * (t - 2.0) / 2.0,
            -(t + 1.0) * t * (t - 2.0) / 2.0,
            (t + 1.0) * t * (t - 1.0) / 6.0,
        ];
        Self { low: low as isize - 1, weights: Weights { cubic, linear: [0.0, 1.0 - t, t, 0.0] } }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Both are exact for what they say: cubic polynomials and straight lines; a grain that stands takes one
    /// point.
    #[test]
    fn weights_are_those_of_cubics_and_lines() {
        for shift in [-2.3, -1.0, -0.4, 0.0, 0.25, 0.999, 3.7] {
            let Interpolation { low, weights } = Interpolation::back(shift);
            let sum = |weights: &[f64; POINTS], power: i32| {
                let place = |point: usize| (low + point as isize) as f64;
                weights.iter().enumerate().map(|(point, w)| w * place(point).powi(power)).sum::<f64>()
            };
            for power in 0..4 {
                let exact = (-shift).powi(power);
                assert!((sum(&weights.cubic, power) - exact).abs() < 1e-12 * (1.0 + exact.abs()));
                assert!(power > 1 || (sum(&weights.linear, power) - exact).abs() < 1e-12);
            }
            assert!((0..POINTS).all(|point| INNER.contains(&point) || weights.linear[point] == 0.0));
        }
        assert_eq!(
            Interpolation::back(0.0).weights,
            Weights { cubic: [0.0, 1.0, 0.0, 0.0], linear: [0.0, 1.0, 0.0, 0.0] }
        );
    }
}
