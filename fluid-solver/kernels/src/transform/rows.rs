//! Where a transform reads and writes: rows of eight neighbouring values, some distance apart.

use crate::lanes::Lanes;
use pulp::Simd;

/// What to do with a result.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Write {
    /// Store it.
    Set,
    /// Add it.
    Add,
}

/// Rows to read: row `j` is entry `j · stride` of `data`.
#[derive(Clone, Copy)]
pub struct Rows<'a> {
    data: &'a [Lanes],
    stride: usize,
}

impl<'a> Rows<'a> {
    /// Rows without gaps.
    pub fn of(data: &'a [Lanes]) -> Self {
        Self { data, stride: 1 }
    }

    /// Eight neighbours of every row of a field that begins with the first of them; `stride` is
    /// that of the field, a multiple of eight.
    pub fn of_field(field: &'a [f64], stride: usize) -> Self {
        debug_assert!(stride.is_multiple_of(8), "rows of a field are padded to whole lanes");
        Self { data: field.as_chunks().0, stride: stride / 8 }
    }

    /// Row `j`.
    #[inline(always)]
    pub(super) fn row(&self, j: usize) -> &Lanes {
        &self.data[j * self.stride]
    }

    /// The data as vectors, and the number of vectors from row to row.
    #[inline(always)]
    pub(super) fn vectors<S: Simd>(self) -> (&'a [S::f64s], usize) {
        (S::as_simd_f64s(self.data.as_flattened()).0, self.stride * (8 / S::F64_LANES))
    }
}

/// Rows to write, see [`Rows`].
pub struct RowsMut<'a> {
    data: &'a mut [Lanes],
    stride: usize,
    pub(super) write: Write,
}

impl<'a> RowsMut<'a> {
    /// Rows without gaps, to be set.
    pub fn of(data: &'a mut [Lanes]) -> Self {
        Self { data, stride: 1, write: Write::Set }
    }

    /// Rows of a field, see [`Rows::of_field`].
    pub fn of_field(field: &'a mut [f64], stride: usize, write: Write) -> Self {
        debug_assert!(stride.is_multiple_of(8), "rows of a field are padded to whole lanes");
        Self { data: field.as_chunks_mut().0, stride: stride / 8, write }
    }

    /// Sets or adds to row `j`.
    pub(super) fn put_row(&mut self, j: usize, values: &Lanes) {
        for (to, value) in self.data[j * self.stride].iter_mut().zip(values) {
            *to = if self.write == Write::Add { *to + value } else { *value };
        }
    }

    /// The data as vectors, and the number of vectors from row to row.
    #[inline(always)]
    pub(super) fn vectors<S: Simd>(self) -> (&'a mut [S::f64s], usize) {
        (S::as_mut_simd_f64s(self.data.as_flattened_mut()).0, self.stride * (8 / S::F64_LANES))
    }
}
