//! Real Fourier transform: even and odd values packed as real and imaginary parts, or an odd number of them
//! as they are.

use super::ends::{Emit, EmitPairs, Read, ReadPairs};
use super::line::{Reader, Writer};
use crate::vector::Complex;
use pulp::Simd;

/// Values in, amplitudes out.
pub(super) struct Fourier<T>(pub(super) T);

/// Amplitudes in, values out (times n).
pub(super) struct FourierBack<T>(pub(super) T);

impl<S: Simd> Read<S> for Fourier<Reader<'_, S>> {
    #[inline(always)]
    fn place(&self, j: usize, t: usize) -> Complex<S> {
        self.0.complex(2 * j, 2 * j + 1, t)
    }
}

impl<S: Simd, const ADD: bool> EmitPairs<S> for Fourier<Writer<'_, S, ADD>> {
    #[inline(always)]
    fn zero(&mut self, t: usize, z: Complex<S>) {
        self.0.put(0, t, z.re + z.im);
        self.0.put(self.0.plan.n / 2, t, z.re - z.im);
    }

    #[inline(always)]
    fn pair(&mut self, k: usize, t: usize, z: Complex<S>, mirror: Complex<S>) {
        let n = self.0.plan.n;
        let [low, high] = self.0.plan.unpack(k, z, mirror);
        self.0.put(k, t, low.re);
        self.0.put(n - k, t, low.im);
        if 4 * k != n {
            self.0.put(n / 2 - k, t, high.re);
            self.0.put(n / 2 + k, t, high.im);
        }
    }
}

impl<S: Simd> ReadPairs<S> for FourierBack<Reader<'_, S>> {
    #[inline(always)]
    fn zero(&self, t: usize) -> Complex<S> {
        let z = self.0.complex(0, self.0.plan.n / 2, t);
        Complex::new(z.re + z.im, z.re - z.im).swap()
    }

    #[inline(always)]
    fn pair(&self, k: usize, t: usize) -> [Complex<S>; 2] {
        let n = self.0.plan.n;
        let here = self.0.complex(k, n - k, t);
        self.0.plan.pack(k, here, self.0.complex(n / 2 - k, n / 2 + k, t))
    }
}

impl<S: Simd, const ADD: bool> Emit<S> for FourierBack<Writer<'_, S, ADD>> {
    #[inline(always)]
    fn place(&mut self, k: usize, t: usize, z: Complex<S>) {
        self.0.put(2 * k, t, z.im);
        self.0.put(2 * k + 1, t, z.re);
    }
}

/// Values in, amplitudes out, an odd number of them.
pub(super) struct Odd<T>(pub(super) T);

/// Amplitudes in, values out (times n), an odd number of them.
pub(super) struct OddBack<T>(pub(super) T);

impl<S: Simd> Read<S> for Odd<Reader<'_, S>> {
    #[inline(always)]
    fn place(&self, j: usize, t: usize) -> Complex<S> {
        let value = self.0.get(j, t);
        Complex::new(value, value.splat(0.0))
    }
}

impl<S: Simd, const ADD: bool> Emit<S> for Odd<Writer<'_, S, ADD>> {
    #[inline(always)]
    fn place(&mut self, k: usize, t: usize, z: Complex<S>) {
        let n = self.0.plan.n;
        // the others are the conjugates of these
        if 2 * k < n {
            self.0.put(k, t, z.re);
            if k > 0 {
                self.0.put(n - k, t, z.im);
            }
        }
    }
}

impl<S: Simd> Read<S> for OddBack<Reader<'_, S>> {
    #[inline(always)]
    fn place(&self, k: usize, t: usize) -> Complex<S> {
        let n = self.0.plan.n;
        let z = match k {
            0 => Complex::new(self.0.get(0, t), self.0.get(0, t).splat(0.0)),
            _ if 2 * k < n => self.0.complex(k, n - k, t),
            _ => self.0.complex(n - k, k, t).conj(),
        };
        z.swap()
    }
}

impl<S: Simd, const ADD: bool> Emit<S> for OddBack<Writer<'_, S, ADD>> {
    #[inline(always)]
    fn place(&mut self, k: usize, t: usize, z: Complex<S>) {
        self.0.put(k, t, z.im);
    }
}
