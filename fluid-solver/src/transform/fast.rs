//! Fast real-to-real transforms of eight lines: an even length n through a complex transform of n/2.
//!
//! Real Fourier by packing even and odd values; cosine II and III after Makhoul (1980); the type
//! IV pair by one rotation before and one after; sine I by the odd–even split of Cooley, Lewis &
//! Welch (1970); sines of type II, III and IV from the cosines by reversal and alternating signs.

use super::Kind;
use super::fft::Fft;
use super::vector::{Complex, Real};
use crate::lanes::{Lanes, ZERO};
use pulp::{Arch, Simd, WithSimd};
use std::f64::consts::PI;

/// Plan of one fast transform.
pub(super) struct Fast {
    kind: Kind,
    /// Number of cells n, even.
    n: usize,
    fft: Fft,
    /// e^{−2πik/n}, k < n/2.
    split: Vec<[f64; 2]>,
    /// Rotation of the kind: e^{−iπk/2n}, or e^{−iπ(k + 1/8)/n} (type IV), or sin πk/n (sine I).
    turn: Vec<[f64; 2]>,
    arch: Arch,
}

/// One call of a plan.
struct Call<'a> {
    plan: &'a Fast,
    inverse: bool,
    data: &'a mut [Lanes],
    work: &'a mut [Lanes],
}

impl Fast {
    /// Plans the transform, or `None` where n is odd or has a prime factor above 5.
    pub(super) fn new(kind: Kind, n: usize) -> Option<Self> {
        if !n.is_multiple_of(2) {
            return None;
        }
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
            fft: Fft::new(n / 2)?,
            split: (0..n / 2).map(|k| unit(2.0 * PI * k as f64 / cells)).collect(),
            turn: (0..n).map(turn).collect(),
            arch: Arch::new(),
        })
    }

    /// Working memory for one thread.
    pub(super) fn scratch(&self) -> Vec<Lanes> {
        vec![ZERO; 2 * self.n]
    }

    /// Transforms `data` in place.
    pub(super) fn run(&self, inverse: bool, data: &mut [Lanes], work: &mut [Lanes]) {
        self.arch.dispatch(Call { plan: self, inverse, data, work });
    }
}

impl WithSimd for Call<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let per = 8 / S::F64_LANES;
        let half = self.plan.n / 2 * per;
        let (x, _) = S::as_mut_simd_f64s(self.data.as_flattened_mut());
        let (work, _) = S::as_mut_simd_f64s(self.work.as_flattened_mut());
        let (a, b) = work[..4 * half].split_at_mut(2 * half);
        let (first, second) = (a.split_at_mut(half), b.split_at_mut(half));
        let lines =
            Lines { plan: self.plan, simd, per, first: [first.0, first.1], second: [second.0, second.1] };
        match (self.plan.kind, self.inverse) {
            (Kind::Periodic, false) => lines.fourier(x),
            (Kind::Periodic, true) => lines.fourier_back(x),
            (Kind::EvenEven | Kind::OddOdd, false) => lines.two(x),
            (Kind::EvenEven | Kind::OddOdd, true) => lines.three(x),
            (Kind::EvenOdd | Kind::OddEven, _) => lines.four(x),
            (Kind::Fixed, _) => lines.sine_one(x),
        }
    }
}

