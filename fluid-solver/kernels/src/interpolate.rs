//! Fields from one grid onto another: along each axis by the cubic through the four nearest nodes, exact
//! where two nodes meet.
//!
//! Beyond a wall there is nothing to interpolate between. A component along a no-slip wall, or on a face that
//! fluid passes through, has its value on the face as a node; where the flow goes on as its mirror image
//! (free slip, the axis of symmetry) the image is one. Both keep the cubic's fourth order up to the wall. The
//! pressure has no value on a wall: from its last two nodes it goes on along a line.

use crate::field::for_each_own_unknown;
use crate::grid::Grid;

/// Nodes that a cubic goes through.
const CUBIC: usize = 4;

/// How a field goes on beyond its last nodes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// A component of the velocity, by the conditions on the faces.
    Velocity,
    /// The pressure: along a line.
    Pressure,
    /// The force of the grains: as it is at the last node.
    Force,
}

/// What gives the value at one place along an axis: indices along it and their weights.
type Weights = Vec<(isize, f64)>;

/// A node along an axis: its position, m, and what gives its value.
#[derive(Clone, Debug)]
struct Node {
    at: f64,
    value: [(isize, f64); 2],
}

impl Node {
    fn plain(at: f64, index: isize) -> Self {
        Self { at, value: [(index, 1.0), (index, 0.0)] }
    }

    /// On a face, between a value inside and its image.
    fn on_face(at: f64, below: isize) -> Self {
        Self { at, value: [(below, 0.5), (below + 1, 0.5)] }
    }
}

/// Nodes of a field along one axis of its grid.
struct Line {
    nodes: Vec<Node>,
    /// Length after which they come again, m.
    period: Option<f64>,
    kind: Kind,
}

impl Line {
    /// Of component `d` (`d = D`: of a scalar).
    fn new<const D: usize>(grid: &Grid<D>, d: usize, axis: usize, kind: Kind) -> Self {
        let positions = grid.nodes(d, axis);
        let n = grid.cells[axis] as isize;
        let plain = |range: std::ops::Range<isize>| {
            range.map(|i| Node::plain(positions[i as usize], i)).collect::<Vec<_>>()
        };
        if grid.periodic(axis) {
            return Self { nodes: plain(0..n), period: Some(grid.axes[axis].length()), kind };
        }
        let faces = &grid.axes[axis].faces;
        let ends = [faces[0], faces[n as usize]];
        let [low, high] = grid.boundaries[axis];
        let own = d == axis;
        let mut nodes = match kind {
            // Of a force only the unknowns are known.
            Kind::Force => plain(isize::from(own)..n),
            _ => plain(0..n + isize::from(own)),
        };
        // The own component has no value beyond the upper face.
        let image = |face: f64, node: &Node, index: isize| Node::plain(2.0 * face - node.at, index);
        if kind != Kind::Force && !low.is_odd() {
            let inside = &nodes[usize::from(own)];
            nodes.insert(0, image(ends[0], inside, -1));
        } else if kind == Kind::Velocity && !own {
            nodes.insert(0, Node::on_face(ends[0], -1));
        }
        if kind != Kind::Force && !high.is_odd() && !own {
            let inside = &nodes[nodes.len() - 1];
            nodes.push(image(ends[1], inside, n));
        } else if kind == Kind::Velocity && !own {
            nodes.push(Node::on_face(ends[1], n - 1));
        }
        Self { nodes, period: None, kind }
    }

    /// Node `k`, counted on beyond both ends of a period.
    fn node(&self, k: isize) -> (f64, &Node) {
        let n = self.nodes.len() as isize;
        let node = &self.nodes[k.rem_euclid(n) as usize];
        (node.at + self.period.unwrap_or(0.0) * k.div_euclid(n) as f64, node)
    }

    /// What gives the value at `x`, m.
    fn weights(&self, x: f64) -> Weights {
        let n = self.nodes.len();
        let (first, last) = (self.nodes[0].at, self.nodes[n - 1].at);
        let mut x = x;
        if let Some(period) = self.period {
            x -= period * ((x - first) / period).floor();
            if x >= first + period {
                x -= period;
            }
        } else if self.kind != Kind::Pressure {
            x = x.clamp(first, last);
        }
        let below = self.nodes.partition_point(|node| node.at <= x) as isize - 1;
        let (count, begin) = if self.period.is_some() {
            (CUBIC, below - 1)
        } else {
            // What lies outside is the pressure's.
            let count = if x < first || x > last { 2.min(n) } else { CUBIC.min(n) };
            let room = (n - count) as isize;
            (count, (below + 1 - count as isize / 2).clamp(0, room))
        };
        let stencil: Vec<(f64, &Node)> = (0..count as isize).map(|k| self.node(begin + k)).collect();
        let mut weights = Weights::new();
        for (i, (at, node)) in stencil.iter().enumerate() {
            let others = stencil.iter().enumerate().filter(|(j, _)| *j != i);
            let weight: f64 = others.map(|(_, (other, _))| (x - other) / (at - other)).product();
            let parts = node.value.iter().filter(|(_, part)| weight * part != 0.0);
            weights.extend(parts.map(|(index, part)| (*index, weight * part)));
        }
        weights
    }
}

/// Interpolates component `d` (`d = D`: a scalar) from `source`, halos filled, to the unknowns of `target` on
/// the planes of this process. What lies outside of `source` along an axis that is not periodic there is
/// taken from its edge.
pub fn interpolate<const D: usize>(
    (source, from): (&Grid<D>, &[f64]),
    (target, to): (&Grid<D>, &mut [f64]),
    d: usize,
    kind: Kind,
) {
    let weights: [Vec<Vec<(isize, f64)>>; D] = std::array::from_fn(|axis| {
        let line = Line::new(source, d, axis, kind);
        let stride = source.stride(axis) as isize;
        // Indices become distances in memory.
        let at = |x: &f64| line.weights(*x).into_iter().map(|(index, w)| (index * stride, w)).collect();
        target.nodes(d, axis).iter().map(at).collect()
    });
    let origin = source.index([0; D]);
    for_each_own_unknown(target, d, |at, index| {
        let lines: [&[(isize, f64)]; D] = std::array::from_fn(|axis| weights[axis][at[axis]].as_slice());
        to[index] = sum(from, origin, &lines);
    });
}

/// Σ over the product of the axes' weights, the first axis innermost.
fn sum(from: &[f64], origin: usize, lines: &[&[(isize, f64)]]) -> f64 {
    let Some((line, inner)) = lines.split_last() else { return from[origin] };
    line.iter().map(|(step, weight)| weight * sum(from, origin.wrapping_add_signed(*step), inner)).sum()
}
