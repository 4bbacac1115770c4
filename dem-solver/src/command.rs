//! `bedload-dem`, and its command `coarse-grain DIR`: fields of a continuum from the last state of a run.

use std::path::PathBuf;
use std::process::ExitCode;

use bedload_output::atomic_write;
use bedload_output::vtk::{Array, image};
use bedload_program::{Failure, RunOptions};
use bedload_scene::{Axis, CheckedScene, Profile as Asked};
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
    #[arg(long, default_value = "z", value_parser = ["x", "y", "z"])]
    axis: String,
    /// Numbers of cells of a grid, as NX,NY,NZ; writes VTI
    #[arg(long, value_name = "NX,NY,NZ", value_parser = three::<usize>)]
    cells: Option<[usize; 3]>,
    /// Width of the Gaussian on the grid, m; by default the largest radius
    #[arg(long, value_name = "W")]
    width: Option<f64>,
    /// Lower corner X,Y,Z of the region, m; by default the box
    #[arg(long, value_name = "X,Y,Z", value_parser = three::<f64>, allow_hyphen_values = true)]
    lower: Option<[f64; 3]>,
    /// Upper corner, m
    #[arg(long, value_name = "X,Y,Z", value_parser = three::<f64>, allow_hyphen_values = true)]
    upper: Option<[f64; 3]>,
    /// File to write; by default coarse-grain.csv or .vti in the folder
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
}

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
    let mut participant = DemParticipant::new(&scene, &arguments.folder)?;
    let (_, state) = checkpoint::read_any::<State>(&checkpoints::newest_of_run(&arguments.folder), "dem")?;
    participant.adopt(&state)?;
    let (lower, upper) = region(arguments, &scene);
    let (name, bytes) = if let Some(slabs) = arguments.slabs {
        let axis = [Axis::X, Axis::Y, Axis::Z]["xyz".find(&arguments.axis).unwrap_or(2)];
        let asked = Asked { axis, lower, upper, slabs: slabs.max(1) };
        let profile =
            Profile::new(&asked, participant.spec(), &participant.dem().grains, &participant.contacts());
        ("coarse-grain.csv", profile.table(&[]).into_bytes())
    } else {
        ("coarse-grain.vti", on_grid(arguments, &participant, lower, upper))
    };
    let path = arguments.out.clone().unwrap_or_else(|| arguments.folder.join(name));
    atomic_write(&path, &bytes)?;
    Ok(path)
}

fn region(arguments: &Arguments, scene: &CheckedScene) -> ([f64; 3], [f64; 3]) {
    let domain = &scene.scene.domain;
    let mut corners = ([0.0; 3], [1.0; 3]);
    for axis in 0..domain.dimensions() {
        let c = domain.geometry.component(axis);
        (corners.0[c], corners.1[c]) = (domain.lower[axis], domain.upper[axis]);
    }
    (arguments.lower.unwrap_or(corners.0), arguments.upper.unwrap_or(corners.1))
}

fn on_grid(arguments: &Arguments, participant: &DemParticipant, lower: [f64; 3], upper: [f64; 3]) -> Vec<u8> {
    let (dem, spec) = (participant.dem(), participant.spec());
    let cells = arguments.cells.unwrap_or([1; 3]).map(|count| count.max(1));
    let spacing: [f64; 3] = std::array::from_fn(|c| (upper[c] - lower[c]) / cells[c] as f64);
    let width = arguments.width.unwrap_or(spec.largest_radius());
    let periods = spec.periods.map(|period| period.map(|(_, length)| length));
    let grid = Grid { lower, spacing, cells, width, periods };
    let averages =
        coarse_grain(&dem.grains, spec.shape, &participant.contacts(), &Partition::Grid(grid), |_| true);
    image(dem.time(), lower, spacing, cells, &arrays(&averages, spec.shape))
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
