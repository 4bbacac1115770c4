//! The `[fluid]` section: as typed ([`FluidSection`]) and as meant ([`Choices`]).

use crate::methods::calibrated::calibration::Calibration;
use crate::methods::method::Method;
use crate::methods::{fictitious, izard2014};
use bedload_scene::{CheckedScene, Retired, SceneError};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Time scheme.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum SchemeKey {
    /// Three-stage Runge–Kutta for convection, Crank–Nicolson for implicit viscosity.
    Rk3,
    /// Adams–Bashforth for convection, Crank–Nicolson for implicit viscosity.
    Ab2,
}

/// How viscosity is integrated.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum ViscosityKey {
    /// Any ν dt/Δx².
    Implicit,
    /// Cheaper; small ν dt/Δx² only.
    Explicit,
    /// Explicit where it does not shorten the step, else implicit.
    #[default]
    Auto,
}

/// `fluid.time`.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct TimeSection {
    /// `rk3` or `ab2`. Without it `ab2`; `rk3` with the method `izard-2014`, and where a fixed step is so
    /// long that ν dt/Δx² > 2, as an adaptive one never is beside grains.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub scheme: Option<SchemeKey>,
    /// `implicit`, `explicit` or `auto`.
    pub viscosity: ViscosityKey,
    /// Time step, s. Without it the step follows what happens.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub dt: Option<f64>,
    /// Largest dt Σ_a |u_a|/Δx_a of an adaptive step.
    pub cfl: f64,
    /// Convection; `false` is Stokes flow.
    pub convection: bool,
}

impl Default for TimeSection {
    fn default() -> Self {
        Self { scheme: None, viscosity: ViscosityKey::default(), dt: None, cfl: 0.5, convection: true }
    }
}

/// The `[fluid]` section.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct FluidSection {
    /// Command of a foreign fluid solver; the coupler's key, without meaning here.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub command: Option<Vec<String>>,
    /// What starts the fluid's ranks, such as `["mpirun", "-np", "4"]`, before the solver's own command; the
    /// coupler's key. Needs a solver built with `--features mpi`. With it the solve along the last axis (in
    /// space) is cut into blocks that depend on the grid alone, so that any number of ranks, one included,
    /// finds the same bits.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub launcher: Option<Vec<String>>,
    /// `calibrated` (default), `izard-2014` (Izard et al. 2014, as printed) or, for discs and other bodies of
    /// the plane, `fictitious-domain` (Yu & Shao 2007).
    pub method: Method,
    /// Time integration.
    pub time: TimeSection,
}

const METHOD: &str = "fluid.method, \"calibrated\" (default), \"izard-2014\" or \"fictitious-domain\"";
const BY_METHOD: &str =
    "leave it out: fluid.method decides it (\"calibrated\", \"izard-2014\" or \"fictitious-domain\")";
/// ν dt/Δx² of a step that is long for Crank–Nicolson in one stage. Adaptive steps stay below it beside
/// grains ([`crate::plan`]).
pub(crate) const LONG: f64 = 2.0;

const LEVELS: &str = "leave it out: an adaptive step has four lengths in an octave";

/// Names that this section had before.
const RETIRED: &[Retired] = &[
    Retired::value("fluid.immersed.method", "carried", "fluid.method = \"calibrated\""),
    Retired::value("fluid.immersed.method", "direct", "fluid.method = \"izard-2014\""),
    Retired::value("fluid.immersed.method", "fictitious-domain", "fluid.method = \"fictitious-domain\""),
    Retired::key("fluid.immersed.method", METHOD),
    Retired::dropped("fluid.immersed.mask", BY_METHOD),
    Retired::dropped("fluid.immersed.width", BY_METHOD),
    Retired::dropped("fluid.immersed.force_transport", BY_METHOD),
    Retired::dropped("fluid.immersed.mask_radius", BY_METHOD),
    Retired::dropped("fluid.immersed.viscous_sweeps", BY_METHOD),
    Retired::dropped("fluid.immersed.carry", BY_METHOD),
    Retired::key("fluid.immersed", METHOD),
    Retired::value("fluid.loads.form", "izard-2014", "fluid.method = \"izard-2014\""),
    Retired::dropped("fluid.loads.form", BY_METHOD),
    Retired::dropped("fluid.loads.virtual_mass", BY_METHOD),
    Retired::dropped("fluid.loads.displaced_mass", BY_METHOD),
    Retired::key("fluid.loads", METHOD),
    Retired::key(
        "fluid.division",
        "fluid.launcher (with it any number of ranks, one included, finds the same bits)",
    ),
    Retired::dropped("fluid.time.projections", "leave it out: \"rk3\" projects after each stage"),
    Retired::dropped("fluid.time.dt_levels_per_octave", LEVELS),
    Retired::dropped("fluid.time.rungs", LEVELS),
];

