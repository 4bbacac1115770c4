//! Metrics of granular columns and of the heaps that they leave.

use bedload_scene::{CheckedScene, Column, HeapEnd, HeapSlope, MetricKind, Motion, SceneError};

use super::accumulator::Accumulator;
use super::deposit::{Heap, Surface};
use super::last::LastState;
use super::rule::{Rule, plain, published, require};
use super::touching::{Ball, largest_cluster};
use crate::points::published_points;
use crate::totals::part_below;

/// The rule of metric `index`, which is about a column.
pub(super) fn rule(scene: &CheckedScene, index: usize) -> Result<Rule, SceneError> {
    round(scene, index)?;
    let kind = &scene.scene.metrics[index].kind;
    let column = kind.column().unwrap_or(Column::at_rest(1.0, 0.0));
    let rule = match kind {
        MetricKind::DepositRunOut(_) => Rule::of_last(move |last| {
            let_go(last.time, &column)?;
            let length = half_length(last, &column).ok_or("there is no heap at its middle")?;
            Ok((length - column.half_length) / column.half_length)
        }),
        MetricKind::DepositAspectRatio(_) => {
            standing(column, move |last| standing_height(last, &column) / column.half_length)
        }
        MetricKind::ColumnSolidFraction(_) => standing(column, move |last| solid_fraction(last, &column)),
        MetricKind::DepositProfileDifference(reference) => {
            let columns = "x_over_half_length and height_over_half_length";
            let published = published(scene, index, &reference.file, columns, |text| {
                let points = published_points(text, "x_over_half_length", "height_over_half_length")?;
                if points.len() < 2 {
                    return Err(format!("has {} points; two are needed", points.len()));
                }
                Ok(Surface::new(points.into_iter()))
            })?;
            let difference = move |heap: Heap| heap.surface(column.half_length).difference(&published);
            Rule::of_last(move |last| Ok(difference(heap(last, &column))))
        }
        MetricKind::DepositHeight(_) => Rule::of_last(move |last| {
            let_go(last.time, &column)?;
            Ok(heap(last, &column).height() / column.half_length)
        }),
        _ => Rule::unknown(),
    };
    Ok(rule.leaving("deposit.csv", move |last| Some(heap(last, &column).table(Some(column.half_length)))))
}

/// The rule of the slope of a heap.
pub(super) fn slope(
    scene: &CheckedScene,
    index: usize,
    HeapSlope { centre, bin, between }: HeapSlope,
) -> Result<Rule, SceneError> {
    round(scene, index)?;
    let heap = move |last: &LastState| heap(last, &Column { bin, ..Column::at_rest(1.0, centre) });
    let rule = Rule::of_last(move |last| heap(last).angle(between));
    Ok(Rule { unit: "deg".into(), ..rule }.leaving("heap.csv", move |last| Some(heap(last).table(None))))
}

/// Heaps are those of spheres and discs.
fn round(scene: &CheckedScene, index: usize) -> Result<(), SceneError> {
    let odd = scene.grains.iter().position(|grain| grain.motion == Motion::Free && !grain.shape.is_round());
    odd.map_or(Ok(()), |grain| {
        Err(scene.source.error(
            &format!("metrics[{index}].kind"),
            format!("is of a heap of spheres or discs, but grain {grain} is not round"),
            "take the columns `run_out` and `height` of series.csv, which go by outlines",
        ))
    })
}

/// A rule about a column as it is let go.
fn standing(column: Column, of: impl Fn(&LastState) -> f64 + Send + Sync + 'static) -> Rule {
    Rule::new(
        "-",
        Accumulator::First(None),
        move |seen, kept| {
            if let (Some(last), Accumulator::First(None)) = (seen.last, &kept)
                && last.time >= column.release
            {
                kept.add(of(last), seen.sample);
            }
        },
        move |kept, end| match kept.value() {
            Ok(value) => plain(value),
            Err(why) => let_go(end.last()?.time, &column).and(Err(why)),
        },
    )
}

/// An error if the column still stood at `time`, s.
fn let_go(time: f64, column: &Column) -> Result<(), String> {
    let Column { release, .. } = column;
    require(time >= *release, &format!("the run ended at t = {time} s, before `release`, {release} s"))
}

fn heap(last: &LastState, column: &Column) -> Heap {
    let mut balls = last.balls();
    let mean = balls.iter().map(|(_, radius)| radius).sum::<f64>() / balls.len().max(1) as f64;
    if column.end == HeapEnd::Contact {
        let mut belongs = largest_cluster(&balls, last.period).into_iter();
        balls.retain(|_| belongs.next() == Some(true));
    }
    let floor = column.floor.unwrap_or(last.floor);
    let place = |(x, radius): &Ball| [x[0] - column.centre, x[2] - floor, *radius];
    let grains: Vec<[f64; 3]> = balls.iter().map(place).collect();
    Heap::new(&grains, if column.bin > 0.0 { column.bin } else { 3.0 * mean })
}

/// L∞ of the heap as `column` says where it ends, m.
fn half_length(last: &LastState, column: &Column) -> Option<f64> {
    match column.end {
        HeapEnd::Gap => heap(last, column).half_length(),
        HeapEnd::Contact | HeapEnd::Outermost => heap(last, column).outermost(),
    }
}

/// H₀ of the standing column, m.
fn standing_height(last: &LastState, column: &Column) -> f64 {
    heap(last, column).mean_height(column.half_length)
}

/// Part of the standing column that grains fill, between a tenth and four fifths of its height; it is
/// as wide as its outermost grains, and as deep as the box (a disc fills its area).
fn solid_fraction(last: &LastState, column: &Column) -> f64 {
    let floor = column.floor.unwrap_or(last.floor);
    let balls = last.balls();
    let height = standing_height(last, column);
    let [low, high] = [0.1, 0.8].map(|part| floor + part * height);
    let edge = |side: f64| balls.iter().map(|(x, r)| side * x[0] + r).fold(f64::NEG_INFINITY, f64::max);
    let solid: f64 = balls.iter().map(|(x, r)| slab(*r, low - x[2], high - x[2], last.depth)).sum();
    solid / ((edge(1.0) + edge(-1.0)) * last.depth.unwrap_or(1.0) * (high - low))
}

/// Volume of a sphere of radius `r` between the heights `low` and `high` above its centre, m³; without a
/// `depth` the area of a disc, m².
fn slab(r: f64, low: f64, high: f64, depth: Option<f64>) -> f64 {
    let whole = std::f64::consts::PI * depth.map_or(r * r, |_| 4.0 / 3.0 * r.powi(3));
    whole * (part_below(high / r, depth.is_none()) - part_below(low / r, depth.is_none()))
}

#[cfg(test)]
mod tests {
    use super::slab;
    use std::f64::consts::PI;

    #[test]
    fn slabs_add_up_to_the_whole() {
        for (depth, whole) in [(Some(1.0), 4.0 / 3.0 * PI * 8.0), (None, PI * 4.0)] {
            assert!((slab(2.0, -9.0, 9.0, depth) - whole).abs() < 1e-12);
            assert!((slab(2.0, 0.0, 9.0, depth) - 0.5 * whole).abs() < 1e-12);
            let parts = slab(2.0, -2.0, 0.7, depth) + slab(2.0, 0.7, 2.0, depth);
            assert!((parts - whole).abs() < 1e-12);
            assert_eq!(slab(2.0, 3.0, 4.0, depth), 0.0);
        }
    }
}
