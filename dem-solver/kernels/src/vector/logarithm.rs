//! Natural logarithms of several numbers.

use crate::vector::lanes::Lanes8;

/// ln x of normal positive numbers, good to 3e-16 beside 1: e ln 2 + 2 artanh((m − 1)/(m + 1)) with x = 2ᵉ m
/// and ¾ ≤ m < 3/2.
#[inline(always)]
pub(crate) fn ln<L: Lanes8>(token: L::Token, x: L) -> L {
    let k = |value: f64| L::splat(token, value);
    let one = k(1.0);
    let (exponent, mantissa) = x.split();
    let low: u8 = mantissa.lt(k(1.5));
    let exponent = exponent.select(low, exponent + one);
    let mantissa = mantissa.select(low, mantissa * k(0.5));
    let s = (mantissa - one) / (mantissa + one);
    let z = s * s;
    let mut series = k(2.0 / 21.0);
    for odd in [19.0, 17.0, 15.0, 13.0, 11.0, 9.0, 7.0, 5.0, 3.0, 1.0] {
        series = series.times_plus(z, k(2.0 / odd));
    }
    exponent.times_plus(k(std::f64::consts::LN_2), s * series)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::vector::lanes::Portable8;

    #[test]
    fn logarithms_are_those_of_the_library() {
        for start in 0..2000 {
            let x: [f64; 8] = std::array::from_fn(|k| 1.003f64.powi(8 * start + k as i32));
            let mut found = [0.0; 8];
            ln((), Portable8::load((), &x)).store(&mut found);
            for (x, found) in x.iter().zip(found) {
                assert!((found - x.ln()).abs() < 3e-16 * x.ln().max(1.0), "ln {x}: {found}");
            }
        }
    }
}
