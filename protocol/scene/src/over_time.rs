//! Values that may change over time: their files are read, and what they hold is checked, key by key.

use crate::error::{Check, SceneError};
use crate::grains::Motion;
use crate::shared::Scene;
use crate::source::SceneSource;
use crate::table::{Table, number};
use bedload_over_time::{OverTime, Quantity};
use std::sync::Arc;

/// Reads the tables that stand in files, and checks every value that may change.
pub(crate) fn settle(scene: &mut Scene, source: &SceneSource) -> Check {
    Place { key: &|| "gravity".to_owned(), source }.settle(&mut scene.gravity)?;
    for (face, velocity) in scene.domain.boundary.velocities() {
        Place { key: &|| format!("domain.boundary.{face}.velocity"), source }.settle(velocity)?;
    }
    if let Some(medium) = &mut scene.medium {
        let drives =
            [("body_force", &mut medium.body_force), ("pressure_gradient", &mut medium.pressure_gradient)];
        for (name, drive) in drives {
            Place { key: &|| format!("medium.{name}"), source }.settle(drive)?;
        }
        if let Some(flow) = &mut medium.flow_rate {
            let key = || "medium.flow_rate.mean_velocity".to_owned();
            Place { key: &key, source }.settle(&mut flow.mean_velocity)?;
        }
    }
    for (index, wall) in scene.walls.iter_mut().enumerate() {
        for (name, value) in [("velocity", &mut wall.velocity), ("spin", &mut wall.spin)] {
            Place { key: &|| format!("walls[{index}].{name}"), source }.settle(value)?;
        }
        one_axis(&wall.spin, &format!("walls[{index}].spin"), source)?;
        if let Some(servo) = &mut wall.servo {
            let key = || format!("walls[{index}].servo.pressure");
            Place { key: &key, source }.settle(&mut servo.pressure)?;
        }
    }
    for (index, grain) in scene.grains.iter_mut().enumerate() {
        for (name, value) in [("velocity", &mut grain.velocity), ("spin", &mut grain.spin)] {
            let place = Place { key: &|| format!("grains[{index}].{name}"), source };
            place.settle(value)?;
            if value.varies() && grain.motion != Motion::Prescribed {
                return Err(place.error(
                    "changes over time, but the grain is not prescribed",
                    "add motion = \"prescribed\", or give the constant that it starts with",
                ));
            }
        }
        one_axis(&grain.spin, &format!("grains[{index}].spin"), source)?;
    }
    Ok(())
}

fn one_axis(spin: &OverTime<[f64; 3]>, key: &str, source: &SceneSource) -> Check {
    source.refuse_if(
        !spin.is_along_one_line(),
        key,
        "turns about an axis that changes",
        "give values along one line, such as [0.0, w, 0.0]",
    )
}

/// Does the value ever have this component?
pub fn acts_along(value: &OverTime<[f64; 3]>, component: usize) -> bool {
    value.extremes().any(|value| value[component] != 0.0)
}

/// Where a value is written.
struct Place<'a> {
    key: &'a dyn Fn() -> String,
    source: &'a SceneSource,
}

impl Place<'_> {
    fn error(&self, message: impl Into<String>, remedy: &str) -> SceneError {
        self.source.error(&(self.key)(), message, remedy)
    }

    fn settle<T: Quantity>(&self, value: &mut OverTime<T>) -> Check {
        if let OverTime::Table(table) = value
            && let Some(file) = table.file()
        {
            let rows = read(file).map_err(|what| {
                let columns = T::COLUMNS.join(", ");
                let remedy = format!("give a CSV file with the columns t, {columns} and rows of numbers");
                self.error(what, &remedy)
            })?;
            *value = OverTime::Table(Arc::new(bedload_over_time::Table::new(rows, Some(file.to_owned()))));
        }
        match value {
            OverTime::Constant(value) => self.finite("", value),
            OverTime::Table(table) => self.rows(table.rows()),
            OverTime::Sine(sine) => {
                let parts = [("amplitude ", &sine.amplitude), ("offset ", &sine.offset)];
                parts.into_iter().try_for_each(|(name, part)| self.finite(name, part))?;
                self.finite("phase ", &sine.phase)?;
                if sine.frequency > 0.0 && sine.frequency.is_finite() {
                    return Ok(());
                }
                Err(self.source.error(
                    &format!("{}.frequency", (self.key)()),
                    format!("is {}; allowed: a finite number > 0", sine.frequency),
                    "give the frequency in Hz, or a constant instead",
                ))
            }
        }
    }

    fn finite<T: Quantity>(&self, what: &str, value: &T) -> Check {
        let Some(number) = value.numbers().iter().find(|number| !number.is_finite()) else { return Ok(()) };
        Err(self.error(format!("{what}holds {number}; allowed: finite numbers"), "give finite numbers"))
    }

    fn rows<T: Quantity>(&self, rows: &[(f64, T)]) -> Check {
        if rows.is_empty() {
            let what = "has no rows; allowed: one row [t, value] and more";
            return Err(self.error(what, "give rows of times, s"));
        }
        let mut before = f64::NEG_INFINITY;
        for (number, (t, value)) in (1..).zip(rows) {
            self.finite(&format!("row {number} "), value)?;
            if !(t.is_finite() && *t > before) {
                return Err(self.error(
                    format!("has t = {t} in row {number}; allowed: finite times, each above the one before"),
                    "put the rows in the order of their times; a jump takes two rows a short time apart",
                ));
            }
            before = *t;
        }
        Ok(())
    }
}

/// The rows of a file.
fn read<T: Quantity>(path: &std::path::Path) -> Result<Vec<(f64, T)>, String> {
    let name = path.display();
    let text =
        protocol::input_file::read_text(path).map_err(|error| format!("cannot read {name}: {error}"))?;
    let table = Table::parse(&text).map_err(|what| format!("{name} {what}"))?;
    table.refuse_odd().map_err(|what| format!("{name}:{what}"))?;
    let time = table.need("t").map_err(|what| format!("{name} {what}"))?;
    let known = |column: &&String| *column == "t" || T::COLUMNS.contains(&column.as_str());
    if let Some(other) = table.columns.iter().find(|column| !known(column)) {
        return Err(format!("{name} has a column `{other}`, which is not read"));
    }
    let columns: Vec<Option<usize>> = T::COLUMNS.iter().map(|column| table.find(column)).collect();
    if columns.iter().all(Option::is_none) {
        return Err(format!("{name} has times, but no column of values"));
    }
    let row = |row: &csv::StringRecord| {
        let line = row.position().map_or(0, csv::Position::line);
        let cell = |column: usize| {
            let text = row.get(column).unwrap_or("");
            number(row, column).ok_or_else(|| format!("{name}:{line}: `{text}` is not a number"))
        };
        let mut value = T::ZERO;
        for (number, column) in value.numbers_mut().iter_mut().zip(&columns) {
            // A component without a column is zero.
            *number = column.map_or(Ok(0.0), cell)?;
        }
        Ok((cell(time)?, value))
    };
    table.rows.iter().map(row).collect()
}
