//! The scene's `[dem]` section, and the way from a scene to a [`DemSpec`].

use std::path::PathBuf;

use bedload_scene::{
    CheckedScene, Freedom as LockedFreedom, Geometry, Motion as SceneMotion, Retired, SceneError,
};
use protocol::facts::DemFacts;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::error::SpecError;
use crate::facts::{StepChoice, facts};
use crate::grain::{Grain, Shape};
use crate::laws::linear::LinearSpringDashpot;
use crate::laws::table::ContactLaw;
use crate::laws::walls::{Servo, Wall};
use crate::lubrication::law::LineResolution;
use crate::lubrication::settings::{Lubrication, LubricationSettings};
use crate::motion::{Freedom, Motion};
use crate::spec::{DemSpec, Integrator};

/// Roughness η/R where a coupled scene names none (Izard et al. 2014, §4.1).
const ROUGHNESS: f64 = 4e-4;

/// The `[dem]` section.
#[derive(Clone, Debug, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct DemSection {
    /// Command of another DEM code in place of `bedload-dem` (read by the coupler).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub command: Option<Vec<String>>,
    /// Contact law; needed as soon as a grain can touch a grain or a wall.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub contact: Option<ContactLaw>,
    /// Lubrication between near surfaces, η/R = 4e-4. Default: none in a dry scene; with a fluid `complement`
    /// up to four cells (at most 0.8 R) for spheres, up to two cells (at most R/2) for discs; none where a
    /// body is not round.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub lubrication: Option<Lubrication>,
    /// What the fluid resolves of films between discs, the rest being the DEM's: `mask` (default) or
    /// `points`. The fluid's method decides it, and `bedload` hands it over; a DEM alone may be given it.
    pub line_film: LineFilm,
    /// Time integration.
    pub integrator: Integrator,
    /// Sub-step, s. Default: contact time over `steps_per_contact`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub dt: Option<f64>,
    /// Sub-steps in a contact time: 20 and more are accurate, below 10 is refused.
    pub steps_per_contact: f64,
    /// Output folder of another run of the same grains, whose last state is the first of this one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub initial_state: Option<PathBuf>,
    /// Take a sub-step above t_c/10 all the same.
    pub allow_coarse_dt: bool,
}

/// How the fluid holds discs, for the films between them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum LineFilm {
    /// By a mask of cells.
    #[default]
    Mask,
    /// At points of the bodies.
    Points,
}

impl Default for DemSection {
    fn default() -> Self {
        Self {
            command: None,
            contact: None,
            lubrication: None,
            line_film: LineFilm::default(),
            integrator: Integrator::default(),
            dt: None,
            steps_per_contact: 50.0,
            initial_state: None,
            allow_coarse_dt: false,
        }
    }
}

#[derive(Deserialize)]
struct Doc {
    #[serde(default)]
    dem: DemSection,
}

/// A scene ready for the DEM.
#[derive(Clone, Debug)]
pub struct Config {
    /// What the solver is made of.
    pub spec: DemSpec,
    /// What the coupler is told.
    pub facts: DemFacts,
    /// Where the first state comes from, if not from the scene.
    pub initial_state: Option<PathBuf>,
}

/// Names that this section had before.
const RETIRED: &[Retired] = &[
    Retired::value("dem.contact.form", "seed", "\"izard-2014\""),
    Retired::value(
        "dem.contact.law",
        "hertz-mindlin",
        "\"linear-spring-dashpot\" with its contact_time or stiffness",
    ),
    Retired::dropped(
        "dem.contact.sliding",
        "leave it out: the tangential spring is cut back while the contact slides",
    ),
    Retired::dropped(
        "dem.contact.lever_arm",
        "leave it out: the tangential force attacks in the middle of the overlap",
    ),
    Retired::value("dem.lubrication.form", "continuous", "\"complement\""),
    Retired::dropped(
        "dem.lubrication.film",
        "leave it out: spheres have the film of a point, discs that of a line",
    ),
    Retired::dropped(
        "dem.lubrication.integration",
        "leave it out: films are implicit, stable at any sub-step",
    ),
    Retired::dropped(
        "dem.lubrication.sweeps",
        "leave it out: eight sweeps at most, fewer where they have converged",
    ),
    Retired::dropped("dem.skin", "leave it out: the width of the neighbour lists follows from the motion"),
    Retired::dropped(
        "dem.engine",
        "leave it out: the program takes the faster engine that knows all that the scene asks for",
    ),
];

