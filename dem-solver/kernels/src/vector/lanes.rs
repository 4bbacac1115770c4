//! Several numbers side by side, in registers where the machine has wide ones.
//!
//! Every operation rounds as the scalar one does, a fused one as the scalar fused one: all kinds give the
//! same bits.

use std::ops::{Add, BitAnd, BitOr, Div, Mul, Not, Sub};

/// One bit per lane.
pub(crate) trait Mask:
    Copy + BitAnd<Output = Self> + BitOr<Output = Self> + Not<Output = Self>
{
    /// Whether any lane is set.
    fn any(self) -> bool;
}

impl Mask for u8 {
    #[inline(always)]
    fn any(self) -> bool {
        self != 0
    }
}

/// Lanes that can be reckoned with.
pub(crate) trait Lanes:
    Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + Div<Output = Self>
{
    /// Proof that the machine has what the lanes need.
    type Token: Copy;
    /// One bit per lane.
    type Mask: Mask;
    /// One value in all lanes.
    fn splat(token: Self::Token, value: f64) -> Self;
    /// `self` × `factor` + `term`, rounded once.
    fn times_plus(self, factor: Self, term: Self) -> Self;
    /// `term` − `self` × `factor`, rounded once.
    fn times_from(self, factor: Self, term: Self) -> Self;
    /// `self` × `factor` − `term`, rounded once.
    fn times_minus(self, factor: Self, term: Self) -> Self;
    /// √ of each lane.
    fn sqrt(self) -> Self;
    /// The larger of both; of equal ones, or with a NaN, `other`.
    fn max(self, other: Self) -> Self;
    /// Lanes where self < other.
    fn lt(self, other: Self) -> Self::Mask;
    /// `self` where the mask is set, else `other`.
    fn select(self, mask: Self::Mask, other: Self) -> Self;
}

/// Eight lanes, which can be read, written and turned from rows into columns.
pub(crate) trait Lanes8: Lanes<Mask = u8> {
    /// Whether they are one register: what costs more in several may be worth a kernel of its own there.
    const ONE_REGISTER: bool;
    /// Eight values.
    fn load(token: Self::Token, values: &[f64; 8]) -> Self;
    /// Two times four values.
    fn load_halves(token: Self::Token, low: &[f64; 4], high: &[f64; 4]) -> Self;
    /// Four values, twice.
    fn load_twice(token: Self::Token, values: &[f64; 4]) -> Self;
    /// Writes the lanes.
    fn store(self, values: &mut [f64; 8]);
    /// Writes lanes 0 to 3.
    fn store_low(self, values: &mut [f64; 4]);
    /// Writes lanes 4 to 7.
    fn store_high(self, values: &mut [f64; 4]);
    /// Lanes 0 to 3 of both.
    fn low_halves(self, other: Self) -> Self;
    /// In lanes 0 and 4 the sums (a + b) + (c + d) of their halves; anything in the others.
    fn sum_halves(self) -> Self;
    /// The larger of both as bits: of positive numbers the larger, and what is not a number before all.
    fn max_bits(self, other: Self) -> Self;
    /// Rows to columns.
    fn transpose(rows: [Self; 8]) -> [Self; 8];
    /// Columns of eight rows of four, as [`crate::vector::rows::pairs`] has them.
    fn columns_of(rows: [Self; 4]) -> [Self; 4];
    /// Such rows of columns.
    fn rows_of(columns: [Self; 4]) -> [Self; 4];
    /// The sum (a + b) + (c + d) of each such row.
    fn row_sums(rows: [Self; 4]) -> Self;
    /// Such rows, each of one number.
    fn spread(self) -> [Self; 4];
    /// Exponents and mantissas from 1 to below 2, of normal positive numbers.
    fn split(self) -> (Self, Self);
}

/// Lanes for any machine.
#[derive(Clone, Copy)]
pub(crate) struct Portable8([f64; 8]);

/// `[value at k = 0, …, value at k = 7]`, written out: loops in what is inlined a thousand times make the
/// kernels compile longer.
macro_rules! eight {
    (|$k:ident| $value:expr) => {
        eight!(|$k| $value; 0 1 2 3 4 5 6 7)
    };
    (|$k:ident| $value:expr; $($number:literal)*) => {
        [$({ let $k = $number; $value }),*]
    };
}

macro_rules! plain {
    ($name:ident, $fn:ident, $op:tt) => {
        impl $name for Portable8 {
            type Output = Self;
            #[inline(always)]
            fn $fn(self, other: Self) -> Self {
                Self(eight!(|k| self.0[k] $op other.0[k]))
            }
        }
    };
}
plain!(Add, add, +);
plain!(Sub, sub, -);
plain!(Mul, mul, *);
plain!(Div, div, /);

