//! The mask of a row of cells at once, without branches, so that it runs on whole vectors.
//!
//! Model and symbols: [`super::mask_model`].
//!
//! A cell is known by four sums over the axes, `r` being the arm from the grain's centre,
//! ```text
//! s = Σ r_a²,   L = Σ |r_a|,   A = Σ r_a² Δx_a²,   F = Σ r_a⁴ Δx_a²
//! ```
//! from which, with λ = L/s^½ and P = σ s, distance, thickness and the mask follow:
//! ```text
//! 1/w = s² / (2^½ f L P A^½),   Σ n_a⁴ Δx_a² = F/s²,   Δx² = A/s,   N = F/(s A)
//! ```

use super::mask_model::{EDGE, Mask, MaskModel, ROUND, SIGMA, SIGMA_SLOPE, SOLID, exact_shear, wave};
use super::nodes::Row;
use super::piece::Piece;
use pulp::Simd;
use std::f64::consts::{FRAC_1_SQRT_2, LN_2, LOG2_E};
use std::ops::Range;

/// Sums over the axes of one cell.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Sums {
    /// Σ r_a², m².
    square: f64,
    /// Σ |r_a|, m.
    size: f64,
    /// Σ r_a² Δx_a², m⁴.
    across: f64,
    /// Σ r_a⁴ Δx_a², m⁶.
    fourth: f64,
}

/// What the mask of exact shear needs of an arm along an axis.
#[derive(Clone, Copy, Debug)]
struct Shear {
    /// r², m².
    square: f64,
    /// |r| Δx, m².
    root: f64,
    /// 1/Δx², 1/m².
    inverse: f64,
}

/// The share of axis 0 in the sums, at every place of a [`Piece`].
#[derive(Clone, Debug, Default)]
pub(super) struct Profile {
    square: Vec<f64>,
    size: Vec<f64>,
    across: Vec<f64>,
    fourth: Vec<f64>,
    /// For the mask of exact shear, in place of the three before.
    root: Vec<f64>,
    inverse: Vec<f64>,
}

/// What is the same for all cells of a grain.
#[derive(Clone, Copy)]
pub(super) struct Law {
    /// 1/(2^½ f), over the cell width if cells are even.
    thin: f64,
    /// q = (this / w²) e^{…}; zero for the mask of Izard et al..
    rate: f64,
    /// Factor of Σ n⁴Δx²/w².
    shift: f64,
    /// Factor in place of `rate`/w² for the mask of Izard et al., else zero.
    plain: f64,
    /// Amplitude of the wave in the distance, cells.
    swing: f64,
    /// Width of the cells if they are even, m, and 1 over it.
    width: f64,
    inverse_width: f64,
    radius: f64,
    /// Squared radius within which a cell is solid, m².
    solid: f64,
    /// Whether cells are equally wide along all axes.
    even: bool,
    /// ν dt for the mask of exact shear, m².
    exact: Option<f64>,
}

impl Sums {
    /// Adds what an arm `r` along an axis with spacing `h` brings.
    #[inline(always)]
    pub(super) fn add(&mut self, r: f64, h: f64) {
        let (r2, h2) = (r * r, h * h);
        self.square += r2;
        self.size += r.abs();
        self.across += r2 * h2;
        self.fourth += r2 * r2 * h2;
    }
}

impl Profile {
    /// Square, size, across and fourth.
    #[inline(always)]
    fn lines(&self) -> [&[f64]; 4] {
        [&self.square, &self.size, &self.across, &self.fourth]
    }

