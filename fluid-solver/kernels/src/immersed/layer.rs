//! What the grains hold of one layer of nodes: rows of cells, and the mask ratios of each.
//!
//! Rows are taken in whole vectors of eight places: those that a grain does not hold have no mask ratios, and
//! nothing that is done with them changes anything.

use super::body::{Motion, Turned, laboratory};
use super::by_layer::{GrainsByLayer, Slice};
use super::mask::{Cells, Law, Profile, Sums};
use super::mask_model::MaskModel;
use super::piece::{PIECES, Piece};
use super::point_mask;
use crate::grid::Grid;
use crate::lanes::{self, dispatch};
use pulp::Simd;

/// Neighbouring places along axis 0 of which one grain holds some.
#[derive(Clone, Copy, Debug)]
pub struct Span {
    /// Place of the first in the layer.
    pub at: usize,
    /// Index of the first along axis 0.
    pub first: usize,
    /// Number of places, a multiple of eight.
    pub count: usize,
    /// Index along axis 1 in space, else 0.
    pub(super) row: usize,
    /// Which of the pieces of its row, where a periodic face cuts it.
    pub(super) piece: usize,
    /// Control volume of a cell over its factor along axis 0.
    pub weight: f64,
    /// Arm along axis 0: this and the position of the node.
    pub shift: f64,
    /// Arm along axis 1 in space, m; else 0.
    pub middle: f64,
}

/// What one grain holds of a layer.
#[derive(Clone, Copy, Debug)]
pub struct Part {
    /// The grain.
    pub grain: usize,
    /// Arm along the last axis, m.
    pub arm: f64,
    /// When the grain was last moved.
    stamp: u64,
    /// Its spans, and the mask ratios of their places.
    spans: Run,
    places: Run,
}

/// Neighbouring entries of a list.
#[derive(Clone, Copy, Debug, Default)]
struct Run {
    first: usize,
    count: usize,
}

impl Run {
    #[inline(always)]
    fn range(self) -> std::ops::Range<usize> {
        self.first..self.first + self.count
    }

    /// Moves the run to `end` in its list, which is at or before it, and `end` behind it.
    fn pull<T: Copy>(&mut self, list: &mut [T], end: &mut usize) {
        if self.first != *end {
            list.copy_within(self.range(), *end);
        }
        self.first = *end;
        *end += self.count;
    }
}

/// What is the same for all places of a row.
#[derive(Clone, Copy)]
struct Row {
    /// Index along axis 1 in space, else 0.
    index: usize,
    /// Arm along axis 1 in space, else 0, m.
    arm: f64,
    weight: f64,
}

/// What all rows of a grain in a layer share.
type Profiles = [Profile; PIECES];

/// Room for filling a layer.
#[derive(Clone, Debug, Default)]
pub(super) struct Room {
    profiles: Profiles,
    /// Cells of a part.
    cells: Cells,
    /// What was known of the layer.
    known: Vec<Part>,
}

impl Part {
    /// Whether this is of `grain` where it is placed.
    #[inline(always)]
    fn is_of<const D: usize>(&self, grains: &GrainsByLayer<D>, grain: usize) -> bool {
        self.grain == grain && self.stamp == grains.stamps[grain]
    }
}

/// The rows of all grains in a layer, and the mask ratios of their cells. Between those of its parts there
/// may be others that are of no use any more.
#[derive(Clone, Debug, Default)]
pub struct Layer {
    parts: Vec<Part>,
    spans: Vec<Span>,
    ratios: Vec<f64>,
    /// Whether this has been looked at since the grains were placed last.
    pub(super) fresh: bool,
}

impl Layer {
    /// Finds the rows of layer `k` and the mask ratios of their cells. What is known of grains that have not
    /// moved is kept.
    pub(super) fn fill<const D: usize>(
        &mut self,
        grid: &Grid<D>,
        grains: &GrainsByLayer<D>,
        model: &MaskModel,
        k: usize,
        room: &mut Room,
    ) {
        if std::mem::replace(&mut self.fresh, grains.caches) || self.holds(grains, k) {
            return;
        }
        let Room { profiles, cells, known } = room;
        if !grains.caches {
            // That was another layer.
            self.parts.clear();
        }
        self.forget(grains, k);
        std::mem::swap(&mut self.parts, known);
        self.parts.clear();
        dispatch(Fill { layer: self, known, grid, grains, model, k, profiles, cells });
    }

