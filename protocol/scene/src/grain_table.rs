//! Grains from a CSV file: written by hand, by other programs, or as the last state of another run.

use crate::grains::{Grain, GrainFile, Motion};
use crate::table::{Table, number};

/// The grains of the file again and again, as far as they lie low enough.
pub(crate) fn copies<'a>(from: &'a GrainFile, once: &'a [Grain]) -> impl Iterator<Item = Grain> + 'a {
    let moved = move |copy: usize| {
        once.iter().map(move |grain| {
            let mut grain = grain.clone();
            for (x, shift) in grain.position.iter_mut().zip(from.shift) {
                *x += copy as f64 * shift;
            }
            grain
        })
    };
    let below = |grain: &Grain| grain.position[2] + grain.radius <= from.below;
    (0..from.copies).flat_map(moved).filter(below)
}

/// Reads the file.
pub(crate) fn read(from: &GrainFile) -> Result<Vec<Grain>, String> {
    let path = from.file.as_path();
    let bytes = std::fs::read(path).map_err(|error| format!("cannot read {}: {error}", path.display()))?;
    let text = String::from_utf8(bytes)
        .map_err(|_| format!("{} is not text: a CSV file is needed", path.display()))?;
    let told = |what: String| format!("{} {what}", path.display());
    let table = Table::parse(&text).map_err(told)?;
    if table.columns.is_empty() {
        return Err(format!("the file {} is empty", path.display()));
    }
    let need = |name: &str| table.need(name).map_err(told);
    let columns = Columns {
        position: [need("x")?, need("y")?, need("z")?],
        size: [need("radius")?, need("density")?],
        velocity: ["vx", "vy", "vz"].map(|name| table.find(name)),
        spin: ["wx", "wy", "wz"].map(|name| table.find(name)),
        motion: table.find("motion"),
    };
    let grains = table.rows.iter().map(|row| {
        let line = row.position().map_or(0, csv::Position::line);
        columns.grain(row, &table).map_err(|what| format!("{}:{line}: {what}", path.display()))
    });
    let grains = grains.collect::<Result<Vec<_>, _>>()?;
    if let Some(odd) = text.lines().find_map(|line| line.strip_prefix("# not round: ")) {
        let count = odd.split_whitespace().next().unwrap_or("some");
        return Err(told(format!(
            "holds {count} bodies that are not round, whose shapes are not in the table: write them out as [[grains]], or go on \
             from that run with dem.initial_state"
        )));
    }
    // A file that says how many grains it holds is checked for its end.
    let count = text.lines().find_map(|line| line.strip_prefix("# grains: ")).map(str::trim);
    match count.filter(|count| count.parse() != Ok(grains.len())) {
        Some(count) => Err(told(format!(
            "says that it holds {count} grains, but has {}: it was cut short or edited",
            grains.len()
        ))),
        None => Ok(grains),
    }
}

/// Places of the columns of a grain.
struct Columns {
    position: [usize; 3],
    /// Radius and density.
    size: [usize; 2],
    velocity: [Option<usize>; 3],
    spin: [Option<usize>; 3],
    motion: Option<usize>,
}

impl Columns {
    fn grain(&self, row: &csv::StringRecord, table: &Table) -> Result<Grain, String> {
        let value = |column: usize| {
            let finite = number(row, column).filter(|value| value.is_finite());
            let (text, name) = (row.get(column).unwrap_or(""), &table.columns[column]);
            finite.ok_or_else(|| format!("`{text}` in column {name} is not a finite number"))
        };
        let or_zero = |column: Option<usize>| column.map_or(Ok(0.0), value);
        let motion = match self.motion.map(|column| row.get(column).unwrap_or("")) {
            None | Some("free") => Motion::Free,
            Some("fixed") => Motion::Fixed,
            Some(other) => return Err(format!("column motion: `{other}`; allowed: free, fixed")),
        };
        let ([x, y, z], [radius, density]) = (self.position, self.size);
        let vector = |[a, b, c]: [Option<usize>; 3]| Ok::<_, String>([or_zero(a)?, or_zero(b)?, or_zero(c)?]);
        Ok(Grain {
            velocity: vector(self.velocity)?,
            spin: vector(self.spin)?,
            motion,
            ..Grain::at([value(x)?, value(y)?, value(z)?], value(radius)?, value(density)?)
        })
    }
}
