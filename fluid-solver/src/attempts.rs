//! Attempts at one window, and the guess with which the next one begins.
//!
//! A guess x is the force λ in the fluid and the grains' velocities at the end of the window. An attempt
//! leads from it to H(x): the λ that imposes the motion which came back, and that motion. The window stands
//! where H(x) = x. With the residuals f = H(x) − x the next guess is
//! ```text
//! Aitken     x' = x_k + ω_k f_k,   ω_k = −ω_{k−1} f_{k−1}·(f_k − f_{k−1}) / |f_k − f_{k−1}|²
//!                                                        (Küttler & Wall 2008, eq. 44)
//! Anderson   x' = Σ_j α_j H(x_j),  Σ α_j = 1,  |Σ α_j f_j| least          (Walker & Ni 2011)
//! ```
//! over force and motion at once: a factor found from the motion alone cannot see the force, whose slow
//! and fast parts it would drive apart. f·f is Σ (dt λ)² over cells, plus |U|² + k²|ω|² of each grain (k its
//! radius of gyration) times the mean number of cells of a grain: both count as velocities. Sums run in one
//! order whatever the number of threads.

use crate::grid::Grid;
use crate::immersed::Immersed;
use crate::immersed::body::Motion;
use crate::immersed::places::{Places, Values};
use protocol::scheme::{Iterations, Relaxation};

/// Largest |ω| of Aitken's factor: beyond it the last two residuals were all but the same.
const MAX_AITKEN: f64 = 20.0;
/// Most attempts that are mixed: `coupling.iterations.depth` is at most 20.
const MAX_MIXED: usize = 21;
/// A difference of residuals that lies in the span of the others up to this share of itself (squared) says
/// nothing new.
const NOTHING_NEW: f64 = 1e-10;

/// A force and a motion, or their change.
#[derive(Clone, Debug)]
struct Iterate<const D: usize> {
    force: Values<D>,
    /// Velocity and spin of each grain.
    motion: Vec<[f64; 6]>,
}

impl<const D: usize> Default for Iterate<D> {
    fn default() -> Self {
        Self { force: std::array::from_fn(|_| Vec::new()), motion: Vec::new() }
    }
}

impl<const D: usize> Iterate<D> {
    /// All values in one order; values that a shorter one lacks are zero.
    fn combine(&mut self, other: &Self, change: impl Fn(&mut f64, f64)) {
        for (to, from) in self.force.iter_mut().zip(&other.force) {
            to.resize(to.len().max(from.len()), 0.0);
            to.iter_mut().zip(from).for_each(|(to, from)| change(to, *from));
        }
        self.motion.resize(other.motion.len(), [0.0; 6]);
        let from = other.motion.as_flattened();
        self.motion.as_flattened_mut().iter_mut().zip(from).for_each(|(to, from)| change(to, *from));
    }

    fn clone_from_other(&mut self, other: &Self) {
        for (to, from) in self.force.iter_mut().zip(&other.force) {
            to.clone_from(from);
        }
        self.motion.clone_from(&other.motion);
    }

    fn set_zero(&mut self) {
        self.force.iter_mut().for_each(|values| values.fill(0.0));
        self.motion.fill([0.0; 6]);
    }
}

/// What an attempt led to.
#[derive(Clone, Debug)]
struct Tried<const D: usize> {
    /// H(x).
    found: Iterate<D>,
    /// H(x) − x.
    residual: Iterate<D>,
}

impl<const D: usize> Default for Tried<D> {
    fn default() -> Self {
        Self { found: Iterate::default(), residual: Iterate::default() }
    }
}

/// The attempts at the window under way. Nothing of it outlives the window.
#[derive(Clone, Debug)]
pub struct Attempts<const D: usize> {
    relaxation: Relaxation,
    places: Places<D>,
    /// Earlier attempts, oldest first, then room for more.
    tried: Vec<Tried<D>>,
    count: usize,
    /// Scalar products of the residuals of `tried`.
    products: Vec<Vec<f64>>,
    guess: Iterate<D>,
    /// Aitken's last factor.
    factor: f64,
    /// Radius of gyration squared of each grain, m².
    gyration: Vec<f64>,
    /// Where each grain was at the end of the last attempt, m.
    centres: Vec<[f64; 3]>,
    /// Weights of the last least squares.
    weights: Vec<f64>,
}

