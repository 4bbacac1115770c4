//! Grains from a CSV file: written by hand, by other programs, or as the last state of another run.

use std::path::Path;

use super::grains::{Grain, GrainFile, Motion};

/// Reads the file, with its copies.
pub(super) fn read(from: &GrainFile) -> Result<Vec<Grain>, String> {
    let once = read_once(&from.file)?;
    let moved = |copy: usize| {
        once.iter().map(move |grain| {
            let mut grain = grain.clone();
            for (x, shift) in grain.position.iter_mut().zip(from.shift) {
                *x += copy as f64 * shift;
            }
            grain
        })
    };
    let below = |grain: &Grain| grain.position[2] + grain.radius <= from.below;
    Ok((0..from.copies).flat_map(moved).filter(below).collect())
}

fn read_once(path: &Path) -> Result<Vec<Grain>, String> {
    let bytes = std::fs::read(path).map_err(|error| format!("cannot read {}: {error}", path.display()))?;
    let text = String::from_utf8(bytes)
        .map_err(|_| format!("{} is not text: a CSV file is needed", path.display()))?;
    let mut lines =
        text.lines().enumerate().filter(|(_, line)| !line.trim().is_empty() && !line.starts_with('#'));
    let (_, header) = lines.next().ok_or_else(|| format!("the file {} is empty", path.display()))?;
    let columns: Vec<&str> = header.split(',').map(str::trim).collect();
    let find = |name: &str| columns.iter().position(|column| *column == name);
    let need = |name: &str| find(name).ok_or(format!("{} has no column `{name}`", path.display()));
    let position = [need("x")?, need("y")?, need("z")?];
    let (radius, density) = (need("radius")?, need("density")?);
    let velocity = [find("vx"), find("vy"), find("vz")];
    let spin = [find("wx"), find("wy"), find("wz")];
    let motion = find("motion");
    // A file that says how many grains it holds is checked for its end.
    let told = text.lines().find_map(|line| line.strip_prefix("# grains: ")).map(str::trim);
    let mut grains = Vec::new();
    for (number, line) in lines {
        let cells: Vec<&str> = line.split(',').map(str::trim).collect();
        let place = |column: usize| format!("{}:{}: column {}", path.display(), number + 1, columns[column]);
        let value = |column: usize| -> Result<f64, String> {
            let text = cells.get(column).copied().unwrap_or("");
            let value = text.parse::<f64>().ok().filter(|value| value.is_finite());
            value.ok_or_else(|| {
                format!(
                    "{}:{}: `{text}` in column {} is not a finite number",
                    path.display(),
                    number + 1,
                    columns[column]
                )
            })
        };
        let or_zero = |column: Option<usize>| column.map_or(Ok(0.0), value);
        let vector = |columns: [Option<usize>; 3]| -> Result<[f64; 3], String> {
            Ok([or_zero(columns[0])?, or_zero(columns[1])?, or_zero(columns[2])?])
        };
        let motion = match motion.map(|column| (column, cells.get(column).copied().unwrap_or(""))) {
            None | Some((_, "free")) => Motion::Free,
            Some((_, "fixed")) => Motion::Fixed,
            Some((column, other)) => {
                return Err(format!("{}: `{other}`; allowed: free, fixed", place(column)));
            }
        };
        let centre = [value(position[0])?, value(position[1])?, value(position[2])?];
        grains.push(Grain {
            velocity: vector(velocity)?,
            spin: vector(spin)?,
            motion,
            ..Grain::at(centre, value(radius)?, value(density)?)
        });
    }
    match told.map(|count| (count, count.parse::<usize>() == Ok(grains.len()))) {
        Some((count, false)) => Err(format!(
            "{} says that it holds {count} grains, but has {}: it was cut short or edited",
            path.display(),
            grains.len()
        )),
        _ => Ok(grains),
    }
}
