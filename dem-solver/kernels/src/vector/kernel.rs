//! Work on eight lanes, compiled for every vector width that a machine may have.

use crate::vector::lanes::{Lanes8, Portable8};
use pulp::{Arch, Simd, WithSimd};
use std::sync::OnceLock;

/// Work on eight lanes.
pub(crate) trait Kernel {
    type Output;

    /// Does it; must be `inline(always)`, else it is compiled for the narrowest vectors.
    fn run<L: Lanes8>(self, token: L::Token) -> Self::Output;
}

/// The vectors to use: the widest of this machine, or fewer where the environment variable `BEDLOAD_VECTORS`
/// says `baseline` or `avx2`. No bit of a result depends on it, which is what it is for: to test that.
pub(crate) fn arch() -> Arch {
    static ARCH: OnceLock<Arch> = OnceLock::new();
    *ARCH.get_or_init(|| {
        let wanted = std::env::var("BEDLOAD_VECTORS").unwrap_or_default();
        #[cfg(target_arch = "x86_64")]
        match (wanted.as_str(), pulp::x86::V3::try_new()) {
            ("baseline", _) => return Arch::Scalar,
            ("avx2", Some(simd)) => return Arch::V3(simd),
            _ => {}
        }
        let _ = wanted;
        Arch::new()
    })
}

/// Does the work with the vectors of [`arch`]; with `plain` the widest of all are left unused.
pub(crate) fn dispatch<K: Kernel>(kernel: K, plain: bool) -> K::Output {
    #[cfg(target_arch = "x86_64")]
    match (arch(), pulp::x86::V3::try_new()) {
        (Arch::V4(simd), _) if !plain => Simd::vectorize(simd, OnAvx512(kernel, simd)),
        (Arch::V4(_) | Arch::V3(_), Some(simd)) => Simd::vectorize(simd, OnPortable(kernel)),
        _ => OnPortable(kernel).with_simd(pulp::Scalar),
    }
    #[cfg(not(target_arch = "x86_64"))]
    {
        let _ = plain;
        arch().dispatch(OnPortable(kernel))
    }
}

#[cfg(target_arch = "x86_64")]
struct OnAvx512<K>(K, pulp::x86::V4);

#[cfg(target_arch = "x86_64")]
impl<K: Kernel> WithSimd for OnAvx512<K> {
    type Output = K::Output;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> K::Output {
        self.0.run::<crate::vector::avx512::Avx512>(self.1)
    }
}

struct OnPortable<K>(K);

impl<K: Kernel> WithSimd for OnPortable<K> {
    type Output = K::Output;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> K::Output {
        self.0.run::<Portable8>(())
    }
}
