//! The first state of a run from the last one of another: `medium.initial = { type = "run", folder = … }`.
//!
//! On the same grid, with the same method and the grains where that run left them, the run goes on:
//! everything that decides the next window is taken, and only time begins anew. Else velocity, pressure and
//! the carried force are interpolated ([`crate::interpolate`]); [`crate::solver::Solver`] then imposes the
//! grains' motion and projects, as at the start of any run.

use crate::boundary::Boundary;
use crate::build;
use crate::checkpoint::part::Head;
use crate::checkpoint::whole::{Whole, read_whole};
use crate::config::{Choices, FluidSection, SchemeKey};
use crate::coupling;
use crate::field::{State, copy_own, own_planes};
use crate::flow_rate::mean;
use crate::grid::Grid;
use crate::halo::{fill_scalar, fill_velocity_and_open};
use crate::health::Health;
use crate::immersed::body::Motion;
use crate::interpolate::{Kind, interpolate};
use crate::methods::grains::Memory;
use crate::methods::method::Method;
use crate::open::OpenFaces;
use crate::scene_grains;
use crate::scheme::Viscous;
use bedload_scene::{CheckedScene, InitialVelocity, Medium, Scene, SceneError, SceneSource, changing};
use protocol::checkpoints;
use std::path::Path;

/// The key at which all of it is refused.
const KEY: &str = "medium.initial.folder";

/// What to do where the folder holds no such run.
const NAME: &str =
    "name the output folder of a run of bedload with a fluid; paths count from the scene's folder";

/// What the fluid needs to know of the scene of a run: all but its grains, whose files may be gone.
const NEEDED: [&str; 6] = ["until", "gravity", "domain", "medium", "fluid", "coupling"];

/// Part of a length by which a box may reach beyond another one: digits of a decimal number.
const ROUNDING: f64 = 1e-9;

/// The last state of another run.
pub struct Start<const D: usize> {
    /// Its grid, whole.
    grid: Grid<D>,
    velocity: [Vec<f64>; D],
    /// What its checkpoint holds, but for the velocity, which is above.
    whole: Whole,
    /// Whether this run goes on with everything.
    goes_on: bool,
    /// Whether the same walls and forces move the fluid.
    same_drive: bool,
    /// Whether the grains are where it left them.
    same_grains: bool,
    /// Whether the carried force means the same in both.
    same_force: bool,
    /// Whether the convection of the last step does, if both treat viscosity alike.
    same_history: bool,
    /// Largest speed, m/s, and largest Σ|u|/Δx, 1/s.
    fastest: [f64; 2],
}

/// The state from which the run of a scene on `grid` starts, if it names one.
///
/// # Errors
/// At `medium.initial.folder`: what is wrong with the folder, or with that run as a start of this one.
pub fn read<const D: usize>(
    scene: &CheckedScene,
    choices: &Choices,
    grid: &Grid<D>,
) -> Result<Option<Start<D>>, SceneError> {
    let Some(InitialVelocity::Run { folder }) = scene.scene.medium.as_ref().map(|medium| &medium.initial)
    else {
        return Ok(None);
    };
    let refuse = |why: String, remedy: &str| {
        scene.source.error(KEY, format!("is {:?}, which {why}", folder.display().to_string()), remedy)
    };
    let (run, identities) = scene_of(folder).map_err(|why| refuse(why, NAME))?;
    let [mine, theirs] = [scene, &run].map(|scene| scene.scene.domain.geometry);
    if mine != theirs {
        return Err(refuse(
            format!("is a run in the geometry {theirs:?}; allowed: this scene's, {mine:?}"),
            "start from a run of the same geometry",
        ));
    }
    let unread = |error: SceneError| refuse(format!("has a scene.toml that says {error}"), NAME);
    let source = build::grid::<D>(&run).map_err(unread)?;
    outside(scene, &source, grid).map_err(|why| {
        refuse(why, "change domain.lower and domain.upper, or start from a run in another box")
    })?;
    let at = checkpoints::newest_of_run(folder);
    let (written_by, whole) = read_whole(&source, &at).map_err(|error| {
        let why = format!("holds no state of a fluid that can be read: {error}");
        refuse(why, "name the output folder of a run that wrote its last state, or make that run anew")
    })?;
    if !identities.iter().any(|identity| text_part(identity) == text_part(&written_by)) {
        return Err(refuse(
            format!(
                "has a checkpoint of another scene than its scene.toml ({written_by}, {})",
                identities[0]
            ),
            "make that run anew, so that both are of one scene",
        ));
    }
    let theirs = FluidSection::of_run(&run).map_err(unread)?.choices(choices.calibration);
    let start = Start::new(scene, &run, [choices, &theirs], grid, source, whole);
    let start = start.map_err(|error| refuse(error.to_string(), NAME))?;
    if !start.fastest.iter().all(|number| number.is_finite()) {
        return Err(refuse("ended with a velocity that is not finite".into(), "make that run anew"));
    }
    Ok(Some(start))
}

