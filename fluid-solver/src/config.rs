//! The `[fluid]` section: as typed ([`FluidSection`]) and as meant ([`Choices`]).

mod fictitious;

use crate::coupling;
use crate::immersed::mask_model::Mask;
use crate::virtual_mass;
use bedload_scene::{CheckedScene, Motion, Retired, SceneError};
use protocol::facts::{Forcing, LoadsForm};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Time scheme.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum SchemeKey {
    /// Three-stage Runge–Kutta for convection, Crank–Nicolson for implicit viscosity.
    #[default]
    Rk3,
    /// Adams–Bashforth for convection, Crank–Nicolson for implicit viscosity.
    Ab2,
}

/// How often a Runge–Kutta step is projected.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum ProjectionsKey {
    /// After every stage.
    #[default]
    EachStage,
    /// At the end of the step.
    Once,
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
    /// `rk3` or `ab2`.
    pub scheme: SchemeKey,
    /// `each-stage` or `once` (`rk3` only).
    pub projections: ProjectionsKey,
    /// `implicit`, `explicit` or `auto`.
    pub viscosity: ViscosityKey,
    /// Time step, s. Without it the step follows `cfl`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub dt: Option<f64>,
    /// dt Σ_a |u_a|/Δx_a that an adaptive step keeps.
    pub cfl: f64,
    /// Lengths that an adaptive step may have in an octave, evenly spaced: a power of two, 1 to 64.
    pub dt_levels_per_octave: u32,
    /// Convection; `false` is Stokes flow.
    pub convection: bool,
}

impl Default for TimeSection {
    fn default() -> Self {
        Self {
            scheme: SchemeKey::default(),
            projections: ProjectionsKey::default(),
            viscosity: ViscosityKey::default(),
            dt: None,
            cfl: 0.5,
            dt_levels_per_octave: 4,
            convection: true,
        }
    }
}

/// `fluid.immersed`.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct ImmersedSection {
    /// `carried` (default), `direct` (Izard et al. 2014, eq. 7) or, for discs, `fictitious-domain` (Yu & Shao 2007).
    pub method: Forcing,
    /// `parameter-free` (default of `carried`) or `izard-2014` (default of `direct`).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mask: Option<Mask>,
    /// Factor on the thickness of Izard et al. (2014), eqs 8–10; by default 0.5 for `parameter-free`, 1 for
    /// `izard-2014`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub width: Option<f64>,
    /// Whether the carried force stays in its cells until the next step (`eulerian`), moves with the grains
    /// (`advected`), or does where the step asks for it (`auto`, default: spheres in space of which two or more
    /// move, or that fill more than a twentieth of their box).
    pub force_transport: ForceTransport,
    /// Whether masks have the grains' own radius (`nominal`) or the one with which the flow feels it
    /// (`corrected`); `auto` (default): corrected for spheres in space with the parameter-free mask.
    pub mask_radius: MaskRadius,
    /// Sweeps of the local solve that lets viscosity feel a change of the advected force in its own step, 0: none;
    /// by default none with `advected` and as many as ν dt/Δx² needs with `auto`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub viscous_sweeps: Option<u32>,
}

/// Radius of the masks.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum MaskRadius {
    /// Corrected where the correction was measured.
    #[default]
    Auto,
    /// The grain's.
    Nominal,
    /// Larger by what curved profiles and pores ask for.
    Corrected,
}

/// How the carried force gets from one step to the next.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum ForceTransport {
    /// It moves with the grains in the steps in which it would lag, where it can.
    #[default]
    Auto,
    /// It stays in its cells.
    Eulerian,
    /// It moves with the grains in every step.
    Advected,
}

/// Virtual mass: one coefficient, or by the gap to walls and neighbours.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(untagged, expecting = "expected \"by-gap\" or a number ≥ 0")]
pub enum VirtualMass {
    /// C_v of all grains, everywhere.
    Constant(f64),
    /// That of an ideal fluid, by the gap.
    By(Nearness),
}

/// What a virtual mass depends on.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Nearness {
    /// The gap to the nearest wall or grain.
    ByGap,
}

