//! Contours of a field on a rectilinear grid, by marching squares.

/// A field at points of a rectilinear grid: `values[k][i]` at (`x[i]`, `z[k]`).
pub(super) struct Field {
    pub(super) x: Vec<f64>,
    pub(super) z: Vec<f64>,
    pub(super) values: Vec<Vec<f64>>,
}

/// A piece of a contour.
pub(super) type Segment = [(f64, f64); 2];

impl Field {
    /// The contour of `level`. Each cell of four points gives at most two straight pieces, whose
    /// ends are interpolated linearly along the sides; a saddle is decided by the mean of its corners.
    pub(super) fn contour(&self, level: f64) -> Vec<Segment> {
        let mut segments = Vec::new();
        for k in 1..self.z.len() {
            for i in 1..self.x.len() {
                self.march(i, k, level, &mut segments);
            }
        }
        segments
    }

    fn march(&self, i: usize, k: usize, level: f64, segments: &mut Vec<Segment>) {
        // Corners and sides counter-clockwise from the lower left.
        let corners = [(i - 1, k - 1), (i, k - 1), (i, k), (i - 1, k)];
        let value = corners.map(|(i, k)| self.values[k][i]);
        if value.iter().any(|value| !value.is_finite()) {
            return;
        }
        let above = value.map(|value| value >= level);
        let crossing = |side: usize| {
            let (a, b) = (side, (side + 1) % 4);
            (above[a] != above[b]).then(|| {
                let part = (level - value[a]) / (value[b] - value[a]);
                let ((ia, ka), (ib, kb)) = (corners[a], corners[b]);
                (self.x[ia] + part * (self.x[ib] - self.x[ia]), self.z[ka] + part * (self.z[kb] - self.z[ka]))
            })
        };
        match [0, 1, 2, 3].map(crossing) {
            [Some(a), Some(b), Some(c), Some(d)] => {
                let middle = value.iter().sum::<f64>() / 4.0 >= level;
                // Cut off the corners that differ from the middle.
                let pairs = if middle == above[0] { [[a, b], [c, d]] } else { [[d, a], [b, c]] };
                segments.extend(pairs);
            }
            sides => {
                let mut ends = sides.into_iter().flatten();
                if let (Some(from), Some(to)) = (ends.next(), ends.next()) {
                    segments.push([from, to]);
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn field(value: impl Fn(f64, f64) -> f64) -> Field {
        // Uneven spacing, as on a stretched grid.
        let x: Vec<f64> = (0..60).map(|i| -1.5 + 3.0 * (f64::from(i) / 59.0).powf(1.2)).collect();
        let z: Vec<f64> = (0..50).map(|k| -1.5 + 3.0 * f64::from(k) / 49.0).collect();
        let values = z.iter().map(|z| x.iter().map(|x| value(*x, *z)).collect()).collect();
        Field { x, z, values }
    }

    #[test]
    fn a_plane_has_straight_contours() {
        let segments = field(|x, z| x + 2.0 * z).contour(0.3);
        assert!(segments.len() > 20);
        assert!(segments.iter().flatten().all(|(x, z)| (x + 2.0 * z - 0.3).abs() < 1e-12));
    }

    #[test]
    fn a_cone_has_circles_of_their_length() {
        let segments = field(|x, z| x.hypot(z)).contour(1.0);
        let length: f64 = segments.iter().map(|[a, b]| (a.0 - b.0).hypot(a.1 - b.1)).sum();
        assert!((length / std::f64::consts::TAU - 1.0).abs() < 2e-3, "{length}");
    }

    #[test]
    fn a_saddle_and_a_hole_do_no_harm() {
        let segments = field(|x, z| if x.hypot(z) < 0.2 { f64::NAN } else { x * z }).contour(0.0);
        assert!(segments.iter().flatten().all(|(x, z)| x.is_finite() && z.is_finite()));
        assert!(segments.len() > 50);
    }
}
