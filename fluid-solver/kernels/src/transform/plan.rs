//! What a fast transform needs to know of its length.

use super::fft::Fft;
use super::kind::Kind;
use std::f64::consts::PI;

/// Plan of one fast transform.
pub(super) struct Plan {
    pub(super) kind: Kind,
    /// Number of cells n, even but for [`Kind::Periodic`].
    pub(super) n: usize,
    /// Whether the transform is the sine of its pair.
    pub(super) odd: bool,
    pub(super) fft: Fft,
    /// e^{−2πik/n}, k < n/2.
    pub(super) split: Vec<[f64; 2]>,
    /// Rotation of the kind: e^{−iπk/2n}, or e^{−iπ(k + 1/8)/n} (type IV), or sin πk/n (sine I).
    pub(super) turn: Vec<[f64; 2]>,
}

impl Plan {
    /// Complex places of the transform of a line of n values: n where n is odd, which only a periodic line
    /// may be.
    /// `None` where there is none, as they are too few or have a prime factor above 5.
    pub(super) fn places(n: usize, periodic: bool) -> Option<Fft> {
        match n.is_multiple_of(2) {
            true => Fft::new(n / 2),
            false if periodic => Fft::new(n),
            false => None,
        }
    }

    /// Plans the transform, or `None` where [`Plan::places`] has none.
    pub(super) fn new(kind: Kind, n: usize) -> Option<Self> {
        let unit = |angle: f64| [angle.cos(), -angle.sin()];
        let cells = n as f64;
        let turn = |k: usize| match kind {
            Kind::EvenOdd | Kind::OddEven => unit(PI * (k as f64 + 0.125) / cells),
            Kind::Fixed => [(PI * k as f64 / cells).sin(), 0.0],
            _ => unit(0.5 * PI * k as f64 / cells),
        };
        Some(Self {
            kind,
            n,
            odd: matches!(kind, Kind::OddOdd | Kind::OddEven),
            fft: Self::places(n, kind == Kind::Periodic)?,
            split: (0..n / 2).map(|k| unit(2.0 * PI * k as f64 / cells)).collect(),
            turn: (0..n).map(turn).collect(),
        })
    }
}
