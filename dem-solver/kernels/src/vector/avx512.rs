//! Eight lanes in a register of 512 bits.

use crate::vector::lanes::{Lanes, Lanes8};
use pulp::{b8, cast, f64x8, x86::V4};
use std::ops::{Add, Div, Mul, Sub};

/// Lanes in a register of 512 bits.
#[derive(Clone, Copy)]
pub(crate) struct Avx512 {
    simd: V4,
    lanes: f64x8,
}

macro_rules! skin {
    ($name:ident, $fn:ident, $op:ident) => {
        impl $name for Avx512 {
            type Output = Self;
            #[inline(always)]
            fn $fn(self, other: Self) -> Self {
                let f = self.simd.avx512f;
                Self { lanes: cast(f.$op(cast(self.lanes), cast(other.lanes))), ..self }
            }
        }
    };
}
skin!(Add, add, _mm512_add_pd);
skin!(Sub, sub, _mm512_sub_pd);
skin!(Mul, mul, _mm512_mul_pd);
skin!(Div, div, _mm512_div_pd);

macro_rules! fused {
    ($fn:ident, $op:ident) => {
        #[inline(always)]
        fn $fn(self, factor: Self, term: Self) -> Self {
            let f = self.simd.avx512f;
            Self { lanes: cast(f.$op(cast(self.lanes), cast(factor.lanes), cast(term.lanes))), ..self }
        }
    };
}

impl Avx512 {
    /// Even (`low`) or odd numbers of each pair of both.
    #[inline(always)]
    fn unpack(self, other: Self, low: bool) -> Self {
        let (a, b, f) = (cast(self.lanes), cast(other.lanes), self.simd.avx512f);
        let lanes = if low { f._mm512_unpacklo_pd(a, b) } else { f._mm512_unpackhi_pd(a, b) };
        Self { simd: self.simd, lanes: cast(lanes) }
    }

    /// Numbers by their places in both, one after the other.
    #[inline(always)]
    fn pick(self, places: [u64; 8], other: Self) -> Self {
        let f = self.simd.avx512f;
        let lanes = f._mm512_permutex2var_pd(cast(self.lanes), cast(places), cast(other.lanes));
        Self { lanes: cast(lanes), ..self }
    }

    /// Quarters `0, 2` (`even`) or `1, 3` of both.
    #[inline(always)]
    fn quarters(self, other: Self, even: bool) -> Self {
        let (a, b, f) = (cast(self.lanes), cast(other.lanes), self.simd.avx512f);
        let lanes =
            if even { f._mm512_shuffle_f64x2::<0x88>(a, b) } else { f._mm512_shuffle_f64x2::<0xdd>(a, b) };
        Self { simd: self.simd, lanes: cast(lanes) }
    }
}

impl Lanes for Avx512 {
    type Token = V4;
    type Mask = u8;

    #[inline(always)]
    fn splat(simd: V4, value: f64) -> Self {
        Self { simd, lanes: simd.splat_f64x8(value) }
    }

    fused!(times_plus, _mm512_fmadd_pd);
    fused!(times_from, _mm512_fnmadd_pd);
    fused!(times_minus, _mm512_fmsub_pd);

    #[inline(always)]
    fn sqrt(self) -> Self {
        Self { lanes: self.simd.sqrt_f64x8(self.lanes), ..self }
    }

    #[inline(always)]
    fn max(self, other: Self) -> Self {
        let lanes = self.simd.avx512f._mm512_max_pd(cast(self.lanes), cast(other.lanes));
        Self { lanes: cast(lanes), ..self }
    }

    #[inline(always)]
    fn lt(self, other: Self) -> u8 {
        self.simd.cmp_lt_f64x8(self.lanes, other.lanes).0
    }

    #[inline(always)]
    fn select(self, mask: u8, other: Self) -> Self {
        Self { lanes: self.simd.select_f64x8(b8(mask), self.lanes, other.lanes), ..self }
    }
}

impl Lanes8 for Avx512 {
    const ONE_REGISTER: bool = true;

    #[inline(always)]
    fn load(simd: V4, values: &[f64; 8]) -> Self {
        Self { simd, lanes: cast(*values) }
    }

    #[inline(always)]
    fn load_halves(simd: V4, low: &[f64; 4], high: &[f64; 4]) -> Self {
        Self { simd, lanes: cast([*low, *high]) }
    }