/// The scene of the run in `folder`, without its grains, and the identities that its checkpoint may bear: in
/// a coupled run the fluid is given that `scene.toml`, alone it has read the scene from which that was
/// written.
fn scene_of(folder: &Path) -> Result<(CheckedScene, Vec<String>), String> {
    if !folder.is_dir() {
        return Err("is no folder; allowed: the output folder of a run".into());
    }
    let path = folder.join("scene.toml");
    let text = protocol::input_file::read_text(&path)
        .map_err(|error| format!("holds no scene.toml that can be read ({error})"))?;
    let unread = |error: &dyn std::fmt::Display| format!("has a scene.toml that cannot be read: {error}");
    let mut table: toml::Table = toml::from_str(&text).map_err(|error| unread(&error))?;
    table.retain(|name, _| NEEDED.contains(&name));
    match table.get_mut("medium").and_then(toml::Value::as_table_mut) {
        None => return Err("is a dry run, which has no fluid".into()),
        // How that run began says nothing of its end.
        Some(medium) => medium.remove("initial"),
    };
    let file = path.display().to_string();
    let source = SceneSource { file: file.clone(), text: table.to_string() };
    let scene = CheckedScene::new(source).map_err(|error| unread(&error))?;
    let alone = bedload_output::state_of(&text).map(str::to_owned);
    let coupled = CheckedScene { source: SceneSource { file, text }, ..scene.clone() }.state_sha256();
    Ok((scene, [coupled].into_iter().chain(alone).collect()))
}

/// The part of an identity that is of the text: tables of the grains may have changed since.
fn text_part(identity: &str) -> &str {
    identity.split_once('-').map_or(identity, |(text, _)| text)
}

/// Why the box of the scene is not in that of `source`, if it is not.
fn outside<const D: usize>(scene: &CheckedScene, source: &Grid<D>, grid: &Grid<D>) -> Result<(), String> {
    for axis in 0..D {
        let ends = |grid: &Grid<D>| [grid.axes[axis].faces[0], grid.axes[axis].faces[grid.cells[axis]]];
        let ([low, high], [from, to]) = (ends(source), ends(grid));
        let slack = ROUNDING * (high - low);
        let letter = format!("{:?}", scene.scene.domain.geometry.axes()[axis]).to_lowercase();
        if source.periodic(axis) {
            let times = (to - from) / (high - low);
            if grid.periodic(axis) && (times - times.round()).abs() > ROUNDING {
                return Err(format!(
                    "comes again after {} m along {letter}; this scene's box is {} m long there, no whole multiple",
                    high - low,
                    to - from
                ));
            }
        } else if from < low - slack || to > high + slack {
            return Err(format!(
                "has its fluid at {low} to {high} m along {letter} only; this scene's reaches from {from} to {to} m"
            ));
        }
    }
    Ok(())
}

