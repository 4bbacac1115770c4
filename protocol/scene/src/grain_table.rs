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

pub(crate) const READ: [&str; 12] =
    ["x", "y", "z", "radius", "density", "vx", "vy", "vz", "wx", "wy", "wz", "motion"];

/// A column that Bedload writes for those who read its tables: the number of the row.
const NUMBER: &str = "id";

/// The name of a column here, and what others call it, in small letters without signs between them.
const OTHER_NAMES: [(&str, &[&str]); 12] = [
    ("x", &["positionx", "posx"]),
    ("y", &["positiony", "posy"]),
    ("z", &["positionz", "posz"]),
    ("vx", &["u", "velx", "velocityx"]),
    ("vy", &["v", "vely", "velocityy"]),
    ("vz", &["w", "velz", "velocityz"]),
    ("wx", &["omegax", "omgx", "spinx"]),
    ("wy", &["omegay", "omgy", "spiny"]),
    ("wz", &["omegaz", "omgz", "spinz"]),
    ("radius", &["r", "rad"]),
    ("radius, of half the value", &["d", "diameter"]),
    ("density", &["rho", "dens", "ρ"]),
];

/// The name under which a column with this one, which is not read, would be: what differs by case, by signs
/// or by a unit behind it, or is another name of the same.
fn meant(column: &str) -> Option<&'static str> {
    let name = column.split(['(', '[']).next().unwrap_or(column).to_lowercase();
    let name: String = name.chars().filter(|sign| sign.is_alphanumeric()).collect();
    let other =
        OTHER_NAMES.iter().find(|(_, others)| others.contains(&name.as_str())).map(|(known, _)| *known);
    READ.into_iter().find(|known| *known == name).or(other)
}

/// Columns that are not read. A name that is all but that of a column which is read is refused.
fn ignored(table: &Table) -> Result<Vec<String>, String> {
    let mut ignored = Vec::new();
    for (index, name) in table.columns.iter().enumerate() {
        if READ.contains(&name.as_str()) || name == NUMBER {
            continue;
        }
        if let Some(known) = meant(name) {
            return Err(format!(
                "column {} `{name}` would not be read: name it {known}, or remove it",
                index + 1
            ));
        }
        if !name.is_empty() {
            ignored.push(format!("`{name}`"));
        } else if table.rows.iter().any(|row| row.get(index).is_some_and(|cell| !cell.is_empty())) {
            ignored.push(format!("{} (without a name)", index + 1));
        }
    }
    Ok(ignored)
}

/// The grains of the file, and the names of its columns that are not read.
pub(crate) fn read(from: &GrainFile) -> Result<(Vec<Grain>, Vec<String>), String> {
    let path = from.file.as_path();
    let bytes = protocol::input_file::read(path)
        .map_err(|error| format!("cannot read {}: {error}", path.display()))?;
    let text = String::from_utf8(bytes)
        .map_err(|_| format!("{} is not text: a CSV file is needed", path.display()))?;
    let told = |what: String| format!("{} {what}", path.display());
    let table = Table::parse(&text).map_err(told)?;
    if table.columns.is_empty() {
        return Err(format!("the file {} is empty", path.display()));
    }
    table.refuse_odd().map_err(|what| format!("{}:{what}", path.display()))?;
    let need = |name: &str| table.need(name).map_err(told);
    let ignored =
        ignored(&table).map_err(|what| format!("{}:{}: {what}", path.display(), table.header_line))?;
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
    // Of remarks only those count that Bedload writes.
    let counted = |head: &str| text.lines().find_map(|line| line.strip_prefix(head)).map(str::trim);
    let odd = counted("# not round: ").and_then(|rest| rest.split_whitespace().next());
    if let Some(count) = odd.and_then(|count| count.parse::<usize>().ok()) {
        return Err(told(format!(
            "holds {count} bodies that are not round, whose shapes are not in the table: write them out as \
             [[grains]], or go on from that run with dem.initial_state"
        )));
    }
    // A file that says how many grains it holds is checked for its end.
    let count = counted("# grains: ").and_then(|count| count.parse::<usize>().ok());
    match count.filter(|count| *count != grains.len()) {
        Some(count) => Err(told(format!(
            "says that it holds {count} grains, but has {}: it was cut short or edited",
            grains.len()
        ))),
        None => Ok((grains, ignored)),
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
            finite.ok_or_else(|| {
                let with_e = text.replace(['d', 'D'], "e");
                let hint = match with_e.parse::<f64>() {
                    Ok(value) if value.is_finite() => format!(": write the exponent with e, {with_e}"),
                    _ => String::new(),
                };
                format!("`{text}` in column {name} is not a finite number{hint}")
            })
        };
        let positive = |column: usize| {
            let (x, name) = (value(column)?, &table.columns[column]);
            let wrong = || format!("column {name} is {x}; allowed: a finite number > 0");
            if x > 0.0 { Ok(x) } else { Err(wrong()) }
        };
        let or_zero = |column: Option<usize>| column.map_or(Ok(0.0), value);
        let motion = match self.motion.map(|column| row.get(column).unwrap_or("")) {
            None | Some("free") => Motion::Free,
            Some("fixed") => Motion::Fixed,
            Some(other) => return Err(format!("column motion: `{other}`; allowed: free, fixed")),
        };
        let moves = || self.velocity.iter().chain(&self.spin).flatten().any(|c| number(row, *c) != Some(0.0));
        if motion == Motion::Fixed && moves() {
            return Err(
                "is `fixed`, and has a velocity or spin, as a grain that its scene moved: write it as \
                        [[grains]] with motion = \"prescribed\", or set them to 0 to hold it"
                    .into(),
            );
        }
        let ([x, y, z], [radius, density]) = (self.position, self.size);
        let vector = |[a, b, c]: [Option<usize>; 3]| Ok::<_, String>([or_zero(a)?, or_zero(b)?, or_zero(c)?]);
        Ok(Grain {
            velocity: vector(self.velocity)?.into(),
            spin: vector(self.spin)?.into(),
            motion,
            ..Grain::at([value(x)?, value(y)?, value(z)?], positive(radius)?, positive(density)?)
        })
    }
}
