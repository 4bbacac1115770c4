//! Averages of fluid and grains over planes of cells: one file per sample, their mean over time, and the
//! metrics that are read from it.

use std::fmt::Write as _;
use std::path::Path;

use crate::error::OutputError;
use bedload_scene::ObservedPlanes;
use bedload_scene::table::{Table, line};

/// Columns of a file, after `# t`.
const HEADER: &str = "at,width,solid_fraction,fluid_velocity_x,fluid_velocity_y,fluid_velocity_z,grain_velocity_x,\
                      grain_velocity_y,grain_velocity_z";

/// Further columns with stresses: each of [`PARTS`] by component.
const MORE: &str = ",pressure,granular_temperature";

/// What the stress on a plane is made of; their sum is that of the mixture.
pub const PARTS: [&str; 5] = ["viscous", "turbulent", "hydrodynamic", "contact", "lubrication"];

/// What `observe.planes.stress` adds of a plane.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Stresses {
    /// Pressure over the whole plane, Pa.
    pub pressure: f64,
    /// Mean square fluctuation of the velocities of grains along each axis, m²/s².
    pub temperature: f64,
    /// Force of what is above on what is below per area, by part and component, Pa.
    pub parts: [[f64; 3]; 5],
}

impl Stresses {
    fn to_cells(self) -> impl Iterator<Item = f64> {
        [self.pressure, self.temperature].into_iter().chain(self.parts.into_iter().flatten())
    }

    fn of_cells(cells: &[f64]) -> Option<Self> {
        let (&[pressure, temperature], parts) = cells.split_first_chunk::<2>()?;
        let mut stresses = Self { pressure, temperature, ..Self::default() };
        (parts.len() == 15).then(|| stresses.parts.as_flattened_mut().copy_from_slice(parts))?;
        Some(stresses)
    }
}

/// Columns of a file with stresses or without.
fn header(stresses: bool) -> String {
    let mut header = HEADER.to_owned();
    if stresses {
        header += MORE;
        for (part, c) in PARTS.iter().flat_map(|part| ["x", "y", "z"].map(|c| (part, c))) {
            header += &format!(",{part}_stress_{c}");
        }
    }
    header
}

/// What begins the names of the files of samples.
const NAME: &str = "planes_";

/// Both phases on one plane of cells.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Plane {
    /// Place of the centres across the planes, m.
    pub at: f64,
    /// Width of the cells across the planes, m.
    pub width: f64,
    /// Part of the volume that grains fill.
    pub solid_fraction: f64,
    /// Mean velocity of the fluid, m/s; zero where there is none (in files NaN).
    pub fluid_velocity: [f64; 3],
    /// Mean velocity of the solid, m/s; zero where there is none (in files NaN).
    pub grain_velocity: [f64; 3],
    /// Where they are asked for.
    pub stresses: Option<Stresses>,
}

/// All planes at one instant, or their mean.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Planes {
    /// Its time, s, and 1; of a mean the times of all its samples, ascending, with their parts of it.
    pub times: Vec<(f64, f64)>,
    /// Lowest first.
    pub planes: Vec<Plane>,
}

impl Planes {
    /// Name of the file of a sample.
    pub fn file_name(step: u64) -> String {
        format!("{NAME}{step:08}.csv")
    }

    /// Reads the text of a file.
    ///
    /// # Errors
    /// What does not fit.
    pub fn parse(text: &str) -> Result<Self, String> {
        let first = text.lines().next().unwrap_or("");
        let time = first.strip_prefix("# t = ").and_then(|rest| rest.trim_end_matches(" s").parse().ok());
        let time = time.ok_or_else(|| format!("begins with {first:?}; `# t = TIME s` was expected"))?;
        let table = Table::parse(text)?;
        let columns = table.columns.join(",");
        let with_stresses = columns == header(true);
        if columns != HEADER && !with_stresses {
            return Err(format!("has other columns than {HEADER}, with those of stresses or without"));
        }
        let plane = |row: &csv::StringRecord| {
            let cells: Result<Vec<f64>, _> = row.iter().map(str::parse::<f64>).collect();
            match cells.as_deref() {
                Ok(&[at, width, solid_fraction, ux, uy, uz, vx, vy, vz, ref more @ ..])
                    if with_stresses != more.is_empty() =>
                {
                    Ok(Plane {
                        at,
                        width,
                        solid_fraction,
                        fluid_velocity: [ux, uy, uz].map(known),
                        grain_velocity: [vx, vy, vz].map(known),
                        stresses: Stresses::of_cells(more),
                    })
                }
                _ => Err(format!("the line {:?} is not a number for each column", line(row))),
            }
        };
        Ok(Self { times: vec![(time, 1.0)], planes: table.rows.iter().map(plane).collect::<Result<_, _>>()? })
    }

