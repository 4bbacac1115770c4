//! Rows of four numbers, such as a vector and a scalar of a grain, turned into lanes.

use crate::vector::lanes::{Lanes, Lanes8};

/// Four numbers.
pub(crate) type Row = [f64; 4];

pub(crate) const EACH: [u32; 8] = [0, 1, 2, 3, 4, 5, 6, 7];

/// Rows `i` in columns 0 to 3 and rows `j` in columns 4 to 7.
#[inline(always)]
pub(crate) fn columns<L: Lanes8>(token: L::Token, rows: &[Row], i: &[u32; 8], j: &[u32; 8]) -> [L; 8] {
    let mut columns = [L::splat(token, 0.0); 8];
    for (column, (i, j)) in columns.iter_mut().zip(i.iter().zip(j)) {
        *column = L::load_halves(token, &rows[*i as usize], &rows[*j as usize]);
    }
    L::transpose(columns)
}

/// Two rows `i` in each: of lanes 0 and 2, 1 and 3, 4 and 6, 5 and 7, which turn into columns soonest.
#[inline(always)]
pub(crate) fn pairs<L: Lanes8>(token: L::Token, rows: &[Row], i: &[u32; 8]) -> [L; 4] {
    let of = |lane: usize| &rows[i[lane] as usize];
    let mut pairs = [L::splat(token, 0.0); 4];
    for (pair, lane) in pairs.iter_mut().zip([0, 1, 4, 5]) {
        *pair = L::load_halves(token, of(lane), of(lane + 2));
    }
    pairs
}

/// Writes what [`pairs`] reads. Rows that several lanes have must not have changed.
#[inline(always)]
pub(crate) fn write_pairs<L: Lanes8>(pairs: [L; 4], rows: &mut [Row], i: &[u32; 8]) {
    for (pair, lane) in pairs.into_iter().zip([0, 1, 4, 5]) {
        pair.store_low(&mut rows[i[lane] as usize]);
        pair.store_high(&mut rows[i[lane + 2] as usize]);
    }
}

/// a × b + c of rows.
#[inline(always)]
pub(crate) fn rows_plus<L: Lanes>(a: [L; 4], b: [L; 4], mut c: [L; 4]) -> [L; 4] {
    for (c, (a, b)) in c.iter_mut().zip(a.into_iter().zip(b)) {
        *c = a.times_plus(b, *c);
    }
    c
}

/// c − a × b of rows.
#[inline(always)]
pub(crate) fn rows_from<L: Lanes>(a: [L; 4], b: [L; 4], mut c: [L; 4]) -> [L; 4] {
    for (c, (a, b)) in c.iter_mut().zip(a.into_iter().zip(b)) {
        *c = a.times_from(b, *c);
    }
    c
}

/// a × b of rows.
#[inline(always)]
pub(crate) fn rows_times<L: Lanes>(mut a: [L; 4], b: [L; 4]) -> [L; 4] {
    for (a, b) in a.iter_mut().zip(b) {
        *a = *a * b;
    }
    a
}

/// a − b of rows.
#[inline(always)]
pub(crate) fn rows_minus<L: Lanes>(mut a: [L; 4], b: [L; 4]) -> [L; 4] {
    for (a, b) in a.iter_mut().zip(b) {
        *a = *a - b;
    }
    a
}

/// Reads several sets of lanes.
#[inline(always)]
pub(crate) fn load_all<L: Lanes8, const N: usize>(token: L::Token, values: &[[f64; 8]; N]) -> [L; N] {
    let mut all = [L::splat(token, 0.0); N];
    for (lanes, values) in all.iter_mut().zip(values) {
        *lanes = L::load(token, values);
    }
    all
}

/// Writes them.
#[inline(always)]
pub(crate) fn store_all<L: Lanes8, const N: usize>(all: [L; N], values: &mut [[f64; 8]; N]) {
    for (lanes, values) in all.into_iter().zip(values) {
        lanes.store(values);
    }
}