impl<const D: usize> Start<D> {
    fn new(
        scene: &CheckedScene,
        run: &CheckedScene,
        [mine, theirs]: [&Choices; 2],
        grid: &Grid<D>,
        mut source: Grid<D>,
        mut whole: Whole,
    ) -> Result<Self, SceneError> {
        source.boundaries = build::boundaries(run, whole.head.time);
        let mut open = OpenFaces::new(&source);
        for (to, from) in open.fields_mut().zip(whole.fields.iter().skip(3 * D + 1)) {
            if to.len() == from.len() {
                to.copy_from_slice(from);
            }
        }
        let mut velocity: [Vec<f64>; D] = std::array::from_fn(|d| std::mem::take(&mut whole.fields[d]));
        for (d, u) in velocity.iter_mut().enumerate() {
            fill_velocity_and_open(&source, &open, d, u);
        }
        fill_scalar(&source, &mut whole.fields[3 * D]);
        let health = Health::of(&source, &velocity);
        let largest = |u: &Vec<f64>| u.iter().fold(0.0, |most: f64, u| most.max(u.abs()));
        let speed = velocity.iter().map(|u| largest(u).powi(2)).sum::<f64>().sqrt();
        let fastest = if health.finite { [speed, health.rate] } else { [f64::NAN; 2] };

        let (now, left) = (scene_grains::motions(scene), &whole.head.memory.motions);
        let place = |motion: &Motion| motion.centre.map(f64::to_bits);
        let same_grains = now.len() == left.len() && now.iter().zip(left).all(|(a, b)| place(a) == place(b));
        let moves = |a: &Motion, b: &Motion| a.velocity == b.velocity && a.spin == b.spin;
        let turned =
            |grain: usize| scene.grains[grain].outline().is_some() && now[grain].angle != left[grain].angle;
        let same_motion =
            same_grains && (0..now.len()).all(|grain| moves(&now[grain], &left[grain]) && !turned(grain));

        let same_method = mine.method == theirs.method;
        let same_force = same_method && mine.method == Method::Calibrated;
        let same_order = coupling::read(scene, mine.method)?.0 == coupling::read(run, theirs.method)?.0;
        let viscosity = |scene: &CheckedScene| {
            scene.scene.medium.as_ref().map(bedload_scene::Medium::kinematic_viscosity)
        };
        let same_history = mine.scheme != SchemeKey::Ab2
            || mine.scheme == theirs.scheme
                && mine.time.convection == theirs.time.convection
                && viscosity(scene) == viscosity(run);
        // What changes over time is not where it was: the time of a run begins at zero.
        let same_drive = changing(scene).is_empty() && moved_by(scene) == moved_by(run);
        let goes_on = same_motion && same_method && same_order && same_grid(grid, &source);
        Ok(Self {
            grid: source,
            velocity,
            whole,
            goes_on,
            same_drive,
            same_grains,
            same_force,
            same_history,
            fastest,
        })
    }

    /// Largest speed, m/s, each component's put together.
    pub fn fastest(&self) -> f64 {
        self.fastest[0]
    }

    /// Bytes of its fields.
    pub fn bytes(&self) -> u64 {
        let fields = self.velocity.iter().chain(&self.whole.fields);
        8 * fields.map(|field| field.len() as u64).sum::<u64>()
    }

    /// Whether the run goes on with everything.
    pub fn goes_on(&self) -> bool {
        self.goes_on
    }

    /// The last step of a run that goes on, moved by the same walls and forces, and the largest Σ|u|/Δx after
    /// it, 1/s.
    pub(crate) fn last(&self) -> Option<(&Head, f64)> {
        let head = &self.whole.head;
        (self.goes_on && self.same_drive && head.previous_dt > 0.0).then_some((head, self.fastest[1]))
    }

