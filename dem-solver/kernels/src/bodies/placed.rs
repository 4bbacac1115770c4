//! Bodies of the plane where they stand: vertices, normals of edges and axes turned into the laboratory.

use crate::bodies::plane::{Vec2, dot, minus};
use crate::grains::Grains;
use bedload_outline::Outline;

/// Turn of a body about y: cosine and sine.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Turn(f64, f64);

impl Turn {
    /// Laboratory from body.
    #[inline(always)]
    pub(crate) fn out(self, v: Vec2) -> Vec2 {
        [v[0] * self.0 + v[1] * self.1, v[1] * self.0 - v[0] * self.1]
    }

    /// Body from laboratory.
    #[inline(always)]
    pub(crate) fn into_body(self, v: Vec2) -> Vec2 {
        [v[0] * self.0 - v[1] * self.1, v[0] * self.1 + v[1] * self.0]
    }
}

/// Edges of a polygon from its centre, in the laboratory: edge k runs from vertex k to the next.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Edges<'a> {
    pub(crate) vertices: &'a [Vec2],
    /// Outward normals.
    pub(crate) normals: &'a [Vec2],
    /// Distances of the edges from the centre, m.
    pub(crate) heights: &'a [f64],
}

impl Edges<'_> {
    /// The last vertex of edge `k`.
    #[inline(always)]
    pub(crate) fn end(&self, k: usize) -> usize {
        if k + 1 == self.vertices.len() { 0 } else { k + 1 }
    }
}

/// A grain of the plane as contacts see it.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Form<'a> {
    Disc(f64),
    Ellipse { semi_axes: Vec2, outline: &'a Outline, turn: Turn },
    Polygon { edges: Edges<'a>, outline: &'a Outline, turn: Turn },
}

impl Form<'_> {
    /// The point of the surface farthest along `direction` (of any length), from the centre.
    #[inline(always)]
    pub(crate) fn support(&self, direction: Vec2) -> Vec2 {
        match self {
            Self::Disc(radius) => {
                let scale = radius / dot(direction, direction).sqrt();
                [direction[0] * scale, direction[1] * scale]
            }
            Self::Ellipse { semi_axes: [a, b], turn, .. } => {
                let own = turn.into_body(direction);
                let scaled = [a * own[0], b * own[1]];
                let size = dot(scaled, scaled).sqrt();
                turn.out([a * scaled[0] / size, b * scaled[1] / size])
            }
            Self::Polygon { edges, .. } => {
                let first = edges.vertices[0];
                let farther =
                    |best: Vec2, v: &Vec2| if dot(*v, direction) > dot(best, direction) { *v } else { best };
                edges.vertices.iter().fold(first, farther)
            }
        }
    }
}

/// All bodies of a run that are not round, turned as they stand.
#[derive(Clone, Debug, Default)]
pub(crate) struct Placed {
    outlines: Vec<Outline>,
    turns: Vec<Turn>,
    /// Range of the vertices of each grain.
    start: Vec<usize>,
    /// Vertices and normals in the frames of the bodies,
    own: Vec<(Vec2, Vec2)>,
    /// and in the laboratory.
    vertices: Vec<Vec2>,
    normals: Vec<Vec2>,
    heights: Vec<f64>,
}

impl Placed {
    /// For these grains; their outlines are among `outlines`.
    pub(crate) fn new(grains: &Grains, outlines: &[Outline]) -> Self {
        let mut placed = Self { outlines: outlines.to_vec(), ..Self::default() };
        for outline in &grains.outline {
            placed.start.push(placed.own.len());
            placed.turns.push(Turn(1.0, 0.0));
            let Some(Outline::Polygon { vertices }) = outline.map(|place| &outlines[place as usize]) else {
                continue;
            };
            for (k, p) in vertices.iter().enumerate() {
                let along = minus(vertices[(k + 1) % vertices.len()], *p);
                let size = along[0].hypot(along[1]);
                let normal = [along[1] / size, -along[0] / size];
                placed.own.push((*p, normal));
                placed.heights.push(dot(normal, *p));
            }
        }
        placed.start.push(placed.own.len());
        (placed.vertices, placed.normals) = placed.own.iter().copied().unzip();
        placed
    }

    /// Takes the present orientations.
    pub(crate) fn place(&mut self, grains: &Grains) {
        for i in (0..grains.len()).filter(|&i| !grains.is_round(i)) {
            let q = &grains.orientation[i];
            let size = q.w * q.w + q.j * q.j;
            let turn = Turn((q.w * q.w - q.j * q.j) / size, 2.0 * q.w * q.j / size);
            self.turns[i] = turn;
            for k in self.start[i]..self.start[i + 1] {
                let (vertex, normal) = self.own[k];
                self.vertices[k] = turn.out(vertex);
                self.normals[k] = turn.out(normal);
            }
        }
    }

    /// Grain `i` as it stands.
    #[inline(always)]
    pub(crate) fn form(&self, grains: &Grains, i: usize) -> Form<'_> {
        let Some(place) = grains.outline[i] else { return Form::Disc(grains.radius[i]) };
        let (outline, turn) = (&self.outlines[place as usize], self.turns[i]);
        match outline {
            Outline::Ellipse { semi_axes } => Form::Ellipse { semi_axes: *semi_axes, outline, turn },
            Outline::Polygon { .. } => {
                let range = self.start[i]..self.start[i + 1];
                let vertices = &self.vertices[range.clone()];
                let edges =
                    Edges { vertices, normals: &self.normals[range.clone()], heights: &self.heights[range] };
                Form::Polygon { edges, outline, turn }
            }
        }
    }
}
