//! Vectors of the plane: components x and z.

pub(crate) use bedload_outline::{dot, minus};

/// Components x and z.
pub(crate) type Vec2 = [f64; 2];

#[inline(always)]
pub(crate) fn plus(a: Vec2, b: Vec2) -> Vec2 {
    [a[0] + b[0], a[1] + b[1]]
}

/// a + s b.
#[inline(always)]
pub(crate) fn along(a: Vec2, b: Vec2, s: f64) -> Vec2 {
    [a[0] + s * b[0], a[1] + s * b[1]]
}

/// The vector a quarter turn on, from x to z.
#[inline(always)]
pub(crate) fn across(a: Vec2) -> Vec2 {
    [-a[1], a[0]]
}

/// Component along y of a × b, where y is the axis of spins.
#[inline(always)]
pub(crate) fn turning(a: Vec2, b: Vec2) -> f64 {
    a[1] * b[0] - a[0] * b[1]
}

#[inline(always)]
pub(crate) fn unit(a: Vec2) -> Vec2 {
    let length = dot(a, a).sqrt();
    [a[0] / length, a[1] / length]
}