    /// Time of the last sample, s.
    pub fn time(&self) -> f64 {
        self.times.last().map_or(f64::NAN, |(time, _)| *time)
    }

    /// Mean over the time from `from`, s, to the last of `samples` of the same planes: each stands for the
    /// time to which it is the nearest, and each phase is weighed with how much of it there is.
    pub fn mean(samples: &[Self], from: f64) -> Option<Self> {
        let last = samples.last()?;
        let mut mean = last.clone();
        mean.times = parts(samples, from);
        for (k, plane) in mean.planes.iter_mut().enumerate() {
            let here = samples.iter().zip(&mean.times);
            let here: Vec<(f64, &Plane)> =
                here.filter_map(|(sample, (_, part))| Some((*part, sample.planes.get(k)?))).collect();
            let over = |velocity: fn(&Plane) -> [f64; 3], share: fn(&Plane) -> f64| {
                let total: f64 = here.iter().map(|(part, p)| part * share(p)).sum();
                std::array::from_fn(|c| {
                    let sum: f64 = here.iter().map(|(part, p)| part * share(p) * velocity(p)[c]).sum();
                    if total > 0.0 { sum / total } else { 0.0 }
                })
            };
            plane.fluid_velocity = over(|p| p.fluid_velocity, |p| 1.0 - p.solid_fraction);
            plane.grain_velocity = over(|p| p.grain_velocity, |p| p.solid_fraction);
            plane.stresses = mean_stresses(&here, plane.grain_velocity);
            plane.solid_fraction = here.iter().map(|(part, p)| part * p.solid_fraction).sum();
        }
        Some(mean)
    }

    /// Mean of a velocity over the volume of all planes, m/s: (phase, component), phase 0 fluid, 1 grains.
    /// Across the radius planes are `rings`.
    pub(super) fn mean_velocity(&self, phase: usize, component: usize, rings: bool) -> f64 {
        let (mut sum, mut total) = (0.0, 0.0);
        for p in &self.planes {
            let volume = p.width * if rings { p.at } else { 1.0 };
            let (velocity, share) = match phase {
                0 => (p.fluid_velocity, 1.0 - p.solid_fraction),
                _ => (p.grain_velocity, p.solid_fraction),
            };
            sum += share * volume * velocity[component];
            total += share * volume;
        }
        sum / total
    }

    /// Planes above the last one that has a solid fraction of `fraction`.
    pub(super) fn above_surface(&self, fraction: f64) -> Option<&[Plane]> {
        let last = self.planes.iter().rposition(|p| p.solid_fraction >= fraction)?;
        self.planes.get(last + 1..).filter(|above| !above.is_empty())
    }

    /// Rate of shear of the fluid where the solid fraction falls below `fraction` for the last time, 1/s.
    pub(super) fn shear_at_surface(&self, fraction: f64) -> Option<f64> {
        let above = self.planes.iter().rposition(|p| p.solid_fraction >= fraction)? + 1;
        let (a, b) = (&self.planes[above - 1], self.planes.get(above)?);
        let square: f64 = (0..3).map(|c| (b.fluid_velocity[c] - a.fluid_velocity[c]).powi(2)).sum();
        Some(square.sqrt() / (b.at - a.at))
    }
}

/// Times of `samples` with the part of the time from `from`, s, to the last to which each is the nearest.
fn parts(samples: &[Planes], from: f64) -> Vec<(f64, f64)> {
    let times: Vec<f64> = samples.iter().map(Planes::time).collect();
    let middles = times.windows(2).map(|pair| 0.5 * (pair[0] + pair[1]));
    let edges: Vec<f64> = std::iter::once(from).chain(middles).chain(times.last().copied()).collect();
    let whole = edges[times.len()] - from;
    let part = |k: usize| match whole > 0.0 {
        true => (edges[k + 1] - edges[k].max(from)).max(0.0) / whole,
        false => 1.0 / times.len() as f64,
    };
    times.iter().enumerate().map(|(k, time)| (*time, part(k))).collect()
}

