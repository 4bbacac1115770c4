//! Eight numbers side by side, in one register where the machine has one.
//!
//! Every operation rounds as the scalar one does, and none is fused: both kinds give the same bits.

use std::ops::{Add, Div, Mul, Sub};

/// Eight lanes. Masks are bits, lane 0 the lowest.
pub(super) trait Lanes:
    Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + Div<Output = Self>
{
    /// Proof that the machine has what the lanes need.
    type Token: Copy;
    /// One value in all lanes.
    fn splat(token: Self::Token, value: f64) -> Self;
    /// Eight values.
    fn load(token: Self::Token, values: &[f64; 8]) -> Self;
    /// Two times four values.
    fn load_halves(token: Self::Token, low: &[f64; 4], high: &[f64; 4]) -> Self;
    /// Writes the lanes.
    fn store(self, values: &mut [f64; 8]);
    /// √ of each lane.
    fn sqrt(self) -> Self;
    /// The larger of both; of equal ones, or with a NaN, `other`.
    fn max(self, other: Self) -> Self;
    /// Lanes where self < other.
    fn lt(self, other: Self) -> u8;
    /// `self` where the mask is set, else `other`.
    fn select(self, mask: u8, other: Self) -> Self;
    /// self − other, but self + other in lanes 3 and 7: the distance of two rows with the sums of
    /// their radii and inverse masses.
    fn apart(self, other: Self) -> Self;
    /// Rows to columns.
    fn transpose(rows: [Self; 8]) -> [Self; 8];
}

/// Lanes for any machine.
#[derive(Clone, Copy)]
pub(super) struct Plain([f64; 8]);

macro_rules! plain {
    ($name:ident, $fn:ident, $op:tt) => {
        impl $name for Plain {
            type Output = Self;
            #[inline(always)]
            fn $fn(mut self, other: Self) -> Self {
                for (a, b) in self.0.iter_mut().zip(other.0) {
                    *a $op b;
                }
                self
            }
        }
    };
}
plain!(Add, add, +=);
plain!(Sub, sub, -=);
plain!(Mul, mul, *=);
plain!(Div, div, /=);

impl Lanes for Plain {
    type Token = ();

    #[inline(always)]
    fn splat((): (), value: f64) -> Self {
        Self([value; 8])
    }

    #[inline(always)]
    fn load((): (), values: &[f64; 8]) -> Self {
        Self(*values)
    }

    #[inline(always)]
    fn load_halves((): (), low: &[f64; 4], high: &[f64; 4]) -> Self {
        let mut lanes = [0.0; 8];
        lanes[..4].copy_from_slice(low);
        lanes[4..].copy_from_slice(high);
        Self(lanes)
    }

    #[inline(always)]
    fn store(self, values: &mut [f64; 8]) {
        *values = self.0;
    }

    #[inline(always)]
    fn sqrt(mut self) -> Self {
        for lane in &mut self.0 {
            *lane = lane.sqrt();
        }
        self
    }

    #[inline(always)]
    fn max(mut self, other: Self) -> Self {
        for k in 0..8 {
            self.0[k] = if self.0[k] > other.0[k] { self.0[k] } else { other.0[k] };
        }
        self
    }

    #[inline(always)]
    fn lt(self, other: Self) -> u8 {
        let mut mask = 0;
        for k in 0..8 {
            mask |= u8::from(self.0[k] < other.0[k]) << k;
        }
        mask
    }

    #[inline(always)]
    fn select(mut self, mask: u8, other: Self) -> Self {
        for k in 0..8 {
            self.0[k] = if mask >> k & 1 == 1 { self.0[k] } else { other.0[k] };
        }
        self
    }

    #[inline(always)]
    fn apart(self, other: Self) -> Self {
        let mut out = self - other;
        out.0[3] = self.0[3] + other.0[3];
        out.0[7] = self.0[7] + other.0[7];
        out
    }

    #[inline(always)]
    fn transpose(rows: [Self; 8]) -> [Self; 8] {
        let mut out = [Self([0.0; 8]); 8];
        for (j, row) in rows.iter().enumerate() {
            for (column, value) in out.iter_mut().zip(row.0) {
                column.0[j] = value;
            }
        }
        out
    }
}

