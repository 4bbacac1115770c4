//! The error of the drag that cells leave, from the chart of a sphere that is towed over the grid.

use bedload_scene::{Geometry, Motion};
use protocol::facts::Side;
use serde::{Deserialize, Serialize};
use toml::Value;

use super::bound::Bound;
use super::facts::Facts;
use crate::keys;
use crate::number::{Short, rounded};
use crate::resolution;

/// Error of the drag above which a plan warns.
const MOST: f64 = 0.05;

/// Error for which a refinement is named.
const AIM: f64 = 0.03;

/// Grids whose D/Δx differ by no more are places of one grid: R/Δr then goes over a whole cell.
const PLACES: f64 = 1.0 + 1e-6;

/// The chart, as `drag.toml` has it: a test of the studies makes it from docs/charts/towed-sphere.csv.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct DragChart {
    /// Table of the chart.
    pub table: String,
    /// Why the table is stale: what a sample of it gives with the build. None: the build gives what it holds.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub stale: Option<String>,
    /// Charted grids, by Reynolds number and then D/Δx.
    pub grids: Vec<DragGrid>,
}

/// What was measured on a grid and those beside it, at one Reynolds number.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct DragGrid {
    /// U D/ν.
    pub reynolds: f64,
    /// D/Δx.
    pub resolution: f64,
    /// Over the places.
    #[serde(flatten)]
    pub error: DragError,
}

/// Relative error of the drag, its sign left out, over the places of the surface on the grid.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize)]
pub struct DragError {
    /// Mean.
    pub mean: f64,
    /// Of the best place.
    pub least: f64,
    /// Of the worst place.
    pub most: f64,
    /// Number of places.
    pub places: usize,
}

impl DragError {
    /// A part of the way to another one.
    fn toward(self, other: Self, part: f64) -> Self {
        let between = |low: f64, high: f64| low + part * (high - low);
        Self {
            mean: between(self.mean, other.mean),
            least: between(self.least, other.least),
            most: between(self.most, other.most),
            places: self.places.min(other.places),
        }
    }
}

impl std::fmt::Display for DragError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let percent = |error: f64| Short(rounded(100.0 * error, 2));
        match self.places {
            1 => write!(f, "{} % (one place on the grid)", percent(self.mean)),
            _ => write!(
                f,
                "{} % ({} to {} % by the place on the grid)",
                percent(self.mean),
                percent(self.least),
                percent(self.most)
            ),
        }
    }
}

impl DragChart {
    /// The file.
    pub const TEXT: &str = include_str!("drag.toml");

    /// From its text.
    pub fn parse(text: &str) -> Result<Self, String> {
        toml::from_str(text).map_err(|error| error.to_string())
    }

    /// From rows of Reynolds number, D/Δx and error, in any order; several of one grid, or beside it, are its
    /// places.
    pub fn new(table: &str, stale: Option<String>, rows: &[[f64; 3]]) -> Self {
        let mut grids: Vec<[f64; 2]> = rows.iter().map(|[re, n, _]| [*re, *n]).collect();
        grids.sort_by(|a, b| a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1])));
        grids.dedup();
        let measured = |[reynolds, resolution]: [f64; 2]| {
            let beside = rows.iter().filter(|[re, n, _]| *re == reynolds && (n - resolution).abs() <= PLACES);
            let places: Vec<f64> = beside.map(|[_, _, error]| *error).collect();
            let error = DragError {
                mean: places.iter().sum::<f64>() / places.len() as f64,
                least: places.iter().copied().fold(f64::INFINITY, f64::min),
                most: places.iter().copied().fold(0.0, f64::max),
                places: places.len(),
            };
            DragGrid { reynolds, resolution, error }
        };
        let grids = grids.into_iter().map(measured).collect();
        Self { table: table.to_owned(), stale, grids }
    }

    /// At a Reynolds number and D/Δx, along straight lines between charted ones; beyond, what was charted.
    pub fn at(&self, reynolds: f64, resolution: f64) -> Result<DragError, String> {
        let mut levels: Vec<f64> = self.grids.iter().map(|grid| grid.reynolds).collect();
        levels.dedup();
        let (low, high, part) =
            around(&levels, reynolds).ok_or_else(|| format!("charted is Re = {}", range(&levels)))?;
        Ok(self.along(levels[low], resolution)?.toward(self.along(levels[high], resolution)?, part))
    }

    /// At a charted Reynolds number.
    fn along(&self, reynolds: f64, resolution: f64) -> Result<DragError, String> {
        let grids: Vec<&DragGrid> = self.grids.iter().filter(|grid| grid.reynolds == reynolds).collect();
        let cells: Vec<f64> = grids.iter().map(|grid| grid.resolution).collect();
        let (low, high, part) = around(&cells, resolution)
            .ok_or_else(|| format!("charted is D/Δx = {} at Re = {}", range(&cells), Short(reynolds)))?;
        Ok(grids[low].error.toward(grids[high].error, part))
    }

    /// Least whole D/Δx from which on the mean error is at most `most`; none where the finest grid has more.
    pub fn needed(&self, reynolds: f64, most: f64) -> Option<u64> {
        let finest = self.grids.iter().map(|grid| grid.resolution).fold(0.0, f64::max) as u64;
        let known = (1..=finest).rev().filter_map(|n| Some((n, self.at(reynolds, n as f64).ok()?.mean)));
        known.take_while(|(_, mean)| *mean <= most).last().map(|(n, _)| n)
    }
}

