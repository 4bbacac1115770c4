//! Collocation points of bodies that are not round: along parallels of the outline, one cell apart.

use super::points::Points;
use bedload_outline::{Outline, cross, dot, length as size, minus};
use nalgebra::{Matrix4, Vector4};
use std::f64::consts::TAU;

/// Sides of the polygon that stands for an ellipse.
const SIDES: u32 = 360;

/// Corners that turn by more than this keep a point of their own, rad.
const SHARP: f64 = 0.4;

/// Widths, in cells, of the bands that the first two parallels stand for: together they reach from the
/// surface to the middle between the second and the third, and have its middle at the middle.
const OUTER_BANDS: [f64; 2] = [0.72, 1.08];

impl Points {
    /// Points in `outline`, `spacing` apart, the outermost `inset` below the surface. Area, centre of mass
    /// and moment of inertia of the body come out exactly.
    pub(super) fn of(outline: &Outline, spacing: f64, inset: f64) -> Self {
        let whole = match outline {
            Outline::Polygon { vertices } => vertices.clone(),
            Outline::Ellipse { semi_axes: [a, b] } => (0..SIDES)
                .map(|k| TAU * f64::from(k) / f64::from(SIDES))
                .map(|angle| [a * angle.cos(), b * angle.sin()])
                .collect(),
        };
        let deepest = depth(&whole);
        let mut points = Self::default();
        for ring in 0.. {
            let at = inset + f64::from(ring) * spacing;
            // Two at least; further ones where they are not too near to their own other side.
            if ring > 1 && deepest - at < 0.5 * spacing {
                break;
            }
            let parallel = inside(&whole, at.min(0.9 * deepest));
            let next = at + spacing;
            let is_last = ring > 0 && deepest - next < 0.5 * spacing;
            let area = if is_last {
                // All that it surrounds.
                enclosed(&inside(&whole, at - 0.5 * spacing))
            } else {
                OUTER_BANDS.get(ring as usize).unwrap_or(&1.0) * spacing * around(&parallel)
            };
            points.along(&parallel, spacing, area);
        }
        points.balance(outline);
        points
    }

    /// Adds points along a closed line, about `spacing` apart, for `area` in all.
    fn along(&mut self, line: &[[f64; 2]], spacing: f64, area: f64) {
        let n = line.len();
        let edge = |k: usize| minus(line[(k + 1) % n], line[k % n]);
        let length = around(line);
        let corners: Vec<usize> = (0..n)
            .filter(|k| {
                let (before, after) = (edge(k + n - 1), edge(*k));
                cross(before, after).atan2(dot(before, after)) > SHARP
            })
            .collect();
        if corners.is_empty() {
            // The same on all four sides, so that a symmetric flow stays so.
            let count = 4 * (0.25 * length / spacing).ceil().max(1.0) as usize;
            self.spaced(line, 0, n, count, [area / count as f64; 2]);
            return;
        }
        for (number, from) in corners.iter().enumerate() {
            let to = corners.get(number + 1).copied().unwrap_or(corners[0] + n);
            let part: f64 = (*from..to).map(|k| size(edge(k))).sum();
            let count = (part / spacing).round().max(1.0) as usize;
            let share = area * part / length / count as f64;
            // The corner has half a segment of either side.
            let before = corners[(number + corners.len() - 1) % corners.len()];
            let back = if number == 0 { before..from + n } else { before..*from };
            let back: f64 = back.map(|k| size(edge(k))).sum();
            let other = area * back / length / (back / spacing).round().max(1.0);
            self.spaced(line, *from, to, count, [0.5 * (share + other), share]);
        }
    }

    /// `count` points at equal distances along the edges `from..to` of a line, from their first end on: the
    /// first one for the area `shares[0]`, the others for `shares[1]`.
    fn spaced(&mut self, line: &[[f64; 2]], from: usize, to: usize, count: usize, shares: [f64; 2]) {
        let n = line.len();
        let lengths: Vec<f64> = (from..to).map(|k| size(minus(line[(k + 1) % n], line[k % n]))).collect();
        let step = lengths.iter().sum::<f64>() / count as f64;
        let (mut k, mut passed) = (0, 0.0);
        for number in 0..count {
            let at = number as f64 * step;
            while k + 1 < lengths.len() && passed + lengths[k] <= at {
                passed += lengths[k];
                k += 1;
            }
            let (p, q) = (line[(from + k) % n], line[(from + k + 1) % n]);
            let part = if lengths[k] > 0.0 { (at - passed) / lengths[k] } else { 0.0 };
            self.arms.push([p[0] + part * (q[0] - p[0]), p[1] + part * (q[1] - p[1])]);
            self.areas.push(shares[usize::from(number > 0)]);
        }
    }

