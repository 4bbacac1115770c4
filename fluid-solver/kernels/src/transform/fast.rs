//! Fast real-to-real transforms of eight lines: an even length n through a complex transform of n/2, an odd
//! periodic one through one of n.

use super::cosine::{Three, Two};
use super::ends::by_radix;
use super::fft::Pair;
use super::four::Four;
use super::fourier::{Fourier, FourierBack, Odd, OddBack};
use super::kind::Kind;
use super::line::{Reader, Writer};
use super::plan::Plan;
use super::rows::{Rows, RowsMut, Write};
use super::sine::One;
use crate::lanes::{Lanes, ZERO, aligned};
use bedload_vectors::arch;
use pulp::{Arch, Simd, WithSimd};

/// A fast transform of one length.
pub(super) struct Fast {
    plan: Plan,
    arch: Arch,
}

impl Fast {
    /// Plans the transform, or `None` where [`Plan::places`] has none.
    pub(super) fn new(kind: Kind, n: usize) -> Option<Self> {
        Some(Self { plan: Plan::new(kind, n)?, arch: arch() })
    }

    /// Working memory for one thread: two buffers of complex places, one of n/2 real ones.
    pub(super) fn scratch(&self) -> Vec<Lanes> {
        vec![ZERO; 4 * self.plan.fft.len() + self.plan.n / 2 + 1]
    }

    /// Reads and transforms, all passes but the last.
    pub(super) fn load(&self, inverse: bool, rows: Rows<'_>, work: &mut [Lanes]) {
        self.arch.dispatch(Load { plan: &self.plan, inverse, rows, work });
    }

    /// The last pass; writes the result.
    pub(super) fn store(&self, inverse: bool, rows: RowsMut<'_>, work: &mut [Lanes]) {
        match rows.write {
            Write::Set => self.arch.dispatch(Store::<false> { plan: &self.plan, inverse, rows, work }),
            Write::Add => self.arch.dispatch(Store::<true> { plan: &self.plan, inverse, rows, work }),
        }
    }
}

/// The two buffers of `count` places, and that for sums.
#[inline(always)]
fn buffers<S: Simd>(count: usize, work: &mut [Lanes]) -> ([&mut [Pair<S>]; 2], &mut [S::f64s]) {
    let (places, sums) = aligned(work).split_at_mut(4 * count);
    let (places, _) = S::as_mut_simd_f64s(places.as_flattened_mut()).0.as_chunks_mut::<2>();
    let (a, b) = places.split_at_mut(count * (8 / S::F64_LANES));
    ([a, b], S::as_mut_simd_f64s(sums.as_flattened_mut()).0)
}

/// [`Fast::load`].
struct Load<'a> {
    plan: &'a Plan,
    inverse: bool,
    rows: Rows<'a>,
    work: &'a mut [Lanes],
}

impl WithSimd for Load<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { plan, inverse, rows, work } = self;
        let ([a, b], _) = buffers::<S>(plan.fft.len(), work);
        let first = &plan.fft.first;
        let (rows, stride) = rows.vectors::<S>();
        let from = Reader { plan, simd, rows, stride };
        match (plan.kind, inverse) {
            (Kind::Periodic, false) if plan.n % 2 == 1 => by_radix!(first, first, simd, &Odd(from), a),
            (Kind::Periodic, true) if plan.n % 2 == 1 => by_radix!(first, first, simd, &OddBack(from), a),
            (Kind::Periodic, false) => by_radix!(first, first, simd, &Fourier(from), a),
            (Kind::Periodic, true) => by_radix!(first, first_pairs, simd, &FourierBack(from), a),
            (Kind::EvenEven | Kind::OddOdd, false) => by_radix!(first, first, simd, &Two(from), a),
            (Kind::EvenEven | Kind::OddOdd, true) => by_radix!(first, first_pairs, simd, &Three(from), a),
            (Kind::EvenOdd | Kind::OddEven, _) => by_radix!(first, first, simd, &Four(from), a),
            (Kind::Fixed, _) => by_radix!(first, first, simd, &One(from), a),
        }
        plan.fft.middle(simd, a, b);
    }
}

/// [`Fast::store`].
struct Store<'a, const ADD: bool> {
    plan: &'a Plan,
    inverse: bool,
    rows: RowsMut<'a>,
    work: &'a mut [Lanes],
}

impl<const ADD: bool> WithSimd for Store<'_, ADD> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { plan, inverse, rows, work } = self;
        let (places, sums) = buffers::<S>(plan.fft.len(), work);
        let from = &*places[plan.fft.result()];
        let last = &plan.fft.last;
        let (rows, stride) = rows.vectors::<S>();
        let to = Writer::<S, ADD> { plan, rows, stride, sums };
        match (plan.kind, inverse) {
            (Kind::Periodic, false) if plan.n % 2 == 1 => by_radix!(last, last, simd, from, &mut Odd(to)),
            (Kind::Periodic, true) if plan.n % 2 == 1 => by_radix!(last, last, simd, from, &mut OddBack(to)),
            (Kind::Periodic, false) => by_radix!(last, last_pairs, simd, from, &mut Fourier(to)),
            (Kind::Periodic, true) => by_radix!(last, last, simd, from, &mut FourierBack(to)),
            (Kind::EvenEven | Kind::OddOdd, false) => by_radix!(last, last_pairs, simd, from, &mut Two(to)),
            (Kind::EvenEven | Kind::OddOdd, true) => by_radix!(last, last, simd, from, &mut Three(to)),
            (Kind::EvenOdd | Kind::OddEven, _) => by_radix!(last, last, simd, from, &mut Four(to)),
            (Kind::Fixed, _) => {
                let mut to = One(to);
                by_radix!(last, last_pairs, simd, from, &mut to);
                to.sum(simd);
            }
        }
    }
}