/// The rising `values` on both sides of `x`, and the part of the way to the second; none beyond them.
fn around(values: &[f64], x: f64) -> Option<(usize, usize, f64)> {
    let high = values.iter().position(|value| *value >= x)?;
    if values[high] == x {
        return Some((high, high, 0.0));
    }
    let low = high.checked_sub(1)?;
    Some((low, high, (x - values[low]) / (values[high] - values[low])))
}

/// First and last of rising values.
fn range(values: &[f64]) -> String {
    let end = |value: Option<&f64>| value.map_or("none".to_owned(), |value| Short(*value).to_string());
    format!("{} to {}", end(values.first()), end(values.last()))
}

/// What the chart says of a scene.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Drag {
    /// U D/ν of the scene's fastest and largest grain, U estimated from above.
    pub reynolds: f64,
    /// D/Δx of its thinnest grain.
    pub resolution: f64,
    /// Relative error of the drag; none outside of what was charted.
    pub error: Option<DragError>,
    /// D/Δx that leaves 3 %; none outside of what was charted, and where no charted grid does.
    pub needed: Option<u64>,
    /// All of it in words.
    pub said: String,
}

/// What the chart says of a scene whose grains our fluid drags with its default method; none where they do
/// not move against it as far as the scene says.
pub(crate) fn of(facts: &Facts<'_>) -> Option<Drag> {
    // What a cell does to a grain was measured with our fluid; another one may have none.
    facts.fluid.filter(|fluid| !fluid.foreign)?;
    let scene = facts.scene;
    let method = keys::look_up(scene, keys::METHOD).and_then(Value::as_str).unwrap_or(keys::CALIBRATED);
    if method != keys::CALIBRATED {
        return None;
    }
    let chart = DragChart::parse(DragChart::TEXT).ok()?;
    let resolution = rounded(resolution::of(scene)?, 6);
    let reynolds = rounded(reynolds(facts)?, 6);
    let found = chart.at(reynolds, resolution);
    let needed = chart.needed(reynolds, AIM);
    let (axisymmetric, alone) =
        (scene.scene.domain.geometry == Geometry::Axisymmetric, scene.grains.len() == 1);
    let nearest = match (axisymmetric, alone) {
        (true, true) => "",
        (_, true) => ", the nearest that is charted",
        _ => ", the nearest that is charted; grains close together have more",
    };
    let of = format!("of a sphere alone in r-z{nearest}");
    let stale = chart.stale.as_ref().map_or(String::new(), |_| format!("; {} is stale", chart.table));
    let (re, n) = (Short(reynolds), Short(resolution));
    let said = match &found {
        Ok(error) => format!("{error} at Re = {re}, D/Δx = {n}: {of}{stale}"),
        Err(charted) => format!("not known at Re = {re}, D/Δx = {n}: {charted}, {of}"),
    };
    Some(Drag { reynolds, resolution, error: found.ok(), needed, said })
}

impl Drag {
    /// Its bound; none outside of what was charted.
    pub(super) fn bound(&self) -> Option<Bound> {
        let bound = Bound::new("drag-accuracy", "error of drag", self.error?.mean, Side::AtMost, MOST);
        let aim = Short(100.0 * AIM);
        let remedy = match self.needed {
            Some(cells) => format!("D/Δx = {cells} leaves {aim} % at most"),
            None => format!("no charted grid leaves {aim} %"),
        };
        let why = format!("{}; {remedy}", self.said);
        let remedy = format!("refine domain.cells ({remedy}), or run with --accuracy 5% --verify");
        Some(bound.warning().because(why, "docs/charts.md, Drag of a sphere", remedy))
    }
}