    /// Whether this is what the grains hold of layer `k` as they are placed.
    fn holds<const D: usize>(&self, grains: &GrainsByLayer<D>, k: usize) -> bool {
        let slices = grains.of(k);
        let same = |(part, slice): (&Part, &Slice)| part.is_of(grains, slice.grain);
        grains.caches && self.parts.len() == slices.len() && self.parts.iter().zip(slices).all(same)
    }

    /// Forgets the parts of grains that have moved, or are not in layer `k` any more; what is left is moved
    /// together where it is less than half of all.
    fn forget<const D: usize>(&mut self, grains: &GrainsByLayer<D>, k: usize) {
        let Self { parts, spans, ratios, .. } = self;
        // Both are in the order of the grains.
        let mut slices = grains.of(k).iter().peekable();
        parts.retain(|part| {
            while slices.next_if(|slice| slice.grain < part.grain).is_some() {}
            slices.peek().is_some_and(|slice| part.is_of(grains, slice.grain))
        });
        let (mut kept, mut end) = ([0; 2], [0; 2]);
        for part in &*parts {
            for (n, run) in [part.spans, part.places].into_iter().enumerate() {
                (kept[n], end[n]) = (kept[n] + run.count, end[n].max(run.range().end));
            }
        }
        if kept != end && 2 * kept[1] < ratios.len() {
            parts.sort_unstable_by_key(|part| part.places.first);
            end = [0; 2];
            for part in &mut *parts {
                part.spans.pull(spans, &mut end[0]);
                part.places.pull(ratios, &mut end[1]);
            }
            parts.sort_unstable_by_key(|part| part.grain);
        }
        spans.truncate(end[0]);
        ratios.truncate(end[1]);
    }

    /// What each grain holds: its rows with their mask ratios, in the order of the grains.
    #[inline(always)]
    pub fn parts(&self) -> impl Iterator<Item = (&Part, &[Span], &[f64])> {
        let Self { parts, spans, ratios, .. } = self;
        parts.iter().map(|part| (part, &spans[part.spans.range()], &ratios[part.places.range()]))
    }
}

/// [`Layer::fill`].
struct Fill<'a, const D: usize> {
    layer: &'a mut Layer,
    /// Parts that are still so.
    known: &'a [Part],
    grid: &'a Grid<D>,
    grains: &'a GrainsByLayer<D>,
    model: &'a MaskModel,
    k: usize,
    profiles: &'a mut Profiles,
    cells: &'a mut Cells,
}

