//! The mean of a series over the part of it that is stationary, with its standard error, in constant memory.
//!
//! Where it begins: MSER-5 (White 1997, Simulation 69, 323; White, Cobb & Spratt 2000, Proc. Winter
//! Simulation Conf., 755): of the means of five batches, drop those from the start whose removal makes the
//! squared error of the mean of the others, Σ (y − ȳ)²/m², least. A least in the second half says that the
//! series is not stationary. Its error: Var/n · 2 τ, τ the integrated autocorrelation time up to the first
//! lag above six times it (Madras & Sokal 1988, J. Stat. Phys. 50, 109), with the bias of a short series
//! taken off (Wolff 2004, Comput. Phys. Commun. 156, 143, eq. 49).

use serde::{Deserialize, Serialize};

/// Batches that are kept: where they are full, each two become one.
const BATCHES: usize = 1024;

/// Batches that MSER-5 takes together.
const FIVE: usize = 5;

/// Batches below which nothing is said.
const FEWEST: usize = 10 * FIVE;

/// Lags that count, in integrated autocorrelation times.
const WINDOW: f64 = 6.0;

/// Independent values below which the error itself is uncertain by a sixth and more.
const FEW: f64 = 20.0;

/// Integrals of a series over batches of equal time.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, Serialize)]
pub struct Stationary {
    /// Start of the first batch, s; none before the first window.
    start: Option<f64>,
    /// Length of a batch, s: first that of the first window.
    length: f64,
    /// Integrals: those of whole batches, and the next.
    integrals: Vec<f64>,
    whole: usize,
    /// How much of the next there is, s.
    begun: f64,
    windows: usize,
}

/// A mean with its standard error.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Estimate {
    pub(super) mean: f64,
    pub(super) error: f64,
    /// Start of the mean, s.
    from: f64,
    /// Independent values that it is worth.
    samples: f64,
}

impl Stationary {
    pub(super) fn new() -> Self {
        Self { integrals: vec![0.0; BATCHES], ..Self::default() }
    }

    /// Adds the mean of a window that begins at `start` and is `length` long, s.
    pub(super) fn add(&mut self, start: f64, length: f64, mean: f64) {
        if self.start.is_none() {
            (self.start, self.length) = (Some(start), length);
        }
        self.windows += 1;
        let mut left = length;
        while left > 0.0 {
            let room = self.length - self.begun;
            self.integrals[self.whole] += mean * left.min(room);
            if left < room {
                self.begun += left;
                return;
            }
            left -= room;
            self.begun = 0.0;
            self.whole += 1;
            if self.whole == BATCHES {
                self.whole /= 2;
                self.length *= 2.0;
                for batch in 0..self.whole {
                    self.integrals[batch] = self.integrals[2 * batch] + self.integrals[2 * batch + 1];
                }
                self.integrals[self.whole..].fill(0.0);
            }
        }
    }

    /// The mean, or why there is none.
    pub(super) fn estimate(&self) -> Result<Estimate, String> {
        let means: Vec<f64> = self.integrals[..self.whole].iter().map(|sum| sum / self.length).collect();
        // Windows may be longer than the first, whose length batches have.
        let (has, least) = (self.windows.min(means.len()), FEWEST);
        if has < least {
            return Err(format!("has {has} windows; whether it is stationary takes {least} to tell"));
        }
        let first = FIVE * truncation(&means);
        let start = self.start.unwrap_or(0.0);
        if 2 * first > means.len() {
            let end = start + self.length * means.len() as f64;
            return Err(format!("is not stationary by t = {end} s (MSER-5): let it run on"));
        }
        let (mean, error, samples) = with_error(&means[first..]);
        Ok(Estimate { mean, error, from: start + self.length * first as f64, samples })
    }
}

impl Estimate {
    /// What is to be known of it.
    pub(super) fn note(&self) -> String {
        let few = if self.samples < FEW { ": so few that the error is rough" } else { "" };
        let Self { from, samples, .. } = self;
        format!("from t = {from:.4} s on, where it is stationary; {samples:.0} independent values{few}")
    }
}

