//! The sweeps over the planes, slab by slab.

use super::halo::{beyond, fill_plane};
use super::momentum::{FirstFluxes, Given, MomentumPlane, Target};
use super::project::{AddPlane, CorrectPlane, DivergencePlane};
use super::shape::Shape;
use super::slab::{Fields, Private, Slab, planes};
use crate::factors::Factors;
use crate::ghosts::{Side, Wanted};
use crate::helmholtz::space::Space;
use crate::lanes::dispatch;
use crate::stages::PressureUpdate;
use crate::threads::share;
use crate::transform::Direction;

/// What all sweeps of a stage share.
#[derive(Clone, Copy)]
pub(super) struct Sweep<'a> {
    pub(super) shape: &'a Shape,
    pub(super) pressure: &'a Space,
    pub(super) viscous: &'a [Space],
    pub(super) has_gradient: bool,
}

/// How the divergence goes to the right-hand side of φ and to the pressure.
#[derive(Clone, Copy)]
pub(super) struct Diverge {
    inverse: f64,
    viscosity: f64,
}

impl Diverge {
    pub(super) fn of(update: PressureUpdate) -> Self {
        Self { inverse: 1.0 / update.duration, viscosity: update.viscosity }
    }
}

/// What is due on a plane before its momentum.
#[derive(Clone, Copy)]
pub(super) enum Before {
    /// The velocity is the caller's: halos and wall faces.
    Fill,
    /// The projection of the stage before, φ times this weight; halos too.
    Correct(f64),
}