impl VirtualMass {
    /// C_v of a grain with nothing near it.
    #[must_use]
    pub fn alone(self) -> f64 {
        match self {
            Self::Constant(coefficient) => coefficient,
            Self::By(Nearness::ByGap) => virtual_mass::ALONE,
        }
    }
}

/// What is done about ρ(∫β dV − V), the mass by which the mask on the grid differs from the grain
/// (`yu-shao-2007`, `yu-shao-fixed-point`): it acts where the grain accelerates.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum DisplacedMass {
    /// Times the acceleration that is known it is taken off the force.
    #[default]
    AsForce,
    /// It goes with the added mass: quiet at very small density ratios, a slower start.
    AsMass,
    /// Nothing: the grain is too heavy or too light by it.
    Neglected,
}

/// `fluid.loads`.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct LoadsSection {
    /// `izard-2014`, `kempe-froehlich-2012`, `uhlmann-2005`, `yu-shao-2007` or `yu-shao-fixed-point`; by
    /// default `yu-shao-fixed-point` for `carried`, `izard-2014` for `direct`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub form: Option<LoadsForm>,
    /// Virtual mass coefficient C_v: a number, or `by-gap` (default): 0.5, but near one wall or one grain that of
    /// an ideal fluid, up to 0.803 where a sphere touches a wall (a disc: 2.29). 0 with `izard-2014`, which has
    /// none in print.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub virtual_mass: Option<VirtualMass>,
    /// What is done about the difference of the grain's volume on the grid from its true one (yu-shao-2007,
    /// yu-shao-fixed-point): `as-force` (default), `as-mass` or `neglected`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub displaced_mass: Option<DisplacedMass>,
}

/// How the tridiagonal solve along the last axis is cut in space.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum DivisionKey {
    /// Not at all: the fastest for one process.
    #[default]
    Whole,
    /// In blocks that depend on the grid alone: any number of ranks, one included, finds the same bits.
    Blocks,
}

/// The `[fluid]` section.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct FluidSection {
    /// Command of a foreign fluid solver; the coupler's key, without meaning here.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub command: Option<Vec<String>>,
    /// What starts the fluid's ranks, such as `["mpirun", "-np", "4"]`, before the solver's own command; the
    /// coupler's key. Needs a solver built with `--features mpi`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub launcher: Option<Vec<String>>,
    /// `whole` or `blocks`: how the solve along the last axis is cut (in space). By default `whole` for one
    /// process, `blocks` for several ranks and with a launcher.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub division: Option<DivisionKey>,
    /// Time integration.
    pub time: TimeSection,
    /// Immersed boundary.
    pub immersed: ImmersedSection,
    /// Loads on the grains.
    pub loads: LoadsSection,
}

/// Names that this section had before.
const RETIRED: &[Retired] = &[
    Retired::key(
        "fluid.immersed.carry",
        "fluid.immersed.force_transport, \"eulerian\" (was \"in-place\") or \"advected\" (was \"with-grains\")",
    ),
    Retired::key("fluid.time.rungs", "fluid.time.dt_levels_per_octave"),
    Retired::value("fluid.immersed.mask", "seed", "\"izard-2014\""),
    Retired::value("fluid.loads.form", "F1", "\"izard-2014\""),
    Retired::value("fluid.loads.form", "F2", "\"kempe-froehlich-2012\""),
    Retired::value("fluid.loads.form", "F3", "\"uhlmann-2005\""),
    Retired::value("fluid.loads.form", "F5", "\"yu-shao-2007\""),
    Retired::value("fluid.loads.form", "F5b", "\"yu-shao-fixed-point\""),
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
    /// Whether the solve along the last axis is in blocks; without an answer as many ranks ask for.
    pub division: Option<DivisionKey>,
    /// Time integration.
    pub time: TimeSection,
    /// How the motion is imposed.
    pub method: Forcing,
    /// Form of the mask.
    pub mask: Mask,
    /// Factor on its thickness.
    pub width: f64,
    /// How the carried force gets from one step to the next.
    pub force_transport: ForceTransport,
    /// Radius of the masks.
    pub mask_radius: MaskRadius,
    /// Sweeps of the local solve, if they are given.
    pub viscous_sweeps: Option<u32>,
    /// Form of the loads.
    pub form: LoadsForm,
    /// C_v.
    pub virtual_mass: VirtualMass,
    /// What is done about the grain's volume on the grid.
    pub displaced_mass: DisplacedMass,
}