/// Largest U D/ν of a grain against the fluid, as far as it follows from the scene: U is what it falls and is
/// thrown with, and for grains that are held or driven that of the fluid, too; 0 without convection. None
/// without grains, and where a flow alone moves them: how they lag behind it is not known.
fn reynolds(facts: &Facts<'_>) -> Option<f64> {
    let scene = facts.scene;
    let nu = scene.scene.medium.as_ref()?.kinematic_viscosity();
    let diameter = scene.grains.iter().map(|grain| 2.0 * grain.radius).reduce(f64::max)?;
    let held = scene.grains.iter().any(|grain| grain.motion != Motion::Free);
    let speed = facts.speeds.grain.max(if held { facts.speeds.flow } else { 0.0 });
    let convection = keys::look_up(scene, keys::CONVECTION).and_then(Value::as_bool).unwrap_or(true);
    (speed > 0.0).then(|| if convection { speed * diameter / nu } else { 0.0 })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Four places about D/Δx = 10 and one grid of 16 at Re = 0; one place each at Re = 100.
    fn chart() -> DragChart {
        let rows = [
            [100.0, 16.0, 0.02],
            [100.0, 10.0, 0.06],
            [0.0, 11.0, 0.04],
            [0.0, 9.5, 0.01],
            [0.0, 10.0, 0.02],
            [0.0, 10.5, 0.03],
            [0.0, 16.0, 0.005],
        ];
        DragChart::new("a.csv", None, &rows)
    }

    #[test]
    fn grids_beside_one_are_its_places() {
        let error = chart().at(0.0, 10.0).unwrap();
        assert!((error.mean - 0.025).abs() < 1e-15);
        assert_eq!((error.least, error.most, error.places), (0.01, 0.04, 4));
        // At D/Δx = 9.5 those of 9.5, 10 and 10.5.
        assert_eq!(chart().at(0.0, 9.5).unwrap().places, 3);
    }

    #[test]
    fn errors_lie_between_the_charted_ones_and_never_beyond_them() {
        let chart = chart();
        let error = chart.at(50.0, 10.0).unwrap();
        assert!((error.mean - 0.0425).abs() < 1e-15 && (error.most - 0.05).abs() < 1e-15, "{error:?}");
        assert_eq!(error.places, 1);
        let middle = chart.at(100.0, 13.0).unwrap().mean;
        assert!((middle - 0.04).abs() < 1e-15, "{middle}");
        assert_eq!(chart.at(100.1, 10.0).unwrap_err(), "charted is Re = 0 to 100");
        assert_eq!(chart.at(50.0, 9.5).unwrap_err(), "charted is D/Δx = 10 to 16 at Re = 100");
        assert!(chart.at(0.0, 16.1).is_err() && chart.at(0.0, 9.5).is_ok());
    }

    #[test]
    fn more_than_five_per_cent_warn_with_the_cells_for_three() {
        let drag = |mean, needed| Drag {
            reynolds: 155.0,
            resolution: 8.0,
            error: Some(DragError { mean, least: 0.01, most: 0.09, places: 4 }),
            needed,
            said: "x".into(),
        };
        let bound = drag(0.051, Some(12)).bound().unwrap();
        assert!(
            !bound.holds && !bound.refuses(&[]) && bound.why.contains("D/Δx = 12 leaves 3 %"),
            "{bound:?}"
        );
        assert!(drag(0.049, None).bound().unwrap().holds);
        assert!(drag(0.1, None).bound().unwrap().remedy.contains("no charted grid leaves 3 %"));
        assert_eq!(Drag { error: None, ..drag(0.1, None) }.bound(), None);
        assert_eq!(drag(0.051, None).error.unwrap().to_string(), "5.1 % (1 to 9 % by the place on the grid)");
    }

    #[test]
    fn the_cells_that_are_needed_keep_the_error_from_there_on() {
        // 0.06 at 10 and 0.02 at 16: 0.03 is at 14.5.
        assert_eq!(chart().needed(100.0, 0.03), Some(15));
        assert_eq!(chart().needed(100.0, 0.01), None);
        // 11 has the mean of 10 to 11, 0.03; nothing whole is charted below 10.
        assert_eq!(chart().needed(0.0, 0.031), Some(10));
        assert_eq!(chart().needed(101.0, 0.5), None);
    }
}