    /// For a grain with this law that is not felt beyond `outer` (m).
    #[inline(always)]
    pub(super) fn set(&mut self, law: &Law, row: &Row, piece: &Piece, outer: f64) {
        let Self { square, size, across, fourth, root, inverse } = self;
        let n = piece.count;
        square.resize(n, 0.0);
        let places = piece.first..piece.first + n;
        let (at, spacing) = (&row.at[places.clone()], &row.spacing[places.clone()]);
        // so far away from what the grain does not hold that nothing is felt there
        let (held, far) = (piece.begin - piece.first..piece.end - piece.first, 1e3 * outer * outer);
        let square = &mut square[..n];
        if law.exact.is_some() {
            root.resize(n, 0.0);
            inverse.clear();
            inverse.extend_from_slice(&row.inverse[places]);
            let root = &mut root[..n];
            for k in 0..n {
                let arm = arm(at[k] + piece.shift, spacing[k]);
                square[k] = if held.contains(&k) { arm * arm } else { far };
                root[k] = arm.abs() * spacing[k];
            }
            return;
        }
        for values in [&mut *size, &mut *across, &mut *fourth] {
            values.resize(n, 0.0);
        }
        for k in 0..n {
            let mut sums = Sums::default();
            sums.add(arm(at[k] + piece.shift, spacing[k]), spacing[k]);
            square[k] = if held.contains(&k) { sums.square } else { far };
            (size[k], across[k], fourth[k]) = (sums.size, sums.across, sums.fourth);
        }
    }
}

/// An arm along axis 0: at the centre itself any direction is as good as another.
#[inline(always)]
fn arm(arm: f64, spacing: f64) -> f64 {
    if arm == 0.0 { 1e-6 * spacing } else { arm }
}

impl Shear {
    /// Of the arm along one axis alone.
    #[inline(always)]
    fn of(sums: &Sums) -> Self {
        let least = f64::MIN_POSITIVE;
        Self {
            square: sums.square,
            root: sums.across.sqrt(),
            inverse: sums.square.max(least) / sums.across.max(least),
        }
    }
}

/// Sums over all axes of the cells of several rows.
#[derive(Clone, Debug, Default)]
pub(super) struct Cells {
    sums: Profile,
    count: usize,
}

impl Cells {
    /// Forgets all cells; there is room for as many as `most` to come.
    #[inline(always)]
    pub(super) fn begin(&mut self, most: usize) {
        self.count = 0;
        let Profile { square, size, across, fourth, .. } = &mut self.sums;
        for values in [square, size, across, fourth] {
            values.resize(most.max(values.len()), 0.0);
        }
    }

    /// Adds the places `window` of a piece, whole vectors; `rest` are the sums over the other axes.
    #[inline(always)]
    fn add<S: Simd>(&mut self, simd: S, profile: &Profile, window: Range<usize>, rest: &Sums) {
        let (at, n) = (self.count, window.len());
        self.count += n;
        let [square, size, across, fourth] =
            [rest.square, rest.size, rest.across, rest.fourth].map(|rest| simd.splat_f64s(rest));
        let [a, b, c, d] = profile.lines().map(|line| S::as_simd_f64s(&line[window.clone()]).0);
        let sums = &mut self.sums;
        let lines = [&mut sums.square, &mut sums.size, &mut sums.across, &mut sums.fourth];
        let [p, q, r, s] = lines.map(|line| S::as_mut_simd_f64s(&mut line[at..at + n]).0);
        let m = p.len();
        let (a, b, c, d) = (&a[..m], &b[..m], &c[..m], &d[..m]);
        let (q, r, s) = (&mut q[..m], &mut r[..m], &mut s[..m]);
        // All four at once: rows are short.
        for t in 0..m {
            p[t] = simd.add_f64s(square, a[t]);
            q[t] = simd.add_f64s(size, b[t]);
            r[t] = simd.add_f64s(across, c[t]);
            s[t] = simd.add_f64s(fourth, d[t]);
        }
    }
}

/// `ratio` of the sums of each cell; only arguments tell that the result overlaps nothing.
#[inline(always)]
fn evaluate(out: &mut [f64], sums: [&[f64]; 4], ratio: impl Fn(Sums) -> f64) {
    let n = out.len();
    let [square, size, across, fourth] = sums.map(|values| &values[..n]);
    for k in 0..n {
        out[k] = ratio(Sums { square: square[k], size: size[k], across: across[k], fourth: fourth[k] });
    }
}