impl<const D: usize> Attempts<D> {
    /// For grains with these radii of gyration (squared).
    pub fn new(rule: Iterations, gyration: Vec<f64>) -> Self {
        let room = match rule.relaxation {
            Relaxation::Aitken => 2,
            Relaxation::Anderson => (rule.depth + 1).clamp(2, MAX_MIXED),
        };
        Self {
            relaxation: rule.relaxation,
            places: Places::default(),
            tried: (0..room).map(|_| Tried::default()).collect(),
            count: 0,
            products: vec![vec![0.0; room]; room],
            guess: Iterate::default(),
            factor: 1.0,
            centres: vec![[0.0; 3]; gyration.len()],
            gyration,
            weights: Vec::with_capacity(room),
        }
    }

    /// First attempt: the guess is the force carried from the last window, and `motion`.
    pub fn begin(
        &mut self,
        grid: &Grid<D>,
        immersed: &Immersed<D>,
        force: &[Vec<f64>; D],
        motion: impl Iterator<Item = [f64; 6]>,
    ) {
        self.places.clear();
        self.places.add(grid, immersed);
        self.places.gather(force, &mut self.guess.force);
        self.guess.motion.clear();
        self.guess.motion.extend(motion);
        (self.count, self.factor) = (0, 1.0);
    }

    /// Every other attempt: puts the guess into `force`, and declares its cells to hold force.
    pub fn go_on(&mut self, immersed: &mut Immersed<D>, force: &mut [Vec<f64>; D]) {
        match self.relaxation {
            Relaxation::Aitken => self.guess_aitken(),
            Relaxation::Anderson => self.guess_anderson(),
        }
        self.places.scatter(&self.guess.force, force);
        self.places.hold(immersed);
    }

    /// Was there an attempt at this window before?
    pub fn has_begun(&self) -> bool {
        self.count > 0
    }

    /// Velocity and spin of the guess.
    pub fn motion(&self, grain: usize) -> &[f64; 6] {
        &self.guess.motion[grain]
    }

    /// Where the last attempt led a grain, m; none in the first.
    pub fn centre(&self, grain: usize) -> Option<[f64; 3]> {
        (self.count > 0).then(|| self.centres[grain])
    }

    /// Takes what the attempt led to.
    pub fn note(
        &mut self,
        dt: f64,
        grid: &Grid<D>,
        immersed: &Immersed<D>,
        force: &[Vec<f64>; D],
        motions: &[Motion],
    ) {
        self.places.add(grid, immersed);
        if self.count == self.tried.len() {
            self.tried.rotate_left(1);
            self.products.rotate_left(1);
            self.products.iter_mut().for_each(|row| row.rotate_left(1));
            self.count -= 1;
        }
        let Tried { found, residual } = &mut self.tried[self.count];
        self.places.gather(force, &mut found.force);
        found.motion.clear();
        found.motion.extend(motions.iter().map(numbers));
        residual.clone_from_other(found);
        residual.combine(&self.guess, |found, guess| *found -= guess);
        for (centre, motion) in self.centres.iter_mut().zip(motions) {
            *centre = motion.centre;
        }
        self.count += 1;
        self.multiply(dt);
    }

    /// Scalar products of the newest residual with all.
    fn multiply(&mut self, dt: f64) {
        let newest = self.count - 1;
        let share = self.places.cells() as f64 / self.gyration.len().max(1) as f64;
        for other in 0..self.count {
            let (a, b) = (&self.tried[newest].residual, &self.tried[other].residual);
            let force: f64 = a.force.iter().zip(&b.force).map(|(a, b)| product(a, b)).sum();
            let pairs = a.motion.iter().zip(&b.motion).zip(&self.gyration);
            let motion: f64 =
                pairs.map(|((a, b), k2)| product(&a[..3], &b[..3]) + k2 * product(&a[3..], &b[3..])).sum();
            let value = dt * dt * force + share * motion;
            self.products[newest][other] = value;
            self.products[other][newest] = value;
        }
    }

    /// x' = H(x_k) + (ω_k − 1) f_k.
    fn guess_aitken(&mut self) {
        let last = self.count - 1;
        if last > 0 {
            let [ff, fg, gg] =
                [(last, last), (last, last - 1), (last - 1, last - 1)].map(|(a, b)| self.products[a][b]);
            let factor = -self.factor * (fg - gg) / (ff - 2.0 * fg + gg);
            self.factor = if factor.is_finite() { factor.clamp(-MAX_AITKEN, MAX_AITKEN) } else { 1.0 };
        }
        let rest = self.factor - 1.0;
        let Self { guess, tried, .. } = self;
        guess.clone_from_other(&tried[last].found);
        guess.combine(&tried[last].residual, |guess, residual| *guess += rest * residual);
    }

    /// x' = Σ α_j H(x_j).
    fn guess_anderson(&mut self) {
        least_squares(&self.products, self.count, &mut self.weights);
        let Self { guess, tried, weights, .. } = self;
        guess.set_zero();
        for (tried, weight) in tried.iter().zip(weights) {
            guess.combine(&tried.found, |guess, found| *guess += *weight * found);
        }
    }
}

