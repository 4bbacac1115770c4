//! Velocity along lines: beside published tables (`velocity-difference`), and behind grains (`wake-length`).

use crate::grid::Grid;
use crate::immersed::body::along_axes;
use crate::solver::Solver;
use bedload_output::{MetricValue, OutputFolder, published_points};
use bedload_scene::{Axis, CheckedScene, MetricKind, SceneError};
use protocol::participant::SolverError;
use std::collections::BTreeMap;
use std::fmt::Write as _;

/// How far beyond the box a coordinate of a table may lie, over the length of the box.
const ROUNDED: f64 = 1e-6;

/// A metric that the velocity on a line decides.
#[derive(Clone, Debug)]
pub struct Line {
    /// Name of the metric, and of the table that the run leaves.
    name: String,
    kind: Kind,
    reference: Option<f64>,
    source: Option<String>,
}

#[derive(Clone, Debug)]
enum Kind {
    Table(Table),
    Wake(Wake),
}

/// A line with the table that it is compared with.
#[derive(Clone, Debug)]
struct Table {
    component: usize,
    along: usize,
    /// Name of the coordinate.
    letter: String,
    through: [f64; 3],
    /// Coordinate and published velocity.
    rows: Vec<(f64, f64)>,
}

/// The line behind a grain.
#[derive(Clone, Debug)]
struct Wake {
    along: usize,
    /// Centre of the grain, m.
    centre: [f64; 3],
    /// How far its surface is from there downstream, m, and upstream.
    reach: [f64; 2],
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
        let line = |kind| Line {
            name: metric.name.clone(),
            kind,
            reference: metric.reference,
            source: metric.source.clone(),
        };
        if let MetricKind::WakeLength { grain, along } = &metric.kind {
            let (grain, along) = (&scene.grains[*grain], place(*along));
            let mut direction = [0.0; 3];
            direction[scene.scene.domain.geometry.component(along)] = 1.0;
            let reach = [grain.reach_along(direction), grain.reach_along(direction.map(|d| -d))];
            lines.push(line(Kind::Wake(Wake { along, centre: grain.position, reach })));
        }
        let MetricKind::VelocityDifference { component, along, through, file, column } = &metric.kind else {
            continue;
        };
        let letter = format!("{along:?}").to_lowercase();
        let refuse = |what: String| {
            let remedy =
                "give a CSV file with a header and coordinates in m; paths count from the scene's folder";
            scene.source.error(&format!("metrics[{index}].file"), what, remedy)
        };
        let text = protocol::input_file::read_text(file)
            .map_err(|error| refuse(format!("is {}, which cannot be read: {error}", file.display())))?;
        let rows = published_points(&text, &letter, column)
            .map_err(|what| refuse(format!("is {}, which {what}", file.display())))?;
        let (component, along, through) = (place(*component), place(*along), *through);
        let domain = &scene.scene.domain;
        let (low, high) = (domain.lower[along], domain.upper[along]);
        // A table may have its ends rounded.
        let margin = ROUNDED * (high - low);
        if let Some((at, _)) = rows.iter().find(|(at, _)| !(low - margin..=high + margin).contains(at)) {
            let (file, what) = (file.display(), format!("{letter} = {at}; the box is from {low} to {high}"));
            return Err(refuse(format!("is {file}, which has {what}")));
        }
        lines.push(line(Kind::Table(Table { component, along, letter, through, rows })));
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
    if lines.is_empty() || !solver.show() {
        return Ok(values);
    }
    for line in lines {
        let (reference, source) = (line.reference, line.source.clone());
        let value = match &line.kind {
            Kind::Table(table) => {
                let (text, largest) = table.compare(solver);
                folder
                    .write(&format!("{}.csv", line.name), text.as_bytes())
                    .map_err(|error| SolverError::Failed(error.to_string()))?;
                MetricValue::measured(largest, "m/s", reference, source)
            }
            Kind::Wake(wake) => match wake.length(solver) {
                Some(length) => MetricValue::measured(length, "-", reference, source),
                None => {
                    let why = "the flow is backward as far as the box reaches";
                    MetricValue::missing(why, "-", reference, source)
                }
            },
        };
        values.insert(line.name.clone(), value);
    }
    Ok(values)
}

impl Table {
    /// The profile beside the table, and their largest difference, m/s.
    fn compare<const D: usize>(&self, solver: &Solver<D>) -> (String, f64) {
        let (grid, u) = (solver.grid(), &solver.stepper().state().velocity[self.component]);
        let mut text = format!("{},velocity,reference\n", self.letter);
        let mut largest = 0.0_f64;
        for (at, published) in &self.rows {
            let mut x: [f64; D] = along_axes(grid.geometry, self.through);
            x[self.along] = *at;
            let value = interpolate(grid, self.component, u, x);
            let _ = writeln!(text, "{at},{value},{published}");
            largest = largest.max((value - published).abs());
        }
        (text, largest)
    }
}

