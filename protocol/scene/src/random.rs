//! Sebastiano Vigna's SplitMix64 (2015): small, seedable, the same on every machine.

use crate::domain::Geometry;

/// Random numbers from a seed.
pub struct SplitMix64(pub(crate) u64);

impl SplitMix64 {
    /// The numbers of a seed, from the first on.
    pub fn new(seed: u64) -> Self {
        Self(seed)
    }

    pub(crate) fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// Uniform in [0, 1).
    pub fn unit(&mut self) -> f64 {
        (self.next() >> 11) as f64 / (1u64 << 53) as f64
    }

    /// Uniform about `mean`, relative half-width `spread`.
    pub fn about(&mut self, mean: f64, spread: f64) -> f64 {
        mean * (1.0 + spread * (2.0 * self.unit() - 1.0))
    }

    /// Place that is uniform in a box which holds a grain of `radius` whole, but for the periodic axes that
    /// it spans ([`Domain::spanned`](crate::Domain::spanned)): there anywhere from face to face, the upper
    /// one not included. y = 0 in the plane.
    pub(crate) fn place(
        &mut self,
        geometry: Geometry,
        spanned: &[Option<(f64, f64)>; 3],
        lower: &[f64; 3],
        upper: &[f64; 3],
        radius: f64,
    ) -> [f64; 3] {
        std::array::from_fn(|axis| {
            if axis == 1 && geometry == Geometry::Plane {
                return 0.0;
            }
            if let Some((lower, length)) = spanned[axis] {
                let place = lower + length * self.unit();
                return if place < lower + length { place } else { lower };
            }
            let (lower, upper) = (lower[axis] + radius, upper[axis] - radius);
            lower + (upper - lower) * self.unit()
        })
    }
}
