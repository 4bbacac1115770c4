//! How far the messages of a replay are from the logged ones, window by window.

use bedload_program::Messages;
use bedload_program::replay::Compare;
use bedload_scene::CheckedScene;
use protocol::log::LoggedWindow;
use protocol::message::{Kinematics, Loads};
use protocol::participant::{Role, Window};

use crate::number::{Short, norm};

/// Below this part of the largest value logged so far a difference is one of rounding.
const ROUNDING: f64 = 1e-12;

/// What is compared: name and unit of a vector of a record.
type Quantity<R> = (&'static str, &'static str, fn(&R) -> [f64; 3]);

const MOTION: [Quantity<Kinematics>; 5] = [
    ("position", "m", |grain| grain.position),
    ("velocity", "m/s", |grain| grain.velocity),
    ("spin", "rad/s", |grain| grain.spin),
    ("contact_force", "N", |grain| grain.contact_force),
    ("lubrication_force", "N", |grain| grain.lubrication_force),
];

const LOADS: [Quantity<Loads>; 2] =
    [("force", "N", |loads| loads.force), ("torque", "N m", |loads| loads.torque)];

/// The largest difference of one quantity over the grains of a window.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Cell {
    /// |sent − logged|, in the quantity's unit; infinite if it is no number.
    difference: f64,
    /// Over the largest logged magnitude so far.
    relative: f64,
    grain: usize,
}

#[derive(Clone, Debug)]
struct Row {
    step: u64,
    /// End of the window, s.
    time: f64,
    cells: Vec<Cell>,
}

/// All windows of a replay.
#[derive(Clone, Debug)]
pub(super) struct Divergence {
    /// Name and unit of each quantity.
    quantities: Vec<(&'static str, &'static str)>,
    /// Largest logged magnitude of each so far.
    scales: Vec<f64>,
    /// Lengths of the periods, m; infinite where there is none.
    periods: [f64; 3],
    rows: Vec<Row>,
}

impl Divergence {
    /// Of what the solver of `role` sends.
    pub(super) fn new(role: Role, scene: &CheckedScene) -> Self {
        let quantities: Vec<_> = match role {
            Role::Fluid => LOADS.map(|(name, unit, _)| (name, unit)).to_vec(),
            Role::Dem => MOTION.map(|(name, unit, _)| (name, unit)).to_vec(),
        };
        let periods = scene.scene.domain.periods();
        let periods = periods.map(|period| period.map_or(f64::INFINITY, |(_, length)| length));
        Self { scales: vec![0.0; quantities.len()], quantities, periods, rows: Vec::new() }
    }

    fn compare<R>(&mut self, window: &Window, of: &[Quantity<R>], logged: &[R], sent: &[R]) {
        let mut cells = Vec::with_capacity(of.len());
        for (scale, (name, _, vector)) in self.scales.iter_mut().zip(of) {
            let periods = if *name == "position" { self.periods } else { [f64::INFINITY; 3] };
            let mut cell = Cell::default();
            for (grain, (theirs, ours)) in logged.iter().zip(sent).enumerate() {
                let (theirs, ours) = (vector(theirs), vector(ours));
                let size = norm(&theirs);
                if size.is_finite() {
                    *scale = scale.max(size);
                }
                let difference = apart(theirs, ours, periods);
                if difference > cell.difference {
                    cell = Cell { difference, grain, relative: 0.0 };
                }
            }
            if cell.difference > 0.0 {
                cell.relative = cell.difference / *scale;
            }
            cells.push(cell);
        }
        self.rows.push(Row { step: window.step, time: window.time + window.dt, cells });
    }

    pub(super) fn windows(&self) -> usize {
        self.rows.len()
    }

    /// The first window with a difference that is more than rounding: its row and quantity.
    fn first(&self) -> Option<(&Row, usize)> {
        let row = self.rows.iter().find(|row| row.cells.iter().any(|cell| cell.relative > ROUNDING))?;
        let largest =
            (0..row.cells.len()).max_by(|a, b| row.cells[*a].relative.total_cmp(&row.cells[*b].relative))?;
        Some((row, largest))
    }

    /// The window in which a quantity differs most.
    fn largest(&self, quantity: usize) -> Option<(&Row, &Cell)> {
        let cells = self.rows.iter().filter_map(|row| Some((row, row.cells.get(quantity)?)));
        cells
            .max_by(|(_, a), (_, b)| a.difference.total_cmp(&b.difference))
            .filter(|(_, c)| c.difference > 0.0)
    }

    /// The first difference and the largest of each quantity, as text.
    pub(super) fn summary(&self) -> String {
        let mut text = match self.first() {
            None => format!("no difference beyond {ROUNDING:e} of the largest logged so far\n"),
            Some((row, quantity)) => {
                let (name, unit) = self.quantities[quantity];
                let Cell { difference, relative, grain } = row.cells[quantity];
                format!(
                    "first difference beyond {ROUNDING:e} of the largest logged so far: window {}, t = {} s, \
                     grain {grain}, {name}: {} {unit}, {} of it\n",
                    row.step,
                    Short(row.time),
                    Short(difference),
                    Short(relative)
                )
            }
        };
        text += &line(
            ["largest difference of", "", "unit", "relative", "t / s", "window", "grain"].map(str::to_owned),
        );
        for (quantity, (name, unit)) in self.quantities.iter().enumerate() {
            let cells = self.largest(quantity).map_or_else(
                || ["0", unit, "0", "–", "–", "–"].map(str::to_owned),
                |(row, cell)| {
                    [
                        Short(cell.difference).to_string(),
                        (*unit).to_owned(),
                        Short(cell.relative).to_string(),
                        Short(row.time).to_string(),
                        row.step.to_string(),
                        cell.grain.to_string(),
                    ]
                },
            );
            let [difference, unit, relative, time, step, grain] = cells;
            text += &line([(*name).to_owned(), difference, unit, relative, time, step, grain]);
        }
        text
    }

