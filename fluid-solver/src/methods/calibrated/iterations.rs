//! A window again and again from the same start, until the motion that it leads to is the one it began with.
//!
//! A guess x is the force λ in the fluid and the grains' velocities at the end of the window. An attempt
//! leads from it to H(x): the λ that imposes the motion which came back, and that motion. The window is
//! converged where H(x) = x. With the residuals f = H(x) − x the next guess is
//! ```text
//! x' = Σ_j α_j H(x_j),  Σ α_j = 1,  |Σ α_j f_j| least          (Anderson; Walker & Ni 2011)
//! ```
//! over force and motion at once: weights found from the motion alone cannot see the force, whose slow and
//! fast parts they would drive apart. f·f is Σ (dt λ)² over cells, plus |U|² + k²|ω|² of each grain (k its
//! radius of gyration) times the mean number of cells of a grain: both count as velocities. Sums run in one
//! order whatever the number of threads.

use crate::grid::Grid;
use crate::immersed::Wrench;
use crate::immersed::body::Motion;
use crate::immersed::places::{Places, Values};
use crate::methods::grains::Grains;
use crate::methods::loads::Measured;
use crate::step::Stepper;
use protocol::participant::Window;

/// Attempts that are mixed: the last one and five before it.
const MIXED: usize = 6;
/// Added to C_v for each ν dt/D²: in long windows the drag of the first attempts, taken with a force that
/// knows nothing of the motion yet, would throw a light grain out of the box. From 1 to 18 all converge at
/// ν dt/D² = 0.8; 0 does not below ρ_r = 0.5. Without influence on what they converge to.
const DRAG: f64 = 2.0;
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
}

/// What an attempt led to.
#[derive(Clone, Debug)]
struct Attempt<const D: usize> {
    /// H(x).
    output: Iterate<D>,
    /// H(x) − x.
    residual: Iterate<D>,
}

/// The attempts at the present window. Nothing of them outlives the window.
#[derive(Clone, Debug)]
pub struct Iterations<const D: usize> {
    places: Places<D>,
    /// Earlier attempts, oldest first; those from `count` on are not of this window.
    attempts: [Attempt<D>; MIXED],
    count: usize,
    /// Scalar products of the residuals of `attempts`.
    products: [[f64; MIXED]; MIXED],
    guess: Iterate<D>,
    /// Radius of gyration squared of each grain, m².
    gyration: Vec<f64>,
    /// Where each grain was at the end of the last attempt, m.
    centres: Vec<[f64; 3]>,
    /// Weights of the last least squares.
    weights: Vec<f64>,
}

impl<const D: usize> Iterations<D> {
    /// For grains with these radii of gyration (squared).
    pub(super) fn new(gyration: Vec<f64>) -> Self {
        Self {
            places: Places::default(),
            attempts: std::array::from_fn(|_| Attempt {
                output: Iterate::default(),
                residual: Iterate::default(),
            }),
            count: 0,
            products: [[0.0; MIXED]; MIXED],
            guess: Iterate::default(),
            centres: vec![[0.0; 3]; gyration.len()],
            gyration,
            weights: Vec::with_capacity(MIXED),
        }
    }

    /// Force and motion at the end of the window with which this attempt begins: in the first the force
    /// carried and the acceleration of the last window, so that it is the semi-implicit one. The fluid is
    /// where the window began: who repeats a window restores it. What drives it in this window is not known
    /// yet: the message of the first attempt adds the change.
    pub(super) fn guess(&mut self, fluid: &Stepper<D>, grains: &mut Grains<D>, window: &Window) {
        if window.attempt > 0 && self.count > 0 {
            self.mix();
            self.places.scatter(&self.guess.force, &mut grains.force);
            self.places.hold(&mut grains.immersed);
            return;
        }
        let Grains { immersed, memory, force, .. } = grains;
        self.places.clear();
        self.places.add(fluid.grid(), immersed);
        self.places.gather(force, &mut self.guess.force);
        self.guess.motion.clear();
        self.guess.motion.extend(memory.motions.iter().enumerate().map(|(grain, motion)| {
            let (u, a) = (numbers(motion), numbers_of(&memory.acceleration(grain)));
            std::array::from_fn(|c| u[c] + window.dt * a[c])
        }));
        self.count = 0;
    }

    /// Puts the grains where the last attempt led them.
    pub(super) fn place(&self, predicted: &mut [Motion]) {
        if self.count > 0 {
            predicted.iter_mut().zip(&self.centres).for_each(|(motion, centre)| motion.centre = *centre);
        }
    }