impl Law {
    /// For a grain of radius `radius` that is solid within `inner` (m), on cells that are `even` wide along
    /// all axes if they are.
    #[inline(always)]
    pub(super) fn new(model: &MaskModel, radius: f64, inner: f64, even: Option<f64>) -> Self {
        let exact = (model.mask == Mask::ExactShear).then_some(model.viscosity * model.dt);
        let (rate, shift, plain) = match model.mask {
            Mask::Izard2014 => (0.0, 0.0, 1.0),
            Mask::ExactShear => (0.0, 0.0, 0.0),
            Mask::ParameterFree => {
                let [rate, shift] = model.rate_and_shift();
                (rate, shift, 0.0)
            }
        };
        let width = even.unwrap_or(1.0);
        Self {
            thin: FRAC_1_SQRT_2 / (model.width * width),
            rate,
            shift,
            plain,
            swing: model.swing(),
            width,
            inverse_width: 1.0 / width,
            radius,
            solid: inner * inner,
            even: even.is_some(),
            exact,
        }
    }

    /// Appends the mask ratios of a row to `out`: the places `window` of the piece; `rest` are the sums over
    /// the other axes. Those of all but the mask of exact shear are kept for [`Law::finish`], as one loop
    /// over many cells: rows are so short that most of their time would go by waiting.
    #[inline(always)]
    pub(super) fn row<S: Simd>(
        &self,
        simd: S,
        profile: &Profile,
        window: Range<usize>,
        rest: &Sums,
        (cells, out): (&mut Cells, &mut Vec<f64>),
    ) {
        let Some(spread) = self.exact else { return cells.add(simd, profile, window, rest) };
        let first = out.len();
        out.resize(first + window.len(), 0.0);
        let lines = [&profile.square, &profile.root, &profile.inverse];
        let [square, root, inverse] = lines.map(|line| &line[window.clone()]);
        let (out, rest) = (&mut out[first..], Shear::of(rest));
        let n = out.len();
        let (square, root, inverse) = (&square[..n], &root[..n], &inverse[..n]);
        for k in 0..n {
            let along = Shear { square: square[k], root: root[k], inverse: inverse[k] };
            out[k] = self.exact_shear(spread, along, rest);
        }
    }

    /// Appends the mask ratios of the rows that were kept.
    #[inline(always)]
    pub(super) fn finish(&self, cells: &Cells, out: &mut Vec<f64>) {
        let (first, n) = (out.len(), cells.count);
        out.resize(first + n, 0.0);
        let sums = cells.sums.lines().map(|line| &line[..n]);
        if self.even {
            evaluate(&mut out[first..], sums, |sums| self.ratio::<true>(sums));
        } else {
            evaluate(&mut out[first..], sums, |sums| self.ratio::<false>(sums));
        }
    }

    /// In the plane.
    #[inline(always)]
    fn exact_shear(&self, spread: f64, along: Shear, rest: Shear) -> f64 {
        let square = along.square + rest.square;
        let distance = square.sqrt();
        // 1/A^½
        let over = (along.root * along.root + rest.root * rest.root).sqrt().recip();
        let x = (distance - self.radius) * distance * over;
        let axes = [along, rest].map(|axis| [axis.root * over, axis.inverse]);
        let ratio = exact_shear(spread, x, axes);
        if square < self.solid { SOLID } else { ratio }
    }

    #[inline(always)]
    fn ratio<const EVEN: bool>(&self, Sums { square, size, across, fourth }: Sums) -> f64 {
        let distance = square.sqrt();
        // P = σ s
        let sigma = SIGMA * square - SIGMA_SLOPE * (size * size);
        // s/(2^½ f L P A^½), so that 1/w = s times this and Σ n⁴Δx²/w² = F times its square. On even cells A
        // = h² s, and the quotient need not wait for the root
        let part = if EVEN {
            self.thin / (size * sigma) * distance
        } else {
            square * (self.thin / (size * sigma * across.sqrt()))
        };
        let inverse = square * part;
        let edge = self.shift * fourth * (part * part);
        let beyond = distance - self.radius;
        // N, 1 where the surface is parallel to nodes, and Δx.
        let aligned = fourth / (square * across);
        let width = if EVEN { self.width } else { (across / square).sqrt() };
        let cells = if EVEN { beyond * self.inverse_width } else { beyond / width };
        let swung = beyond + self.swing * width * (aligned * aligned) * wave(cells);
        let exponent = edge - 2.0 * swung * inverse;
        let ratio = (self.rate * (inverse * inverse) + self.plain) * exp(exponent.clamp(-200.0, 200.0));
        let ratio = if ratio < 1.0 / EDGE { 0.0 } else { ratio };
        let full = square < self.solid || ratio > EDGE;
        if full { SOLID } else { ratio }
    }
}

