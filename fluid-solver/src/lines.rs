//! Velocity along lines, beside published tables: metrics of kind `velocity-difference`.

use crate::grid::Grid;
use crate::immersed::body::along_axes;
use crate::solver::Solver;
use bedload_output::{MetricValue, OutputFolder, atomic_write, points};
use protocol::participant::SolverError;
use protocol::scene::{Axis, CheckedScene, MetricKind, SceneError};
use std::collections::BTreeMap;
use std::fmt::Write as _;

/// A line with the table that it is compared with.
#[derive(Clone, Debug)]
pub struct Line {
    /// Name of the metric, and of the table that the run leaves.
    name: String,
    component: usize,
    along: usize,
    /// Name of the coordinate.
    letter: &'static str,
    through: [f64; 3],
    /// Coordinate and published velocity.
    table: Vec<(f64, f64)>,
    reference: Option<f64>,
    source: Option<String>,
}

/// The lines of a scene, their tables read.
///
/// # Errors
/// A table that cannot be read, naming its key.
pub fn of(scene: &CheckedScene) -> Result<Vec<Line>, SceneError> {
    let axes = scene.scene.domain.geometry.axes();
    let place = |axis: Axis| axes.iter().position(|known| *known == axis).unwrap_or(0);
    let mut lines = Vec::new();
    for (index, metric) in scene.scene.metrics.iter().enumerate() {
        let MetricKind::VelocityDifference { component, along, through, file, column } = &metric.kind else {
            continue;
        };
        let letter = match along {
            Axis::X => "x",
            Axis::Y => "y",
            Axis::Z => "z",
            Axis::R => "r",
        };
        let refuse = |what: String| {
            let remedy = "give a CSV file with a header; paths count from the scene's folder";
            scene.source.error(&format!("metrics[{index}].file"), what, remedy)
        };
        let text = std::fs::read_to_string(file)
            .map_err(|error| refuse(format!("is {}, which cannot be read: {error}", file.display())))?;
        let table = points(&text, letter, column)
            .map_err(|what| refuse(format!("is {}, which {what}", file.display())))?;
        lines.push(Line {
            name: metric.name.clone(),
            component: place(*component),
            along: place(*along),
            letter,
            through: *through,
            table,
            reference: metric.reference,
            source: metric.source.clone(),
        });
    }
    Ok(lines)
}

/// Measures every line and writes its profile to `<name>.csv`.
///
/// # Errors
/// [`SolverError`] if a table cannot be written.
pub fn finish<const D: usize>(
    solver: &mut Solver<D>,
    lines: &[Line],
    folder: &OutputFolder,
) -> Result<BTreeMap<String, MetricValue>, SolverError> {
    let mut values = BTreeMap::new();
    if lines.is_empty() {
        return Ok(values);
    }
    if !solver.show() {
        return Ok(values);
    }
    let grid = solver.grid();
    for line in lines {
        let u = &solver.stepper().state().velocity[line.component];
        let mut text = format!("{},velocity,reference\n", line.letter);
        let mut largest = 0.0_f64;
        for (at, published) in &line.table {
            let mut x: [f64; D] = along_axes(grid.geometry, line.through);
            x[line.along] = *at;
            let value = interpolate(grid, line.component, u, x);
            let _ = writeln!(text, "{at},{value},{published}");
            largest = largest.max((value - published).abs());
        }
        let path = folder.root().join(format!("{}.csv", line.name));
        atomic_write(&path, text.as_bytes()).map_err(|error| SolverError::Failed(error.to_string()))?;
        let value = MetricValue::measured(largest, "m/s", line.reference, line.source.clone());
        values.insert(line.name.clone(), value);
    }
    Ok(values)
}

/// Component `d` at `x`, linear between nodes along each axis; halos are filled, so walls count.
pub fn interpolate<const D: usize>(grid: &Grid<D>, d: usize, u: &[f64], x: [f64; D]) -> f64 {
    let mut first = [0; D];
    let mut share = [0.0; D];
    for a in 0..D {
        (first[a], share[a]) = between(grid, d, a, x[a]);
    }
    let start = grid.index(first);
    (0..1 << D).fold(0.0, |sum, corner: usize| {
        let (mut weight, mut at) = (1.0, start);
        for (a, share) in share.iter().enumerate() {
            let upper = corner >> a & 1 == 1;
            weight *= if upper { *share } else { 1.0 - share };
            at += if upper { grid.stride(a) } else { 0 };
        }
        sum + weight * u[at]
    })
}

/// Index of the node of component `d` at or below `x` along `axis`, from −1, and the share of the
/// next one. Beyond the box the nearest place in it counts.
fn between<const D: usize>(grid: &Grid<D>, d: usize, axis: usize, x: f64) -> (isize, f64) {
    let (faces, centres) = (&grid.axes[axis].faces, &grid.axes[axis].centres);
    let n = grid.cells[axis] as isize;
    let node = |i: isize| -> f64 {
        if d == axis {
            faces[i as usize]
        } else if i < 0 {
            2.0 * faces[0] - centres[0]
        } else if i >= n {
            2.0 * faces[n as usize] - centres[n as usize - 1]
        } else {
            centres[i as usize]
        }
    };
    let x = x.clamp(faces[0], faces[n as usize]);
    let lowest = if d == axis { 0 } else { -1 };
    let (mut low, mut high) = (lowest, n);
    while high - low > 1 {
        let middle = (low + high) / 2;
        if node(middle) <= x { low = middle } else { high = middle }
    }
    (low, (x - node(low)) / (node(low + 1) - node(low)))
}
