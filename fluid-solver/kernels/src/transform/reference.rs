//! Transforms by `rustdct` and `realfft`, line by line: any length, and the measure of the fast ones.

use super::kind::Kind;
use super::rows::{Rows, RowsMut};
use crate::lanes::{Lanes, ZERO};
use realfft::num_complex::Complex;
use realfft::{ComplexToReal, RealFftPlanner, RealToComplex};
use rustdct::{DctPlanner, Dst1, TransformType2And3, TransformType4};
use std::sync::Arc;

/// One planned transform.
enum Plan {
    Fourier(Arc<dyn RealToComplex<f64>>, Arc<dyn ComplexToReal<f64>>),
    Two(Arc<dyn TransformType2And3<f64>>),
    Four(Arc<dyn TransformType4<f64>>),
    SineOne(Arc<dyn Dst1<f64>>),
}

/// Working memory: eight lines, one of them, its spectrum, and what the libraries ask for.
#[derive(Debug, Default)]
pub(super) struct Scratch {
    data: Vec<Lanes>,
    line: Vec<f64>,
    spectrum: Vec<Complex<f64>>,
    real: Vec<f64>,
    complex: Vec<Complex<f64>>,
}

/// A transform of any length, one line after the other.
pub(super) struct Reference {
    kind: Kind,
    values: usize,
    plan: Plan,
}

impl Reference {
    pub(super) fn new(kind: Kind, cells: usize) -> Self {
        let values = kind.values(cells);
        let mut dct = DctPlanner::new();
        let plan = match kind {
            Kind::Periodic => {
                let mut fft = RealFftPlanner::new();
                Plan::Fourier(fft.plan_fft_forward(values), fft.plan_fft_inverse(values))
            }
            Kind::EvenEven | Kind::OddOdd => Plan::Two(dct.plan_dct2(values)),
            Kind::EvenOdd | Kind::OddEven => Plan::Four(dct.plan_dct4(values)),
            Kind::Fixed => Plan::SineOne(dct.plan_dst1(values)),
        };
        Self { kind, values, plan }
    }

    /// Working memory for one thread.
    pub(super) fn scratch(&self) -> Scratch {
        let mut scratch =
            Scratch { data: vec![ZERO; self.values], line: vec![0.0; self.values], ..Scratch::default() };
        match &self.plan {
            Plan::Fourier(forward, inverse) => {
                scratch.spectrum = forward.make_output_vec();
                let len = forward.get_scratch_len().max(inverse.get_scratch_len());
                scratch.complex = vec![Complex::default(); len];
            }
            Plan::Two(plan) => scratch.real = vec![0.0; plan.get_scratch_len()],
            Plan::Four(plan) => scratch.real = vec![0.0; plan.get_scratch_len()],
            Plan::SineOne(plan) => scratch.real = vec![0.0; plan.get_scratch_len()],
        }
        scratch
    }

    /// Reads and transforms, line by line.
    pub(super) fn load(&self, inverse: bool, rows: Rows<'_>, s: &mut Scratch) {
        for (j, row) in s.data.iter_mut().enumerate() {
            row.copy_from_slice(rows.row(j));
        }
        for lane in 0..8 {
            for (x, row) in s.line.iter_mut().zip(&s.data) {
                *x = row[lane];
            }
            self.transform(inverse, s);
            for (x, row) in s.line.iter().zip(&mut s.data) {
                row[lane] = *x;
            }
        }
    }

    pub(super) fn store(&self, mut rows: RowsMut<'_>, scratch: &mut Scratch) {
        for (j, row) in scratch.data.iter().enumerate() {
            rows.put_row(j, row);
        }
    }

    /// Values of a line to amplitudes, or back.
    fn transform(&self, inverse: bool, s: &mut Scratch) {
        let (line, room) = (&mut s.line[..], &mut s.real[..]);
        match (&self.plan, self.kind) {
            (Plan::Fourier(_, plan), _) if inverse => from_halfcomplex(plan.as_ref(), s),
            (Plan::Fourier(plan, _), _) => to_halfcomplex(plan.as_ref(), s),
            (Plan::Two(plan), Kind::EvenEven) if inverse => plan.process_dct3_with_scratch(line, room),
            (Plan::Two(plan), Kind::EvenEven) => plan.process_dct2_with_scratch(line, room),
            (Plan::Two(plan), _) if inverse => plan.process_dst3_with_scratch(line, room),
            (Plan::Two(plan), _) => plan.process_dst2_with_scratch(line, room),
            (Plan::Four(plan), Kind::EvenOdd) => plan.process_dct4_with_scratch(line, room),
            (Plan::Four(plan), _) => plan.process_dst4_with_scratch(line, room),
            (Plan::SineOne(plan), _) => {
                // rustdct 0.7.1 takes places 0 and n of its odd continuation from the scratch
                // memory without setting them: they have to be zero.
                room.fill(0.0);
                plan.process_dst1_with_scratch(line, room);
            }
        }
    }
}

/// Real line to cosine amplitudes (places k) and sine amplitudes (places n − k).
fn to_halfcomplex(plan: &dyn RealToComplex<f64>, s: &mut Scratch) {
    let n = s.line.len();
    plan.process_with_scratch(&mut s.line, &mut s.spectrum, &mut s.complex)
        .expect("the buffers come from the plan");
    for (k, z) in s.spectrum.iter().enumerate() {
        s.line[k] = z.re;
        if k > 0 && 2 * k < n {
            s.line[n - k] = z.im;
        }
    }
}

/// The way back from [`to_halfcomplex`], times n.
fn from_halfcomplex(plan: &dyn ComplexToReal<f64>, s: &mut Scratch) {
    let n = s.line.len();
    for (k, z) in s.spectrum.iter_mut().enumerate() {
        let im = if k > 0 && 2 * k < n { s.line[n - k] } else { 0.0 };
        *z = Complex::new(s.line[k], im);
    }
    plan.process_with_scratch(&mut s.spectrum, &mut s.line, &mut s.complex)
        .expect("the buffers come from the plan, and the end amplitudes are real");
}
