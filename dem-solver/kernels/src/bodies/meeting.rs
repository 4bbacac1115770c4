//! Where two grains of the plane meet: gap, and the points at which they touch.
//!
//! The gap is the largest distance by which a line can keep them apart, max over n of σ(n) = n·(x₁ − x₂) −
//! h₁(−n) − h₂(n) with the support functions h: the distance where they are apart, the least way out where
//! they overlap. Two polygons touch in up to two points, each a vertex of one at an edge of the other; all
//! other pairs in one.

use crate::bodies::placed::{Edges, Form};
use crate::bodies::plane::{Vec2, across, along, dot, minus, plus, unit};

/// Features of vertices of the second body count from here; 0 to here those of the first.
pub(crate) const SECOND: u32 = 1 << 16;

/// A point of contact.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Touch {
    /// A vertex, or 0 where there is one point only.
    pub(crate) feature: u32,
    /// From the second to the first.
    pub(crate) normal: Vec2,
    /// m, negative where they overlap.
    pub(crate) gap: f64,
    /// From the centre of the first, m: in the middle of the overlap.
    pub(crate) arm: Vec2,
}

/// Two grains near each other.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Meeting {
    /// m; of two polygons that are apart a lower bound.
    pub(crate) gap: f64,
    touches: [Touch; 2],
    count: usize,
}

impl Meeting {
    fn apart(gap: f64) -> Self {
        Self { gap, touches: [Touch::default(); 2], count: 0 }
    }

    fn one(touch: Touch) -> Self {
        Self { gap: touch.gap, touches: [touch, Touch::default()], count: 1 }
    }

    #[inline(always)]
    pub(crate) fn touches(&self) -> &[Touch] {
        &self.touches[..self.count]
    }

    /// With first and second the other way round; `apart` is that of the new first from the new second.
    fn swapped(mut self, apart: Vec2) -> Self {
        for touch in &mut self.touches {
            touch.normal = [-touch.normal[0], -touch.normal[1]];
            touch.arm = minus(touch.arm, apart);
        }
        self
    }
}

/// How `first` meets `second`, whose centre lies `apart` behind that of the first. Polygons that are apart
/// have points only where those are asked for (`keep`).
pub(crate) fn meet(first: &Form<'_>, second: &Form<'_>, apart: Vec2, keep: bool) -> Meeting {
    let back = [-apart[0], -apart[1]];
    match (first, second) {
        (Form::Disc(one), Form::Disc(other)) => {
            let normal = if apart == [0.0; 2] { [0.0, 1.0] } else { unit(apart) };
            let gap = dot(apart, normal) - one - other;
            Meeting::one(Touch { feature: 0, normal, gap, arm: along([0.0; 2], normal, -one - 0.5 * gap) })
        }
        (Form::Disc(radius), body) => disc_at_body(*radius, body, apart),
        (body, Form::Disc(radius)) => disc_at_body(*radius, body, back).swapped(apart),
        (Form::Polygon { edges: one, .. }, Form::Polygon { edges: other, .. }) => {
            polygons(one, other, apart, keep)
        }
        (Form::Ellipse { .. }, Form::Polygon { edges, .. }) => ellipse_at_polygon(first, edges, apart),
        (Form::Polygon { edges, .. }, Form::Ellipse { .. }) => {
            ellipse_at_polygon(second, edges, back).swapped(apart)
        }
        (Form::Ellipse { .. }, Form::Ellipse { .. }) => ellipses(first, second, apart),
    }
}

/// Distance of two grains, negative where they overlap, m.
pub(crate) fn distance(first: &Form<'_>, second: &Form<'_>, apart: Vec2) -> f64 {
    let gap = meet(first, second, apart, false).gap;
    let (
        Form::Polygon { edges: one, outline: outline_one, turn: turn_one },
        Form::Polygon { edges: other, outline: outline_other, turn: turn_other },
    ) = (first, second)
    else {
        return gap;
    };
    if gap <= 0.0 {
        return gap;
    }
    let of_one = one.vertices.iter().map(|v| outline_other.distance(turn_other.into_body(plus(*v, apart))).0);
    let of_other =
        other.vertices.iter().map(|v| outline_one.distance(turn_one.into_body(minus(*v, apart))).0);
    of_one.chain(of_other).fold(f64::INFINITY, f64::min)
}

/// A disc, the first, at a body that is not round.
fn disc_at_body(radius: f64, body: &Form<'_>, apart: Vec2) -> Meeting {
    let (Form::Ellipse { outline, turn, .. } | Form::Polygon { outline, turn, .. }) = body else {
        return Meeting::apart(f64::INFINITY);
    };
    let (distance, own) = outline.distance(turn.into_body(apart));
    let (normal, gap) = (turn.out(own), distance - radius);
    Meeting::one(Touch { feature: 0, normal, gap, arm: along([0.0; 2], normal, -radius - 0.5 * gap) })
}

