//! Grains laid out one by one.

use bedload_over_time::OverTime;

use crate::domain::{Domain, Geometry};
use crate::error::SceneError;
use crate::grain_table;
use crate::grains::{Freedom, Grain, GrainFile, Group, Motion, Shape};
use crate::insertions::{self, Inserted};
use crate::random::SplitMix64;
use crate::shared::Scene;
use crate::source::SceneSource;

/// More grains than this are refused before anything is made for them: their messages alone would fill 2 GB.
const MOST_GRAINS: usize = 10_000_000;

/// What is wrong with so many grains in all, asked before anything is made for them: more than
/// [`MOST_GRAINS`], or than the memory that is left can hold.
pub(crate) fn too_many(grains: f64) -> Option<String> {
    if grains > MOST_GRAINS as f64 {
        return Some(format!("asks for more than {MOST_GRAINS} grains in all"));
    }
    // Small numbers need no look at the system. As they are laid out, a list that grows is there twice.
    let bytes = grains * (2 * size_of::<Grain>()) as f64;
    let left = (bytes > 1e8).then(protocol::memory::available).flatten()?;
    (bytes > left.bytes as f64).then(|| {
        format!(
            "asks for {grains} grains in all, which take {:.1} GB before the run; {:.1} GB are left ({})",
            bytes / 1e9,
            left.bytes as f64 / 1e9,
            left.source
        )
    })
}

/// Copies of a table that lie in each other: each that is kept meets its own copy.
fn meet(from: &GrainFile, once: &[Grain]) -> Option<String> {
    let shift = from.shift.iter().map(|x| x * x).sum::<f64>().sqrt();
    let is_kept = |grain: &Grain| grain.position[2] + from.shift[2].max(0.0) + grain.radius <= from.below;
    let meets = |grain: &Grain| {
        grain.motion == Motion::Free && is_kept(grain) && 2.0 * grain.radius - shift > 0.01 * grain.radius
    };
    let row = once.iter().position(meets).filter(|_| from.copies > 1)?;
    Some(format!(
        "is {:?}: each copy lies in the one before it, {shift} m beside it, such as grain {row} of radius \
         {} m",
        from.shift, once[row].radius
    ))
}

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
        let key = |name: &str| format!("grain_files[{index}].{name}");
        let (once, ignored) = grain_table::read(from).map_err(|why| {
            source.error(
                &key("file"),
                why,
                "mend what is named; a table is a CSV file with the header \
                 x,y,z,radius,density[,vx,vy,vz][,wx,wy,wz][,motion] and one row per grain; paths count \
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
        if from.copies == 0 || from.below.is_nan() {
            let (name, value) = if from.copies == 0 { ("copies", 0.0) } else { ("below", from.below) };
            let what = format!("is {value}; allowed: 1 copy and more, below a height in m");
            return Err(source.error(&key(name), what, "leave it out, or mend it"));
        }
        let count = once.len() as f64 * from.copies as f64 + grains.len() as f64;
        if let Some(why) = too_many(count) {
            let what = format!("is {}: with {} grains in the file it {why}", from.copies, once.len());
            return Err(source.error(&key("copies"), what, "lay it fewer times"));
        }
        if let Some(why) = meet(from, &once) {
            let remedy = "shift it by the size of the packing at least, or lay it once";
            return Err(source.error(&key("shift"), why, remedy));
        }
        let (copies, before) = (grain_table::copies(from, &once), grains.len());
        grains.extend(copies.map(|grain| Grain { with_fluid: from.with_fluid, ..grain }));
        if grains.len() == before {
            let (file, count, below) = (from.file.display(), once.len(), from.below);
            notes.push(format!("grain_files[{index}]: {file}: none of {count} grains is below {below} m"));
        }
    }
    for wall in &scene.rough_walls {
        wall.lay(geometry, &scene.walls, &mut grains);
    }
    for (index, group) in scene.groups.iter().enumerate() {
        place(group, &scene.domain, &mut grains).map_err(|why| {
            let remedy = "make the region larger, or the count or the radius smaller";
            source.error(&format!("groups[{index}]"), why, remedy)
        })?;
    }
    let (more, inserted) = insertions::lay_out(&scene.insertions, geometry);
    grains.extend(more);
    if geometry == Geometry::Plane {
        let spheres = grains.iter_mut().filter(|grain| grain.shape == Shape::Sphere);
        spheres.for_each(|grain| grain.shape = Shape::Disc);
    }
    grains.iter_mut().filter(|grain| grain.with_fluid).for_each(|grain| start_with_fluid(grain, scene));
    Ok((grains, inserted))
}

/// Adds the motion of the fluid at t = 0 along the degrees of freedom that are free.
fn start_with_fluid(grain: &mut Grain, scene: &Scene) {
    use Freedom::{SpinX, SpinY, SpinZ, X, Y, Z};
    let (domain, Some(medium)) = (&scene.domain, &scene.medium) else { return };
    let [velocity, spin] = medium.initial.at(domain, grain.position);
    let mut along_with = [[0.0; 3]; 2];
    for (c, (along, about)) in [(X, SpinX), (Y, SpinY), (Z, SpinZ)].into_iter().enumerate() {
        if grain.is_free(along, domain.geometry) {
            along_with[0][c] = velocity[c];
        }
        if grain.is_free(about, domain.geometry) {
            along_with[1][c] = spin[c];
        }
    }
    // Only a prescribed motion changes over time, and that has no free degree.
    for (value, more) in [&mut grain.velocity, &mut grain.spin].into_iter().zip(along_with) {
        if more != [0.0; 3] {
            let own = value.start();
            *value = OverTime::Constant(std::array::from_fn(|c| own[c] + more[c]));
        }
    }
}

/// Tries for a place of one grain. Random sequential placement takes some 700 for each on the way to a solid
/// fraction of 0.35, nearly all of them for the last grains.
const TRIES: u32 = 1_000_000;

/// Random sequential placement: draw, keep if free of every grain so far. Neighbours are found
/// through a table of cells as wide as the largest grain, so that n grains cost O(n).
fn place(group: &Group, domain: &Domain, grains: &mut Vec<Grain>) -> Result<(), String> {
    let largest =
        grains.iter().map(|grain| grain.radius).fold(group.radius * (1.0 + group.radius_spread), f64::max);
    let spanned = domain.spanned(&group.lower, &group.upper);
    let mut cells = Cells::new(2.0 * largest, spanned);
    for (index, grain) in grains.iter().enumerate() {
        cells.add(index, &grain.position);
    }
    let mut random = SplitMix64(group.seed);
    for number in 0..group.count {
        let radius = random.about(group.radius, group.radius_spread);
        let position = (0..TRIES)
            .map(|_| random.place(domain.geometry, &spanned, &group.lower, &group.upper, radius))
            .find(|position| cells.is_clear(position, radius, grains))
            .ok_or_else(|| {
                format!("no room for grain {} of {} after {TRIES} tries", number + 1, group.count)
            })?;
        cells.add(grains.len(), &position);
        let (motion, locked) = (group.motion, group.locked.clone());
        let with_fluid = group.with_fluid;
        grains.push(Grain { motion, locked, with_fluid, ..Grain::at(position, radius, group.density) });
    }
    if group.velocity_deviation > 0.0 {
        let first = grains.len() - group.count;
        stir(group, domain.geometry, &mut grains[first..]);
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
                let mut velocity = grain.velocity.start();
                velocity[axis] = (value - mean) * scale;
                grain.velocity = velocity.into();
            }
        }
    }
}

