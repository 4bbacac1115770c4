//! Work on eight lanes, compiled for every vector width that a machine may have.

use crate::vector::lanes::{Lanes8, Portable8};
use bedload_vectors::arch;
use pulp::{Simd, WithSimd};

/// Work on eight lanes.
pub(crate) trait Kernel {
    type Output;

    /// Does it; must be `inline(always)`, else it is compiled for the narrowest vectors.
    fn run<L: Lanes8>(self, token: L::Token) -> Self::Output;
}

/// Does the work with the vectors of [`arch`]; with `plain` the widest of all are left unused.
pub(crate) fn dispatch<K: Kernel>(kernel: K, plain: bool) -> K::Output {
    #[cfg(target_arch = "x86_64")]
    match (arch(), pulp::x86::V3::try_new()) {
        (pulp::Arch::V4(simd), _) if !plain => Simd::vectorize(simd, OnAvx512(kernel, simd)),
        (pulp::Arch::V4(_) | pulp::Arch::V3(_), Some(simd)) => Simd::vectorize(simd, OnPortable(kernel)),
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
