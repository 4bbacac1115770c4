//! Work on eight lanes, compiled for every vector width that a machine may have.

use crate::vector::lanes::{Lanes8, Portable8};
use pulp::{Simd, WithSimd};

/// Work on eight lanes.
pub(crate) trait Kernel {
    type Output;

    /// Does it; must be `inline(always)`, else it is compiled for the narrowest vectors.
    fn run<L: Lanes8>(self, token: L::Token) -> Self::Output;
}

/// Does the work in the widest vectors of the machine; with `plain` the widest of all are left unused.
pub(crate) fn dispatch<K: Kernel>(kernel: K, plain: bool) -> K::Output {
    #[cfg(target_arch = "x86_64")]
    {
        if let Some(simd) = pulp::x86::V4::try_new().filter(|_| !plain) {
            return Simd::vectorize(simd, OnAvx512(kernel, simd));
        }
        match pulp::x86::V3::try_new() {
            Some(simd) => Simd::vectorize(simd, OnPortable(kernel)),
            None => OnPortable(kernel).with_simd(pulp::Scalar),
        }
    }
    #[cfg(not(target_arch = "x86_64"))]
    {
        let _ = plain;
        pulp::Arch::new().dispatch(OnPortable(kernel))
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