    /// Changes the areas by a factor a + b·r + c r² so that the body's own moments come out.
    fn balance(&mut self, outline: &Outline) {
        let reach = outline.reach();
        let terms = |arm: &[f64; 2]| {
            let [x, z] = arm.map(|r| r / reach);
            Vector4::new(1.0, x, z, x * x + z * z)
        };
        let mut matrix = Matrix4::zeros();
        for (arm, area) in self.arms.iter().zip(&self.areas) {
            let terms = terms(arm);
            matrix += terms * terms.transpose() * *area;
        }
        let area = outline.area();
        let wanted = Vector4::new(area, 0.0, 0.0, area * outline.gyration() / (reach * reach));
        // Points on a circle alone would have no inverse; there are two parallels at least.
        let Some(inverse) = matrix.try_inverse() else { return };
        let factors = inverse * wanted;
        for (arm, area) in self.arms.iter().zip(&mut self.areas) {
            *area *= terms(arm).dot(&factors);
        }
    }
}

/// Length of a closed line, m.
fn around(line: &[[f64; 2]]) -> f64 {
    (0..line.len()).map(|k| size(minus(line[(k + 1) % line.len()], line[k]))).sum()
}

/// Area within a closed line, m².
fn enclosed(line: &[[f64; 2]]) -> f64 {
    (0..line.len()).map(|k| 0.5 * cross(line[k], line[(k + 1) % line.len()])).sum()
}

/// The part of a convex polygon that lies `depth` and more below its surface; nothing if there is none.
fn inside(polygon: &[[f64; 2]], depth: f64) -> Vec<[f64; 2]> {
    let mut left = polygon.to_vec();
    for k in 0..polygon.len() {
        let (p, q) = (polygon[k], polygon[(k + 1) % polygon.len()]);
        let along = minus(q, p);
        let length = size(along);
        let above = |v: [f64; 2]| cross(along, minus(v, p)) / length - depth;
        let mut cut = Vec::with_capacity(left.len() + 1);
        for (j, v) in left.iter().enumerate() {
            let w = left[(j + 1) % left.len()];
            let (here, there) = (above(*v), above(w));
            if here >= 0.0 {
                cut.push(*v);
            }
            if (here >= 0.0) != (there >= 0.0) {
                let part = here / (here - there);
                cut.push([v[0] + part * (w[0] - v[0]), v[1] + part * (w[1] - v[1])]);
            }
        }
        left = cut;
    }
    left
}

/// Depth of the deepest point of a convex polygon, m.
fn depth(polygon: &[[f64; 2]]) -> f64 {
    let (mut low, mut high) = (0.0, around(polygon));
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if inside(polygon, middle).len() > 2 { low = middle } else { high = middle }
    }
    low
}

#[cfg(test)]
mod tests {
    use super::*;

    fn moments(points: &Points) -> [f64; 4] {
        let sum =
            |f: &dyn Fn(&[f64; 2]) -> f64| points.arms.iter().zip(&points.areas).map(|(r, a)| f(r) * a).sum();
        [sum(&|_| 1.0), sum(&|r| r[0]), sum(&|r| r[1]), sum(&|r| dot(*r, *r))]
    }

    #[test]
    fn area_centre_and_inertia_are_those_of_the_body() {
        let five = [[0.3, -0.4], [0.9, 0.1], [0.5, 0.8], [-0.2, 0.7], [-0.5, 0.0]];
        for outline in [
            Outline::rectangle([1.0, 1.0]),
            Outline::rectangle([4.0, 1.0]),
            Outline::polygon(&five).unwrap(),
            Outline::Ellipse { semi_axes: [1.0, 0.5] },
            Outline::Ellipse { semi_axes: [0.3, 1.2] },
        ] {
            for cells in [4.0, 5.3, 8.0, 16.0, 31.7] {
                let spacing = outline.thickness() / cells;
                let points = Points::of(&outline, spacing, 0.3 * spacing);
                let [area, x, z, second] = moments(&points);
                let (exact, reach) = (outline.area(), outline.reach());
                assert!((area / exact - 1.0).abs() < 1e-11, "{outline:?} {cells}: {area}");
                assert!(x.abs() + z.abs() < 1e-11 * area * reach, "{outline:?} {cells}");
                assert!((second / (exact * outline.gyration()) - 1.0).abs() < 1e-11, "{outline:?} {cells}");
                let (least, most) = points
                    .areas
                    .iter()
                    .fold((f64::INFINITY, 0.0_f64), |(least, most), a| (least.min(*a), most.max(*a)));
                let cell = spacing * spacing;
                assert!(
                    least > 0.2 * cell && most < 2.0 * cell,
                    "{outline:?} {cells}: {} {}",
                    least / cell,
                    most / cell
                );
                assert!(
                    points.arms.iter().all(|arm| outline.distance(*arm).0 < -0.28 * spacing),
                    "{outline:?} {cells}"
                );
            }
        }
    }

    #[test]
    fn an_ellipse_of_equal_axes_has_the_points_of_a_disc_but_for_where_they_begin() {
        let (spacing, radius) = (0.1, 0.5);
        let ellipse = Points::of(&Outline::Ellipse { semi_axes: [radius; 2] }, spacing, 0.3 * spacing);
        let disc = Points::disc(radius, spacing, 0.3 * spacing);
        assert_eq!(ellipse.arms.len(), disc.arms.len());
        let [one, other] = [&ellipse, &disc].map(moments);
        assert!((0..4).all(|k| (one[k] - other[k]).abs() < 1e-12));
    }
}
