//! `bedload-dem`, and its command `coarse-grain DIR`: fields of a continuum from the last state of a run.

use std::path::PathBuf;
use std::process::ExitCode;

use bedload_output::vtk::{Array, image};
use bedload_output::{atomic_write, refuse_changed_files};
use bedload_program::{Failure, RunOptions};
use bedload_scene::{Axis, Domain, Geometry, Profile as Asked};
use clap::Parser;
use nalgebra::Matrix3;
use protocol::{checkpoint, checkpoints};

use crate::config::refuse_averages;
use crate::grain::Shape;
use crate::output::coarse_grain::{Cell, coarse_grain};
use crate::output::partition::{Grid, Partition};
use crate::output::profile::Profile;
use crate::participant::DemParticipant;
use crate::state::State;

/// Solid fraction, velocity and stress of the grains as a run left them (Goldhirsch 2010): over slabs
/// as a table, or on a grid for ParaView.
#[derive(Debug, Parser)]
#[command(name = "bedload-dem coarse-grain", version)]
struct Arguments {
    /// Output folder of a run with a checkpoint
    folder: PathBuf,
    /// Number of slabs; writes CSV
    #[arg(long, value_name = "N", conflicts_with = "cells", required_unless_present = "cells")]
    slabs: Option<usize>,
    /// Axis across the slabs
    #[arg(long, default_value = "z", value_parser = ["x", "y", "z"], conflicts_with = "cells")]
    axis: String,
    /// Numbers of cells of a grid, as NX,NY,NZ; writes VTI
    #[arg(long, value_name = "NX,NY,NZ", value_parser = three::<usize>)]
    cells: Option<[usize; 3]>,
    /// Width of the Gaussian on the grid, m; by default the largest radius
    #[arg(long, value_name = "W", conflicts_with = "slabs")]
    width: Option<f64>,
    /// Lower corner X,Y,Z of the region, m; by default the box. In the plane Y is of no account
    #[arg(long, value_name = "X,Y,Z", value_parser = three::<f64>, allow_hyphen_values = true)]
    lower: Option<[f64; 3]>,
    /// Upper corner, m
    #[arg(long, value_name = "X,Y,Z", value_parser = three::<f64>, allow_hyphen_values = true)]
    upper: Option<[f64; 3]>,
    /// New file to write; by default coarse-grain.csv or .vti in the folder
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
}

/// Most slabs, and most cells of a grid.
const MOST_SLABS: usize = 100_000;
const MOST_CELLS: usize = 10_000_000;

/// `A,B,C` as three numbers.
fn three<T: std::str::FromStr>(text: &str) -> Result<[T; 3], String> {
    let numbers: Option<Vec<T>> = text.split(',').map(|part| part.trim().parse().ok()).collect();
    let three = numbers.and_then(|numbers| <[T; 3]>::try_from(numbers).ok());
    three.ok_or_else(|| "three numbers with commas between them are needed".into())
}

/// The whole program: the one command that is about grains alone, or those of every solver.
pub fn main() -> ExitCode {
    if std::env::args().nth(1).as_deref() == Some("coarse-grain") {
        return average();
    }
    bedload_program::main::<DemParticipant>()
}

fn average() -> ExitCode {
    // The program's own name and the command's are one name here.
    let words = std::iter::once("bedload-dem coarse-grain".into()).chain(std::env::args_os().skip(2));
    match run(&Arguments::parse_from(words)) {
        Ok(path) => {
            println!("{}", path.display());
            ExitCode::SUCCESS
        }
        Err(error) => {
            error.explain("bedload-dem");
            ExitCode::from(error.exit_code())
        }
    }
}

fn run(arguments: &Arguments) -> Result<PathBuf, Failure> {
    // The scene as the run resolved it has another identity than the one that its checkpoint bears.
    let scene = RunOptions::of_scene(&arguments.folder.join("scene.toml")).read_scene()?;
    refuse_averages(&scene, "grains")?;
    // Radii and densities are those of the tables.
    refuse_changed_files(&scene, &scene.source.text)?;
    let mut participant = DemParticipant::new(&scene, &arguments.folder)?;
    let (_, state) = checkpoint::read_any::<State>(&checkpoints::newest_of_run(&arguments.folder), "dem")?;
    participant.adopt(&state)?;
    let whole = scene.scene.domain.corners();
    let [lower, upper] = region(arguments, &scene.scene.domain, whole)?;
    let (name, bytes) = if let Some(slabs) = arguments.slabs {
        let axis = [Axis::X, Axis::Y, Axis::Z]["xyz".find(&arguments.axis).unwrap_or(2)];
        if axis == Axis::Y && scene.scene.domain.geometry == Geometry::Plane {
            return refuse("--axis y", "goes out of the plane; allowed: x, z");
        }
        if !(1..=MOST_SLABS).contains(&slabs) {
            return refuse(&format!("--slabs {slabs}"), format_args!("allowed: 1 to {MOST_SLABS}"));
        }
        let asked = Asked { axis, lower, upper, slabs };
        let profile =
            Profile::new(&asked, participant.spec(), &participant.dem().grains, &participant.contacts());
        ("coarse-grain.csv", profile.table(&[]).into_bytes())
    } else {
        ("coarse-grain.vti", on_grid(arguments, &participant, [lower, upper], whole)?)
    };
    let path = arguments.out.clone().unwrap_or_else(|| arguments.folder.join(name));
    if arguments.out.is_some() && std::fs::symlink_metadata(&path).is_ok() {
        return refuse(&format!("--out {}", path.display()), "exists: name another file, or remove it");
    }
    atomic_write(&path, &bytes)?;
    Ok(path)
}

