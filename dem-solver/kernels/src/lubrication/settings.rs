//! Which lubrication a scene asks for.

use crate::error::SpecError;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Model of lubrication between near surfaces.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "form", rename_all = "kebab-case")]
pub enum Lubrication {
    /// No lubrication.
    #[default]
    None,
    /// Eq. 19 up to the cut-off.
    AsPrinted(LubricationSettings),
    /// What the grid of the flow does not resolve.
    Complement(LubricationSettings),
}

/// Parameters of lubrication.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct LubricationSettings {
    /// Roughness over radius η/R; real grains have 1e-6 to 1e-3.
    pub roughness: f64,
    /// Gap over radius δ_c/R beyond which lubrication does not act; Izard et al. (2014) take ½.
    #[serde(default = "default_cut_off")]
    pub cut_off: f64,
    /// Gap beyond which it does not act whatever the radii, m; none by default.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub longest: Option<f64>,
    /// Length L below which the flow does not resolve the gap, m (`complement` only); by default one
    /// cell, as measured with the default width ½ of the mask. In general (0.43 + 1.14 width) cells.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub resolved_length: Option<f64>,
    /// Whether surfaces that slide or roll past each other have a film too (`complement` only); by default
    /// those of spheres have, those of discs have not.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub tangential: Option<bool>,
    /// Most Gauss–Seidel sweeps over all gaps of one sub-step; a scene has the default.
    #[serde(skip, default = "default_sweeps")]
    pub sweeps: u32,
}

/// R/2, the upper bound of eq. 19 (Izard et al. 2014).
fn default_cut_off() -> f64 {
    0.5
}

/// Enough for chains of a few gaps; one gap or gaps that share no free grain need one.
fn default_sweeps() -> u32 {
    8
}

impl LubricationSettings {
    /// Settings with everything but the roughness at its default.
    #[must_use]
    pub fn new(roughness: f64) -> Self {
        Self {
            roughness,
            cut_off: default_cut_off(),
            longest: None,
            resolved_length: None,
            tangential: None,
            sweeps: default_sweeps(),
        }
    }
}

impl Lubrication {
    /// The parameters, if there is lubrication.
    #[must_use]
    pub fn settings(&self) -> Option<&LubricationSettings> {
        match self {
            Self::None => None,
            Self::AsPrinted(settings) | Self::Complement(settings) => Some(settings),
        }
    }

    /// Whether surfaces that slide or roll past each other have a film too.
    #[must_use]
    pub fn is_tangential(&self) -> bool {
        matches!(self, Self::Complement(settings) if settings.tangential != Some(false))
    }

    /// Checks ranges.
    pub fn validate(&self) -> Result<(), SpecError> {
        let Some(settings) = self.settings() else { return Ok(()) };
        let bad = |quantity, value, allowed| {
            Err(SpecError::Model { model: "lubrication", quantity, value, allowed })
        };
        if !(settings.roughness > 0.0 && settings.roughness.is_finite()) {
            return bad("roughness", settings.roughness, "positive (real grains: 1e-6 to 1e-3)");
        }
        let longest = settings.longest.unwrap_or(settings.cut_off);
        SpecError::unless_positive("lubrication", &[("cut_off", settings.cut_off), ("longest", longest)])?;
        if settings.tangential == Some(true) && !self.is_tangential() {
            return bad("tangential", 1.0, "false: only form = \"complement\" has that film");
        }
        if settings.sweeps == 0 {
            return bad("sweeps", 0.0, "at least 1");
        }
        match (self, settings.resolved_length) {
            (_, Some(length)) if !(length > 0.0 && length.is_finite()) => {
                bad("resolved_length", length, "positive and finite")
            }
            (Self::Complement(_), None) => bad(
                "resolved_length",
                f64::NAN,
                "the width of a cell of the flow; form = \"as-printed\" needs none",
            ),
            (Self::AsPrinted(_), Some(length)) => {
                bad("resolved_length", length, "read by form = \"complement\" only")
            }
            _ => Ok(()),
        }
    }
}
