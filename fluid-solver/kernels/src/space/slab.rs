//! Slabs of planes: each thread owns one, with private copies of the planes beside it.

use super::momentum::{FluxesAcross, Lines};
use super::shape::Shape;
use crate::helmholtz::space::{Memory, Space};
use crate::lanes::Aligned;
use std::ops::Range;

/// The fields of a step. `work[0]` is φ; all three are the increments of implicit viscosity.
pub(super) struct Fields<'a> {
    pub(super) velocity: [&'a mut [f64]; 3],
    pub(super) history: [&'a mut [f64]; 3],
    pub(super) work: [&'a mut [f64]; 3],
    /// The pressure; empty where φ is the pressure.
    pub(super) pressure: &'a mut [f64],
}

/// The part of the fields that one thread owns. Fields that a step does without are empty.
pub(super) struct Slab<'a> {
    pub(super) planes: Range<usize>,
    pub(super) fields: Fields<'a>,
    pub(super) privates: &'a mut [Private],
}

/// What one thread needs for itself.
pub(super) struct Private {
    /// Old velocity on the planes below and above the slab.
    pub(super) below: [Aligned; 3],
    pub(super) above: [Aligned; 3],
    /// φ and pressure on the plane below.
    pub(super) phi: Aligned,
    pub(super) pressure: Aligned,
    pub(super) fluxes: FluxesAcross,
    pub(super) lines: Lines,
    /// For the transforms of the pressure and of each component with implicit viscosity.
    pub(super) transforms: Memory,
    pub(super) viscous: Vec<Memory>,
}

impl Private {
    pub(super) fn new(shape: &Shape, pressure: &Space, viscous: &[Space]) -> Self {
        let plane = || Aligned::zeros(shape.plane);
        Self {
            below: std::array::from_fn(|_| plane()),
            above: std::array::from_fn(|_| plane()),
            phi: plane(),
            pressure: plane(),
            fluxes: FluxesAcross::new(shape),
            lines: Lines::new(shape),
            transforms: pressure.new_memory(),
            viscous: viscous.iter().map(Space::new_memory).collect(),
        }
    }
}

impl Fields<'_> {
    /// Every field, to be cut.
    fn all(&mut self) -> [&mut [f64]; 10] {
        let [u, v, w] = &mut self.velocity;
        let [a, b, c] = &mut self.history;
        let [x, y, z] = &mut self.work;
        [u, v, w, a, b, c, x, y, z, &mut self.pressure]
    }

    fn of(fields: [&mut [f64]; 10]) -> Fields<'_> {
        let [u, v, w, a, b, c, x, y, z, pressure] = fields;
        Fields { velocity: [u, v, w], history: [a, b, c], work: [x, y, z], pressure }
    }

    /// The planes of this process as one slab.
    pub(super) fn slab<'a>(&'a mut self, shape: &Shape, privates: &'a mut [Private]) -> Slab<'a> {
        let own = shape.own.clone();
        let range = shape.planes(own.start as isize, own.end as isize);
        let cut = self.all().map(|f| if f.is_empty() { f } else { &mut f[range.clone()] });
        Slab { planes: own, fields: Fields::of(cut), privates }
    }

    /// Calls `task` for every slab, in parallel where there are several.
    pub(super) fn each(
        &mut self,
        shape: &Shape,
        privates: &mut [Private],
        task: impl Fn(&mut Slab<'_>) + Sync,
    ) {
        let slabs = 0..privates.len();
        self.slab(shape, privates).each(shape, slabs.end, slabs, &task);
    }
}

/// The planes of slab `slab` of `slabs`.
pub(super) fn planes(shape: &Shape, slab: usize, slabs: usize) -> Range<usize> {
    let cut = |s: usize| shape.own.start + shape.own.len() * s / slabs;
    cut(slab)..cut(slab + 1)
}

impl Slab<'_> {
    fn each(
        mut self,
        shape: &Shape,
        all: usize,
        slabs: Range<usize>,
        task: &(impl Fn(&mut Slab<'_>) + Sync),
    ) {
        if slabs.len() == 1 {
            return task(&mut self);
        }
        let middle = slabs.start + slabs.len() / 2;
        let cut = planes(shape, middle, all).start;
        let at = (cut - self.planes.start) * shape.plane;
        let mut high: [&mut [f64]; 10] = Default::default();
        let mut low = self.fields.all();
        for (low, high) in low.iter_mut().zip(&mut high) {
            let whole = std::mem::take(low);
            (*low, *high) = whole.split_at_mut(at.min(whole.len()));
        }
        let (below, above) = self.privates.split_at_mut(middle - slabs.start);
        let low = Slab { planes: self.planes.start..cut, fields: Fields::of(low), privates: below };
        let high = Slab { planes: cut..self.planes.end, fields: Fields::of(high), privates: above };
        rayon::join(
            || low.each(shape, all, slabs.start..middle, task),
            || high.each(shape, all, middle..slabs.end, task),
        );
    }
}