    /// The DEM adds m_a A_prev with the acceleration of the last window; the message adds what the attempt
    /// before knows better.
    pub(super) fn virtual_mass_ahead(&self, grains: &Grains<D>, dt: f64, measured: &mut [Measured]) {
        let shapes = grains.immersed.shapes();
        for (grain, (m, shape)) in measured.iter_mut().zip(shapes).enumerate() {
            m.more = DRAG * grains.model.viscosity * dt / (2.0 * shape.radius).powi(2);
            let (guess, now) = (&self.guess.motion[grain], numbers(&grains.memory.motions[grain]));
            let before = numbers_of(&m.acceleration);
            let ahead = |c: usize| (guess[c] - now[c]) / dt - before[c];
            // The attempt before has seen the drive of this window.
            if self.count > 0 {
                (m.drive, m.free_drive) = ([0.0; 3], [0.0; 3]);
            }
            m.ahead =
                Wrench { force: std::array::from_fn(ahead), torque: std::array::from_fn(|c| ahead(c + 3)) };
        }
    }

    /// Takes what the attempt led to.
    pub(super) fn note(&mut self, dt: f64, grid: &Grid<D>, grains: &Grains<D>) {
        self.places.add(grid, &grains.immersed);
        if self.count == MIXED {
            self.attempts.rotate_left(1);
            self.products.rotate_left(1);
            self.products.iter_mut().for_each(|row| row.rotate_left(1));
            self.count -= 1;
        }
        let motions = &grains.memory.motions;
        let Attempt { output, residual } = &mut self.attempts[self.count];
        self.places.gather(&grains.force, &mut output.force);
        output.motion.clear();
        output.motion.extend(motions.iter().map(numbers));
        residual.force.clone_from(&output.force);
        residual.motion.clone_from(&output.motion);
        residual.combine(&self.guess, |output, guess| *output -= guess);
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
            let (a, b) = (&self.attempts[newest].residual, &self.attempts[other].residual);
            let force: f64 = a.force.iter().zip(&b.force).map(|(a, b)| product(a, b)).sum();
            let pairs = a.motion.iter().zip(&b.motion).zip(&self.gyration);
            let motion: f64 =
                pairs.map(|((a, b), k2)| product(&a[..3], &b[..3]) + k2 * product(&a[3..], &b[3..])).sum();
            let value = dt * dt * force + share * motion;
            self.products[newest][other] = value;
            self.products[other][newest] = value;
        }
    }

    /// x' = Σ α_j H(x_j).
    fn mix(&mut self) {
        least_squares(&self.products, self.count, &mut self.weights);
        let Self { guess, attempts, weights, .. } = self;
        guess.force.iter_mut().for_each(|values| values.fill(0.0));
        guess.motion.fill([0.0; 6]);
        for (attempt, weight) in attempts.iter().zip(weights) {
            guess.combine(&attempt.output, |guess, output| *guess += *weight * output);
        }
    }
}

/// Velocity and spin.
fn numbers(motion: &Motion) -> [f64; 6] {
    let [u, w] = [motion.velocity, motion.spin];
    [u[0], u[1], u[2], w[0], w[1], w[2]]
}

/// A vector and its moment.
fn numbers_of(wrench: &Wrench) -> [f64; 6] {
    let [f, t] = [wrench.force, wrench.torque];
    [f[0], f[1], f[2], t[0], t[1], t[2]]
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

/// Weights α_j of `count` ≤ [`MIXED`] residuals with scalar products `products`, Σ α_j = 1, that make |Σ
/// α_j f_j| least. The newest has the differences f_j − f_k to the others to work with, newer ones first;
/// those that add nothing new are left out.
fn least_squares(products: &[[f64; MIXED]; MIXED], count: usize, weights: &mut Vec<f64>) {
    weights.clear();
    weights.resize(count, 0.0);
    let k = count - 1;
    let difference = |i: usize, j: usize| products[i][j] - products[i][k] - products[j][k] + products[k][k];
    // Gram–Schmidt by coefficients: q_n = Σ_j basis[n][j] (f_j − f_k), orthogonal, with its square.
    let mut basis = [([0.0; MIXED], 0.0); MIXED];
    let mut found = 0;
    let along = |a: &[f64; MIXED], b: &[f64; MIXED]| -> f64 {
        (0..k).map(|i| a[i] * (0..k).map(|j| b[j] * difference(i, j)).sum::<f64>()).sum()
    };
    for new in (0..k).rev() {
        let own = difference(new, new);
        let mut q = [0.0; MIXED];
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
        let mut products = [[0.0; MIXED]; MIXED];
        for (row, a) in products.iter_mut().zip(residuals) {
            row.iter_mut().zip(residuals).for_each(|(product, b)| *product = a[0] * b[0] + a[1] * b[1]);
        }
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
