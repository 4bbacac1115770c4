//! Numbers that say how far a scene is from those that were charted.

use std::ops::RangeInclusive;

use crate::number::Short;

/// Part by which a scene's number may lie outside of the charted ones: rounding of what users type.
const LEEWAY: f64 = 0.02;

/// Which way from the charted numbers a chart still tells.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    Between,
    /// From the smallest on: with more of it there is less to resolve.
    FromSmallest,
    /// Up to the largest: with less of it there is less to resolve.
    UpToLargest,
}

/// One number of a scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Number {
    /// Symbol and meaning, for people.
    pub name: &'static str,
    /// Its value.
    pub value: f64,
    /// Which way from the charted values it may lie.
    pub side: Side,
}

/// Those numbers of a scene that lie outside of those of the charted runs, in words.
pub(super) fn outside(numbers: &[Number], charted: &[Vec<f64>]) -> Vec<String> {
    let check = |(place, number): (usize, &Number)| {
        let values = || charted.iter().filter_map(|run| run.get(place).copied());
        let (smallest, largest) =
            (values().fold(f64::INFINITY, f64::min), values().fold(f64::NEG_INFINITY, f64::max));
        let Number { name, value, side } = *number;
        let low = side != Side::UpToLargest && value < smallest - LEEWAY * smallest.abs();
        let high = side != Side::FromSmallest && value > largest + LEEWAY * largest.abs();
        let is_in = value.is_finite() && !low && !high;
        let (from, to) = (Short(smallest), Short(largest));
        let range = match side {
            Side::Between if smallest == largest => format!("at {from} alone"),
            Side::Between => format!("from {from} to {to}"),
            Side::FromSmallest => format!("from {from} on"),
            Side::UpToLargest => format!("up to {to}"),
        };
        (!is_in).then(|| format!("{name} is {}, charted {range}", Short(value)))
    };
    numbers.iter().enumerate().filter_map(check).collect()
}

/// Range that holds the charted values of the first number beside `value`: the largest below or at it, the
/// smallest above or at it, and what is the same as either but for rounding. What lies beyond the last has
/// that one alone.
pub(super) fn beside(value: f64, charted: impl Iterator<Item = f64> + Clone) -> RangeInclusive<f64> {
    let leeway = |value: f64| LEEWAY * value.abs();
    let below = charted.clone().filter(|c| *c <= value + leeway(value)).fold(f64::NEG_INFINITY, f64::max);
    let above = charted.filter(|c| *c >= value - leeway(value)).fold(f64::INFINITY, f64::min);
    let below = if below.is_finite() { below } else { above };
    let above = if above.is_finite() { above } else { below };
    below.min(above) - leeway(below)..=above.max(below) + leeway(above)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_number_is_inside_as_its_side_says() {
        let number = |value, side| [Number { name: "Ar", value, side }];
        let charted = [vec![10.0], vec![200.0]];
        let text = |value, side| outside(&number(value, side), &charted).first().cloned();
        assert_eq!(text(50.0, Side::Between), None);
        assert_eq!(text(203.0, Side::Between), None, "typed with two digits");
        assert_eq!(text(210.0, Side::Between).unwrap(), "Ar is 210, charted from 10 to 200");
        assert_eq!(text(1e9, Side::FromSmallest), None);
        assert_eq!(text(9.0, Side::FromSmallest).unwrap(), "Ar is 9, charted from 10 on");
        assert_eq!(text(1e-9, Side::UpToLargest), None);
        assert_eq!(text(300.0, Side::UpToLargest).unwrap(), "Ar is 300, charted up to 200");
        assert!(text(f64::NAN, Side::Between).is_some() && text(f64::INFINITY, Side::FromSmallest).is_some());
    }

    #[test]
    fn neighbours_stand_on_both_sides_and_with_all_that_equal_them_but_for_rounding() {
        let charted = [10.0, 9.999_985, 50.0, 200.0, 200.000_1];
        let of = |value| {
            let range = beside(value, charted.into_iter());
            charted.into_iter().filter(|c| range.contains(c)).collect::<Vec<_>>()
        };
        assert_eq!(of(20.0), [10.0, 9.999_985, 50.0]);
        assert_eq!([of(50.0), of(50.5), of(49.5)], [[50.0], [50.0], [50.0]]);
        assert_eq!([of(5.0), of(10.1), of(9.9), of(9.999_99)], [[10.0, 9.999_985]; 4].map(Vec::from));
        assert_eq!([of(300.0), of(203.0), of(198.0), of(200.0)], [[200.0, 200.000_1]; 4].map(Vec::from));
    }
}