    #[inline(always)]
    fn load_twice(simd: V4, values: &[f64; 4]) -> Self {
        Self { simd, lanes: cast(simd.avx512f._mm512_broadcast_f64x4(cast(*values))) }
    }

    #[inline(always)]
    fn store(self, values: &mut [f64; 8]) {
        *values = cast(self.lanes);
    }

    #[inline(always)]
    fn store_low(self, values: &mut [f64; 4]) {
        *values = cast(self.simd.avx512f._mm512_extractf64x4_pd::<0>(cast(self.lanes)));
    }

    #[inline(always)]
    fn store_high(self, values: &mut [f64; 4]) {
        *values = cast(self.simd.avx512f._mm512_extractf64x4_pd::<1>(cast(self.lanes)));
    }

    #[inline(always)]
    fn low_halves(self, other: Self) -> Self {
        let f = self.simd.avx512f;
        let lanes = f._mm512_shuffle_f64x2::<0x44>(cast(self.lanes), cast(other.lanes));
        Self { lanes: cast(lanes), ..self }
    }

    #[inline(always)]
    fn sum_halves(self) -> Self {
        let f = self.simd.avx512f;
        let (x, next) = (cast(self.lanes), f._mm512_permute_pd::<0x55>(cast(self.lanes)));
        let twos = f._mm512_add_pd(x, next);
        let lanes = f._mm512_add_pd(twos, f._mm512_shuffle_f64x2::<0xb1>(twos, twos));
        Self { lanes: cast(lanes), ..self }
    }

    #[inline(always)]
    fn max_bits(self, other: Self) -> Self {
        let lanes = self.simd.avx512f._mm512_max_epu64(cast(self.lanes), cast(other.lanes));
        Self { lanes: cast(lanes), ..self }
    }

    #[inline(always)]
    fn transpose(r: [Self; 8]) -> [Self; 8] {
        let [a0, a1, a2, a3] = Self::columns_of([r[0], r[1], r[2], r[3]]);
        let [b0, b1, b2, b3] = Self::columns_of([r[4], r[5], r[6], r[7]]);
        [
            a0.quarters(b0, true),
            a1.quarters(b1, true),
            a2.quarters(b2, true),
            a3.quarters(b3, true),
            a0.quarters(b0, false),
            a1.quarters(b1, false),
            a2.quarters(b2, false),
            a3.quarters(b3, false),
        ]
    }

    #[inline(always)]
    fn columns_of([a, b, c, d]: [Self; 4]) -> [Self; 4] {
        let (l0, h0) = (a.unpack(b, true), a.unpack(b, false));
        let (l1, h1) = (c.unpack(d, true), c.unpack(d, false));
        [l0.quarters(l1, true), h0.quarters(h1, true), l0.quarters(l1, false), h0.quarters(h1, false)]
    }

    #[inline(always)]
    fn rows_of([x, y, z, w]: [Self; 4]) -> [Self; 4] {
        let (a, b) = (x.unpack(y, true), z.unpack(w, true));
        let (c, d) = (x.unpack(y, false), z.unpack(w, false));
        let (low, high) = ([0, 1, 8, 9, 2, 3, 10, 11], [4, 5, 12, 13, 6, 7, 14, 15]);
        [a.pick(low, b), c.pick(low, d), a.pick(high, b), c.pick(high, d)]
    }

    #[inline(always)]
    fn row_sums([a, b, c, d]: [Self; 4]) -> Self {
        let first = a.unpack(b, true) + a.unpack(b, false);
        let second = c.unpack(d, true) + c.unpack(d, false);
        first.quarters(second, true) + first.quarters(second, false)
    }

    #[inline(always)]
    fn spread(self) -> [Self; 4] {
        let [a, b] = [[0, 0, 0, 0, 2, 2, 2, 2], [1, 1, 1, 1, 3, 3, 3, 3]];
        let [c, d] = [[4, 4, 4, 4, 6, 6, 6, 6], [5, 5, 5, 5, 7, 7, 7, 7]];
        [self.pick(a, self), self.pick(b, self), self.pick(c, self), self.pick(d, self)]
    }

    #[inline(always)]
    fn split(self) -> (Self, Self) {
        let (f, x) = (self.simd.avx512f, cast(self.lanes));
        let mantissa = f._mm512_getmant_pd::<0, 0>(x);
        (Self { lanes: cast(f._mm512_getexp_pd(x)), ..self }, Self { lanes: cast(mantissa), ..self })
    }
}