/// The edge of `one` that keeps `other` farthest off, and by how much; `apart` is the centre of `one` from
/// that of `other`.
#[inline(always)]
fn best_edge(one: &Edges<'_>, other: &Edges<'_>, apart: Vec2) -> (f64, usize) {
    let mut best = (f64::NEG_INFINITY, 0);
    for (k, normal) in one.normals.iter().enumerate() {
        let lowest = other.vertices.iter().map(|v| dot(*v, *normal)).fold(f64::INFINITY, f64::min);
        let off = lowest - dot(apart, *normal) - one.heights[k];
        if off > best.0 {
            best = (off, k);
        }
    }
    best
}

/// Which of `vectors` goes least along `normal`: of the normals of edges the one that faces it most, of
/// vertices the lowest.
#[inline(always)]
fn least(vectors: &[Vec2], normal: Vec2) -> usize {
    let mut best = (f64::INFINITY, 0);
    for (k, vector) in vectors.iter().enumerate() {
        let size = dot(*vector, normal);
        if size < best.0 {
            best = (size, k);
        }
    }
    best.1
}

/// Vertex `v` of the first (`is_first`) or the second at edge `k` of the other; `apart` as in [`meet`].
#[inline(always)]
fn vertex_at_edge(
    (one, other): (&Edges<'_>, &Edges<'_>),
    apart: Vec2,
    is_first: bool,
    v: usize,
    k: usize,
) -> Touch {
    if is_first {
        let (normal, x) = (other.normals[k], one.vertices[v]);
        let gap = dot(normal, plus(x, apart)) - other.heights[k];
        Touch { feature: v as u32, normal, gap, arm: along(x, normal, -0.5 * gap) }
    } else {
        let (outward, x) = (one.normals[k], minus(other.vertices[v], apart));
        let gap = dot(outward, x) - one.heights[k];
        let normal = [-outward[0], -outward[1]];
        Touch { feature: SECOND + v as u32, normal, gap, arm: along(x, outward, -0.5 * gap) }
    }
}

/// Two polygons: the axis of least overlap names an edge of one, the edge of the other that faces it most is
/// its partner. Where their shadows on each other end, a vertex of one stands at the edge of the other.
fn polygons(one: &Edges<'_>, other: &Edges<'_>, apart: Vec2, keep: bool) -> Meeting {
    let (of_one, of_other) = (best_edge(one, other, apart), best_edge(other, one, [-apart[0], -apart[1]]));
    let gap = of_one.0.max(of_other.0);
    if gap >= 0.0 && !keep {
        return Meeting::apart(gap);
    }
    let by_one = of_one.0 >= of_other.0;
    let (k, m) = if by_one {
        (of_one.1, least(other.normals, one.normals[of_one.1]))
    } else {
        (least(one.normals, other.normals[of_other.1]), of_other.1)
    };
    let tangent = across(if by_one { one.normals[k] } else { other.normals[m] });
    // Places of the ends of both edges along the tangent; the two edges run against each other.
    let shift = dot(apart, tangent);
    let of = |edges: &Edges<'_>, v: usize, shift: f64| (dot(edges.vertices[v], tangent) + shift, v);
    let (a, b) = (of(one, k, shift), of(one, one.end(k), shift));
    let (c, d) = (of(other, m, 0.0), of(other, other.end(m), 0.0));
    let ordered = |p: (f64, usize), q: (f64, usize)| if p.0 <= q.0 { (p, q) } else { (q, p) };
    let ((low_one, high_one), (low_other, high_other)) = (ordered(a, b), ordered(c, d));
    let both = (one, other);
    let low = low_one.0.max(low_other.0);
    let high = high_one.0.min(high_other.0);
    if low > high {
        // Corner beside corner: the deepest vertex alone.
        let touch = if by_one {
            vertex_at_edge(both, apart, false, least(other.vertices, one.normals[k]), k)
        } else {
            vertex_at_edge(both, apart, true, least(one.vertices, other.normals[m]), m)
        };
        return Meeting { gap, ..Meeting::one(touch) };
    }
    let at = |of_one: bool, v: usize| vertex_at_edge(both, apart, of_one, v, if of_one { m } else { k });
    let first = if low_one.0 >= low_other.0 { at(true, low_one.1) } else { at(false, low_other.1) };
    let last = if high_one.0 <= high_other.0 { at(true, high_one.1) } else { at(false, high_other.1) };
    Meeting { gap, touches: [first, last], count: 2 }
}