/// Number of means of five to drop from the start.
fn truncation(means: &[f64]) -> usize {
    let (mut best, mut least) = (means.len() / FIVE, f64::INFINITY);
    let (mut mean, mut square) = (0.0, 0.0);
    let groups = means.as_chunks::<FIVE>().0;
    for (kept, group) in groups.iter().rev().enumerate() {
        let count = (kept + 1) as f64;
        let away = group.iter().sum::<f64>() / FIVE as f64 - mean;
        mean += away / count;
        square += away * away * kept as f64 / count;
        // The last few are alike by chance; ties go to the longer series.
        let square = square.max(count * (4.0 * f64::EPSILON * mean).powi(2));
        if kept + 1 >= FIVE && square / (count * count) <= least {
            (best, least) = (groups.len() - kept - 1, square / (count * count));
        }
    }
    best
}

/// Mean, its standard error, and the independent values that this is worth.
fn with_error(values: &[f64]) -> (f64, f64, f64) {
    let count = values.len() as f64;
    let first = values[0];
    let mean = first + values.iter().map(|value| value - first).sum::<f64>() / count;
    let covariance = |lag: usize| {
        let pairs = values.iter().zip(&values[lag..]);
        pairs.map(|(a, b)| (a - mean) * (b - mean)).sum::<f64>() / (count - lag as f64)
    };
    let variance = covariance(0);
    // A constant, to round-off.
    if variance <= (4.0 * f64::EPSILON * mean).powi(2) {
        return (mean, 0.0, count);
    }
    let (mut time, mut lag) = (0.5, 1);
    while lag < values.len() / 2 && lag as f64 <= WINDOW * time {
        time += covariance(lag) / variance;
        lag += 1;
    }
    let inefficiency = 2.0 * time.max(0.5 / count) * (1.0 + (2 * lag - 1) as f64 / count);
    (mean, (variance * inefficiency / count).sqrt(), count / inefficiency)
}

#[cfg(test)]
mod tests {
    use super::*;
    use bedload_scene::SplitMix64;

    /// A series x ← φ x + noise of unit variance about 5, with a start of so many of its deviations that dies
    /// out with `decay` steps, and its estimate.
    fn drawn(seed: u64, count: u32, phi: f64, start: f64, decay: f64) -> Result<Estimate, String> {
        let mut random = SplitMix64::new(seed);
        let mut noise = || (0..12).map(|_| random.unit()).sum::<f64>() - 6.0;
        let deviation = (1.0 - phi * phi).sqrt().recip();
        let (mut x, mut series) = (deviation * noise(), Stationary::new());
        for step in 0..count {
            x = phi * x + noise();
            let begins = start * deviation * (-f64::from(step) / decay).exp();
            series.add(0.1 * f64::from(step), 0.1, 5.0 + x + begins);
        }
        series.estimate()
    }

    /// Part of 400 series whose mean lies within two standard errors, and their mean distance in standard
    /// errors; a share of them may be found not stationary.
    fn covered(count: u32, phi: f64, start: f64, decay: f64) -> (f64, f64) {
        let found: Vec<f64> = (0..400)
            .filter_map(|seed| drawn(seed, count, phi, start, decay).ok())
            .map(|found| (found.mean - 5.0) / found.error)
            .collect();
        assert!(found.len() >= 380, "{} of 400", found.len());
        let inside = found.iter().filter(|away| away.abs() < 2.0).count();
        (inside as f64 / found.len() as f64, found.iter().sum::<f64>() / found.len() as f64)
    }

    /// Two standard errors hold 0.954 of a normal distribution; of 400 draws ± 0.01, less where there are few
    /// independent values (100 and more here).
    #[test]
    fn two_standard_errors_hold_the_mean_in_the_right_share_of_series() {
        for (count, phi) in [(2_000, 0.0), (2_000, 0.9), (10_000, 0.9), (20_000, 0.98)] {
            let (share, away) = covered(count, phi, 0.0, 1.0);
            assert!((0.91..=0.98).contains(&share), "{count} values, {phi}: {share}");
            assert!(away.abs() < 0.2, "{count} values, {phi}: {away}");
        }
    }