impl Config {
    /// Reads and checks `[dem]` and lays out the grains.
    ///
    /// # Errors
    /// [`SceneError`] with the key and the remedy.
    pub fn new(scene: &CheckedScene) -> Result<Self, SceneError> {
        scene.source.refuse_retired(RETIRED)?;
        let Doc { mut dem } = scene.source.section()?;
        let spec = spec(scene, &mut dem)?;
        if let Err(fault) = spec.validate() {
            return Err(refusal(scene, &fault));
        }
        if scene.scene.observe.profile.is_some() {
            refuse_averages(scene, "observe.profile")?;
        }
        let resolved = toml::Table::try_from(&dem).unwrap_or_default();
        let step =
            StepChoice { dt: dem.dt, steps_per_contact: dem.steps_per_contact, coarse: dem.allow_coarse_dt };
        let facts = facts(scene, &spec, &step, resolved)?;
        Ok(Self { spec, facts, initial_state: dem.initial_state })
    }
}

/// Averages over grains are over boxes, and spread each of them over its circle: a cylinder is no box, and a
/// body that is not round has no circle.
pub(crate) fn refuse_averages(scene: &CheckedScene, key: &str) -> Result<(), SceneError> {
    scene.source.refuse_if(
        scene.scene.domain.geometry == Geometry::Axisymmetric,
        key,
        "averages over boxes, and an axisymmetric scene is a cylinder; allowed: a plane, and space",
        "leave it out, or take planes of the fluid (observe.planes)",
    )?;
    let odd = scene.grains.iter().position(|grain| !grain.shape.is_round());
    odd.map_or(Ok(()), |i| {
        let fault =
            format!("averages over round grains, and grain {i} is not round; allowed: spheres and discs");
        Err(scene.source.error(key, fault, "leave it out, or average the outlines of bodies_*.vtp"))
    })
}

/// The fault at the key it is about.
fn refusal(scene: &CheckedScene, fault: &SpecError) -> SceneError {
    let (key, remedy) = match fault {
        SpecError::Grain { grain, .. } => (format!("grains[{grain}]"), "mend this grain"),
        SpecError::Wall { wall, .. } if *wall < scene.scene.walls.len() => {
            (format!("walls[{wall}]"), "mend this wall")
        }
        SpecError::Wall { .. } => ("domain.boundary".to_owned(), "mend the faces of the box"),
        SpecError::Model { model: "lubrication", quantity: "viscosity", .. } => {
            ("dem.lubrication".to_owned(), "write form = \"none\", or add [medium]")
        }
        SpecError::Model { model: "lubrication", quantity, .. } => {
            (format!("dem.lubrication.{quantity}"), "give a value in that range")
        }
        SpecError::Model { model: "gravity", .. } => ("gravity".to_owned(), "give finite numbers"),
        SpecError::Model { quantity, .. } => {
            (format!("dem.contact.{quantity}"), "give a value in that range")
        }
        SpecError::Period { .. } if scene.scene.medium.is_none() => {
            ("domain.upper".to_owned(), "make the box longer, or the grains smaller")
        }
        SpecError::Period { .. } => {
            ("domain.upper".to_owned(), "make the box longer, or dem.lubrication.cut_off smaller")
        }
        SpecError::Combination(_) if scene.scene.observe.energy => {
            ("observe.energy".to_owned(), "leave the key out, or mend what is named")
        }
        SpecError::Combination(_) => {
            ("dem.integrator".to_owned(), "change the integrator, or write dem.lubrication.form = \"none\"")
        }
        SpecError::Missing { quantity, .. } => (format!("dem.contact.{quantity}"), "add one of the two keys"),
        SpecError::Body { key, remedy, .. } => ((*key).to_owned(), *remedy),
        SpecError::Engine(_) => ("dem".to_owned(), "mend what is named"),
    };
    scene.source.error(&key, fault.to_string(), remedy)
}

fn spec(scene: &CheckedScene, dem: &mut DemSection) -> Result<DemSpec, SceneError> {
    let shared = &scene.scene;
    let mut walls: Vec<Wall> = scene.contact_walls().iter().map(wall).collect();
    let can_touch = scene.grains.len() > 1 || !walls.is_empty();
    if dem.contact.is_none() && can_touch {
        let remedy =
            "add [dem.contact] with law = \"linear-spring-dashpot\", restitution, contact_time and friction";
        return Err(scene.source.error(
            "dem.contact",
            "is missing: there is no contact law, but grains can touch a grain or a wall",
            remedy,
        ));
    }
    // Never used where nothing can touch.
    let contact = dem
        .contact
        .unwrap_or_else(|| ContactLaw::LinearSpringDashpot(LinearSpringDashpot::new(1.0, 1.0, 0.0)));
    for (number, wall) in walls.iter_mut().enumerate().take(shared.walls.len()) {
        wall.servo = follow(scene, number)?;
    }
    let lubrication = dem.lubrication.get_or_insert_with(|| default_lubrication(scene));
    // A film without a fluid is refused below.
    if let Lubrication::Complement(settings) = lubrication
        && shared.medium.is_some()
    {
        settings.resolved_length.get_or_insert(coarsest_spacing(scene));
    }
    let lubrication = *lubrication;
    let mut outlines = Vec::new();
    let grains = scene.grains.iter().map(|grain| {
        let outline = grain.outline().map(|outline| {
            outlines.push(outline);
            outlines.len() as u32 - 1
        });
        Grain { outline, ..self::grain(grain, shared.domain.geometry) }
    });
    let spec = DemSpec::new(grains.collect(), contact);
    Ok(DemSpec {
        shape: if shared.domain.geometry == Geometry::Plane { Shape::Disc } else { Shape::Sphere },
        outlines,
        walls,
        periods: shared.domain.periods(),
        gravity: shared.gravity.clone(),
        lubrication,
        line_resolution: match dem.line_film {
            LineFilm::Mask => LineResolution::MASK,
            LineFilm::Points => LineResolution::POINTS,
        },
        viscosity: shared.medium.as_ref().map_or(0.0, |medium| medium.viscosity),
        fluid_density: shared.medium.as_ref().map_or(0.0, |medium| medium.density),
        integrator: dem.integrator,
        energy: shared.observe.energy,
        split: shared.observe.substeps.is_some(),
        ..spec
    })
}

