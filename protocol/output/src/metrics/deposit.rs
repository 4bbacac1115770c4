//! The heap that a granular column leaves: profile, half-length, height, and its difference from a
//! published profile.

use std::fmt::Write;

use super::line::{Line, interpolate};

/// Most bins on either side: what has flown further off lies in the outermost one.
const MOST_BINS: f64 = 1e6;

/// Profile of a heap over bins along x.
#[derive(Clone, Debug)]
pub(super) struct Heap {
    bin: f64,
    /// Number of bins left of the middle.
    left: usize,
    /// Topmost surface in each bin, m; zero where it is empty.
    top: Vec<f64>,
    /// Outermost surface in each bin: largest |x| + R, m.
    reach: Vec<f64>,
}

impl Heap {
    /// Of grains given by x from the middle, z above the floor, and radius.
    pub(super) fn new(grains: &[[f64; 3]], bin: f64) -> Self {
        let farthest = grains.iter().map(|[x, ..]| x.abs()).filter(|x| x.is_finite()).fold(0.0, f64::max);
        let left = (farthest / bin).floor().min(MOST_BINS) as usize + 1;
        let mut heap = Self { bin, left, top: vec![0.0; 2 * left], reach: vec![0.0; 2 * left] };
        for [x, z, radius] in grains.iter().filter(|grain| grain.iter().all(|value| value.is_finite())) {
            let place = ((x / bin).floor() + left as f64) as usize;
            let place = place.min(2 * left - 1);
            heap.top[place] = heap.top[place].max(z + radius);
            heap.reach[place] = heap.reach[place].max(x.abs() + radius);
        }
        heap
    }

    /// Filled bins from the middle outward, right and left, up to the first two empty ones in a row:
    /// what lies beyond (3 d by default) is no part of the heap.
    fn sides(&self) -> [Vec<usize>; 2] {
        let walk = |places: &mut dyn Iterator<Item = usize>| {
            let (mut side, mut empty) = (Vec::new(), 0);
            for place in places {
                empty = if self.top[place] > 0.0 { 0 } else { empty + 1 };
                match empty {
                    0 => side.push(place),
                    1 => {}
                    _ => break,
                }
            }
            side
        };
        [walk(&mut (self.left..self.top.len())), walk(&mut (0..self.left).rev())]
    }

    /// Mean of the half-lengths to both sides, or of the one that there is.
    pub(super) fn half_length(&self) -> Option<f64> {
        self.mean_reach(&self.sides())
    }

    /// The same of the outermost grains to both sides, apart from the heap or not.
    pub(super) fn outermost(&self) -> Option<f64> {
        let filled = |places: std::ops::Range<usize>| places.filter(|p| self.top[*p] > 0.0).collect();
        self.mean_reach(&[filled(self.left..self.top.len()), filled(0..self.left)])
    }

    fn mean_reach(&self, sides: &[Vec<usize>; 2]) -> Option<f64> {
        let end = |side: &Vec<usize>| side.iter().map(|place| self.reach[*place]).fold(0.0, f64::max);
        let ends: Vec<f64> = sides.iter().filter(|side| !side.is_empty()).map(end).collect();
        (!ends.is_empty()).then(|| ends.iter().sum::<f64>() / ends.len() as f64)
    }

    /// Topmost surface of the heap, m.
    pub(super) fn height(&self) -> f64 {
        self.sides().iter().flatten().map(|place| self.top[*place]).fold(0.0, f64::max)
    }

    /// Angle of the surface, degrees: a straight line through each flank between two parts of the height,
    /// mean over the flanks that have three bins there.
    pub(super) fn angle(&self, between: [f64; 2]) -> Result<f64, String> {
        let [low, high] = between.map(|part| part * self.height());
        let slope = |side: &Vec<usize>| {
            let foot = side.iter().position(|place| self.top[*place] < low).unwrap_or(side.len());
            let flank: Vec<usize> =
                side[..foot].iter().copied().filter(|place| self.top[*place] <= high).collect();
            let mut line = Line::new(f64::NEG_INFINITY, f64::INFINITY);
            for &place in &flank {
                line.add(self.middle(place).abs(), 1.0, self.top[place]);
            }
            (flank.len() >= 3).then(|| line.fit().ok()).flatten().map(|(_, slope)| slope)
        };
        let slopes: Vec<f64> = self.sides().iter().filter_map(slope).collect();
        if slopes.is_empty() {
            return Err("no flank of the heap has three bins; take smaller bins or more grains".into());
        }
        let angles = slopes.iter().map(|slope| (-slope).atan().to_degrees());
        Ok(angles.sum::<f64>() / slopes.len() as f64)
    }

