//! What a solver says of itself before a run, so that the coupler can plan and refuse without knowing
//! its insides. `bedload-fluid check SCENE --json` and `bedload-dem check SCENE --json` print these.

use serde::{Deserialize, Serialize};

/// How the loads are formed from the immersed-boundary forcing (docs/numerics.md, Forms of the loads).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize)]
#[cfg_attr(feature = "scene", derive(schemars::JsonSchema))]
pub enum LoadsForm {
    /// −ρρ_p/(ρ_p−ρ) ∫f dV (Izard et al. 2014, eqs 5–6): singular at ρ_p = ρ.
    #[serde(rename = "izard-2014")]
    Izard2014,
    /// −ρ∫f dV + ρ d/dt∫αu dV (Kempe & Fröhlich 2012).
    #[serde(rename = "kempe-froehlich-2012")]
    KempeFroehlich2012,
    /// −ρ∫f dV + ρV dU/dt (Uhlmann 2005).
    #[serde(rename = "uhlmann-2005")]
    Uhlmann2005,
    /// Force before forcing (after Yu & Shao 2007); imposes (2−β)λ at steady state.
    #[serde(rename = "yu-shao-2007")]
    YuShao2007,
    /// Force before forcing with λ as a true fixed point.
    #[default]
    #[serde(rename = "yu-shao-fixed-point")]
    YuShaoFixedPoint,
}

impl LoadsForm {
    /// Does the fluid wait for the new motion before it imposes it (semi-implicit order)?
    #[must_use]
    pub fn is_semi_implicit(self) -> bool {
        matches!(self, Self::YuShao2007 | Self::YuShaoFixedPoint)
    }
}

impl std::fmt::Display for LoadsForm {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::Izard2014 => "izard-2014",
            Self::KempeFroehlich2012 => "kempe-froehlich-2012",
            Self::Uhlmann2005 => "uhlmann-2005",
            Self::YuShao2007 => "yu-shao-2007",
            Self::YuShaoFixedPoint => "yu-shao-fixed-point",
        })
    }
}

/// How the immersed boundary imposes the motion.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize)]
#[cfg_attr(feature = "scene", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum Forcing {
    /// f = α(U − u)/Δt anew each step (Izard et al. 2014, eq. 7).
    Direct,
    /// λ carried from step to step (docs/equations-immersed.md, section 3).
    #[default]
    Carried,
}

/// Facts of the fluid solver.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, Serialize)]
#[serde(default)]
pub struct FluidFacts {
    /// Cells.
    pub cells: u64,
    /// Estimated memory, bytes.
    pub memory: u64,
    /// Largest step it proposes, s: the scene's dt, or from CFL and an estimated speed.
    pub dt: f64,
    /// May the step be changed while the run goes (dt from CFL)?
    pub adaptive: bool,
    /// CFL number it keeps when adaptive.
    pub cfl: f64,
    /// Largest CFL number at which its time scheme is stable.
    pub cfl_limit: f64,
    /// Smallest spacing, m.
    pub spacing: f64,
    /// Is viscosity implicit?
    pub implicit_viscosity: bool,
    /// Form of the loads.
    pub loads: LoadsForm,
    /// Virtual mass coefficient C_v it sends.
    pub virtual_mass: f64,
    /// How the motion is imposed.
    pub forcing: Forcing,
    /// Estimated cost of a step, s.
    pub step_cost: f64,
    /// Things the user should know (fallbacks, say).
    pub notices: Vec<String>,
    /// The `[fluid]` section with every default written out.
    pub resolved: toml::Table,
}

/// Facts of the DEM solver.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, Serialize)]
#[serde(default)]
pub struct DemFacts {
    /// Grains.
    pub grains: u64,
    /// Estimated memory, bytes.
    pub memory: u64,
    /// Sub-step it asks for, s.
    pub dt: f64,
    /// Shortest contact duration over all pairs, s (infinite: nothing can touch).
    pub contact_time: f64,
    /// Largest γ_t/m* of a tangential dashpot between free grains, 1/s (0: none).
    pub tangential_rate: f64,
    /// Did the user accept sub-steps above t_c/10?
    pub coarse_dt: bool,
    /// Largest stable sub-step of its explicit lubrication, s (infinite where implicit or off).
    pub lubrication_dt: f64,
    /// Range within which contact or lubrication acts, as a gap, m.
    pub interaction_range: f64,
    /// Estimated cost of a sub-step, s.
    pub substep_cost: f64,
    /// Things the user should know.
    pub notices: Vec<String>,
    /// The `[dem]` section with every default written out.
    pub resolved: toml::Table,
}

impl DemFacts {
    /// Largest γ_t dt/m* at which a packing comes to rest: all dashpots of a grain act on its spin at once
    /// (docs/stability.md, Dashpots in a packing).
    pub const MOST_DASHPOT: f64 = 0.15;
    /// Fewer grains than this are no packing.
    pub const FEWEST_OF_A_PACKING: u64 = 8;

    /// γ_t dt/m* with sub-steps of `dt` (s), where there are enough grains for a packing.
    #[must_use]
    pub fn dashpot_number(&self, dt: f64) -> Option<f64> {
        (self.tangential_rate > 0.0 && self.grains >= Self::FEWEST_OF_A_PACKING)
            .then_some(self.tangential_rate * dt)
    }
}