/// Grains by cells that are as wide as the largest, at least; along spanned periodic axes a whole number of
/// them goes round.
struct Cells {
    width: f64,
    /// Lower corner and length along the axes that go round.
    spanned: [Option<(f64, f64)>; 3],
    grains: std::collections::HashMap<[i64; 3], Vec<usize>>,
}

impl Cells {
    fn new(width: f64, spanned: [Option<(f64, f64)>; 3]) -> Self {
        Self { width, spanned, grains: std::collections::HashMap::new() }
    }

    /// Cells once round an axis of that length.
    fn round(&self, length: f64) -> i64 {
        ((length / self.width).floor() as i64).max(1)
    }

    fn cell(&self, position: &[f64; 3]) -> [i64; 3] {
        std::array::from_fn(|axis| match self.spanned[axis] {
            None => (position[axis] / self.width).floor() as i64,
            Some((lower, length)) => {
                let count = self.round(length);
                ((position[axis] - lower) / length * count as f64).floor() as i64
            }
        })
    }

    /// The cell itself along axes with ends, the one that it stands for along those that go round.
    fn folded(&self, cell: [i64; 3]) -> [i64; 3] {
        std::array::from_fn(|axis| match self.spanned[axis] {
            None => cell[axis],
            Some((_, length)) => cell[axis].rem_euclid(self.round(length)),
        })
    }

    fn add(&mut self, index: usize, position: &[f64; 3]) {
        self.grains.entry(self.folded(self.cell(position))).or_default().push(index);
    }

    /// Is a grain there free of all others, and of their images?
    fn is_clear(&self, position: &[f64; 3], radius: f64, grains: &[Grain]) -> bool {
        let home = self.cell(position);
        // Its own cell first: most tries fail there.
        let near = (13..40i64).map(|n| n % 27);
        let near = near.map(|n| [home[0] + n % 3 - 1, home[1] + n / 3 % 3 - 1, home[2] + n / 9 - 1]);
        near.filter_map(|cell| self.grains.get(&self.folded(cell))).flatten().all(|other| {
            let other = &grains[*other];
            let square = |axis: usize| {
                let apart = position[axis] - other.position[axis];
                let turn = |(_, length): (f64, f64)| length * (apart / length).round();
                (apart - self.spanned[axis].map_or(0.0, turn)).powi(2)
            };
            let distance2: f64 = (0..3).map(square).sum();
            distance2 >= (radius + other.radius).powi(2)
        })
    }
}
