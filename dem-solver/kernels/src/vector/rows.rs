//! Rows of four numbers, such as a vector and a scalar of a grain, turned into lanes.

use crate::vector::lanes::Lanes8;

/// Four numbers.
pub(crate) type Row = [f64; 4];

/// Rows `i` in columns 0 to 3 and rows `j` in columns 4 to 7.
#[inline(always)]
pub(crate) fn columns<L: Lanes8>(token: L::Token, rows: &[Row], i: &[u32; 8], j: &[u32; 8]) -> [L; 8] {
    both(token, (rows, i), (rows, j))
}

/// Rows `i` of `a` in columns 0 to 3 and rows `j` of `b` in columns 4 to 7.
#[inline(always)]
pub(crate) fn both<L: Lanes8>(
    token: L::Token,
    (a, i): (&[Row], &[u32; 8]),
    (b, j): (&[Row], &[u32; 8]),
) -> [L; 8] {
    let mut rows = [L::splat(token, 0.0); 8];
    for (row, (i, j)) in rows.iter_mut().zip(i.iter().zip(j)) {
        *row = L::load_halves(token, &a[*i as usize], &b[*j as usize]);
    }
    L::transpose(rows)
}

/// Writes what [`columns`] reads. Rows that several lanes have must not have changed.
#[inline(always)]
pub(crate) fn write<L: Lanes8>(columns: [L; 8], rows: &mut [Row], i: &[u32; 8], j: &[u32; 8]) {
    for (row, (i, j)) in L::transpose(columns).into_iter().zip(i.iter().zip(j)) {
        row.store_low(&mut rows[*i as usize]);
        row.store_high(&mut rows[*j as usize]);
    }
}
