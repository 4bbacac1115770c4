//! The planes beside a rank's own ones, fetched from the ranks that own them.
//!
//! Fields have the indices of the whole grid, so a plane that is fetched goes where it stands there: on a
//! periodic axis the plane below the first is the last one.

use crate::division::Division;
use crate::grid::Grid;
use std::ops::Range;

/// What a rank needs to fetch planes.
#[derive(Clone, Debug)]
pub(crate) struct Ghosts {
    division: Division,
    planes: usize,
    periodic: bool,
    /// Where plane 0 begins in a field, and its length.
    first: usize,
    stride: usize,
}

/// On which sides of the own planes a field is wanted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Side {
    Below,
    Above,
    Both,
}

/// A field, and where it is wanted.
pub(crate) type Wanted<'a> = (&'a mut [f64], Side);

impl Ghosts {
    /// Of the planes of a grid.
    pub(crate) fn new<const D: usize>(grid: &Grid<D>) -> Self {
        Self {
            division: grid.division.clone(),
            planes: grid.cells[D - 1],
            periodic: grid.periodic(D - 1),
            first: grid.planes(0, 0).start,
            stride: grid.stride(D - 1),
        }
    }

    /// The same with `each` numbers for a plane, from the beginning of an array on.
    pub(crate) fn packed<const D: usize>(grid: &Grid<D>, each: usize) -> Self {
        Self { first: 0, stride: each, ..Self::new(grid) }
    }

    /// Where `width` planes from plane `k` on stand, counted round the axis.
    fn place(&self, k: usize, width: usize) -> Range<usize> {
        let first = self.first + k % self.planes * self.stride;
        first..first + width * self.stride
    }

    /// Sets the planes beside the own ones to zero.
    pub(crate) fn forget(&self, field: &mut [f64]) {
        if !self.division.ranks().is_alone() {
            let own = self.division.own();
            field[self.place(own.start + self.planes - 1, 1)].fill(0.0);
            field[self.place(own.end, 1)].fill(0.0);
        }
    }

    /// Fetches `width` planes of every field on the sides where it is wanted; no slab has fewer planes.
    pub(crate) fn fetch(&self, width: usize, fields: &mut [Wanted<'_>]) {
        if let Some(sent) = self.pack(width, fields) {
            let received = self.exchange(sent, &mut || {});
            self.unpack(width, &received, fields);
        }
    }

    /// The planes that the neighbours want, to go up and down; nothing without ranks.
    pub(crate) fn pack(&self, width: usize, fields: &[Wanted<'_>]) -> Option<[Vec<f64>; 2]> {
        let own = self.division.own();
        if self.division.ranks().is_alone() {
            return None;
        }
        // What goes up is wanted below the rank above.
        let pack = |place: Range<usize>, not: Side| -> Vec<f64> {
            let wanted = fields.iter().filter(|(_, side)| *side != not);
            wanted.flat_map(|(field, _)| &field[place.clone()]).copied().collect()
        };
        let [below, above] = [self.place(own.end - width, width), self.place(own.start, width)];
        Some([pack(below, Side::Above), pack(above, Side::Below)])
    }

    /// Sends what was packed; what comes from below and from above. `meanwhile` is done while it is on its
    /// way.
    pub(crate) fn exchange(&self, [up, down]: [Vec<f64>; 2], meanwhile: &mut dyn FnMut()) -> [Vec<f64>; 2] {
        let mut into = [vec![0.0; up.len()], vec![0.0; down.len()]];
        let [below, above] = self.division.neighbours(self.periodic);
        let mut messages = Vec::new();
        messages.extend(below.filter(|_| !down.is_empty()).map(|rank| (rank, &down[..])));
        messages.extend(above.filter(|_| !up.is_empty()).map(|rank| (rank, &up[..])));
        let [from_below, from_above] = &mut into;
        let mut room = Vec::new();
        room.extend(above.filter(|_| !down.is_empty()).map(|rank| (rank, &mut from_above[..])));
        room.extend(below.filter(|_| !up.is_empty()).map(|rank| (rank, &mut from_below[..])));
        self.division.ranks().exchange_while(&messages, &mut room, meanwhile);
        into
    }

    /// Puts what came where it stands in the fields.
    pub(crate) fn unpack(&self, width: usize, received: &[Vec<f64>; 2], fields: &mut [Wanted<'_>]) {
        let own = self.division.own();
        let places = [self.place(own.start + self.planes - width, width), self.place(own.end, width)];
        let beside = self.division.neighbours(self.periodic).into_iter().zip(places);
        for ((rank, place), (from, not)) in beside.zip(received.iter().zip([Side::Above, Side::Below])) {
            let wanted = fields.iter_mut().filter(|(_, side)| rank.is_some() && *side != not);
            for ((field, _), from) in wanted.zip(from.chunks(width * self.stride)) {
                field[place.clone()].copy_from_slice(from);
            }
        }
    }
}