    /// Everything, where the run goes on: `fields` are those of [`crate::solver::Solver::fields_mut`]. The
    /// length of the step before (zero where its convection is of no use with `viscous`) and the grains;
    /// nothing where the fields are others.
    pub(crate) fn take(
        &self,
        grid: &Grid<D>,
        viscous: Viscous,
        mut fields: Vec<&mut [f64]>,
    ) -> Option<(f64, Memory)> {
        let theirs = || self.velocity.iter().chain(&self.whole.fields[D..]);
        let fit = fields.iter().map(|field| field.len()).eq(theirs().map(Vec::len));
        if !self.goes_on || !fit {
            return None;
        }
        let (own, whole) = (own_planes(grid), grid.len());
        for (to, from) in fields.iter_mut().zip(theirs()) {
            copy_own(&own, whole, to, from);
        }
        let alike = self.same_history && self.whole.head.explicit == (viscous == Viscous::Explicit);
        let previous_dt = if alike { self.whole.head.previous_dt } else { 0.0 };
        Some((previous_dt, self.whole.head.memory.clone()))
    }

    /// Velocity and pressure on another grid. The velocity is to be projected.
    pub(crate) fn interpolate(&self, grid: &Grid<D>, state: &mut State<D>) {
        for (d, (from, to)) in self.velocity.iter().zip(&mut state.velocity).enumerate() {
            interpolate((&self.grid, from), (grid, to), d, Kind::Velocity);
        }
        let to = &mut state.pressure;
        interpolate((&self.grid, &self.whole.fields[3 * D]), (grid, to), D, Kind::Pressure);
        let mean = mean(grid, D, to);
        for row in grid.own_rows() {
            to[grid.row(row)..][..grid.cells[0]].iter_mut().for_each(|p| *p -= mean);
        }
        if grid.division.ranks().is_alone() {
            fill_scalar(grid, to);
        }
    }

    /// The carried force on another grid; whether there is one.
    pub(crate) fn interpolate_force(&self, grid: &Grid<D>, lambda: &mut [Vec<f64>; D]) -> bool {
        let from = &self.whole.fields[2 * D..3 * D];
        if !self.same_force || from.iter().chain(lambda.iter()).any(Vec::is_empty) {
            return false;
        }
        for (d, (from, to)) in from.iter().zip(lambda).enumerate() {
            interpolate((&self.grid, from), (grid, to), d, Kind::Force);
        }
        true
    }

    /// What it knows of the grains, if they are where it left them.
    pub(crate) fn memory(&self) -> Option<&Memory> {
        self.same_grains.then_some(&self.whole.head.memory)
    }
}

/// What moves the fluid: gravity, the faces of the box and the forces on the medium.
fn moved_by(scene: &CheckedScene) -> impl PartialEq + '_ {
    let Scene { gravity, domain, medium, .. } = &scene.scene;
    let faces: Vec<_> = (0..domain.dimensions()).map(|axis| domain.boundary(axis)).collect();
    let forces = medium.as_ref().map(|medium| {
        let Medium { density, viscosity, body_force, pressure_gradient, flow_rate, .. } = medium;
        (density, viscosity, body_force, pressure_gradient, flow_rate)
    });
    (gravity, faces, forces)
}

/// Whether fields of both mean the same: walls may move otherwise, and inflows enter faster or slower.
fn same_grid<const D: usize>(a: &Grid<D>, b: &Grid<D>) -> bool {
    let faces = a.boundaries.iter().flatten().zip(b.boundaries.iter().flatten());
    let walls = |a: &Boundary<D>| a.is_odd() && !a.is_open();
    let enter = |a: &Boundary<D>, b: &Boundary<D>| match (a, b) {
        (Boundary::Inflow { profile: a, .. }, Boundary::Inflow { profile: b, .. }) => a == b,
        _ => false,
    };
    a.geometry == b.geometry
        && a.axes.iter().zip(&b.axes).all(|(a, b)| a.faces == b.faces)
        && faces.into_iter().all(|(a, b)| a == b || walls(a) && walls(b) || enter(a, b))
}
