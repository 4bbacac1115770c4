//! Janssen's model of a silo (1895; Izard et al. 2014, eq. 22) against a profile.
//!
//! p(z) = ρ_g g S/(k P) (1 − exp(−k P (h − z)/S)), k = f_w K, S area and P perimeter of the silo, ρ_g
//! density of the granular medium, h height of its top.

use crate::output::profile::Profile;

/// A number and how far it is certain.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Measured {
    /// Value.
    pub value: f64,
    /// Standard error of a fit, or standard deviation over slabs.
    pub spread: f64,
    /// Slabs that it comes from.
    pub slabs: usize,
}

/// A silo as Janssen sees it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Silo {
    /// ρ_g, kg/m³.
    pub density: f64,
    /// g, m/s².
    pub gravity: f64,
    /// S/P, m.
    pub section: f64,
    /// h, m.
    pub top: f64,
}

impl Silo {
    /// From the slabs of `range`: ρ_g is their mean, and h where a column of that density ends.
    /// `None` if there is no grain or no slab.
    pub fn new(profile: &Profile, range: [f64; 2], gravity: f64) -> Option<Self> {
        let filled: Vec<f64> = profile.slabs_in(range).map(|slab| profile.cells[slab].density).collect();
        // Slabs above the top, and the one that holds it, say nothing of the density.
        let most = filled.iter().copied().fold(0.0, f64::max);
        let full: Vec<f64> = filled.into_iter().filter(|density| *density > 0.8 * most).collect();
        if full.is_empty() || most <= 0.0 {
            return None;
        }
        let density = full.iter().sum::<f64>() / full.len() as f64;
        let above = [range[0], f64::INFINITY];
        let first = profile.slabs_in(above).next()?;
        let mass: f64 = profile.slabs_in(above).map(|slab| profile.cells[slab].density * profile.width).sum();
        let top = profile.middle(first) - 0.5 * profile.width + mass / density;
        Some(Self { density, gravity: gravity.abs(), section: profile.area / profile.perimeter, top })
    }

    /// Janssen's pressure at `z` for k = f_w K, Pa.
    pub fn pressure(&self, z: f64, k: f64) -> f64 {
        let depth = (self.top - z).max(0.0);
        self.density * self.gravity * self.section / k * -(-k * depth / self.section).exp_m1()
    }

    /// Hydrostatic pressure at `z`, Pa.
    pub fn hydrostatic(&self, z: f64) -> f64 {
        self.density * self.gravity * (self.top - z).max(0.0)
    }

    /// k of least squares over the slabs of `range` below the top, from 1e-4 to 100, none if it lies beyond.
    pub fn fit(&self, profile: &Profile, range: [f64; 2]) -> Option<Measured> {
        let below = [range[0], range[1].min(self.top)];
        let points: Vec<(f64, f64)> =
            profile.slabs_in(below).map(|slab| (profile.middle(slab), profile.pressure(slab))).collect();
        if points.len() < 3 {
            return None;
        }
        let miss = |ln_k: f64| -> f64 {
            points.iter().map(|(z, p)| (p - self.pressure(*z, ln_k.exp())).powi(2)).sum()
        };
        let value = least(miss, 1e-4f64.ln(), 1e2f64.ln())?.exp();
        let slope =
            |z: f64| (self.pressure(z, value * 1.001) - self.pressure(z, value * 0.999)) / (0.002 * value);
        let steepness: f64 = points.iter().map(|(z, _)| slope(*z).powi(2)).sum();
        let spread = (miss(value.ln()) / (points.len() - 1) as f64 / steepness).sqrt();
        Some(Measured { value, spread, slabs: points.len() })
    }
}

/// Place of the least value between `low` and `high`: the best of a coarse walk, then golden section; none if
/// it is at an end.
pub(crate) fn least(f: impl Fn(f64) -> f64, low: f64, high: f64) -> Option<f64> {
    const WALK: usize = 400;
    let step = (high - low) / WALK as f64;
    let best = (0..=WALK).min_by(|a, b| f(low + step * *a as f64).total_cmp(&f(low + step * *b as f64)));
    let middle = low + step * best.filter(|best| (1..WALK).contains(best))? as f64;
    let golden = 0.5 * (5.0_f64.sqrt() - 1.0);
    let (mut a, mut b) = (middle - step, middle + step);
    for _ in 0..100 {
        let (c, d) = (b - golden * (b - a), a + golden * (b - a));
        if f(c) < f(d) {
            b = d;
        } else {
            a = c;
        }
    }
    Some(0.5 * (a + b))
}

/// f_w K measured: friction of the side walls over granular pressure, slab by slab; none without a wall.
pub fn direct(profile: &Profile, range: [f64; 2]) -> Option<Measured> {
    if profile.perimeter == 0.0 {
        return None;
    }
    mean(bearing(profile, range).map(|slab| profile.wall_stress(slab)[1] / profile.pressure(slab)))
}

/// Mean granular pressure, Pa.
pub fn plateau(profile: &Profile, range: [f64; 2]) -> Option<Measured> {
    mean(bearing(profile, range).map(|slab| profile.pressure(slab)))
}

/// Slabs of `range` that bear a pressure.
fn bearing(profile: &Profile, range: [f64; 2]) -> impl Iterator<Item = usize> + '_ {
    profile.slabs_in(range).filter(|&slab| profile.pressure(slab) > 0.0)
}

/// Mean and standard deviation of the values of slabs.
pub(crate) fn mean(values: impl Iterator<Item = f64>) -> Option<Measured> {
    let values: Vec<f64> = values.collect();
    let count = values.len() as f64;
    let value = values.iter().sum::<f64>() / count;
    let spread = (values.iter().map(|v| (v - value).powi(2)).sum::<f64>() / count).sqrt();
    (!values.is_empty()).then_some(Measured { value, spread, slabs: values.len() })
}