/// Eight lines in work; row `k` of any array is `per` vectors long.
struct Lines<'a, S: Simd> {
    plan: &'a Fast,
    simd: S,
    per: usize,
    first: [&'a mut [S::f64s]; 2],
    second: [&'a mut [S::f64s]; 2],
}

impl<S: Simd> Lines<'_, S> {
    #[inline(always)]
    fn real(&self, v: S::f64s) -> Real<S> {
        Real::new(self.simd, v)
    }

    /// Sets place `at` of the Fourier transform's input.
    #[inline(always)]
    fn put(&mut self, at: usize, z: Complex<S>) {
        let into = if self.plan.fft.starts_in_second() { &mut self.second } else { &mut self.first };
        into[0][at] = z.re.get();
        into[1][at] = z.im.get();
    }

    /// Place `at` of the Fourier transform's result.
    #[inline(always)]
    fn got(&self, at: usize) -> Complex<S> {
        Complex::new(self.real(self.first[0][at]), self.real(self.first[1][at]))
    }

    #[inline(always)]
    fn forward(&mut self) {
        let ([a, b], [c, d]) = (&mut self.first, &mut self.second);
        self.plan.fft.run(self.simd, [&mut **a, &mut **b], [&mut **c, &mut **d]);
    }

    #[inline(always)]
    fn backward(&mut self) {
        // Conjugate before and after = real and imaginary parts exchanged.
        let ([a, b], [c, d]) = (&mut self.first, &mut self.second);
        self.plan.fft.run(self.simd, [&mut **b, &mut **a], [&mut **d, &mut **c]);
    }

    /// Amplitudes k and n/2 − k (0 < k ≤ n/4) of the real transform whose packed transform is in
    /// place: even ± odd part, the second conjugated.
    #[inline(always)]
    fn amplitudes(&self, k: usize, t: usize) -> [Complex<S>; 2] {
        let m = self.plan.n / 2;
        let z = self.got(k * self.per + t);
        let mirror = self.got((m - k) * self.per + t).conj();
        let (even, odd) = ((z + mirror) * 0.5, (z - mirror).minus_i() * 0.5);
        let odd = odd.rotate(self.plan.split[k]);
        [even + odd, (even - odd).conj()]
    }

    /// Amplitudes 0 and n/2, both real.
    #[inline(always)]
    fn ends(&self, t: usize) -> [Real<S>; 2] {
        let z = self.got(t);
        [z.re + z.im, z.re - z.im]
    }

    /// Packed input k and n/2 − k for the way back from the amplitudes there (0 < k ≤ n/4).
    #[inline(always)]
    fn pack(&mut self, k: usize, t: usize, here: Complex<S>, mirror: Complex<S>) {
        let mirror = mirror.conj();
        let [c, s] = self.plan.split[k];
        let odd = (here - mirror).rotate([c, -s]);
        let (even, odd) = (here + mirror, odd.minus_i());
        // even + i odd, and the conjugate of even − i odd.
        self.put(k * self.per + t, even - odd);
        self.put((self.plan.n / 2 - k) * self.per + t, (even + odd).conj());
    }

    /// Value `j` of the line in the order of the packed transform: even values up, odd values down.
    #[inline(always)]
    fn makhoul(&self, j: usize) -> (usize, bool) {
        let n = self.plan.n;
        if j < n.div_ceil(2) { (2 * j, false) } else { (2 * (n - 1 - j) + 1, true) }
    }

    /// Whether the transform is the sine of its pair.
    #[inline(always)]
    fn odd(&self) -> bool {
        matches!(self.plan.kind, Kind::OddOdd | Kind::OddEven)
    }

    /// Where amplitude `k` of the cosine II stands: sines are reversed.
    #[inline(always)]
    fn place(&self, k: usize) -> usize {
        if self.odd() { self.plan.n - 1 - k } else { k }
    }

    /// Places `a` and `b` of the line as one complex number.
    #[inline(always)]
    fn pair(&self, x: &[S::f64s], a: usize, b: usize, t: usize) -> Complex<S> {
        let (a, b) = (x[a * self.per + t], x[b * self.per + t]);
        Complex::new(self.real(a), self.real(b))
    }

    /// Value `j` of the packed order, sign of the sine included.
    #[inline(always)]
    fn value(&self, x: &[S::f64s], j: usize, t: usize) -> Real<S> {
        let (from, flip) = self.makhoul(j);
        let v = self.real(x[from * self.per + t]);
        if flip && self.odd() { -v } else { v }
    }

    /// Fourier amplitude `k` that belongs to the cosine amplitudes `k` and `n − k`, halved.
    #[inline(always)]
    fn cosine_pair(&self, x: &[S::f64s], k: usize, t: usize) -> Complex<S> {
        let z = self.pair(x, self.place(k), self.place(self.plan.n - k), t).conj();
        let [c, s] = self.plan.turn[k];
        z.rotate([0.5 * c, -0.5 * s])
    }

    /// Value `j` of the real line whose Fourier transform holds the sine I.
    #[inline(always)]
    fn folded(&self, x: &[S::f64s], j: usize, t: usize) -> Real<S> {
        if j == 0 {
            return self.real(x[t]) * 0.0;
        }
        let (a, b) = (x[(j - 1) * self.per + t], x[(self.plan.n - j - 1) * self.per + t]);
        let (a, b) = (self.real(a), self.real(b));
        (a + b) * self.plan.turn[j][0] + (a - b) * 0.5
    }

    #[inline(always)]
    fn fourier(mut self, x: &mut [S::f64s]) {
        let (n, per) = (self.plan.n, self.per);
        for j in 0..n / 2 {
            for t in 0..per {
                let (a, b) = (self.real(x[2 * j * per + t]), self.real(x[(2 * j + 1) * per + t]));
                self.put(j * per + t, Complex::new(a, b));
            }
        }
        self.forward();
        for t in 0..per {
            let [low, high] = self.ends(t);
            x[t] = low.get();
            x[n / 2 * per + t] = high.get();
        }
        for k in 1..n / 4 + 1 {
            for t in 0..per {
                let [low, high] = self.amplitudes(k, t);
                for (k, z) in [(n / 2 - k, high), (k, low)] {
                    x[k * per + t] = z.re.get();
                    x[(n - k) * per + t] = z.im.get();
                }
            }
        }
    }

    #[inline(always)]
    fn fourier_back(mut self, x: &mut [S::f64s]) {
        let (n, per) = (self.plan.n, self.per);
        for t in 0..per {
            let (low, high) = (self.real(x[t]), self.real(x[n / 2 * per + t]));
            self.put(t, Complex::new(low + high, low - high));
        }
        for k in 1..n / 4 + 1 {
            for t in 0..per {
                let here = self.pair(x, k, n - k, t);
                let mirror = self.pair(x, n / 2 - k, n / 2 + k, t);
                self.pack(k, t, here, mirror);
            }
        }
        self.backward();
        for j in 0..n / 2 {
            for t in 0..per {
                let z = self.got(j * per + t);
                x[2 * j * per + t] = z.re.get();
                x[(2 * j + 1) * per + t] = z.im.get();
            }
        }
    }

    /// Cosine II, or sine II by alternating signs and reversed places.
    #[inline(always)]
    fn two(mut self, x: &mut [S::f64s]) {
        let (n, per) = (self.plan.n, self.per);
        for j in 0..n / 2 {
            for t in 0..per {
                let z = Complex::new(self.value(x, 2 * j, t), self.value(x, 2 * j + 1, t));
                self.put(j * per + t, z);
            }
        }
        self.forward();
        let quarter = self.plan.turn[n / 2][0];
        for t in 0..per {
            let [low, high] = self.ends(t);
            x[self.place(0) * per + t] = low.get();
            x[self.place(n / 2) * per + t] = (high * quarter).get();
        }
        for k in 1..n / 4 + 1 {
            for t in 0..per {
                let [low, high] = self.amplitudes(k, t);
                for (k, z) in [(n / 2 - k, high), (k, low)] {
                    let z = z.rotate(self.plan.turn[k]);
                    x[self.place(k) * per + t] = z.re.get();
                    x[self.place(n - k) * per + t] = (-z.im).get();
                }
            }
        }
    }

    /// Cosine III, the way back of [`Self::two`] (times n/2), and sine III.
    #[inline(always)]
    fn three(mut self, x: &mut [S::f64s]) {
        let (n, per) = (self.plan.n, self.per);
        let quarter = 0.5 / self.plan.turn[n / 2][0];
        for t in 0..per {
            let low = self.real(x[self.place(0) * per + t]) * 0.5;
            let high = self.real(x[self.place(n / 2) * per + t]) * quarter;
            self.put(t, Complex::new(low + high, low - high));
        }
        for k in 1..n / 4 + 1 {
            for t in 0..per {
                let here = self.cosine_pair(x, k, t);
                let mirror = self.cosine_pair(x, n / 2 - k, t);
                self.pack(k, t, here, mirror);
            }
        }
        self.backward();
        for j in 0..n / 2 {
            for t in 0..per {
                let z = self.got(j * per + t);
                for (j, v) in [(2 * j, z.re), (2 * j + 1, z.im)] {
                    let (to, flip) = self.makhoul(j);
                    let flip = flip && self.odd();
                    x[to * per + t] = if flip { (-v).get() } else { v.get() };
                }
            }
        }
    }

    /// Cosine IV, or sine IV by reversed values and alternating signs.
    #[inline(always)]
    fn four(mut self, x: &mut [S::f64s]) {
        let (n, per, odd) = (self.plan.n, self.per, self.plan.kind == Kind::OddEven);
        for j in 0..n / 2 {
            for t in 0..per {
                let (a, b) = (2 * j, n - 1 - 2 * j);
                let (a, b) = if odd { (b, a) } else { (a, b) };
                let z = self.pair(x, a, b, t).rotate(self.plan.turn[j]);
                self.put(j * per + t, z);
            }
        }
        self.forward();
        for k in 0..n / 2 {
            for t in 0..per {
                let z = self.got(k * per + t).rotate(self.plan.turn[k]);
                x[2 * k * per + t] = z.re.get();
                // n is even, so n − 1 − 2k is odd: the sign of sine IV turns once more.
                let high = if odd { z.im } else { -z.im };
                x[(n - 1 - 2 * k) * per + t] = high.get();
            }
        }
    }

    /// Sine I of n − 1 values.
    #[inline(always)]
    fn sine_one(mut self, x: &mut [S::f64s]) {
        let (n, per) = (self.plan.n, self.per);
        for j in 0..n / 2 {
            for t in 0..per {
                let z = Complex::new(self.folded(x, 2 * j, t), self.folded(x, 2 * j + 1, t));
                self.put(j * per + t, z);
            }
        }
        self.forward();
        for k in 1..n / 4 + 1 {
            for t in 0..per {
                let [low, high] = self.amplitudes(k, t);
                for (k, z) in [(n / 2 - k, high), (k, low)] {
                    x[(2 * k - 1) * per + t] = (-z.im).get();
                    x[2 * k * per + t] = z.re.get();
                }
            }
        }
        // The odd amplitudes are the running sum of the real parts.
        for t in 0..per {
            let mut sum = self.ends(t)[0] * 0.5;
            x[t] = sum.get();
            for k in 1..n / 2 {
                sum = sum + self.real(x[2 * k * per + t]);
                x[2 * k * per + t] = sum.get();
            }
        }
    }
}