/// Mean of the stresses of one plane at samples, with their parts of it. The granular temperature is that
/// about the mean velocity of the grains over all samples, `mean`.
fn mean_stresses(samples: &[(f64, &Plane)], mean: [f64; 3]) -> Option<Stresses> {
    let all: Vec<(f64, &Plane, Stresses)> =
        samples.iter().filter_map(|(part, p)| Some((*part, *p, p.stresses?))).collect();
    let axes = if samples.iter().all(|(_, p)| p.fluid_velocity[1] == 0.0) { 2.0 } else { 3.0 };
    let about = |p: &Plane| (0..3).map(|c| (p.grain_velocity[c] - mean[c]).powi(2)).sum::<f64>() / axes;
    let over = |of: &dyn Fn(&Plane, &Stresses) -> f64| -> f64 {
        all.iter().map(|(part, p, stresses)| part * of(p, stresses)).sum()
    };
    let solid = over(&|p, _| p.solid_fraction);
    let fluctuation = over(&|p, s| p.solid_fraction * (s.temperature + about(p)));
    (!all.is_empty()).then(|| Stresses {
        pressure: over(&|_, s| s.pressure),
        temperature: if solid > 0.0 { fluctuation / solid } else { 0.0 },
        parts: std::array::from_fn(|part| std::array::from_fn(|c| over(&|_, s| s.parts[part][c]))),
    })
}

/// A velocity as it was written, zero in place of NaN: there is none of the phase.
fn known(velocity: f64) -> f64 {
    if velocity.is_nan() { 0.0 } else { velocity }
}

impl std::fmt::Display for Planes {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let with_stresses = self.planes.iter().any(|p| p.stresses.is_some());
        writeln!(f, "# t = {} s\n{}", self.time(), header(with_stresses))?;
        for p in &self.planes {
            write!(f, "{},{},{}", p.at, p.width, p.solid_fraction)?;
            for (velocity, share) in
                [(p.fluid_velocity, 1.0 - p.solid_fraction), (p.grain_velocity, p.solid_fraction)]
            {
                for v in velocity {
                    write!(f, ",{}", if share > 0.0 { v } else { f64::NAN })?;
                }
            }
            for cell in p.stresses.filter(|_| with_stresses).into_iter().flat_map(Stresses::to_cells) {
                write!(f, ",{cell}")?;
            }
            f.write_char('\n')?;
        }
        Ok(())
    }
}

/// The samples of a run and their mean.
#[derive(Clone, Debug, Default)]
pub(super) struct Record {
    samples: Vec<Planes>,
    pub(super) mean: Option<Planes>,
}

impl Record {
    /// Reads the samples in `fields` up to `time` (s), and takes the mean over those that `asked` names.
    pub(super) fn read(fields: &Path, asked: &ObservedPlanes, time: f64) -> Result<Self, OutputError> {
        let mut samples = Vec::new();
        let entries = std::fs::read_dir(fields).map_err(OutputError::file("read", fields))?;
        for entry in entries {
            let path = entry.map_err(OutputError::file("read", fields))?.path();
            let name = path.file_name().and_then(|name| name.to_str()).unwrap_or("");
            if name.starts_with(NAME) && name.ends_with(".csv") {
                let text = std::fs::read_to_string(&path).map_err(OutputError::file("read", &path))?;
                let sample = Planes::parse(&text);
                samples.push(sample.map_err(|what| OutputError::Content { path: path.clone(), what })?);
            }
        }
        samples.retain(|sample| sample.time() <= time * (1.0 + 1e-12));
        samples.sort_by(|a, b| a.time().total_cmp(&b.time()));
        let counts = |sample: &&Planes| asked.counts(sample.time());
        let inside: Vec<Planes> = samples.iter().filter(counts).cloned().collect();
        Ok(Self { mean: Planes::mean(&inside, asked.from), samples })
    }

    pub(super) fn table(&self) -> Option<String> {
        self.mean.as_ref().map(Planes::to_string)
    }