/// eˣ for |x| ≤ 200 to 1e-11 of itself: 2^k e^r with |r| ≤ ln 2/2, e^r by its series.
#[inline(always)]
fn exp(x: f64) -> f64 {
    let shifted = x * LOG2_E + ROUND;
    let r = x - (shifted - ROUND) * LN_2;
    // by pairs (Estrin), so that little waits for what came before: rows are short, and time goes by waiting.
    // Written out: a loop in here would keep the loop over the cells from becoming vectors
    let r2 = r * r;
    let r4 = r2 * r2;
    let first = (1.0 + r) + r2 * (0.5 + r * (1.0 / 6.0));
    let second = (1.0 / 24.0 + r * (1.0 / 120.0)) + r2 * (1.0 / 720.0 + r * (1.0 / 5_040.0));
    let third = (1.0 / 40_320.0 + r * (1.0 / 362_880.0)) + r2 * (1.0 / 3_628_800.0);
    let sum = (first + r4 * second) + (r4 * r4) * third;
    let power = f64::from_bits((shifted.to_bits() << 52).wrapping_add(1.0f64.to_bits()));
    sum * power
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::immersed::point_mask;

    #[test]
    fn exp_is_that_of_the_library() {
        for k in -4000..=4000 {
            let x = f64::from(k) * 0.05;
            assert!((exp(x) / x.exp() - 1.0).abs() < 3e-12, "{x}: {}", exp(x) / x.exp() - 1.0);
        }
    }

    /// Compares the mask ratios of rows with those of single points; places that the grain does not hold have
    /// none. `even`: the width of all cells; `arms` of each row and `widths` of cells along the other axes.
    /// Returns the number of places between solid and none.
    fn compare<const D: usize>(mask: Mask, even: Option<f64>, arms: &[&[f64]], widths: &[f64]) -> usize {
        let model = MaskModel { mask, width: 0.5, wave: 1.0, viscosity: 1e-2, dt: 0.03 };
        let (radius, inner, outer) = (0.5, 0.2, 2.0);
        let spacing: Vec<f64> = (0..40).map(|k| even.unwrap_or(0.1 + 0.001 * f64::from(k % 7))).collect();
        let row = Row {
            at: (0..40).map(|k| -0.7 + 0.035 * f64::from(k)).collect(),
            inverse: spacing.iter().map(|h| h.powi(-2)).collect(),
            volume: vec![1.0; 40],
            spacing,
        };
        let piece = Piece { first: 0, count: 40, begin: 3, end: 37, shift: 0.01, arm: -0.69, rate: 0.0 };
        let mut profile = Profile::default();
        let law = Law::new(&model, radius, inner, even);
        profile.set(&law, &row, &piece, outer);
        let (mut out, mut expected, mut cells) = (Vec::new(), Vec::new(), Cells::default());
        cells.begin(200);
        for arms in arms {
            let mut rest = Sums::default();
            arms.iter().zip(widths).for_each(|(arm, width)| rest.add(*arm, *width));
            law.row(pulp::Scalar, &profile, 0..40, &rest, (&mut cells, &mut out));
            for (k, (x, width)) in row.at.iter().zip(&row.spacing).enumerate() {
                let r: [f64; D] = std::array::from_fn(|a| if a == 0 { x + 0.01 } else { arms[a - 1] });
                let spacing: [f64; D] = std::array::from_fn(|a| if a == 0 { *width } else { widths[a - 1] });
                let distance = r.iter().map(|r| r * r).sum::<f64>().sqrt();
                let ratio = point_mask::ratio(&model, distance - radius, &r.map(|r| r / distance), &spacing);
                let ratio = if distance < inner { SOLID } else { ratio };
                expected.push(if (piece.begin..piece.end).contains(&k) { ratio } else { 0.0 });
            }
        }
        law.finish(&cells, &mut out);
        assert_eq!(out.len(), expected.len());
        let tolerance = if mask == Mask::ExactShear { [1e-9, 1e-15] } else { [1e-10, 0.0] };
        for (k, (ours, exact)) in out.iter().zip(&expected).enumerate() {
            let close = (ours - exact).abs() <= tolerance[0] * exact + tolerance[1];
            assert!(close, "{mask:?} {k}: {ours} against {exact}");
        }
        expected.iter().filter(|ratio| **ratio > 0.0 && **ratio < SOLID).count()
    }

    #[test]
    fn mask_ratios_of_rows_are_those_of_single_points() {
        let arms: [&[f64]; 5] = [&[0.0, 0.0], &[0.1, -0.2], &[0.3, 0.35], &[-0.55, 0.1], &[0.6, 0.6]];
        compare::<3>(Mask::ParameterFree, None, &arms, &[0.11, 0.09]);
        compare::<3>(Mask::ParameterFree, Some(0.1), &arms, &[0.1, 0.1]);
        compare::<3>(Mask::Izard2014, None, &arms, &[0.11, 0.09]);
        // In the plane.
        let felt =
            compare::<2>(Mask::ExactShear, None, &[&[0.0], &[0.1], &[-0.33], &[0.55], &[0.6]], &[0.09]);
        assert!(felt > 40, "{felt}");
    }

    const MODEL: MaskModel =
        MaskModel { mask: Mask::ParameterFree, width: 0.5, wave: 1.0, viscosity: 1e-2, dt: 0.5 };

    /// Mask ratio at distance `s` outside a unit sphere, along the normal `n`, as rows have it.
    fn at_distance(model: &MaskModel, s: f64, n: [f64; 2], h: f64) -> f64 {
        let [inner, _] = model.reach(1.0, h, h);
        let [along, rest] = n.map(|n| {
            let mut sums = Sums::default();
            sums.add((1.0 + s) * n, h);
            sums
        });
        let law = Law::new(model, 1.0, inner, None);
        match law.exact {
            Some(spread) => law.exact_shear(spread, Shear::of(&along), Shear::of(&rest)),
            None => {
                let mut both = Sums::default();
                both.add((1.0 + s) * n[1], h);
                both.add((1.0 + s) * n[0], h);
                law.ratio::<false>(both)
            }
        }
    }

    #[test]
    fn parameter_free_mask_is_the_printed_formula() {
        let (n, s) = ([0.6, 0.8], 0.03);
        let w = point_mask::thickness(0.5, &n, &[0.1; 2]);
        let fourth = n[0].powi(4) + n[1].powi(4);
        let tau = w * w / (4.0 * 1e-2) * (2.0 * 0.5772156649_f64 - 0.0617 * fourth * 0.01 / (w * w)).exp();
        // 0.3 of a cell: 8 · 0.3 (1 − 2 · 0.3) = 0.96
        let swung = s + 0.092 * fourth * fourth * 0.1 * 0.96;
        let beta = 1.0 / (1.0 + tau / 0.5 * (2.0 * swung / w).exp());
        let ours = point_mask::fraction(at_distance(&MODEL, s, n, 0.1));
        assert!((ours - beta).abs() < 1e-9, "{ours} against {beta}");
    }

    #[test]
    fn inside_is_solid_outside_is_fluid_and_the_reach_knows_it() {
        for mask in [Mask::ParameterFree, Mask::Izard2014, Mask::ExactShear] {
            for dt in [1e-4, 0.5, 100.0] {
                let model = MaskModel { mask, dt, ..MODEL };
                let [inner, outer] = model.reach(1.0, 0.1, 0.1);
                for angle in 0..90 {
                    let angle = f64::from(angle).to_radians();
                    let n = [angle.cos(), angle.sin()];
                    assert_eq!(at_distance(&model, outer - 1.0, n, 0.1), 0.0);
                    assert_eq!(at_distance(&model, inner - 1.0, n, 0.1), SOLID);
                }
            }
        }
    }

    #[test]
    fn permeability_does_not_depend_on_dt() {
        // χ = q / dt is what the steady state sees.
        let chi = |dt: f64| at_distance(&MaskModel { dt, ..MODEL }, 0.02, [0.0, 1.0], 0.1) / dt;
        assert!((chi(0.5) / chi(0.01) - 1.0).abs() < 1e-10);
    }
}