    /// Mean of the surface over the bins whose middle is nearer than `within`, m. A side without any grain
    /// is no part of the column: it stands against a wall.
    pub(super) fn mean_height(&self, within: f64) -> f64 {
        let stands = |place: &usize| {
            let side = if *place < self.left { 0..self.left } else { self.left..self.top.len() };
            self.top[side].iter().any(|top| *top > 0.0)
        };
        let inside = (0..self.top.len()).filter(|place| self.middle(*place).abs() < within).filter(stands);
        let inside: Vec<f64> = inside.map(|place| self.top[place]).collect();
        inside.iter().sum::<f64>() / inside.len().max(1) as f64
    }

    fn middle(&self, place: usize) -> f64 {
        (place as f64 - self.left as f64 + 0.5) * self.bin
    }

    /// Surface of the heap without what lies apart, in units of `half_length`.
    pub(super) fn surface(&self, half_length: f64) -> Surface {
        let places = self.sides().concat();
        Surface::new(places.iter().map(|p| (self.middle(*p) / half_length, self.top[*p] / half_length)))
    }

    /// The profile as CSV, also in units of the half-length of a column, m, where it was one.
    pub(super) fn table(&self, half_length: Option<f64>) -> String {
        let mut text = String::from("x,height");
        text.push_str(half_length.map_or("", |_| ",x_over_half_length,height_over_half_length"));
        for place in 0..self.top.len() {
            let (x, top) = (self.middle(place), self.top[place]);
            let _ = write!(text, "\n{x},{top}");
            if let Some(length) = half_length {
                let _ = write!(text, ",{},{}", x / length, top / length);
            }
        }
        text + "\n"
    }
}

/// Height of a heap against x, on straight lines between its points and zero beyond them.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Surface {
    points: Vec<(f64, f64)>,
}

impl Surface {
    /// Through `points`, in any order. Where there are some on one side of the middle alone, as in a table of
    /// half a heap, or of a heap at a wall, the other side is the same.
    pub(super) fn new(points: impl Iterator<Item = (f64, f64)>) -> Self {
        let mut points: Vec<(f64, f64)> = points.collect();
        let is_one_sided = points.iter().all(|(x, _)| *x >= 0.0) || points.iter().all(|(x, _)| *x <= 0.0);
        if is_one_sided {
            points.extend(points.clone().into_iter().filter(|(x, _)| *x != 0.0).map(|(x, y)| (-x, y)));
        }
        points.sort_by(|a, b| a.0.total_cmp(&b.0));
        Self { points }
    }

    fn at(&self, x: f64) -> f64 {
        let after = self.points.partition_point(|(place, _)| *place <= x);
        if after == 0 || after == self.points.len() {
            return 0.0;
        }
        interpolate(x, self.points[after - 1], self.points[after])
    }

    /// Mean of both sides at the distance `x` from the middle.
    fn mean(&self, x: f64) -> f64 {
        0.5 * (self.at(x) + self.at(-x))
    }

    /// Farthest point above zero.
    fn reach(&self) -> f64 {
        self.points.iter().filter(|(_, y)| *y > 0.0).map(|(x, _)| x.abs()).fold(0.0, f64::max)
    }

    /// Root mean square of the difference between the means of both sides, from the middle to where
    /// both surfaces have ended.
    pub(super) fn difference(&self, other: &Self) -> f64 {
        let end = self.reach().max(other.reach());
        let place = |sample: u32| end * (f64::from(sample) + 0.5) / f64::from(SAMPLES);
        let square = |x: f64| (self.mean(x) - other.mean(x)).powi(2);
        ((0..SAMPLES).map(|sample| square(place(sample))).sum::<f64>() / f64::from(SAMPLES)).sqrt()
    }
}