    /// The sample nearest to time `t`, s, if the run came so far.
    pub(super) fn nearest(&self, t: f64) -> Option<&Planes> {
        let apart = |sample: &Planes| (sample.time() - t).abs();
        self.samples.last().filter(|last| last.time() >= t * (1.0 - 1e-9))?;
        self.samples.iter().min_by(|a, b| apart(a).total_cmp(&apart(b)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A bed of solid fraction ½ up to z = 2 that creeps, below fluid sheared at rate 3.
    fn sample(time: f64, speed: f64) -> Planes {
        let plane = |k: usize| {
            let at = 0.25 + 0.5 * k as f64;
            let solid = if at < 2.0 { 0.5 } else { 0.0 };
            Plane {
                at,
                width: 0.5,
                solid_fraction: solid,
                fluid_velocity: [3.0 * at, 0.0, 0.0],
                grain_velocity: [if solid > 0.0 { speed } else { 0.0 }, 0.0, 0.0],
                stresses: None,
            }
        };
        Planes { times: vec![(time, 1.0)], planes: (0..8).map(plane).collect() }
    }

    #[test]
    fn a_file_reads_back_to_the_same_bits() {
        let planes = sample(1.0 / 3.0, 0.1);
        assert!(
            planes.to_string().ends_with(",0,11.25,0,0,NaN,NaN,NaN\n"),
            "no grains: no velocity of theirs"
        );
        assert_eq!(Planes::parse(&planes.to_string()), Ok(planes));
        assert!(Planes::parse("").is_err());
        assert!(Planes::parse("# t = 1 s\nz\n").unwrap_err().contains("other columns"));
    }

    /// Also with stresses; of two samples whose grains creep at 0.1 and 0.3 the temperature is about 0.2.
    #[test]
    fn stresses_read_back_and_fluctuations_are_about_the_mean_over_time() {
        let with = |time: f64, speed: f64| {
            let mut planes = sample(time, speed);
            for (k, plane) in planes.planes.iter_mut().enumerate() {
                let parts = std::array::from_fn(|part| [1.0, 0.0, time].map(|x| x * (part + k) as f64));
                plane.stresses = Some(Stresses { pressure: 3.0 * time, temperature: 0.5, parts });
            }
            planes
        };
        let planes = with(1.0 / 3.0, 0.1);
        assert_eq!(Planes::parse(&planes.to_string()), Ok(planes.clone()));
        let cut = planes.to_string().replace(",lubrication_stress_z", "");
        assert!(Planes::parse(&cut).unwrap_err().contains("other columns"));
        let mean = Planes::mean(&[with(1.0, 0.1), with(2.0, 0.3)], 1.0).unwrap();
        let [low, high] = [0, 7].map(|k: usize| mean.planes[k].stresses.unwrap());
        assert!((low.temperature - (0.5 + 0.01 / 2.0)).abs() < 1e-15, "{low:?}");
        assert_eq!((high.temperature, high.pressure, high.parts[4]), (0.0, 4.5, [11.0, 0.0, 16.5]));
    }

    /// A speed of 1 + 2 t over 0.5 to 4, whose samples lie close where it is fast; and a whole period of four
    /// samples with both its ends.
    #[test]
    fn the_mean_is_over_time_however_the_samples_lie() {
        let mean = |times: &[f64], from: f64, speed: &dyn Fn(f64) -> f64| {
            let samples: Vec<Planes> = times.iter().map(|t| sample(*t, speed(*t))).collect();
            Planes::mean(&samples, from).unwrap().planes[0].grain_velocity[0]
        };
        let linear = |t: f64| 1.0 + 2.0 * t;
        assert!((mean(&[0.5, 2.0, 3.0, 3.5, 3.75, 4.0], 0.5, &linear) - 5.5).abs() < 1e-14);
        assert!((mean(&[1.0, 2.0, 3.0, 4.0], 0.5, &|_| 7.0) - 7.0).abs() < 1e-14);
        let wave = |t: f64| 2.0 + (0.5 * std::f64::consts::PI * t).cos();
        assert!((mean(&[4.0, 5.0, 6.0, 7.0, 8.0], 4.0, &wave) - 2.0).abs() < 1e-14);
        assert_eq!(mean(&[4.0], 4.0, &linear), 9.0);
    }

    #[test]
    fn phases_are_weighed_with_how_much_of_them_there_is() {
        let mean = Planes::mean(&[sample(1.0, 0.1), sample(2.0, 0.3)], 1.0).unwrap();
        assert!((mean.mean_velocity(1, 0, false) - 0.2).abs() < 1e-15);
        // fluid: half of z < 2 at a mean speed of 3, all of 2 < z < 4 at 9
        assert!((mean.mean_velocity(0, 0, false) - (1.0 * 3.0 + 2.0 * 9.0) / 3.0).abs() < 1e-14);
        assert_eq!(Planes::mean(&[], 0.0), None);
        // Poiseuille's flow in a tube, across the radius: twice the mean in the middle.
        let ring = |k: u32| {
            let at = (f64::from(k) + 0.5) / 400.0;
            Plane {
                at,
                width: 1.0 / 400.0,
                fluid_velocity: [0.0, 0.0, 2.0 - 2.0 * at * at],
                ..Plane::default()
            }
        };
        let tube = Planes { times: vec![(0.0, 1.0)], planes: (0..400).map(ring).collect() };
        assert!((tube.mean_velocity(0, 2, true) - 1.0).abs() < 1e-5);
    }

    #[test]
    fn the_shear_is_that_at_the_surface_of_the_nearest_sample() {
        let record = Record { samples: vec![sample(1.0, 0.0), sample(2.0, 0.0)], mean: None };
        let nearest = record.nearest(1.9).unwrap();
        assert_eq!(nearest.time(), 2.0);
        assert!((nearest.shear_at_surface(0.3).unwrap() - 3.0).abs() < 1e-12);
        assert_eq!(record.nearest(2.000_000_000_000_000_4).map(|sample| sample.time()), Some(2.0));
        assert_eq!((record.nearest(9.0), nearest.shear_at_surface(0.6)), (None, None));
    }
}