impl FluidSection {
    /// Reads the section of a scene.
    ///
    /// # Errors
    /// With the place of an unknown key, a wrong type or a value that is not allowed.
    pub fn read(scene: &CheckedScene) -> Result<Self, SceneError> {
        scene.source.refuse_retired(RETIRED)?;
        let section = scene.source.section::<Document>()?.fluid;
        section.check(scene)?;
        Ok(section)
    }

    /// Reads the section of a run that was made, of whose grains nothing is known.
    ///
    /// # Errors
    /// With the place of an unknown key or a wrong type.
    pub(crate) fn of_run(scene: &CheckedScene) -> Result<Self, SceneError> {
        Ok(scene.source.section::<Document>()?.fluid)
    }

    /// Every choice made, defaults filled in.
    #[must_use]
    pub fn choices(&self) -> Choices {
        let method = self.immersed.method;
        let direct = method == Forcing::Direct;
        let mask = self.immersed.mask.unwrap_or(if direct { Mask::Izard2014 } else { Mask::ParameterFree });
        let form = self.loads.form.unwrap_or(if direct {
            LoadsForm::Izard2014
        } else {
            LoadsForm::YuShaoFixedPoint
        });
        let none = form == LoadsForm::Izard2014;
        Choices {
            division: self.division.or_else(|| self.launcher.as_ref().map(|_| DivisionKey::Blocks)),
            time: self.time.clone(),
            method,
            mask,
            width: self.immersed.width.unwrap_or(if mask == Mask::Izard2014 { 1.0 } else { 0.5 }),
            force_transport: self.immersed.force_transport,
            mask_radius: self.immersed.mask_radius,
            viscous_sweeps: self
                .immersed
                .viscous_sweeps
                .or_else(|| (self.immersed.force_transport == ForceTransport::Advected).then_some(0)),
            form,
            virtual_mass: self.loads.virtual_mass.unwrap_or(if none {
                VirtualMass::Constant(0.0)
            } else {
                VirtualMass::By(Nearness::ByGap)
            }),
            displaced_mass: match self.loads.displaced_mass {
                // Points have the area of their body exactly.
                _ if method == Forcing::FictitiousDomain => DisplacedMass::Neglected,
                Some(choice) => choice,
                None if form.is_semi_implicit() => DisplacedMass::AsForce,
                None => DisplacedMass::Neglected,
            },
        }
    }

    /// The section with every default written out.
    #[must_use]
    pub fn resolved(&self) -> Self {
        let choices = self.choices();
        let mut section = self.clone();
        section.division = choices.division;
        let masked = choices.method != Forcing::FictitiousDomain;
        section.immersed.mask = masked.then_some(choices.mask);
        section.immersed.width = masked.then_some(choices.width);
        section.loads.form = Some(choices.form);
        section.loads.virtual_mass = Some(choices.virtual_mass);
        section.loads.displaced_mass =
            (masked && choices.form.is_semi_implicit()).then_some(choices.displaced_mass);
        section
    }