macro_rules! fused {
    ($fn:ident, |$a:ident, $factor:ident, $term:ident| $value:expr) => {
        #[inline(always)]
        fn $fn(self, factor: Self, term: Self) -> Self {
            Self(eight!(|k| {
                let ($a, $factor, $term) = (self.0[k], factor.0[k], term.0[k]);
                $value
            }))
        }
    };
}

impl Lanes for Portable8 {
    type Token = ();
    type Mask = u8;

    #[inline(always)]
    fn splat((): (), value: f64) -> Self {
        Self([value; 8])
    }

    fused!(times_plus, |a, factor, term| a.mul_add(factor, term));
    fused!(times_from, |a, factor, term| (-a).mul_add(factor, term));
    fused!(times_minus, |a, factor, term| a.mul_add(factor, -term));

    #[inline(always)]
    fn sqrt(self) -> Self {
        Self(eight!(|k| self.0[k].sqrt()))
    }

    #[inline(always)]
    fn max(self, other: Self) -> Self {
        Self(eight!(|k| if self.0[k] > other.0[k] { self.0[k] } else { other.0[k] }))
    }

    #[inline(always)]
    fn lt(self, other: Self) -> u8 {
        let [a, b, c, d, e, f, g, h] = eight!(|k| u8::from(self.0[k] < other.0[k]) << k);
        a | b | c | d | e | f | g | h
    }

    #[inline(always)]
    fn select(self, mask: u8, other: Self) -> Self {
        Self(eight!(|k| if mask >> k & 1 == 1 { self.0[k] } else { other.0[k] }))
    }
}

impl Lanes8 for Portable8 {
    const ONE_REGISTER: bool = false;

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
    fn load_twice((): (), values: &[f64; 4]) -> Self {
        Self::load_halves((), values, values)
    }

    #[inline(always)]
    fn store(self, values: &mut [f64; 8]) {
        *values = self.0;
    }

    #[inline(always)]
    fn store_low(self, values: &mut [f64; 4]) {
        values.copy_from_slice(&self.0[..4]);
    }

    #[inline(always)]
    fn store_high(self, values: &mut [f64; 4]) {
        values.copy_from_slice(&self.0[4..]);
    }

    #[inline(always)]
    fn low_halves(mut self, other: Self) -> Self {
        self.0[4..].copy_from_slice(&other.0[..4]);
        self
    }

    #[inline(always)]
    fn sum_halves(mut self) -> Self {
        for k in [0, 4] {
            self.0[k] = (self.0[k] + self.0[k + 1]) + (self.0[k + 2] + self.0[k + 3]);
        }
        self
    }

    #[inline(always)]
    fn max_bits(self, other: Self) -> Self {
        Self(eight!(|k| f64::from_bits(self.0[k].to_bits().max(other.0[k].to_bits()))))
    }

    #[inline(always)]
    fn transpose(rows: [Self; 8]) -> [Self; 8] {
        eight!(|column| Self(eight!(|row| rows[row].0[column])))
    }

    #[inline(always)]
    fn columns_of(rows: [Self; 4]) -> [Self; 4] {
        [0, 1, 2, 3].map(|c| Self(eight!(|k| rows[PAIR[k].0].0[PAIR[k].1 + c])))
    }

    #[inline(always)]
    fn rows_of(columns: [Self; 4]) -> [Self; 4] {
        let mut out = [Self([0.0; 8]); 4];
        for (c, column) in columns.iter().enumerate() {
            for (k, value) in column.0.iter().enumerate() {
                out[PAIR[k].0].0[PAIR[k].1 + c] = *value;
            }
        }
        out
    }

    #[inline(always)]
    fn row_sums(rows: [Self; 4]) -> Self {
        let [x, y, z, w] = Self::columns_of(rows);
        (x + y) + (z + w)
    }

    #[inline(always)]
    fn spread(self) -> [Self; 4] {
        Self::rows_of([self; 4])
    }

    #[inline(always)]
    fn split(self) -> (Self, Self) {
        let bits = eight!(|k| self.0[k].to_bits());
        let mantissa = eight!(|k| f64::from_bits(bits[k] & ((1 << 52) - 1) | 1023 << 52));
        (Self(eight!(|k| (bits[k] >> 52) as i32 as f64 - 1023.0)), Self(mantissa))
    }
}

/// Where [`crate::vector::rows::pairs`] has the row of each lane: which pair, and its first number.
pub(crate) const PAIR: [(usize, usize); 8] = [(0, 0), (1, 0), (0, 4), (1, 4), (2, 0), (3, 0), (2, 4), (3, 4)];