impl Wake {
    /// From the surface to the last place of backward flow, over the width of the grain, on a periodic axis
    /// beyond its end, too. Zero if there is none; nothing if it does not end in the box.
    fn length<const D: usize>(&self, solver: &Solver<D>) -> Option<f64> {
        let (grid, u) = (solver.grid(), &solver.stepper().state().velocity[self.along]);
        let mut x: [f64; D] = along_axes(grid.geometry, self.centre);
        let (faces, length) = (&grid.axes[self.along].faces, grid.axes[self.along].length());
        let surface = x[self.along] + self.reach[0];
        let upstream = x[self.along] - self.reach[1] + length;
        let beyond = faces.iter().skip(1).map(|face| face + length).filter(|face| *face < upstream);
        let beyond = beyond.filter(|_| grid.periodic(self.along));
        let places = faces.iter().copied().chain(beyond).filter(|face| *face > surface);
        let mut before: Option<(f64, f64)> = None;
        for place in places {
            x[self.along] = if place > faces[faces.len() - 1] { place - length } else { place };
            let value = interpolate(grid, self.along, u, x);
            if let Some((last, backward)) = before.filter(|(_, value)| *value < 0.0)
                && value >= 0.0
            {
                let end = last + (place - last) * backward / (backward - value);
                return Some((end - surface) / (self.reach[0] + self.reach[1]));
            }
            before = Some((place, value));
        }
        before.is_none_or(|(_, value)| value >= 0.0).then_some(0.0)
    }
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
    let (faces, nodes) = (&grid.axes[axis].faces, grid.nodes(d, axis));
    let n = grid.cells[axis] as isize;
    let node = |i: isize| -> f64 {
        if i < 0 {
            2.0 * faces[0] - nodes[0]
        } else if d != axis && i >= n {
            2.0 * faces[n as usize] - nodes[n as usize - 1]
        } else {
            nodes[i as usize]
        }
    };
    let x = x.clamp(faces[0], faces[n as usize]);
    let low = (nodes.partition_point(|node| *node <= x) as isize - 1).min(n - 1);
    (low, (x - node(low)) / (node(low + 1) - node(low)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::field::set_component;
    use bedload_scene::SceneSource;
    use std::f64::consts::TAU;

    const PERIODIC: &str = "x = \"periodic\"";
    const STREAM: &str = "x_lower = { type = \"inflow\", velocity = [0.1, 0.0, 0.0] }, x_upper = \"outflow\"";

    /// Backward flow from the disc at `x` to 1 m behind its centre, in a box of 4 m.
    fn length(x: f64, faces: &str) -> Option<f64> {
        let text = format!(
            "until = 1.0\n[domain]\ngeometry = \"plane\"\nlower = [0.0, 0.0]\nupper = [4.0, 2.0]\ncells = [80, 40]\n\
             boundary = {{ {faces}, z = \"free-slip\" }}\n[medium]\ndensity = 1.0\nviscosity = 0.1\n[[grains]]\n\
             position = [{x:?}, 0.0, 1.0]\nradius = 0.25\ndensity = 1.0\nmotion = \"fixed\"\n[[metrics]]\n\
             name = \"wake\"\nkind = \"wake-length\"\ngrain = 0\nalong = \"x\"\n"
        );
        let scene = CheckedScene::new(SceneSource { file: "test".into(), text }).expect("a scene");
        let mut solver = Solver::<2>::new(&scene).expect("a fluid");
        let (grid, state) = solver.stepper_mut().parts_mut();
        let wave = |at: [f64; 2]| -(TAU * (at[0] - x) / 4.0).cos() * (TAU * (at[1] - 1.0) / 2.0).cos();
        set_component(grid, 0, &mut state.velocity[0], wave);
        state.open.follow(grid, &state.velocity);
        assert!(solver.show());
        match &of(&scene).expect("lines")[..] {
            [Line { kind: Kind::Wake(wake), .. }] => wake.length(&solver),
            others => panic!("{others:?}"),
        }
    }

    #[test]
    fn a_wake_goes_on_beyond_a_periodic_face_and_not_beyond_another() {
        for x in [0.5, 1.5, 3.1, 3.5, 3.9] {
            let length = length(x, PERIODIC).expect("it ends");
            assert!((length - 1.5).abs() < 0.01, "{length} at {x}");
        }
        let inside = length(1.5, STREAM).expect("it ends");
        assert!((inside - 1.5).abs() < 0.01, "{inside}");
        assert_eq!(length(3.4, STREAM), None);
    }
}
