//! Collocation points of a body: where they lie in it and which part of it each stands for.

use std::f64::consts::{PI, TAU};

/// Points of one body about its centre.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Points {
    /// Places from the centre (first two axes of the grid), m.
    pub(super) arms: Vec<[f64; 2]>,
    /// Area that each stands for, m².
    pub(super) areas: Vec<f64>,
}

impl Points {
    /// Rings in a disc of radius `radius`, `spacing` apart, the outermost `inset` below the surface. Area and
    /// moment of inertia of the disc come out exactly.
    pub(super) fn disc(radius: f64, spacing: f64, inset: f64) -> Self {
        let outermost = radius - inset;
        let count = ((outermost / spacing - 0.5).floor() as usize + 1).max(3);
        let radii: Vec<f64> = (0..count).map(|k| outermost - k as f64 * spacing).collect();
        let last = radii[count - 1] + 0.5 * spacing;
        let mut areas: Vec<f64> = radii.iter().map(|r| TAU * r * spacing).collect();
        // The innermost ring stands for all that it surrounds.
        areas[count - 1] = PI * last * last;
        // The two outer rings take what is missing of area and moment of inertia.
        let moment: f64 = radii[2..].iter().zip(&areas[2..]).map(|(r, area)| area * r * r).sum();
        let area = PI * radius * radius - areas[2..].iter().sum::<f64>();
        let inertia = 0.5 * PI * radius.powi(4) - moment;
        let (outer, inner) = (radii[0] * radii[0], radii[1] * radii[1]);
        areas[0] = (inertia - area * inner) / (outer - inner);
        areas[1] = area - areas[0];
        let mut points = Self::default();
        for (ring, (r, area)) in radii.iter().zip(areas).enumerate() {
            // The same on all four sides, so that a symmetric flow stays so.
            let count = 4 * (0.25 * TAU * r / spacing).ceil() as usize;
            for k in 0..count {
                // Rings are turned against each other.
                let angle = TAU * (k as f64 + 0.5 * (ring % 2) as f64) / count as f64;
                points.arms.push([r * angle.cos(), r * angle.sin()]);
                points.areas.push(area / count as f64);
            }
        }
        points
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_disc_has_its_area_and_its_moment_of_inertia() {
        for cells in [5.0, 8.0, 16.3, 40.0] {
            let radius = 0.5;
            let spacing = 2.0 * radius / cells;
            let points = Points::disc(radius, spacing, 0.3 * spacing);
            let area: f64 = points.areas.iter().sum();
            let inertia: f64 = points
                .arms
                .iter()
                .zip(&points.areas)
                .map(|(a, area)| area * (a[0] * a[0] + a[1] * a[1]))
                .sum();
            assert!((area / (PI * radius * radius) - 1.0).abs() < 1e-12);
            assert!((inertia / (0.5 * PI * radius.powi(4)) - 1.0).abs() < 1e-12);
            assert!(
                points.areas.iter().all(|area| *area > 0.0 && *area < 1.5 * spacing * spacing),
                "{cells}"
            );
            let first: [f64; 2] =
                [0, 1].map(|a| points.arms.iter().zip(&points.areas).map(|(p, w)| p[a] * w).sum());
            assert!(first.iter().all(|m| m.abs() < 1e-12));
        }
    }
}