/// Refuses an option.
fn refuse<T>(option: &str, what: impl std::fmt::Display) -> Result<T, Failure> {
    Err(Failure::Input(format!("{option}: {what}")))
}

/// Lower and upper corner.
type Corners = [[f64; 3]; 2];

/// The region, in the box.
fn region(arguments: &Arguments, domain: &Domain, whole: Corners) -> Result<Corners, Failure> {
    let mut region = whole;
    for c in (0..3).filter(|c| *c != 1 || domain.geometry != Geometry::Plane) {
        for (corner, given) in region.iter_mut().zip([arguments.lower, arguments.upper]) {
            corner[c] = given.map_or(corner[c], |given| given[c]);
        }
    }
    match domain.no_part(region) {
        Some(what) => {
            refuse("--lower, --upper", format_args!("the region {what}, with --lower below --upper"))
        }
        None => Ok(region),
    }
}

fn on_grid(
    arguments: &Arguments,
    participant: &DemParticipant,
    [lower, upper]: Corners,
    whole: Corners,
) -> Result<Vec<u8>, Failure> {
    let (dem, spec) = (participant.dem(), participant.spec());
    let cells = arguments.cells.unwrap_or([1; 3]);
    let number =
        cells.iter().try_fold(1_usize, |number, count| number.checked_mul(*count)).unwrap_or(usize::MAX);
    let layers = if spec.shape == Shape::Disc { cells[1] } else { 1 };
    if !(1..=MOST_CELLS).contains(&number) || layers != 1 {
        let what =
            format!("allowed: 1 at least along each axis, 1 along y in the plane, {MOST_CELLS} in all");
        return refuse(&format!("--cells {cells:?}"), what);
    }
    let edges: [f64; 3] = std::array::from_fn(|c| upper[c] - lower[c]);
    let spacing: [f64; 3] = std::array::from_fn(|c| edges[c] / cells[c] as f64);
    let radius = spec.largest_radius();
    let width = arguments.width.unwrap_or(radius);
    let seen = (0..3).filter(|c| *c != 1 || spec.shape == Shape::Sphere);
    let allowed = 0.01 * radius..=seen.map(|c| edges[c]).fold(radius, f64::max);
    if !allowed.contains(&width) {
        let (least, most) = (allowed.start(), allowed.end());
        let what = format!(
            "allowed: {least} m, a hundredth of the largest radius, to {most} m, the longest edge of the region"
        );
        return refuse(&format!("--width {width}"), what);
    }
    let periods = spec.periods.map(|period| period.map(|(_, length)| length));
    let beyond = std::array::from_fn(|c| {
        [lower[c] - whole[0][c], whole[1][c] - upper[c]].map(|room| (room / spacing[c] + 1e-9) as usize)
    });
    let grid = Grid { lower, spacing, cells, beyond, width, periods };
    let averages =
        coarse_grain(&dem.grains, spec.shape, &participant.contacts(), &Partition::Grid(grid), |_| true);
    Ok(image(dem.time(), lower, spacing, cells, &arrays(&averages, spec.shape)))
}

fn arrays(cells: &[Cell], shape: Shape) -> Vec<Array> {
    let scalar = |name, of: &dyn Fn(&Cell) -> f64| Array::scalar(name, cells.iter().map(of).collect());
    let tensor = |name, of: &dyn Fn(&Cell) -> Matrix3<f64>| {
        Array::real(name, 9, cells.iter().flat_map(|cell| of(cell).data.0).flatten().collect())
    };
    let velocity = cells.iter().flat_map(|c| [c.velocity.x, c.velocity.y, c.velocity.z]);
    vec![
        scalar("solid_fraction", &|cell| cell.solid),
        scalar("density", &|cell| cell.density),
        scalar("pressure", &|cell| cell.pressure(shape)),
        Array::real("velocity", 3, velocity.collect()),
        // VTK takes tensors row by row, nalgebra keeps them column by column; the kinetic stress is symmetric
        tensor("stress", &|cell| cell.stress().transpose()),
        tensor("kinetic_stress", &|cell| cell.kinetic),
    ]
}
