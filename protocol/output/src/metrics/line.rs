//! A straight line through values over time, by least squares, in constant memory.

use serde::{Deserialize, Serialize};

/// Sums of the values so far, each window with its length as weight.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, Serialize)]
pub struct Line {
    /// Part of the run that counts, s.
    from: f64,
    to: f64,
    /// Σ w, means of t and y, and Σ w of their squares and product about the means (Welford 1962).
    weight: f64,
    mean: [f64; 2],
    tt: f64,
    ty: f64,
    yy: f64,
}

impl Line {
    /// Nothing yet.
    pub(super) fn new(from: f64, to: f64) -> Self {
        Self { from, to, ..Self::default() }
    }

    /// Adds a value at `t` with a weight.
    pub(super) fn add(&mut self, t: f64, weight: f64, y: f64) {
        if !(self.from..=self.to).contains(&t) || !y.is_finite() {
            return;
        }
        self.weight += weight;
        let share = weight / self.weight;
        let (dt, dy) = (t - self.mean[0], y - self.mean[1]);
        self.mean[0] += dt * share;
        self.mean[1] += dy * share;
        self.tt += weight * dt * (t - self.mean[0]);
        self.ty += weight * dt * (y - self.mean[1]);
        self.yy += weight * dy * (y - self.mean[1]);
    }

    /// Value at t = 0 and slope.
    pub(super) fn fit(&self) -> Result<(f64, f64), String> {
        if self.tt <= 0.0 {
            return Err(format!("fewer than two windows ended between {} and {} s", self.from, self.to));
        }
        let slope = self.ty / self.tt;
        Ok((self.mean[1] - slope * self.mean[0], slope))
    }

    /// Root mean square about the line over the mean.
    pub(super) fn misfit(&self) -> Result<f64, String> {
        let (_, slope) = self.fit()?;
        Ok(((self.yy - slope * self.ty).max(0.0) / self.weight).sqrt() / self.mean[1].abs())
    }
}

/// Value at `x` on the line through two points (x, y).
pub(super) fn interpolate(x: f64, (x0, y0): (f64, f64), (x1, y1): (f64, f64)) -> f64 {
    y0 + (y1 - y0) * (x - x0) / (x1 - x0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_is_found_again_and_what_lies_outside_does_not_count() {
        let mut line = Line::new(1.0, 9.0);
        for k in 0..100 {
            let t = 0.1 * f64::from(k);
            let y = if (1.0..=9.0).contains(&t) { 3.0 + 0.5 * t } else { 1e9 };
            line.add(t, 0.1 + 0.01 * f64::from(k % 7), y);
        }
        let (start, slope) = line.fit().unwrap();
        assert!((start - 3.0).abs() < 1e-12 && (slope - 0.5).abs() < 1e-13, "{start}, {slope}");
        assert!(line.misfit().unwrap() < 1e-8);
        line.add(5.0, 1.0, 100.0);
        assert!(line.misfit().unwrap() > 0.1);
        assert!(Line::new(0.0, 1.0).fit().is_err());
    }
}
