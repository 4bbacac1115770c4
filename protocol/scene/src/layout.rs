//! Grains laid out one by one.

use crate::domain::Geometry;
use crate::error::SceneError;
use crate::grain_table;
use crate::grains::{Freedom, Grain, Group, Shape};
use crate::insertions::{self, Inserted};
use crate::random::SplitMix64;
use crate::shared::Scene;
use crate::source::SceneSource;

/// More grains than this are refused before anything is made for them: their messages alone would fill 2 GB.
pub(crate) const MOST_GRAINS: usize = 10_000_000;

/// Every grain of the scene in message order: `grains`, `grain_files`, `rough_walls`, `groups`, and, in
/// order of their times, `insertions`. `notes` gains what is to be known of it.
pub(crate) fn lay_out(
    scene: &Scene,
    source: &SceneSource,
    notes: &mut Vec<String>,
) -> Result<(Vec<Grain>, Vec<Inserted>), SceneError> {
    let geometry = scene.domain.geometry;
    let mut grains = scene.grains.clone();
    for (index, from) in scene.grain_files.iter().enumerate() {
        let (once, ignored) = grain_table::read(from).map_err(|why| {
            source.error(
                &format!("grain_files[{index}].file"),
                why,
                "give a CSV file with the header x,y,z,radius,density[,vx,vy,vz][,wx,wy,wz][,motion] and one row per grain; paths count \
                 from the scene's folder",
            )
        })?;
        if !ignored.is_empty() {
            notes.push(format!(
                "grain_files[{index}].file: {}: not read: column {}; columns that are: {}",
                from.file.display(),
                ignored.join(", "),
                grain_table::READ.join(", ")
            ));
        }
        let count = once.len().checked_mul(from.copies).and_then(|count| count.checked_add(grains.len()));
        if count.is_none_or(|count| count > MOST_GRAINS) {
            return Err(source.error(
                &format!("grain_files[{index}].copies"),
                format!(
                    "is {}: with {} grains in the file more than {MOST_GRAINS} in all",
                    from.copies,
                    once.len()
                ),
                "lay it fewer times",
            ));
        }
        grains.extend(grain_table::copies(from, &once));
    }
    for wall in &scene.rough_walls {
        wall.lay(geometry, &mut grains);
    }
    for (index, group) in scene.groups.iter().enumerate() {
        place(group, geometry, &mut grains).map_err(|why| {
            source.error(
                &format!("groups[{index}]"),
                why,
                "make the region larger, or the count or the radius smaller",
            )
        })?;
    }
    let (more, inserted) = insertions::lay_out(&scene.insertions, geometry);
    grains.extend(more);
    let grains = grains.into_iter().map(|grain| with_shape(grain, geometry)).collect();
    Ok((grains, inserted))
}

fn with_shape(mut grain: Grain, geometry: Geometry) -> Grain {
    if geometry == Geometry::Plane && grain.shape == Shape::Sphere {
        grain.shape = Shape::Disc;
    }
    grain
}

/// Random sequential placement: draw, keep if free of every grain so far. Neighbours are found
/// through a table of cells as wide as the largest grain, so that n grains cost O(n).
fn place(group: &Group, geometry: Geometry, grains: &mut Vec<Grain>) -> Result<(), String> {
    let largest =
        grains.iter().map(|grain| grain.radius).fold(group.radius * (1.0 + group.radius_spread), f64::max);
    let cell = |position: &[f64; 3]| position.map(|x| (x / (2.0 * largest)).floor() as i64);
    let mut table: std::collections::HashMap<[i64; 3], Vec<usize>> = std::collections::HashMap::new();
    for (index, grain) in grains.iter().enumerate() {
        table.entry(cell(&grain.position)).or_default().push(index);
    }
    let mut random = SplitMix64(group.seed);
    for number in 0..group.count {
        let radius = random.about(group.radius, group.radius_spread);
        let position = (0..1_000)
            .map(|_| random.place(geometry, &group.lower, &group.upper, radius))
            .find(|position| is_clear(position, radius, cell(position), &table, grains))
            .ok_or(format!("no room for grain {} of {} after 1000 tries", number + 1, group.count))?;
        table.entry(cell(&position)).or_default().push(grains.len());
        let (motion, locked) = (group.motion, group.locked.clone());
        grains.push(Grain { motion, locked, ..Grain::at(position, radius, group.density) });
    }
    if group.velocity_deviation > 0.0 {
        let first = grains.len() - group.count;
        stir(group, geometry, &mut grains[first..]);
    }
    Ok(())
}

/// Random velocities: each component a sum of twelve uniform numbers (Irwin–Hall), which is nearly Gaussian
/// and the same on every machine, less the mean, and scaled to the standard deviation asked for.
fn stir(group: &Group, geometry: Geometry, grains: &mut [Grain]) {
    // A stream of its own: the places do not depend on it.
    let mut random = SplitMix64(group.seed ^ 0x6a09_e667_f3bc_c908);
    for (axis, freedom) in [Freedom::X, Freedom::Y, Freedom::Z].into_iter().enumerate() {
        let drawn: Vec<f64> = grains.iter().map(|_| (0..12).map(|_| random.unit()).sum::<f64>()).collect();
        let count = drawn.len().max(1) as f64;
        let mean = drawn.iter().sum::<f64>() / count;
        let square = drawn.iter().map(|v| (v - mean) * (v - mean)).sum::<f64>() / count;
        let scale = if square > 0.0 { group.velocity_deviation / square.sqrt() } else { 0.0 };
        for (grain, value) in grains.iter_mut().zip(drawn) {
            if grain.is_free(freedom, geometry) {
                grain.velocity[axis] = (value - mean) * scale;
            }
        }
    }
}

fn is_clear(
    position: &[f64; 3],
    radius: f64,
    home: [i64; 3],
    table: &std::collections::HashMap<[i64; 3], Vec<usize>>,
    grains: &[Grain],
) -> bool {
    let near = (0..27i64).map(|n| [home[0] + n % 3 - 1, home[1] + n / 3 % 3 - 1, home[2] + n / 9 - 1]);
    near.filter_map(|cell| table.get(&cell)).flatten().all(|other| {
        let other = &grains[*other];
        let distance2: f64 = (0..3).map(|axis| (position[axis] - other.position[axis]).powi(2)).sum();
        distance2 >= (radius + other.radius).powi(2)
    })
}