/// Points at which two surfaces are compared: more than a profile has bins.
const SAMPLES: u32 = 2000;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_slope_of_a_heap_is_found_between_foot_and_top() {
        let side = |tan: f64| {
            let mut grains = Vec::new();
            for k in -200..=200 {
                let x = 0.05 * f64::from(k);
                // a rounded top, and a foot one grain high that runs out
                grains.push([x, (4.0 - tan * x.abs()).clamp(0.1, 3.4), 0.1]);
            }
            Heap::new(&grains, 0.3).angle([0.2, 0.8]).unwrap()
        };
        for degrees in [15.0f64, 25.0, 35.0] {
            let found = side(degrees.to_radians().tan());
            assert!((found - degrees).abs() < 0.6, "{found} instead of {degrees}");
        }
        assert!(Heap::new(&[[0.0, 0.1, 0.1]], 0.3).angle([0.2, 0.8]).is_err());
    }

    #[test]
    fn grains_that_lie_apart_are_no_part_of_the_heap() {
        let r = 0.5;
        let mut grains: Vec<[f64; 3]> = (-10..=10).map(|k| [f64::from(k), r, r]).collect();
        grains.extend((-4..=4).map(|k| [f64::from(k), 1.5, r]));
        let heap = Heap::new(&grains, 1.5);
        assert_eq!(heap.half_length(), Some(10.5));
        assert_eq!(heap.height(), 2.0);
        assert_eq!(heap.mean_height(2.0), 2.0);
        grains.push([40.0, r, r]);
        assert_eq!(Heap::new(&grains, 1.5).half_length(), Some(10.5), "one rolled away");
        grains.push([12.5, r, r]);
        assert_eq!(Heap::new(&grains, 1.5).half_length(), Some(11.75), "one bin apart still belongs");
        grains.pop();
        let one_sided: Vec<[f64; 3]> = grains.into_iter().filter(|[x, ..]| *x >= 0.0).collect();
        assert_eq!(Heap::new(&one_sided, 1.5).half_length(), Some(10.5));
        assert_eq!(Heap::new(&[], 1.5).half_length(), None);
        assert!(heap.table(Some(5.0)).lines().count() > 13);
    }

    #[test]
    fn the_outermost_grain_counts_wherever_it_lies() {
        let heap = Heap::new(&[[0.0, 0.5, 0.5], [-1.0, 0.5, 0.5], [40.0, 0.5, 0.5]], 1.5);
        assert_eq!(
            (heap.half_length(), heap.outermost()),
            (Some((0.5 + 1.5) / 2.0), Some((40.5 + 1.5) / 2.0))
        );
    }

    #[test]
    fn two_triangles_differ_by_the_integral_of_their_difference() {
        // the surface ends at its last point above zero
        let triangle = |end: f64| Surface::new([(-end, 1e-9), (0.0, 1.0), (end, 1e-9)].into_iter());
        let (narrow, wide) = (triangle(1.0), triangle(2.0));
        assert_eq!(narrow.difference(&narrow), 0.0);
        // ∫₀¹ (x/2)² dx + ∫₁² (1 − x/2)² dx = 1/12 + 1/12, over a length of 2
        let exact = (1.0_f64 / 12.0).sqrt();
        assert!((narrow.difference(&wide) - exact).abs() < 1e-5, "{}", narrow.difference(&wide));
        // half of it says the same
        let half = Surface::new([(2.0, 1e-9), (0.0, 1.0)].into_iter());
        assert_eq!((wide.difference(&half), half.difference(&wide)), (0.0, 0.0));
        // only the mean of both sides counts
        let leaning = Surface::new([(-2.0, 1e-9), (-1.0, 1.0), (0.0, 1.0), (1.0, 0.0)].into_iter());
        let upright =
            Surface::new([(-2.0, 0.0), (-1.0, 0.5), (0.0, 1.0), (1.0, 0.5), (2.0, 0.0)].into_iter());
        assert!(leaning.difference(&upright) < 1e-8);
    }
}
