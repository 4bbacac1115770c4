//! What the grains hold of one layer of nodes: rows of cells, and the mask ratios of each.
//!
//! Rows are taken in whole vectors of eight places: those that a grain does not hold have no mask ratios, and
//! nothing that is done with them changes anything.

use super::body::{Motion, Turned};
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
    /// Number of its spans, and of their places.
    spans: usize,
    places: usize,
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
    before: Layer,
}

impl Part {
    /// Whether this is of `grain` where it is placed.
    #[inline(always)]
    fn is_of<const D: usize>(&self, grains: &GrainsByLayer<D>, grain: usize) -> bool {
        self.grain == grain && self.stamp == grains.stamp(grain)
    }
}

/// The rows of all grains in a layer, and the mask ratios of their cells.
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
    /// moved is taken over.
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
        let Room { profiles, cells, before } = room;
        std::mem::swap(self, before);
        self.fresh = before.fresh;
        if !grains.caches {
            // That was another layer.
            before.parts.clear();
        }
        self.parts.clear();
        self.spans.clear();
        self.ratios.clear();
        dispatch(Fill { layer: self, before, grid, grains, model, k, profiles, cells });
    }

    /// Whether this is what the grains hold of layer `k` as they are placed.
    fn holds<const D: usize>(&self, grains: &GrainsByLayer<D>, k: usize) -> bool {
        let slices = grains.of(k);
        let same = |(part, slice): (&Part, &Slice)| part.is_of(grains, slice.grain);
        grains.caches && self.parts.len() == slices.len() && self.parts.iter().zip(slices).all(same)
    }

    /// All rows, and all mask ratios, one after the other.
    pub(super) fn rows(&self) -> (&[Span], &[f64]) {
        (&self.spans, &self.ratios)
    }

    /// What each grain holds: its rows with their mask ratios, in the order of the grains.
    #[inline(always)]
    pub fn parts(&self) -> impl Iterator<Item = (&Part, &[Span], &[f64])> {
        let (mut spans, mut ratios) = (self.spans.as_slice(), self.ratios.as_slice());
        self.parts.iter().map(move |part| {
            let (mine, rest) = spans.split_at(part.spans);
            let (held, left) = ratios.split_at(part.places);
            (spans, ratios) = (rest, left);
            (part, mine, held)
        })
    }
}

/// [`Layer::fill`].
struct Fill<'a, const D: usize> {
    layer: &'a mut Layer,
    before: &'a Layer,
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
        let chord = extent.outer * extent.outer - slice.arm * slice.arm;
        let mut part = Part {
            grain: slice.grain,
            arm: slice.arm,
            stamp: grains.stamp(slice.grain),
            spans: 0,
            places: 0,
        };
        if chord <= 0.0 {
            self.layer.parts.push(part);
            return;
        }
        let pieces = Piece::of(grid, nodes, extent.at[0], chord.sqrt());
        let pieces = &pieces[..pieces.iter().filter(|piece| piece.count > 0).count()];
        for (piece, profile) in pieces.iter().zip(self.profiles.iter_mut()) {
            profile.set(&nodes.row, piece, extent.outer);
        }
        let mut sums = Sums::default();
        sums.add(slice.arm, nodes.spacing[D - 1][k]);
        let law =
            Law::new(&MaskModel { wave: extent.wave, ..*model }, extent.radius, extent.inner, nodes.even);
        let weight = grid.turn() * grid.volumes(nodes.component(), D - 1)[k];
        let places = pieces.iter().map(|piece| piece.count).sum::<usize>();
        self.cells.begin(0);
        if let Some(outline) = grains.outline(slice.grain) {
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
                let weight = weight * grid.volumes(nodes.component(), 1)[near.index];
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
        [part.spans, part.places] = [self.layer.spans.len() - first[0], self.layer.ratios.len() - first[1]];
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
}

impl<const D: usize> Fill<'_, D> {
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
        let mut known = self.before.parts();
        let mut next = known.next();
        for slice in self.grains.of(self.k) {
            while next.is_some_and(|(part, ..)| part.grain < slice.grain) {
                next = known.next();
            }
            if let Some((part, spans, ratios)) =
                next.filter(|(part, ..)| part.is_of(self.grains, slice.grain))
            {
                self.layer.parts.push(*part);
                self.layer.spans.extend_from_slice(spans);
                self.layer.ratios.extend_from_slice(ratios);
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
        let slope = motion.slope(c, 0);
        [motion.velocity_at(c, [self.shift, self.middle, arm]), slope]
    }
}