/// The part of a scene that is read here.
#[derive(Deserialize)]
struct Document {
    #[serde(default)]
    fluid: FluidSection,
}

/// The section with every choice made.
#[derive(Clone, Debug, PartialEq)]
pub struct Choices {
    /// Whether the solve along the last axis is in blocks, for ranks.
    pub blocks: bool,
    /// Time scheme.
    pub scheme: SchemeKey,
    /// Time integration.
    pub time: TimeSection,
    /// Method of the immersed boundary.
    pub method: Method,
    /// Parts of the method `calibrated`.
    pub calibration: Calibration,
}

impl FluidSection {
    /// Reads the section of a scene.
    ///
    /// # Errors
    /// With the place of an unknown key, a wrong type or a value that is not allowed.
    pub fn read(scene: &CheckedScene) -> Result<Self, SceneError> {
        scene.source.refuse_retired(RETIRED)?;
        let section = Self::of_run(scene)?;
        section.check(scene)?;
        Ok(section)
    }

    /// Reads the section of a run that was made, of whose grains nothing is known.
    ///
    /// # Errors
    /// With the place of an unknown key or a wrong type.
    pub(crate) fn of_run(scene: &CheckedScene) -> Result<Self, SceneError> {
        let mut section = scene.source.section::<Document>()?.fluid;
        section.time.scheme = Some(section.time.scheme.unwrap_or_else(|| section.default_scheme(scene)));
        Ok(section)
    }

    /// Every choice made.
    pub fn choices(&self, calibration: Calibration) -> Choices {
        Choices {
            blocks: self.launcher.is_some(),
            scheme: self.scheme(),
            time: self.time.clone(),
            method: self.method,
            calibration,
        }
    }

    /// Time scheme.
    pub fn scheme(&self) -> SchemeKey {
        self.time.scheme.unwrap_or(SchemeKey::Ab2)
    }

    /// The time scheme where none is asked for: docs/decisions/time-scheme.md.
    fn default_scheme(&self, scene: &CheckedScene) -> SchemeKey {
        // Without a fluid there are no cells, and the scene is refused ([`FluidSection::check`]).
        let long = scene.scene.medium.as_ref().zip(self.time.dt).is_some_and(|(medium, dt)| {
            let spacing = scene.scene.domain.smallest_spacing();
            medium.kinematic_viscosity() * dt / (spacing * spacing) > LONG
        });
        if self.method == Method::Izard2014 || long { SchemeKey::Rk3 } else { SchemeKey::Ab2 }
    }

    /// Refuses values and combinations that mean nothing.
    fn check(&self, scene: &CheckedScene) -> Result<(), SceneError> {
        let source = &scene.source;
        let time = &self.time;
        if let Some(dt) = time.dt.filter(|dt| !(dt.is_finite() && *dt > 0.0)) {
            return Err(source.error(
                "fluid.time.dt",
                format!("is {dt}; allowed: a finite number > 0"),
                "give a positive time step in s, or leave it out: the step then follows what happens",
            ));
        }
        time.dt.map_or(Ok(()), |dt| scene.step_changes_time("fluid.time.dt", dt))?;
        let limit = self.scheme().cfl_limit();
        if !(time.cfl > 0.0 && time.cfl <= limit) {
            return Err(source.error(
                "fluid.time.cfl",
                format!("is {}; allowed: above 0, up to {limit} with this scheme", time.cfl),
                "give a CFL number such as 0.5",
            ));
        }
        let Some(medium) = &scene.scene.medium else {
            return Err(source.error(
                "medium",
                "is missing: a scene without fluid needs no fluid solver",
                "add [medium] with density and viscosity, or run bedload-dem alone",
            ));
        };
        match self.method {
            Method::Calibrated => Ok(()),
            Method::Izard2014 => match izard2014::neutral_grain(scene, medium.density) {
                None => Ok(()),
                Some(grain) => Err(source.error(
                    "fluid.method",
                    format!(
                        "is \"izard-2014\", which divides by the difference of the densities, and grain {grain} is as \
                         dense as the fluid ({})",
                        medium.density
                    ),
                    "take fluid.method = \"calibrated\"",
                )),
            },
            Method::FictitiousDomain => fictitious::check(scene),
        }
    }
}

impl SchemeKey {
    /// Largest dt Σ_a |u_a|/Δx_a at which flows with grains were seen stable.
    pub fn cfl_limit(self) -> f64 {
        match self {
            Self::Rk3 => 1.7,
            Self::Ab2 => 0.75,
        }
    }

    /// Largest ν dt Σ_a 1/Δx_a² with explicit viscosity.
    pub fn viscous_limit(self) -> f64 {
        match self {
            Self::Rk3 => 0.6,
            Self::Ab2 => 0.25,
        }
    }
}
