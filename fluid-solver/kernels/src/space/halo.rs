//! Halos of one plane at a time, while it is in the cache; the rules are those of
//! [`crate::boundary`].

use super::shape::Shape;
use crate::boundary::Boundary;
use std::ops::Range;

/// What stands beyond a wall for a tangential component: `shift + sign u`.
fn image(wall: Boundary<3>, d: usize) -> (f64, f64) {
    if d < 3 && wall.is_odd() { (2.0 * wall.velocity(d), -1.0) } else { (0.0, 1.0) }
}

/// Left and right halo of rows `rows` of component `d` (3: a scalar), and its wall faces.
#[inline(always)]
pub(super) fn fill_ends(shape: &Shape, d: usize, plane: &mut [f64], rows: Range<isize>) {
    let n = shape.n[0];
    let [low, high] = shape.walls[0];
    for j in rows {
        let at = shape.at(j);
        // The left halo of row −1 lies in another plane; nothing asks for it.
        let left = at.checked_sub(1);
        let row = &mut plane[at..=at + n];
        let (below, above) = if low.is_periodic() {
            (row[n - 1], row[0])
        } else if d == 0 {
            row[0] = 0.0;
            (-row[1], 0.0)
        } else {
            let ((a, b), (c, e)) = (image(low, d), image(high, d));
            (a + b * row[0], c + e * row[n - 1])
        };
        row[n] = above;
        if let Some(left) = left {
            plane[left] = below;
        }
    }
}

/// Ghost rows of component `d` (3: a scalar), and its wall rows; the ends of rows come first.
pub(super) fn fill_sides(shape: &Shape, d: usize, plane: &mut [f64]) {
    let n = shape.n[1] as isize;
    let [low, high] = shape.walls[1];
    if low.is_periodic() {
        copy_row(shape, plane, n - 1, -1, (0.0, 1.0));
        copy_row(shape, plane, 0, n, (0.0, 1.0));
    } else if d == 1 {
        copy_row(shape, plane, 0, 0, (0.0, 0.0));
        copy_row(shape, plane, n, n, (0.0, 0.0));
        copy_row(shape, plane, 1, -1, (0.0, -1.0));
    } else {
        copy_row(shape, plane, 0, -1, image(low, d));
        copy_row(shape, plane, n - 1, n, image(high, d));
    }
}

/// Row `to` ← shift + sign · row `from`, halos included (but for that left of row −1).
fn copy_row(shape: &Shape, plane: &mut [f64], from: isize, to: isize, (shift, sign): (f64, f64)) {
    let (from, to) = (shape.at(from), shape.at(to));
    let begin = usize::from(from > 0 && to > 0);
    let length = shape.n[0] + 1 + begin;
    let (from, to) = (from - begin, to - begin);
    if from < to {
        let (source, out) = plane.split_at_mut(to);
        image_row(shift, sign, &source[from..][..length], out);
    } else if to < from {
        let (out, source) = plane.split_at_mut(from);
        image_row(shift, sign, &source[..length], &mut out[to..]);
    } else {
        plane[to..][..length].iter_mut().for_each(|u| *u = shift + sign * *u);
    }
}

/// out = shift + sign x.
fn image_row(shift: f64, sign: f64, x: &[f64], out: &mut [f64]) {
    for (out, x) in out.iter_mut().zip(x) {
        *out = shift + sign * x;
    }
}

/// All halos of one plane.
pub(super) fn fill_plane(shape: &Shape, d: usize, plane: &mut [f64]) {
    fill_ends(shape, d, plane, 0..shape.n[1] as isize);
    fill_sides(shape, d, plane);
}

/// The plane of component `d` beyond the wall of side `side` across z, from the one inside it.
pub(super) fn beyond(shape: &Shape, d: usize, side: usize, inside: &[f64], out: &mut [f64]) {
    if d == 2 {
        // Above: the wall itself. Below: beyond the wall, asked for only to be left out.
        out.fill(0.0);
        return;
    }
    let (shift, sign) = image(shape.walls[2][side], d);
    for (out, inside) in out.iter_mut().zip(inside) {
        *out = shift + sign * inside;
    }
}
