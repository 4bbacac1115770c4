//! What `check` refuses, as a region of a map: columns of sampled values, and the step around them.

use super::axis::Axis;

/// What the bound says at a sampled point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Cell {
    pub(super) refused: bool,
    pub(super) margin: f64,
}

/// A refused part of a column, in places 0 to 1 of both axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Strip {
    pub(super) x: (f64, f64),
    pub(super) y: (f64, f64),
}

/// A straight piece of the line around what is refused: from, to.
pub(super) type Piece = ((f64, f64), (f64, f64));

/// The sampled points of a map, by number of x, then of y.
pub(super) struct Region<'a> {
    pub(super) x: &'a Axis,
    pub(super) y: &'a Axis,
    pub(super) cells: Vec<Vec<Option<Cell>>>,
}

impl Region<'_> {
    /// Refused parts, column by column.
    pub(super) fn strips(&self) -> Vec<Strip> {
        let columns = (0..self.x.len()).map(|i| (i, self.intervals(i)));
        columns
            .flat_map(|(i, parts)| {
                let x = (self.side(i), self.side(i + 1));
                parts.into_iter().map(move |y| Strip { x, y })
            })
            .collect()
    }

    /// The line between what is refused and what is accepted.
    pub(super) fn pieces(&self) -> Vec<Piece> {
        let mut pieces = Vec::new();
        let columns: Vec<Vec<(f64, f64)>> = (0..self.x.len()).map(|i| self.intervals(i)).collect();
        for (i, parts) in columns.iter().enumerate() {
            let (left, right) = (self.side(i), self.side(i + 1));
            for height in parts.iter().flat_map(|(low, high)| [*low, *high]) {
                if height > 0.0 && height < 1.0 {
                    pieces.push(((left, height), (right, height)));
                }
            }
            let Some(next) = columns.get(i + 1) else { continue };
            for (low, high) in difference(parts, next) {
                pieces.push(((right, low), (right, high)));
            }
        }
        pieces
    }

    fn cell(&self, i: usize, j: usize) -> Option<Cell> {
        self.cells[i][j]
    }

    fn refused(&self, i: usize, j: usize) -> bool {
        self.cell(i, j).is_some_and(|cell| cell.refused)
    }

    /// Refused intervals of y in column `i`, neighbours joined.
    fn intervals(&self, i: usize) -> Vec<(f64, f64)> {
        let mut parts: Vec<(f64, f64)> = Vec::new();
        for j in (0..self.y.len()).filter(|j| self.refused(i, *j)) {
            let (low, high) = (self.level(i, j), self.level(i, j + 1));
            match parts.last_mut().filter(|last| last.1 == low) {
                Some(last) => last.1 = high,
                None => parts.push((low, high)),
            }
        }
        parts
    }

    /// Between rows `j − 1` and `j` of column `i`.
    fn level(&self, i: usize, j: usize) -> f64 {
        if j == 0 || j == self.y.len() {
            return self.y.edge(j);
        }
        match (self.cell(i, j - 1), self.cell(i, j)) {
            (Some(below), Some(above)) if below.refused != above.refused => {
                self.y.crossing(j, below.margin, above.margin)
            }
            _ => self.y.edge(j),
        }
    }

    /// Between columns `i − 1` and `i`: where the bound is one on x alone, where it crosses.
    fn side(&self, i: usize) -> f64 {
        if i == 0 || i == self.x.len() {
            return self.x.edge(i);
        }
        let rows = 0..self.y.len();
        let pairs: Vec<(Cell, Cell)> =
            rows.filter_map(|j| Some((self.cell(i - 1, j)?, self.cell(i, j)?))).collect();
        let all_cross = pairs.iter().all(|(left, right)| left.refused != right.refused);
        match pairs.first() {
            Some((left, right)) if all_cross => self.x.crossing(i, left.margin, right.margin),
            _ => self.x.edge(i),
        }
    }
}

/// Where exactly one of two sets of intervals is.
fn difference(a: &[(f64, f64)], b: &[(f64, f64)]) -> Vec<(f64, f64)> {
    let mut ends: Vec<f64> = a.iter().chain(b).flat_map(|(low, high)| [*low, *high]).collect();
    ends.sort_by(f64::total_cmp);
    ends.dedup();
    let within = |set: &[(f64, f64)], at: f64| set.iter().any(|(low, high)| (*low..*high).contains(&at));
    ends.windows(2)
        .filter(|pair| {
            let middle = (pair[0] + pair[1]) / 2.0;
            within(a, middle) != within(b, middle)
        })
        .map(|pair| (pair[0], pair[1]))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A bound y ≥ limit(x) on a grid of 3 × 3 values 0.1, 1, 10.
    fn region<'a>(x: &'a Axis, y: &'a Axis, limit: [f64; 3]) -> Region<'a> {
        let value = |at: usize| [0.1, 1.0, 10.0][at];
        let cell = |i: usize, j: usize| {
            let margin = value(j) / limit[i];
            Some(Cell { refused: margin < 1.0, margin })
        };
        Region { x, y, cells: (0..3).map(|i| (0..3).map(|j| cell(i, j)).collect()).collect() }
    }

    #[test]
    fn the_step_stands_at_the_limit_and_closes() {
        let (x, y) = (Axis::new(["0.1", "1", "10"].into_iter()), Axis::new(["0.1", "1", "10"].into_iter()));
        let limit = [0.5, 0.5, 5.0];
        let region = region(&x, &y, limit);
        let strips = region.strips();
        assert_eq!(strips.len(), 3);
        let place = |value: f64| y.place(0) + (y.place(2) - y.place(0)) * (value / 0.1).log10() / 2.0;
        for (strip, limit) in strips.iter().zip(limit) {
            assert!((strip.y.1 - place(limit)).abs() < 1e-12 && strip.y.0 == 0.0, "{strip:?}");
        }
        // Three levels, and one riser between the second and the third column.
        let pieces = region.pieces();
        assert_eq!(pieces.len(), 4, "{pieces:?}");
        let riser = pieces.iter().find(|(from, to)| from.0 == to.0).unwrap();
        assert_eq!((riser.0.1, riser.1.1), (strips[1].y.1, strips[2].y.1));
    }

    #[test]
    fn a_bound_on_x_alone_is_an_upright_line_where_it_crosses() {
        let (x, y) = (Axis::new(["1", "2", "4"].into_iter()), Axis::new(["ab2", "rk3"].into_iter()));
        let cell = |i: usize| {
            let margin = 2.5 / [1.0, 2.0, 4.0][i];
            Some(Cell { refused: margin < 1.0, margin })
        };
        let region = Region { x: &x, y: &y, cells: (0..3).map(|i| vec![cell(i); 2]).collect() };
        let pieces = region.pieces();
        assert!(!pieces.is_empty() && pieces.iter().all(|(from, to)| from.0 == to.0));
        assert!(pieces[0].0.0 > x.place(1) && pieces[0].0.0 < x.place(2));
        assert_eq!(region.strips(), [Strip { x: (pieces[0].0.0, 1.0), y: (0.0, 1.0) }]);
    }

    #[test]
    fn nothing_refused_draws_nothing() {
        let (x, y) = (Axis::new(["1"].into_iter()), Axis::new(["1", "2"].into_iter()));
        let open = Region { x: &x, y: &y, cells: vec![vec![None; 2]] };
        assert!(open.strips().is_empty() && open.pieces().is_empty());
    }
}
