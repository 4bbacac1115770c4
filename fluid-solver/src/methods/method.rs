//! `fluid.method`: the names of the methods.

use crate::grid::Geometry;
use crate::immersed::mask_model::{Mask, MaskModel};
use protocol::scheme::Scheme;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// How the grains' motion is imposed on the fluid, and how their loads are found.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
pub enum Method {
    /// A force carried from step to step in a mask whose surface is where the flow feels it, at any dt and
    /// resolution.
    #[default]
    #[serde(rename = "calibrated")]
    Calibrated,
    /// Direct forcing and loads as printed in Izard et al. (2014).
    #[serde(rename = "izard-2014")]
    Izard2014,
    /// Lagrange multipliers at points of discs and other bodies of the plane (Yu & Shao 2007).
    #[serde(rename = "fictitious-domain")]
    FictitiousDomain,
}

impl Method {
    /// Orders of the exchange that the method can follow, its own first.
    ///
    /// Only `calibrated` can repeat a window: its force acts on the prediction, and is known again where the
    /// window began.
    pub fn schemes(self) -> &'static [Scheme] {
        match self {
            Self::Calibrated => &[Scheme::SemiImplicit, Scheme::Iterated],
            Self::Izard2014 => &[Scheme::Explicit],
            Self::FictitiousDomain => &[Scheme::SemiImplicit],
        }
    }

    /// Its mask in a fluid of kinematic viscosity `viscosity` (m²/s); dt is to be set. With
    /// `fictitious-domain` it serves the start and the output.
    pub(crate) fn mask(self, geometry: Geometry, viscosity: f64) -> MaskModel {
        let (mask, width) = match self {
            Self::Izard2014 => (Mask::Izard2014, 1.0),
            Self::Calibrated if geometry == Geometry::Plane => (Mask::ExactShear, 0.5),
            Self::Calibrated | Self::FictitiousDomain => (Mask::ParameterFree, 0.5),
        };
        MaskModel { mask, width, wave: 1.0, viscosity, dt: 0.0 }
    }
}
