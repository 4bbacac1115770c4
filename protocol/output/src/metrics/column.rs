//! What a column of `series.csv` comes to: its mean, last or largest value, frequency, distance from a
//! published course, and Haff's law of a cooling granular gas (Haff 1983): the kinetic energy falls as
//! (1 + t/τ)⁻², a straight line in E^(−1/2).

use bedload_scene::{CheckedScene, MeanFrom, MetricKind, SceneError};

use super::accumulator::{Accumulator, Passages};
use super::course::Course;
use super::line::Line;
use super::rule::{Rule, plain, published, require};
use crate::columns::Columns;
use crate::sample::Sides;

/// The rule of metric `index`, which is about a column.
pub(super) fn rule(
    scene: &CheckedScene,
    index: usize,
    columns: &Columns,
    sides: Sides,
) -> Result<Rule, SceneError> {
    let kind = &scene.scene.metrics[index].kind;
    let keys = kind.keys();
    let name = keys.get("column").and_then(toml::Value::as_str).unwrap_or("kinetic_energy");
    let Some((place, unit)) = columns.find(name) else {
        if sees_all(scene, sides) {
            return Err(unknown_column(scene, columns, index, name));
        }
        let why = format!("this run has no column `{name}`");
        return Ok(Rule::at_end("-", move |_| Err(why.clone())));
    };
    let keeps = match kind {
        MetricKind::Mean(of) => match of.from {
            MeanFrom::Time(from) => Accumulator::mean(from, columns.when(place)),
            MeanFrom::Test(_) => Accumulator::stationary(columns.when(place)),
        },
        MetricKind::Deviation(of) => Accumulator::deviation(of.from, columns.when(place)),
        MetricKind::Max(of) => Accumulator::Largest { from: of.from, value: None },
        MetricKind::Frequency { from, level, .. } => Accumulator::Passages(Passages::of(*from, *level)),
        MetricKind::SeriesDifference { file, .. } => {
            Accumulator::Course(published(scene, index, file, "t and value", Course::parse)?)
        }
        MetricKind::HaffTime(span) | MetricKind::HaffMisfit(span) => {
            Accumulator::Line(Line::new(span.from, span.to))
        }
        MetricKind::Final { .. } => Accumulator::Last(None),
        _ => return Ok(Rule::unknown()),
    };
    let misfit = matches!(kind, MetricKind::HaffMisfit(_));
    // Over the time in which its grain is there.
    let (inserted, present) = (columns.inserted(place), scene.present());
    let late = move |why: String| match inserted {
        Some(grain) => format!("{why}; grain {grain} is there once it is inserted"),
        None => why,
    };
    let unit = match kind {
        MetricKind::Frequency { .. } => "1/s",
        MetricKind::HaffTime(_) => "s",
        MetricKind::HaffMisfit(_) => "-",
        _ => unit,
    };
    Ok(Rule::new(
        unit,
        keeps,
        move |seen, kept| {
            if inserted.is_some_and(|grain| seen.sample.lacks(grain, present)) {
                return;
            }
            let (value, line) = (seen.row[place], matches!(kept, Accumulator::Line(_)));
            kept.add(if line { value.sqrt().recip() } else { value }, seen.sample);
        },
        move |kept, _| match kept {
            Accumulator::Line(line) if misfit => plain(line.misfit()?),
            Accumulator::Line(line) => {
                let (start, slope) = line.fit()?;
                require(slope > 0.0, "the kinetic energy does not fall")?;
                plain(start / slope)
            }
            Accumulator::Course(course) if !course.is_whole() => {
                Ok((course.value()?, Some("of the part of the table that the run reached".into())))
            }
            Accumulator::Stationary { series, .. } => {
                series.estimate().map(|found| (found.mean, Some(found.note())))
            }
            _ => plain(kept.value().map_err(&late)?),
        },
    ))
}

/// Does the run see everything that the scene has?
fn sees_all(scene: &CheckedScene, sides: Sides) -> bool {
    let loads = sides.loads || scene.scene.medium.is_none() || scene.grains.is_empty();
    let contact = sides.contact || !scene.has_free_grains();
    loads && contact
}

fn unknown_column(scene: &CheckedScene, columns: &Columns, index: usize, name: &str) -> SceneError {
    scene.source.error(
        &format!("metrics[{index}].column"),
        format!("is `{name}`; the columns of this run are {}", columns.names().join(", ")),
        "name one of them; grains need a place in observe.grains to have columns",
    )
}