    /// The same where the series begins 20 deviations away: what is left of that is small beside the error.
    #[test]
    fn a_start_that_dies_out_is_left_out() {
        let (share, away) = covered(10_000, 0.9, 20.0, 100.0);
        assert!((0.91..=0.98).contains(&share) && away.abs() < 0.25, "{share}, {away}");
        let found = drawn(1, 10_000, 0.9, 20.0, 100.0).unwrap();
        assert!((20.0..100.0).contains(&found.from), "20 e^(-t/10 s) is 0.4 after 39 s: {found:?}");
    }

    /// The error of the mean of an AR(1) series is known: (1 + φ)/(1 − φ) over the count times its variance.
    #[test]
    fn the_error_is_that_of_theory() {
        let (count, phi) = (10_000, 0.9);
        let exact = ((1.0 + phi) / (1.0 - phi) / f64::from(count) / (1.0 - phi * phi)).sqrt();
        let errors = (0..100).filter_map(|seed| drawn(seed, count, phi, 0.0, 1.0).ok());
        let errors: Vec<f64> = errors.map(|found| found.error / exact).collect();
        let mean = errors.iter().sum::<f64>() / errors.len() as f64;
        assert!((mean - 1.0).abs() < 0.05, "{mean}");
    }

    #[test]
    fn what_still_drifts_or_is_too_short_has_no_mean() {
        let mut series = Stationary::new();
        (0..3000).for_each(|step| series.add(f64::from(step), 1.0, f64::from(step)));
        assert!(series.estimate().unwrap_err().contains("is not stationary by t = 3000 s"));
        assert!(drawn(1, 49, 0.0, 0.0, 1.0).unwrap_err().contains("49 windows"));
    }

    /// Windows of any length, and the batches of a series that is much longer: the integral stays.
    #[test]
    fn batches_hold_the_whole_integral() {
        let (mut series, mut whole, mut time) = (Stationary::new(), 0.0, 0.0);
        for step in 0..5000 {
            let length = 0.01 * f64::from(1 + step % 7);
            series.add(time, length, f64::from(step));
            whole += length * f64::from(step);
            time += length;
        }
        assert!((series.integrals.iter().sum::<f64>() / whole - 1.0).abs() < 1e-12);
        assert!((series.length * series.whole as f64 + series.begun - time).abs() < 1e-9 * time);
        assert!((BATCHES / 2..BATCHES).contains(&series.whole));
        let constant = (0..100).fold(Stationary::new(), |mut series, step| {
            series.add(f64::from(step), 1.0, 0.1);
            series
        });
        let found = constant.estimate().unwrap();
        assert!(found.error <= 1e-16 && (found.mean - 0.1).abs() < 1e-16 && found.from == 0.0, "{found:?}");
    }

    /// A mean that is constant but for round-off is stationary from where it is so; 20 long windows are few.
    #[test]
    fn round_off_is_no_drift_and_batches_are_no_windows() {
        let mut series = Stationary::new();
        for step in 0..2000 {
            let round_off = f64::EPSILON * f64::from(step % 3 + step / 700);
            series.add(f64::from(step), 1.0, -5.7e-3 * (1.0 + (-f64::from(step) / 10.0).exp() + round_off));
        }
        let found = series.estimate().expect("stationary");
        assert!((found.mean / -5.7e-3 - 1.0).abs() < 1e-12 && found.from < 600.0, "{found:?}");
        let mut few = Stationary::new();
        (0..20).for_each(|step| few.add(f64::from(step), if step == 0 { 0.1 } else { 1.0 }, 1.0));
        assert!(few.estimate().unwrap_err().contains("20 windows"));
    }

    /// What comes before the last value that is not a number does not count.
    #[test]
    fn what_is_not_known_at_the_start_is_left_out() {
        let mut series = Stationary::new();
        for step in 0..500 {
            let value = if step < 3 { f64::NAN } else { f64::from(step % 2) };
            series.add(f64::from(step), 1.0, value);
        }
        let found = series.estimate().unwrap();
        assert!(found.from >= 3.0 && (found.mean - 0.5).abs() < 0.01, "{found:?}");
    }
}
