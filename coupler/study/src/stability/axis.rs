//! An axis of a map: the sampled values are its ticks.

/// Part of the axis that is left free at each end.
const MARGIN: f64 = 0.07;

/// From this ratio of largest to least on, the axis is logarithmic.
const DECADE: f64 = 9.0;

/// Values along an axis, in order, at places from 0 to 1.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Axis {
    /// As they stand in the table.
    texts: Vec<String>,
    places: Vec<f64>,
    spacing: Spacing,
}

/// What distances along an axis mean.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Spacing {
    /// Nothing: names.
    Names,
    Linear,
    Logarithmic,
}

impl Axis {
    /// An axis through all values that occur: numbers by size, names in order of appearance.
    pub(super) fn new<'a>(values: impl Iterator<Item = &'a str>) -> Self {
        let mut texts: Vec<String> = Vec::new();
        for text in values {
            if !texts.iter().any(|known| known == text) {
                texts.push(text.to_owned());
            }
        }
        let numbers: Option<Vec<f64>> =
            texts.iter().map(|text| text.parse().ok().filter(|value: &f64| value.is_finite())).collect();
        let Some(numbers) = numbers else {
            let heights: Vec<f64> = (0..texts.len()).map(|at| at as f64).collect();
            let places = spread(&heights, 0.5 / texts.len() as f64);
            return Self { texts, places, spacing: Spacing::Names };
        };
        let mut order: Vec<usize> = (0..texts.len()).collect();
        order.sort_by(|a, b| numbers[*a].total_cmp(&numbers[*b]));
        texts = order.iter().map(|at| texts[*at].clone()).collect();
        let (spacing, heights) = scaled(&order.iter().map(|at| numbers[*at]).collect::<Vec<_>>());
        Self { texts, places: spread(&heights, MARGIN), spacing }
    }

    /// Number of values.
    pub(super) fn len(&self) -> usize {
        self.texts.len()
    }

    /// A value as it stands in the table.
    pub(super) fn text(&self, at: usize) -> &str {
        &self.texts[at]
    }

    /// Number of a value.
    pub(super) fn find(&self, text: &str) -> Option<usize> {
        self.texts.iter().position(|known| known == text)
    }

    /// Place of a value, 0 to 1.
    pub(super) fn place(&self, at: usize) -> f64 {
        self.places[at]
    }

    /// Where the cell of value `at` begins, half-way from the value before; 0 for the first, 1 behind the
    /// last.
    pub(super) fn edge(&self, at: usize) -> f64 {
        match at {
            0 => 0.0,
            at if at == self.len() => 1.0,
            at => (self.places[at - 1] + self.places[at]) / 2.0,
        }
    }

    /// Between values `at − 1` and `at`: where a margin that is `before` at the one and `after` at the
    /// other is 1, on the axis as it is drawn; half-way where that cannot be told.
    pub(super) fn crossing(&self, at: usize, before: f64, after: f64) -> f64 {
        // A margin is value/limit or limit/value: the first is linear in the value and grows, of the
        // other its inverse; the logarithm of both is linear in that of the value.
        let height = |margin: f64| match self.spacing {
            Spacing::Logarithmic => margin.ln(),
            _ if before < after => margin,
            _ => 1.0 / margin,
        };
        let part = (height(1.0) - height(before)) / (height(after) - height(before));
        if self.spacing != Spacing::Names && (0.0..=1.0).contains(&part) {
            self.places[at - 1] + part * (self.places[at] - self.places[at - 1])
        } else {
            self.edge(at)
        }
    }

    /// Values that get a label, such that `room` (part of the axis) lies between neighbours: the first,
    /// the last, and what fits between.
    pub(super) fn labelled(&self, room: f64) -> Vec<usize> {
        let mut chosen: Vec<usize> = Vec::new();
        let last = self.len().saturating_sub(1);
        for at in 0..self.len() {
            let free = |other: usize| (self.places[at] - self.places[other]).abs() >= room;
            if at == 0 || at == last || (chosen.last().is_none_or(|other| free(*other)) && free(last)) {
                chosen.push(at);
            }
        }
        chosen
    }
}

/// Ascending numbers as heights: their logarithms where they span a decade.
fn scaled(numbers: &[f64]) -> (Spacing, Vec<f64>) {
    let spans = numbers.first().zip(numbers.last());
    if spans.is_some_and(|(least, most)| *least > 0.0 && most / least >= DECADE) {
        (Spacing::Logarithmic, numbers.iter().map(|value| value.ln()).collect())
    } else {
        (Spacing::Linear, numbers.to_vec())
    }
}

/// Ascending numbers over 0 to 1, with `margin` free at both ends.
fn spread(heights: &[f64], margin: f64) -> Vec<f64> {
    let (Some(least), Some(most)) = (heights.first(), heights.last()) else { return Vec::new() };
    let place = |height: &f64| {
        if most > least { margin + (1.0 - 2.0 * margin) * (height - least) / (most - least) } else { 0.5 }
    };
    heights.iter().map(place).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_sorted_and_spread_by_ratio_where_they_span_decades() {
        let axis = Axis::new(["1.0", "0.01", "0.1", "0.1"].into_iter());
        assert_eq!((axis.len(), axis.text(0), axis.find("1.0")), (3, "0.01", Some(2)));
        assert!((axis.place(1) - 0.5).abs() < 1e-12, "a tenth lies half-way: {}", axis.place(1));
        assert_eq!((axis.edge(0), axis.edge(3)), (0.0, 1.0));
        let linear = Axis::new(["1", "2", "3"].into_iter());
        assert!((linear.place(1) - 0.5).abs() < 1e-12);
        let names = Axis::new(["rk3", "ab2"].into_iter());
        assert_eq!((names.text(0), names.place(0), names.place(1)), ("rk3", 0.25, 0.75));
    }

    #[test]
    fn a_bound_crosses_where_its_margin_is_one() {
        let axis = Axis::new(["1", "100"].into_iter());
        // margin = value/10: at 1 it is 0.1, at 100 it is 10, so the limit 10 lies half-way.
        assert!((axis.crossing(1, 0.1, 10.0) - 0.5).abs() < 1e-12);
        assert!((axis.crossing(1, 1.0, 10.0) - axis.place(0)).abs() < 1e-12);
        assert_eq!(axis.crossing(1, f64::NAN, 10.0), axis.edge(1));
        assert_eq!(axis.crossing(1, 2.0, 10.0), axis.edge(1), "it does not cross");
        // The limit 2 on a linear axis from 1 to 5, from below and from above.
        let axis = Axis::new(["1", "5"].into_iter());
        let place = axis.place(0) + 0.25 * (axis.place(1) - axis.place(0));
        for (before, after) in [(0.5, 2.5), (2.0, 0.4)] {
            assert!((axis.crossing(1, before, after) - place).abs() < 1e-12);
        }
    }

    #[test]
    fn labels_keep_their_distance() {
        let axis = Axis::new(["1", "2", "2.1", "3", "10"].into_iter());
        assert_eq!(axis.labelled(0.0), [0, 1, 2, 3, 4]);
        assert_eq!(axis.labelled(0.1), [0, 1, 3, 4]);
        assert_eq!(axis.labelled(2.0), [0, 4]);
    }
}