/// The lubrication that the fluid does not resolve.
fn default_lubrication(scene: &CheckedScene) -> Lubrication {
    let radii = || scene.grains.iter().map(|grain| grain.radius);
    let (smallest, largest) = (radii().fold(f64::INFINITY, f64::min), radii().fold(0.0, f64::max));
    let round = scene.grains.iter().all(|grain| grain.shape.is_round());
    if scene.scene.medium.is_none() || largest == 0.0 || !round {
        return Lubrication::None;
    }
    let plane = scene.scene.domain.geometry == Geometry::Plane;
    let (count, most) = if plane { (2.0, 0.5) } else { (4.0, 0.8) };
    let cells = count * coarsest_spacing(scene);
    let cut_off = (cells / smallest).min(most);
    // As many cells between large grains as between small ones.
    let longest = (smallest < largest).then_some(cells);
    Lubrication::Complement(LubricationSettings { cut_off, longest, ..LubricationSettings::new(ROUGHNESS) })
}

/// Widest cell near the grains, m.
fn coarsest_spacing(scene: &CheckedScene) -> f64 {
    let domain = &scene.scene.domain;
    (0..domain.dimensions()).map(|axis| domain.spacing(axis)).fold(0.0, f64::max)
}

/// The servo of wall `number`, as heavy as one layer of the free grains (docs/equations.md).
fn follow(scene: &CheckedScene, number: usize) -> Result<Option<Servo>, SceneError> {
    let wall = &scene.scene.walls[number];
    let Some(servo) = &wall.servo else { return Ok(None) };
    let free = || scene.grains.iter().filter(|grain| grain.motion == SceneMotion::Free);
    let count = free().count() as f64;
    if count == 0.0 {
        let what = "follows the pressure of grains, and none is free";
        let remedy = "add grains, or leave `servo` out";
        return Err(scene.source.error(&format!("walls[{number}].servo"), what, remedy));
    }
    let diameter = free().map(|grain| 2.0 * grain.radius).sum::<f64>() / count;
    let mass = free().map(bedload_scene::Grain::mass).sum::<f64>() / count;
    let area = wall.area(&scene.scene.domain).unwrap_or_default();
    Ok(Some(Servo {
        pressure: servo.pressure.clone(),
        area,
        largest_speed: servo.largest_speed,
        mass: area / diameter.powi(scene.scene.domain.dimensions() as i32 - 1) * mass,
    }))
}

fn wall(wall: &bedload_scene::Wall) -> Wall {
    Wall {
        velocity: wall.velocity.clone(),
        spin: wall.spin.clone(),
        about: wall.about,
        from: wall.from,
        until: Some(wall.until).filter(|until| until.is_finite()),
        ..Wall::new(wall.point, wall.normal)
    }
}

fn grain(grain: &bedload_scene::Grain, geometry: Geometry) -> Grain {
    use LockedFreedom::{SpinX, SpinY, SpinZ, X, Y, Z};
    let is_free = |freedom| grain.is_free(freedom, geometry);
    let motion = match grain.motion {
        SceneMotion::Free => Motion::Free,
        SceneMotion::Fixed => Motion::Fixed,
        SceneMotion::Prescribed => {
            Motion::Prescribed { velocity: grain.velocity.clone(), spin: grain.spin.clone() }
        }
    };
    Grain {
        velocity: grain.velocity.start(),
        spin: grain.spin.start(),
        orientation: grain.orientation,
        motion,
        wall: grain.wall.map(|wall| wall as u32),
        free: Freedom {
            translation: [is_free(X), is_free(Y), is_free(Z)],
            rotation: [is_free(SpinX), is_free(SpinY), is_free(SpinZ)],
        },
        ..Grain::new(grain.position, grain.radius, grain.density)
    }
}