impl Sweep<'_> {
    /// φ on the last plane of each slab, copied to the slab above.
    fn exchange_phi(&self, fields: &mut Fields<'_>, privates: &mut [Private]) {
        let shape = self.shape;
        fields.each(shape, privates, |slab| self.back(slab, slab.planes.end - 1));
        shape.ghosts.fetch(1, &mut [(&mut *fields.work[0], Side::Below)]);
        let phi = &*fields.work[0];
        each_private(shape, privates, |range, private| {
            // Above a wall nothing is needed: φ has no slope there.
            if range.start > 0 || shape.periodic(2) {
                let from = if range.start > 0 { range.start } else { shape.n[2] } as isize;
                copy(&mut private.phi, &phi[shape.planes(from - 1, from)]);
            }
        });
    }

    /// Prepares the first and the last plane of each slab, so that its neighbours can copy them.
    pub(super) fn prepare_ends(&self, fields: &mut Fields<'_>, privates: &mut [Private], before: Before) {
        if let Before::Correct(_) = before {
            self.exchange_phi(fields, privates);
        }
        fields.each(self.shape, privates, |slab| {
            let (first, last) = (slab.planes.start, slab.planes.end - 1);
            match before {
                Before::Fill => {
                    self.fill(slab, first);
                    self.fill(slab, last);
                }
                Before::Correct(weight) => {
                    if first < last {
                        self.back(slab, first);
                    }
                    self.correct(slab, first, weight);
                    if first + 1 < last {
                        self.back(slab, last - 1);
                    }
                    if first < last {
                        self.correct(slab, last, weight);
                    }
                }
            }
        });
    }

    /// Prepares plane `k`, which lies between the first and the last one of the slab.
    fn prepare(&self, slab: &mut Slab<'_>, k: usize, before: Before) {
        match before {
            Before::Fill => self.fill(slab, k),
            Before::Correct(weight) => {
                if k + 2 < slab.planes.end {
                    self.back(slab, k);
                }
                self.correct(slab, k, weight);
            }
        }
    }

    /// Halos and wall faces of the velocity on plane `k`.
    fn fill(&self, slab: &mut Slab<'_>, k: usize) {
        if self.shape.open {
            return;
        }
        let at = self.place(slab, k);
        for (d, u) in slab.fields.velocity.iter_mut().enumerate() {
            let plane = &mut u[at.clone()];
            if d == 2 && k == 0 && !self.shape.periodic(2) {
                plane.fill(0.0);
            }
            fill_plane(self.shape, d, plane);
        }
    }

    /// Copies the planes beside each slab. While those of other ranks are on their way the second plane of
    /// each slab is prepared, which the momentum of the first one asks for.
    pub(super) fn exchange_planes(&self, fields: &mut Fields<'_>, privates: &mut [Private], before: Before) {
        let (shape, has_gradient) = (self.shape, self.has_gradient);
        let packed = shape.ghosts.pack(1, &wanted(fields, has_gradient));
        let mut second = || {
            fields.each(shape, privates, |slab| {
                if slab.planes.start + 2 < slab.planes.end {
                    self.prepare(slab, slab.planes.start + 1, before);
                }
            });
        };
        match packed {
            None => second(),
            Some(packed) => {
                let received = shape.ghosts.exchange(packed, &mut second);
                shape.ghosts.unpack(1, &received, &mut wanted(fields, has_gradient));
            }
        }
        each_private(shape, privates, |range, private| {
            let n = shape.n[2];
            let plane = |k: usize| shape.planes(k as isize, k as isize + 1);
            let inside = !shape.periodic(2);
            let (first, last) = (range.start == 0 && inside, range.end == n && inside);
            let (under, over) = ((range.start + n - 1) % n, range.end % n);
            for d in 0..3 {
                let u = &*fields.velocity[d];
                let (below, above) = (&mut private.below[d], &mut private.above[d]);
                if first && shape.open {
                    copy(below, &u[shape.planes(-1, 0)]);
                } else if first {
                    beyond(shape, d, 0, &u[plane(range.start)], below);
                } else {
                    copy(below, &u[plane(under)]);
                }
                if last && shape.open {
                    copy(above, &u[shape.planes(n as isize, n as isize + 1)]);
                } else if last {
                    beyond(shape, d, 1, &u[plane(range.end - 1)], above);
                } else {
                    copy(above, &u[plane(over)]);
                }
            }
            if has_gradient {
                let from = if first { range.start } else { under };
                copy(&mut private.pressure, &fields.pressure[plane(from)]);
            }
        });
    }

    /// Momentum, with what is due before it ([`Sweep::prepare_ends`] did it at the ends,
    /// [`Sweep::exchange_planes`] on the second plane), and the divergence.
    pub(super) fn momentum<const D: usize>(
        &self,
        fields: &mut Fields<'_>,
        privates: &mut [Private],
        factors: &Factors,
        given: Given<'_, D>,
        before: Before,
        diverge: Option<Diverge>,
    ) {
        fields.each(self.shape, privates, |slab| {
            let range = slab.planes.clone();
            self.first_fluxes(slab, factors);
            for k in range.clone() {
                if k > range.start && k + 2 < range.end {
                    self.prepare(slab, k + 1, before);
                }
                self.plane(slab, k, factors, given);
                self.viscous.iter().enumerate().for_each(|(d, solver)| {
                    let at = self.place(slab, k);
                    let plane = &mut slab.fields.work[d][at];
                    solver.transform_plane(Direction::Forward, plane, &mut slab.privates[0].viscous[d]);
                });
                if let (Some(diverge), true) = (diverge, k > range.start) {
                    self.divergence(slab, k - 1, diverge);
                }
            }
        });
        self.close(fields, privates, diverge);
    }

    /// Adds the solved increments of implicit viscosity.
    pub(super) fn viscous(
        &self,
        fields: &mut Fields<'_>,
        privates: &mut [Private],
        diverge: Option<Diverge>,
    ) {
        let shape = self.shape;
        fields.each(shape, privates, |slab| {
            for k in slab.planes.clone() {
                let at = self.place(slab, k);
                for (d, solver) in self.viscous.iter().enumerate() {
                    let plane = &mut slab.fields.work[d][at.clone()];
                    solver.transform_plane(Direction::Inverse, plane, &mut slab.privates[0].viscous[d]);
                    let velocity = &mut slab.fields.velocity[d][at.clone()];
                    dispatch(AddPlane { shape, d, k, increment: plane, velocity });
                }
                if let (Some(diverge), true) = (diverge, k > slab.planes.start) {
                    self.divergence(slab, k - 1, diverge);
                }
            }
        });
        self.close(fields, privates, diverge);
    }

    /// The divergence of everything.
    pub(super) fn diverge(&self, fields: &mut Fields<'_>, privates: &mut [Private], diverge: Diverge) {
        fields.each(self.shape, privates, |slab| {
            for k in slab.planes.start..slab.planes.end - 1 {
                self.divergence(slab, k, diverge);
            }
        });
        self.close(fields, privates, Some(diverge));
    }

    /// Divergence of the last plane of each slab, once w above it is new.
    fn close(&self, fields: &mut Fields<'_>, privates: &mut [Private], diverge: Option<Diverge>) {
        let Some(diverge) = diverge else { return };
        let shape = self.shape;
        shape.ghosts.fetch(1, &mut [(&mut *fields.velocity[2], Side::Above)]);
        let w = &*fields.velocity[2];
        each_private(shape, privates, |range, private| {
            let above = &mut private.above[2];
            if range.end == shape.n[2] && !shape.periodic(2) {
                if shape.open {
                    copy(above, &w[shape.planes(range.end as isize, range.end as isize + 1)]);
                } else {
                    above.fill(0.0);
                }
            } else {
                let k = (range.end % shape.n[2]) as isize;
                copy(above, &w[shape.planes(k, k + 1)]);
            }
        });
        fields.each(shape, privates, |slab| self.divergence(slab, slab.planes.end - 1, diverge));
    }

    /// The end of a projection.
    pub(super) fn finish(&self, fields: &mut Fields<'_>, privates: &mut [Private], weight: f64) {
        self.exchange_phi(fields, privates);
        fields.each(self.shape, privates, |slab| {
            for k in slab.planes.clone() {
                if k + 1 < slab.planes.end {
                    self.back(slab, k);
                }
                self.correct(slab, k, weight);
            }
        });
    }

    /// Where plane `k` lies in the fields of a slab.
    fn place(&self, slab: &Slab<'_>, k: usize) -> std::ops::Range<usize> {
        let at = (k - slab.planes.start) * self.shape.plane;
        at..at + self.shape.plane
    }

    /// φ of plane `k` from its amplitudes, halos included.
    fn back(&self, slab: &mut Slab<'_>, k: usize) {
        let at = self.place(slab, k);
        let phi = &mut slab.fields.work[0][at];
        self.pressure.transform_plane(Direction::Inverse, phi, &mut slab.privates[0].transforms);
        fill_plane(self.shape, 3, phi);
    }

    /// Velocity and pressure of plane `k` from φ there and below.
    fn correct(&self, slab: &mut Slab<'_>, k: usize, weight: f64) {
        let (at, shape) = (self.place(slab, k), self.shape);
        let Slab { fields: Fields { velocity, work: [phi, ..], pressure, .. }, privates, planes } = slab;
        let here = &phi[at.clone()];
        let low = if k > planes.start {
            &phi[at.start - shape.plane..at.start]
        } else if k == 0 && !shape.periodic(2) {
            here
        } else {
            &privates[0].phi[..]
        };
        dispatch(CorrectPlane {
            shape,
            k,
            weight,
            phi: [here, low],
            velocity: velocity.each_mut().map(|u| &mut u[at.clone()]),
            pressure: self.has_gradient.then(|| &mut pressure[at.clone()]),
        });
    }

    /// Fluxes into the first plane of a slab.
    fn first_fluxes(&self, slab: &mut Slab<'_>, factors: &Factors) {
        let at = self.place(slab, slab.planes.start);
        let Private { below, fluxes, lines, .. } = &mut slab.privates[0];
        dispatch(FirstFluxes {
            shape: self.shape,
            factors,
            k: slab.planes.start,
            below: below.each_ref().map(|u| &u[..]),
            first: slab.fields.velocity.each_ref().map(|u| &u[at.clone()]),
            fluxes,
            lines,
        });
    }

    /// Momentum of plane `k`.
    fn plane<const D: usize>(&self, slab: &mut Slab<'_>, k: usize, factors: &Factors, given: Given<'_, D>) {
        let (at, shape) = (self.place(slab, k), self.shape);
        let Slab { fields: Fields { velocity, history, work, pressure }, privates, planes } = slab;
        let Private { below: under, above: over, pressure: low, fluxes, lines, .. } = &mut privates[0];
        let (mut below, mut above) = (under.each_ref().map(|u| &u[..]), over.each_ref().map(|u| &u[..]));
        let mut here: [&mut [f64]; 3] = Default::default();
        for (d, u) in velocity.iter_mut().enumerate() {
            let (before, rest) = u.split_at_mut(at.start);
            let (plane, after) = rest.split_at_mut(shape.plane);
            here[d] = plane;
            if k > planes.start {
                below[d] = &before[at.start - shape.plane..];
            }
            if k + 1 < planes.end {
                above[d] = &after[..shape.plane];
            }
        }
        let low = if k > planes.start { at.start.checked_sub(shape.plane) } else { None }
            .map_or(&low[..], |low| if self.has_gradient { &pressure[low..at.start] } else { &[] });
        dispatch(MomentumPlane {
            shape,
            factors,
            k,
            here,
            above,
            below,
            target: if self.viscous.is_empty() {
                Target::Velocity
            } else {
                Target::Increment(work.each_mut().map(|x| &mut x[at.clone()]))
            },
            history: history.each_mut().map(|x| &mut x[at.clone()]),
            force: given.force.map(|f| f.map(|f| &f[shape.planes(k as isize, k as isize + 1)])),
            near: given.near,
            pressure: self.has_gradient.then(|| [&pressure[at.clone()], low]),
            fluxes,
            lines,
        });
    }

    /// Right-hand side of φ on plane `k`, transformed.
    fn divergence(&self, slab: &mut Slab<'_>, k: usize, diverge: Diverge) {
        let (at, shape) = (self.place(slab, k), self.shape);
        let Slab { fields: Fields { velocity: [u, v, w], work: [phi, ..], pressure, .. }, privates, planes } =
            slab;
        let Private { above, transforms, .. } = &mut privates[0];
        let (low, high) = w.split_at_mut(at.end);
        let out = &mut phi[at.clone()];
        let changes_pressure = self.has_gradient && diverge.viscosity != 0.0;
        dispatch(DivergencePlane {
            shape,
            k,
            inverse: diverge.inverse,
            velocity: [&mut u[at.clone()], &mut v[at.clone()], &mut low[at.start..]],
            above: if k + 1 < planes.end { &high[..shape.plane] } else { &above[2] },
            out: &mut *out,
            pressure: changes_pressure.then(|| (&mut pressure[at.clone()], diverge.viscosity)),
        });
        self.pressure.transform_plane(Direction::Forward, out, transforms);
    }
}

/// What momentum needs of the ranks beside this one.
fn wanted<'a>(fields: &'a mut Fields<'_>, has_gradient: bool) -> Vec<Wanted<'a>> {
    let velocity = fields.velocity.iter_mut().map(|u| (&mut **u, Side::Both));
    let pressure = has_gradient.then_some((&mut *fields.pressure, Side::Below));
    velocity.chain(pressure).collect()
}

/// Copies a plane into private memory, which may be a little longer.
fn copy(to: &mut [f64], plane: &[f64]) {
    to[..plane.len()].copy_from_slice(plane);
}

/// Calls `task` for each thread's private memory, with the planes of its slab.
fn each_private(
    shape: &Shape,
    privates: &mut [Private],
    task: impl Fn(std::ops::Range<usize>, &mut Private) + Sync,
) {
    let slabs = privates.len();
    share(privates, 0..slabs, 1, &|slab, privates| {
        task(planes(shape, slab.start, slabs), &mut privates[0]);
    });
}