/// Velocity and spin.
pub fn numbers(motion: &Motion) -> [f64; 6] {
    let [u, w] = [motion.velocity, motion.spin];
    [u[0], u[1], u[2], w[0], w[1], w[2]]
}

/// Σ a b in eight sums.
fn product(a: &[f64], b: &[f64]) -> f64 {
    let length = a.len().min(b.len());
    let (a, b) = (a[..length].chunks_exact(8), b[..length].chunks_exact(8));
    let rest: f64 = a.remainder().iter().zip(b.remainder()).map(|(a, b)| a * b).sum();
    let mut sums = [0.0; 8];
    for (a, b) in a.zip(b) {
        for l in 0..8 {
            sums[l] += a[l] * b[l];
        }
    }
    sums.iter().sum::<f64>() + rest
}

/// Weights α_j of `count` ≤ [`MAX_MIXED`] residuals with scalar products `products`, Σ α_j = 1, that make |Σ
/// α_j f_j| least. The newest has the differences f_j − f_k to the others to work with, newer ones first;
/// those that add nothing new are left out.
fn least_squares(products: &[Vec<f64>], count: usize, weights: &mut Vec<f64>) {
    weights.clear();
    weights.resize(count, 0.0);
    let k = count - 1;
    let difference = |i: usize, j: usize| products[i][j] - products[i][k] - products[j][k] + products[k][k];
    // Gram–Schmidt by coefficients: q_n = Σ_j basis[n][j] (f_j − f_k), orthogonal, with its square.
    let mut basis = [([0.0; MAX_MIXED], 0.0); MAX_MIXED];
    let mut found = 0;
    let along = |a: &[f64; MAX_MIXED], b: &[f64; MAX_MIXED]| -> f64 {
        (0..k).map(|i| a[i] * (0..k).map(|j| b[j] * difference(i, j)).sum::<f64>()).sum()
    };
    for new in (0..k).rev() {
        let own = difference(new, new);
        let mut q = [0.0; MAX_MIXED];
        q[new] = 1.0;
        for (other, size) in &basis[..found] {
            let share = along(&q, other) / size;
            (0..k).for_each(|j| q[j] -= share * other[j]);
        }
        let size = along(&q, &q);
        if size > NOTHING_NEW * own {
            basis[found] = (q, size);
            found += 1;
        }
    }
    for (q, size) in &basis[..found] {
        let with_last: f64 = (0..k).map(|j| q[j] * (products[j][k] - products[k][k])).sum();
        (0..k).for_each(|j| weights[j] -= with_last / size * q[j]);
    }
    weights[k] = 1.0 - weights[..k].iter().sum::<f64>();
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Residuals in the plane: the point of their affine hull nearest to the origin.
    fn mixed(residuals: &[[f64; 2]]) -> ([f64; 2], Vec<f64>) {
        let products: Vec<Vec<f64>> =
            residuals.iter().map(|a| residuals.iter().map(|b| a[0] * b[0] + a[1] * b[1]).collect()).collect();
        let mut weights = Vec::new();
        least_squares(&products, residuals.len(), &mut weights);
        let sum = |c: usize| weights.iter().zip(residuals).map(|(w, r)| w * r[c]).sum();
        ([sum(0), sum(1)], weights)
    }

    #[test]
    fn the_mixture_is_the_nearest_point_of_what_was_tried() {
        let (one, weights) = mixed(&[[3.0, 4.0]]);
        assert_eq!((one, weights), ([3.0, 4.0], vec![1.0]));
        // On the line x = 2 the nearest point is (2, 0).
        let (two, _) = mixed(&[[2.0, 3.0], [2.0, 1.0]]);
        assert!((two[0] - 2.0).abs() < 1e-14 && two[1].abs() < 1e-14, "{two:?}");
        // Three points span the plane: nothing is left.
        let (three, weights) = mixed(&[[2.0, 3.0], [2.0, 1.0], [-1.0, 0.5]]);
        assert!(three[0].hypot(three[1]) < 1e-13, "{three:?}");
        assert!((weights.iter().sum::<f64>() - 1.0).abs() < 1e-14);
    }

    #[test]
    fn what_adds_nothing_new_is_left_out() {
        // The first two are the same up to rounding: only one difference counts.
        let (mixed, weights) = mixed(&[[2.0, 3.0], [2.0, 3.0 + 1e-12], [2.0, 1.0]]);
        assert!((mixed[0] - 2.0).abs() < 1e-12 && mixed[1].abs() < 1e-6, "{mixed:?}");
        assert!(weights.iter().all(|w| w.abs() < 10.0), "{weights:?}");
    }
}