/// An ellipse, the first, at a polygon: at the edge that keeps it farthest off, or at that edge's end if it
/// hangs over.
fn ellipse_at_polygon(ellipse: &Form<'_>, edges: &Edges<'_>, apart: Vec2) -> Meeting {
    let Form::Ellipse { outline, turn, .. } = ellipse else { return Meeting::apart(f64::INFINITY) };
    let mut best = (f64::NEG_INFINITY, 0, [0.0; 2]);
    for (k, normal) in edges.normals.iter().enumerate() {
        let down = ellipse.support([-normal[0], -normal[1]]);
        let off = dot(plus(apart, down), *normal) - edges.heights[k];
        if off > best.0 {
            best = (off, k, down);
        }
    }
    let (gap, k, down) = best;
    let (normal, point) = (edges.normals[k], plus(apart, down));
    let (p, q) = (edges.vertices[k], edges.vertices[edges.end(k)]);
    let edge = minus(q, p);
    let vertex = if dot(minus(point, p), edge) < 0.0 {
        p
    } else if dot(minus(point, q), edge) > 0.0 {
        q
    } else {
        return Meeting::one(Touch { feature: 0, normal, gap, arm: along(down, normal, -0.5 * gap) });
    };
    let arm = minus(vertex, apart);
    let (gap, own) = outline.distance(turn.into_body(arm));
    let outward = turn.out(own);
    let normal = [-outward[0], -outward[1]];
    Meeting::one(Touch { feature: 0, normal, gap, arm: along(arm, outward, -0.5 * gap) })
}

/// Two ellipses: σ is largest where the line between the two support points runs along n, that is where
/// σ′ = t·(p₁ − p₂) = 0.
fn ellipses(first: &Form<'_>, second: &Form<'_>, apart: Vec2) -> Meeting {
    let points = |n: Vec2| (plus(apart, first.support([-n[0], -n[1]])), second.support(n));
    let sigma = |n: Vec2| {
        let (p, q) = points(n);
        dot(n, minus(p, q))
    };
    let slope = |n: Vec2| {
        let (p, q) = points(n);
        dot(across(n), minus(p, q))
    };
    let start = if apart == [0.0; 2] { [0.0, 1.0] } else { unit(apart) };
    let mut best = (sigma(start), start);
    for form in [first, second] {
        let Form::Ellipse { semi_axes: [a, b], turn, .. } = form else { continue };
        for [cosine, sine] in COMPASS {
            let n = unit(turn.out([cosine / a, sine / b]));
            let size = sigma(n);
            if size > best.0 {
                best = (size, n);
            }
        }
    }
    let normal = root(best.1, slope);
    let (p, q) = points(normal);
    let gap = dot(normal, minus(p, q));
    let middle = [0.5 * (p[0] + q[0]), 0.5 * (p[1] + q[1])];
    Meeting::one(Touch { feature: 0, normal, gap, arm: minus(middle, apart) })
}

/// Cosines and sines of eighths of a turn, along the surfaces of two ellipses: from there the search between
/// them starts.
const COMPASS: [Vec2; 8] = {
    const R: f64 = std::f64::consts::FRAC_1_SQRT_2;
    [[1.0, 0.0], [R, R], [0.0, 1.0], [-R, R], [-1.0, 0.0], [-R, -R], [0.0, -1.0], [R, -R]]
};

/// The direction near `start` where `slope`, which falls there as the direction turns on, is zero.
fn root(start: Vec2, slope: impl Fn(Vec2) -> f64) -> Vec2 {
    let at_start = slope(start);
    if at_start == 0.0 {
        return start;
    }
    let sign = at_start.signum();
    let (mut near, mut far) = ((start, at_start), (start, at_start));
    let mut step = 0.02;
    while far.1 * sign > 0.0 && step < 4.0 {
        near = far;
        let n = unit(along(far.0, across(far.0), sign * step));
        far = (n, slope(n));
        step *= 2.0;
    }
    if far.1 * sign > 0.0 {
        return start;
    }
    // False position, the weight of an end that stays halved (Illinois).
    let (mut weight_near, mut weight_far) = (near.1.abs(), far.1.abs());
    for _ in 0..100 {
        let sum = weight_near + weight_far;
        if sum == 0.0 {
            break;
        }
        let (a, b) = (weight_far / sum, weight_near / sum);
        let n = unit([a * near.0[0] + b * far.0[0], a * near.0[1] + b * far.0[1]]);
        if n == near.0 || n == far.0 {
            break;
        }
        let size = slope(n);
        if size == 0.0 {
            return n;
        }
        if size * sign > 0.0 {
            near = (n, size);
            weight_near = size.abs();
            weight_far *= 0.5;
        } else {
            far = (n, size);
            weight_far = size.abs();
            weight_near *= 0.5;
        }
    }
    if near.1.abs() <= far.1.abs() { near.0 } else { far.0 }
}