#[cfg(target_arch = "x86_64")]
pub(super) use wide::Wide;

#[cfg(target_arch = "x86_64")]
mod wide {
    use super::Lanes;
    use pulp::{b8, cast, f64x8, x86::V4};
    use std::ops::{Add, Div, Mul, Sub};

    /// Lanes in a register of 512 bits.
    #[derive(Clone, Copy)]
    pub(in super::super) struct Wide {
        simd: V4,
        lanes: f64x8,
    }

    macro_rules! wide {
        ($name:ident, $fn:ident, $op:ident) => {
            impl $name for Wide {
                type Output = Self;
                #[inline(always)]
                fn $fn(self, other: Self) -> Self {
                    Self {
                        simd: self.simd,
                        lanes: cast(self.simd.avx512f.$op(cast(self.lanes), cast(other.lanes))),
                    }
                }
            }
        };
    }
    wide!(Add, add, _mm512_add_pd);
    wide!(Sub, sub, _mm512_sub_pd);
    wide!(Mul, mul, _mm512_mul_pd);
    wide!(Div, div, _mm512_div_pd);

    impl Wide {
        /// Even (`low`) or odd numbers of each pair of both.
        #[inline(always)]
        fn unpack(self, other: Self, low: bool) -> Self {
            let (a, b, f) = (cast(self.lanes), cast(other.lanes), self.simd.avx512f);
            let lanes = if low { f._mm512_unpacklo_pd(a, b) } else { f._mm512_unpackhi_pd(a, b) };
            Self { simd: self.simd, lanes: cast(lanes) }
        }

        /// Quarters `0, 2` (`even`) or `1, 3` of both.
        #[inline(always)]
        fn quarters(self, other: Self, even: bool) -> Self {
            let (a, b, f) = (cast(self.lanes), cast(other.lanes), self.simd.avx512f);
            let lanes = if even {
                f._mm512_shuffle_f64x2::<0x88>(a, b)
            } else {
                f._mm512_shuffle_f64x2::<0xdd>(a, b)
            };
            Self { simd: self.simd, lanes: cast(lanes) }
        }
    }

    impl Lanes for Wide {
        type Token = V4;

        #[inline(always)]
        fn splat(simd: V4, value: f64) -> Self {
            Self { simd, lanes: simd.splat_f64x8(value) }
        }

        #[inline(always)]
        fn load(simd: V4, values: &[f64; 8]) -> Self {
            Self { simd, lanes: cast(*values) }
        }

        #[inline(always)]
        fn load_halves(simd: V4, low: &[f64; 4], high: &[f64; 4]) -> Self {
            Self { simd, lanes: cast([*low, *high]) }
        }

        #[inline(always)]
        fn store(self, values: &mut [f64; 8]) {
            *values = cast(self.lanes);
        }

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

        #[inline(always)]
        fn apart(self, other: Self) -> Self {
            let f = self.simd.avx512f;
            let apart = f._mm512_sub_pd(cast(self.lanes), cast(other.lanes));
            let lanes = f._mm512_mask_add_pd(apart, 0x88, cast(self.lanes), cast(other.lanes));
            Self { lanes: cast(lanes), ..self }
        }

        #[inline(always)]
        fn transpose(r: [Self; 8]) -> [Self; 8] {
            let (l0, h0) = (r[0].unpack(r[1], true), r[0].unpack(r[1], false));
            let (l1, h1) = (r[2].unpack(r[3], true), r[2].unpack(r[3], false));
            let (l2, h2) = (r[4].unpack(r[5], true), r[4].unpack(r[5], false));
            let (l3, h3) = (r[6].unpack(r[7], true), r[6].unpack(r[7], false));
            let (a0, a2) = (l0.quarters(l1, true), l0.quarters(l1, false));
            let (b0, b2) = (l2.quarters(l3, true), l2.quarters(l3, false));
            let (a1, a3) = (h0.quarters(h1, true), h0.quarters(h1, false));
            let (b1, b3) = (h2.quarters(h3, true), h2.quarters(h3, false));
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
    }
}