impl<const D: usize> Fill<'_, D> {
    /// Adds what the grain of `slice` holds of layer `k`.
    #[inline(always)]
    fn part<S: Simd>(&mut self, simd: S, slice: &Slice) {
        let Self { grid, grains, model, k, .. } = *self;
        let (nodes, extent) = (&grains.nodes, &grains.extents[slice.grain]);
        let first = [self.layer.spans.len(), self.layer.ratios.len()];
        let [spans, places] = first.map(|first| Run { first, count: 0 });
        let chord = extent.outer * extent.outer - slice.arm * slice.arm;
        let mut part =
            Part { grain: slice.grain, arm: slice.arm, stamp: grains.stamps[slice.grain], spans, places };
        if chord <= 0.0 {
            self.layer.parts.push(part);
            return;
        }
        let pieces = Piece::of(grid, nodes, extent.at[0], chord.sqrt());
        let pieces = &pieces[..pieces.iter().filter(|piece| piece.count > 0).count()];
        let law =
            Law::new(&MaskModel { wave: extent.wave, ..*model }, extent.radius, extent.inner, nodes.even);
        for (piece, profile) in pieces.iter().zip(self.profiles.iter_mut()) {
            profile.set(&law, &nodes.row, piece, extent.outer);
        }
        let mut sums = Sums::default();
        sums.add(slice.arm, nodes.spacing[D - 1][k]);
        let weight = grid.turn() * grid.volumes(nodes.component, D - 1)[k];
        let places = pieces.iter().map(|piece| piece.count).sum::<usize>();
        self.cells.begin(0);
        if let Some(outline) = &grains.turned[slice.grain] {
            self.outlined_row(pieces, chord, outline, slice.arm, weight);
        } else if D == 2 {
            self.cells.begin(places);
            self.row(simd, pieces, chord.sqrt(), &law, sums, Row { index: 0, arm: 0.0, weight });
        } else {
            let (low, high) = nodes.range(grid, 1, extent.at[1], chord.sqrt());
            self.cells.begin(places * (high - low) as usize);
            for m in low..high {
                let near = nodes.node(grid, 1, extent.at[1], m);
                let chord = chord - near.arm * near.arm;
                if chord <= 0.0 {
                    continue;
                }
                let mut sums = sums;
                sums.add(near.arm, nodes.spacing[1][near.index]);
                let weight = weight * grid.volumes(nodes.component, 1)[near.index];
                self.row(
                    simd,
                    pieces,
                    chord.sqrt(),
                    &law,
                    sums,
                    Row { index: near.index, arm: near.arm, weight },
                );
            }
        }
        law.finish(self.cells, &mut self.layer.ratios);
        self.open_mask(slice, first);
        part.spans.count = self.layer.spans.len() - first[0];
        part.places.count = self.layer.ratios.len() - first[1];
        self.layer.parts.push(part);
    }

    /// Adds the places of one row of which the grain holds some, `half` of its chord to each side.
    #[inline(always)]
    fn row<S: Simd>(&mut self, simd: S, pieces: &[Piece], half: f64, law: &Law, sums: Sums, row: Row) {
        let stride = self.grid.stride(1);
        for (index, (piece, profile)) in pieces.iter().zip(&*self.profiles).enumerate() {
            let window = piece.window(half);
            if window.is_empty() {
                continue;
            }
            let first = piece.first + window.start;
            self.layer.spans.push(Span {
                at: row.index * stride + first,
                first,
                count: window.len(),
                row: row.index,
                piece: index,
                weight: row.weight,
                shift: piece.shift,
                middle: row.arm,
            });
            law.row(simd, profile, window, &sums, (&mut *self.cells, &mut self.layer.ratios));
        }
    }

    /// Opens the mask of the grain of `slice` in its patches, in spans and places from `first` on: to what
    /// flows along the surface there. At cell centres nothing flows.
    #[inline(always)]
    fn open_mask(&mut self, slice: &Slice, first: [usize; 2]) {
        let Self { grains, grid, layer, .. } = self;
        let (patches, component) = (&grains.patches[slice.grain], grains.nodes.component);
        if patches.is_empty() || component == D {
            return;
        }
        let c = laboratory(grid.geometry, component);
        let (row, reach) = (&grains.nodes.row.at, grains.extents[slice.grain].outer);
        for patch in patches.iter().filter(|patch| patch.lies_along(c)) {
            let Some([low, high]) = patch.rows(slice.arm, reach) else { continue };
            let mut at = first[1];
            for span in &layer.spans[first[0]..] {
                if (low..=high).contains(&span.middle) {
                    let (ratios, places) = (&mut layer.ratios[at..], &row[span.first..][..span.count]);
                    patch.open(&mut ratios[..span.count], places, [span.shift, span.middle, slice.arm]);
                }
                at += span.count;
            }
        }
    }

    /// The same for a body of the plane that is not round, cell by cell.
    fn outlined_row(&mut self, pieces: &[Piece], chord: f64, outline: &Turned, arm: f64, weight: f64) {
        let nodes = &self.grains.nodes;
        let across = nodes.spacing[D - 1][self.k];
        for (index, piece) in pieces.iter().enumerate() {
            let window = piece.window(chord.sqrt());
            if window.is_empty() {
                continue;
            }
            let first = piece.first + window.start;
            let (at, count) = (first, window.len());
            let span =
                Span { at, first, count, row: 0, piece: index, weight, shift: piece.shift, middle: 0.0 };
            self.layer.spans.push(span);
            self.layer.ratios.extend((first..first + count).map(|place| {
                if !(piece.begin..piece.end).contains(&place) {
                    return 0.0;
                }
                let (distance, normal) = outline.distance([nodes.row.at[place] + piece.shift, arm]);
                point_mask::ratio(self.model, distance, &normal, &[nodes.row.spacing[place], across])
            }));
        }
    }
}

impl<const D: usize> lanes::Kernel for Fill<'_, D> {
    #[inline(always)]
    fn run<S: Simd>(mut self, simd: S) {
        // Both are in the order of the grains.
        let mut known = self.known.iter().peekable();
        for slice in self.grains.of(self.k) {
            if let Some(part) = known.next_if(|part| part.grain == slice.grain) {
                self.layer.parts.push(*part);
            } else {
                self.part(simd, slice);
            }
        }
    }
}

impl Span {
    /// Rigid velocity of component `c` along the row, as a line: at the origin of axis 0, and per metre.
    #[inline(always)]
    pub(crate) fn velocity(&self, motion: &Motion, c: usize, arm: f64) -> [f64; 2] {
        [motion.velocity_at(c, [self.shift, self.middle, arm]), motion.slope(c, 0)]
    }
}