    /// Refuses values and combinations that mean nothing.
    fn check(&self, scene: &CheckedScene) -> Result<(), SceneError> {
        let source = &scene.source;
        let time = &self.time;
        if let Some(dt) = time.dt.filter(|dt| !(dt.is_finite() && *dt > 0.0)) {
            return Err(source.error(
                "fluid.time.dt",
                format!("is {dt}; allowed: a finite number > 0"),
                "give a positive time step in s, or leave it out to follow fluid.time.cfl",
            ));
        }
        let limit = time.scheme.cfl_limit();
        if !(time.cfl > 0.0 && time.cfl <= limit) {
            return Err(source.error(
                "fluid.time.cfl",
                format!("is {}; allowed: above 0, up to {limit} with this scheme", time.cfl),
                "give a CFL number such as 0.5",
            ));
        }
        if !(time.dt_levels_per_octave.is_power_of_two() && time.dt_levels_per_octave <= 64) {
            return Err(source.error(
                "fluid.time.dt_levels_per_octave",
                format!("is {}; allowed: 1, 2, 4, 8, 16, 32 or 64", time.dt_levels_per_octave),
                "give the number of lengths that an adaptive step may have in an octave, such as 4",
            ));
        }
        let choices = self.choices();
        if !(choices.width > 0.0 && choices.width <= 4.0) {
            return Err(source.error(
                "fluid.immersed.width",
                format!("is {}; allowed: above 0, up to 4", choices.width),
                "give a factor on the thickness of Izard et al. (2014), such as 0.5",
            ));
        }
        let scheme = coupling::read(scene, choices.form)?.0;
        let can = choices.method == Forcing::Carried
            && choices.form == LoadsForm::YuShaoFixedPoint
            && scheme.carries(choices.form, true);
        if choices.force_transport == ForceTransport::Advected && !can {
            return Err(source.error(
                "fluid.immersed.force_transport",
                format!(
                    "is \"advected\" with method {:?}, form {} and the coupling scheme {scheme}",
                    choices.method, choices.form
                ),
                "take method = \"carried\", form = \"yu-shao-fixed-point\" and coupling.scheme = \"semi-implicit\" or \"overlapped\", or \
                 leave force_transport out",
            ));
        }
        if let VirtualMass::Constant(coefficient) = choices.virtual_mass
            && !(coefficient >= 0.0 && coefficient.is_finite())
        {
            return Err(source.error(
                "fluid.loads.virtual_mass",
                format!("is {coefficient}; allowed: \"by-gap\" or a finite number ≥ 0"),
                "give the coefficient C_v, such as 0.5, or leave it out",
            ));
        }
        if choices.method == Forcing::FictitiousDomain {
            self.check_fictitious(scene, &choices, scheme)?;
        }
        self.check_loads(scene, &choices)
    }

    /// Refuses forms of the loads that the method or the grains do not allow.
    fn check_loads(&self, scene: &CheckedScene, choices: &Choices) -> Result<(), SceneError> {
        let source = &scene.source;
        let (form, semi) = (choices.form, choices.form.is_semi_implicit());
        if choices.method == Forcing::Direct && semi {
            return Err(source.error(
                "fluid.loads.form",
                format!("is {form}, which needs a carried force; fluid.immersed.method is \"direct\""),
                "take izard-2014, kempe-froehlich-2012 or uhlmann-2005, or set fluid.immersed.method = \"carried\"",
            ));
        }
        if self.loads.displaced_mass.is_some() && !semi {
            return Err(source.error(
                "fluid.loads.displaced_mass",
                format!("has no meaning for {form}"),
                "remove it, or take fluid.loads.form = \"yu-shao-fixed-point\"",
            ));
        }
        let Some(medium) = &scene.scene.medium else {
            return Err(source.error(
                "medium",
                "is missing: a scene without fluid needs no fluid solver",
                "add [medium] with density and viscosity, or run bedload-dem alone",
            ));
        };
        let near = |density: f64| (density / medium.density - 1.0).abs() < 1e-6;
        let neutral = scene.grains.iter().position(|g| g.motion == Motion::Free && near(g.density));
        if let (LoadsForm::Izard2014, Some(grain)) = (form, neutral) {
            return Err(source.error(
                "fluid.loads.form",
                format!(
                    "is izard-2014, which divides by the difference of the densities, and grain {grain} is as \
                     dense as the fluid ({})",
                    medium.density
                ),
                "take yu-shao-fixed-point (fluid.immersed.method = \"carried\"), or kempe-froehlich-2012",
            ));
        }
        Ok(())
    }
}

impl SchemeKey {
    /// Largest dt Σ_a |u_a|/Δx_a at which flows with grains were seen stable.
    #[must_use]
    pub fn cfl_limit(self) -> f64 {
        match self {
            Self::Rk3 => 1.7,
            Self::Ab2 => 0.75,
        }
    }

    /// Largest ν dt Σ_a 1/Δx_a² with explicit viscosity.
    #[must_use]
    pub fn viscous_limit(self) -> f64 {
        match self {
            Self::Rk3 => 0.6,
            Self::Ab2 => 0.25,
        }
    }
}