    /// `divergence.csv`: a row for each window.
    pub(super) fn csv(&self) -> String {
        let mut text = String::from("t,window");
        for (name, _) in &self.quantities {
            text += &format!(",{name},{name}_grain,{name}_relative");
        }
        text.push('\n');
        for row in &self.rows {
            text += &format!("{},{}", row.time, row.step);
            for cell in &row.cells {
                let grain = if cell.difference > 0.0 { cell.grain.to_string() } else { String::new() };
                text += &format!(",{:e},{grain},{:e}", cell.difference, cell.relative);
            }
            text.push('\n');
        }
        text
    }

    /// Name of each quantity, and its relative difference against time.
    pub(super) fn curves(&self) -> Vec<(String, Vec<(f64, f64)>)> {
        let curve = |quantity: usize| {
            let point = |row: &Row| Some((row.time, row.cells.get(quantity)?.relative));
            self.rows.iter().filter_map(point).collect()
        };
        let name = |(quantity, (name, _)): (usize, &(&str, _))| (name.replace('_', " "), curve(quantity));
        self.quantities.iter().enumerate().map(name).collect()
    }
}

impl Compare for Divergence {
    /// Compares what was accepted; there is nothing to compare where the solver took no part in the logged
    /// run.
    fn take(&mut self, logged: &LoggedWindow, sent: &Messages<'_>, is_last: bool) -> bool {
        let window = logged.window();
        match (sent.loads_header, &logged.loads, &logged.kinematics) {
            _ if !is_last => {}
            (Some(_), Some((_, loads)), _) => self.compare(&window, &LOADS, loads, sent.loads),
            (None, _, Some((_, motion))) => self.compare(&window, &MOTION, motion, sent.kinematics),
            _ => {}
        }
        true
    }
}

fn line([name, difference, unit, relative, time, step, grain]: [String; 7]) -> String {
    format!("  {name:22} {difference:>10} {unit:6} {relative:>10} {time:>10} {step:>8} {grain:>7}\n")
}

/// Distance of two vectors, by the shortest way around the periods; infinite if it is no number.
fn apart(logged: [f64; 3], sent: [f64; 3], periods: [f64; 3]) -> f64 {
    let along = |axis: usize| {
        let (d, period) = (sent[axis] - logged[axis], periods[axis]);
        if period.is_finite() { d - period * (d / period).round() } else { d }
    };
    let apart = norm(&std::array::from_fn(along));
    if apart.is_nan() { f64::INFINITY } else { apart }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_scenes::scene;

    fn two_grains() -> CheckedScene {
        let grain = "[[grains]]\nposition = [1.0, 1.0, 1.0]\nradius = 0.25\ndensity = 1.0\n";
        scene(format!(
            "until = 1.0\n[domain]\ngeometry = \"space\"\nlower = [0.0, 0.0, 0.0]\nupper = [4.0, 4.0, 4.0]\n\
             boundary = {{ x = \"periodic\", y = \"no-slip\", z = \"no-slip\" }}\n{grain}{}",
            grain.replace("[1.0, 1.0", "[3.0, 3.0")
        ))
    }

    fn window(step: u64) -> Window {
        Window { step, attempt: 0, time: step as f64, dt: 1.0, substeps: 1, output: false }
    }

    fn at(position: [f64; 3], contact_force: f64) -> Kinematics {
        Kinematics { position, contact_force: [contact_force, 0.0, 0.0], ..Kinematics::default() }
    }

    #[test]
    fn the_first_and_the_largest_difference_are_named() {
        let mut divergence = Divergence::new(Role::Dem, &two_grains());
        let logged = vec![at([1.0; 3], 0.0), at([3.9, 0.0, 0.0], 2.0)];
        divergence.compare(&window(0), &MOTION, &logged, &logged);
        // Beyond the period, the same place up to rounding.
        let turned = vec![at([1.0; 3], 0.0), at([-0.1, 0.0, 0.0], 2.0)];
        divergence.compare(&window(1), &MOTION, &logged, &turned);
        let other = vec![at([1.0; 3], 0.0), at([3.9, 0.0, 0.0], 2.5)];
        divergence.compare(&window(2), &MOTION, &logged, &other);
        let nothing = vec![at([f64::NAN; 3], 0.0), at([3.9, 0.0, 0.0], 2.0)];
        divergence.compare(&window(3), &MOTION, &logged, &nothing);
        let said = divergence.summary();
        assert!(said.contains("window 2, t = 3 s, grain 1, contact_force: 0.5 N, 0.25 of it"), "{said}");
        let csv = divergence.csv();
        let rows: Vec<&str> = csv.lines().collect();
        assert_eq!(rows.len(), 5);
        assert!(rows[0].starts_with("t,window,position,position_grain,position_relative,velocity,"));
        assert!(rows[1].starts_with("1,0,0e0,,0e0,"), "{}", rows[1]);
        assert!(rows[4].starts_with("4,3,inf,0,inf,"), "{}", rows[4]);
    }

    #[test]
    fn rounding_is_no_difference() {
        let mut divergence = Divergence::new(Role::Dem, &two_grains());
        let logged = vec![at([1.0; 3], 0.0); 2];
        let sent = vec![at([1.0 + f64::EPSILON, 1.0, 1.0], 0.0); 2];
        divergence.compare(&window(0), &MOTION, &logged, &sent);
        assert!(divergence.summary().starts_with("no difference beyond"), "{}", divergence.summary());
        assert!(divergence.csv().contains("2.220446049250313e-16"));
    }
}
