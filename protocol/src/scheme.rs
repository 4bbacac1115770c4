//! Order of the exchange within a window: `coupling.scheme`, shared because it is part of the contract.
//!
//! | scheme | a window |
//! |---|---|
//! | `explicit` | the fluid takes its whole step with the motion known, sends the loads of it, then the DEM works |
//! | `semi-implicit` | the fluid predicts, sends the loads, waits for the new motion, and imposes it |
//! | `overlapped` | the fluid sends the loads of the window before; both work at once; the fluid imposes |
//! | `iterated` | as `semi-implicit`, again and again from the same start until the motion stays the same |

use serde::{Deserialize, Serialize};

use crate::facts::LoadsForm;

/// Order of the exchange within a window.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum Scheme {
    /// The fluid takes its whole step with the grains' last motion and sends the loads of it (Izard
    /// et al. 2014).
    Explicit,
    /// The fluid predicts, sends the loads, waits for the new motion, and only then imposes it.
    SemiImplicit,
    /// Both solvers work at once: the loads are those of the window before.
    Overlapped,
    /// A window is repeated with the motion that it led to, until that motion stays the same.
    Iterated,
}

impl Scheme {
    /// The order that a form of the loads stands for by itself.
    #[must_use]
    pub fn of(loads: LoadsForm) -> Self {
        if loads.is_semi_implicit() { Self::SemiImplicit } else { Self::Explicit }
    }

    /// Forms of the loads that can be exchanged in this order.
    ///
    /// `iterated` asks for yu-shao-fixed-point, the only form whose force acts on the prediction: the others measure
    /// their force before the pressure has answered to it, so that repeating uhlmann-2005 leads to the
    /// semi-implicit yu-shao-fixed-point and no further (docs/equations-immersed.md, §6).
    #[must_use]
    pub fn forms(self) -> &'static [LoadsForm] {
        match self {
            Self::Explicit => &[LoadsForm::Izard2014, LoadsForm::KempeFroehlich2012, LoadsForm::Uhlmann2005],
            Self::SemiImplicit | Self::Overlapped => &[LoadsForm::YuShao2007, LoadsForm::YuShaoFixedPoint],
            Self::Iterated => &[LoadsForm::YuShaoFixedPoint],
        }
    }

    /// Can loads of this form be exchanged in this order, where `advected_force` says that the carried
    /// force moves with the grains? Such a window cannot be done again from its start.
    #[must_use]
    pub fn carries(self, loads: LoadsForm, advected_force: bool) -> bool {
        self.forms().contains(&loads) && !(advected_force && self == Self::Iterated)
    }
}

impl std::fmt::Display for Scheme {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::Explicit => "explicit",
            Self::SemiImplicit => "semi-implicit",
            Self::Overlapped => "overlapped",
            Self::Iterated => "iterated",
        })
    }
}

/// `coupling.scheme` as typed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum SchemeKey {
    /// What the form of the loads stands for; with yu-shao-fixed-point `iterated` where `density-ratio` asks for it.
    #[default]
    Auto,
    /// [`Scheme::Explicit`].
    Explicit,
    /// [`Scheme::SemiImplicit`].
    SemiImplicit,
    /// [`Scheme::Overlapped`].
    Overlapped,
    /// [`Scheme::Iterated`].
    Iterated,
}

impl SchemeKey {
    /// The scheme that is named, if one is.
    #[must_use]
    pub fn named(self) -> Option<Scheme> {
        match self {
            Self::Auto => None,
            Self::Explicit => Some(Scheme::Explicit),
            Self::SemiImplicit => Some(Scheme::SemiImplicit),
            Self::Overlapped => Some(Scheme::Overlapped),
            Self::Iterated => Some(Scheme::Iterated),
        }
    }
}

impl From<Scheme> for SchemeKey {
    fn from(scheme: Scheme) -> Self {
        match scheme {
            Scheme::Explicit => Self::Explicit,
            Scheme::SemiImplicit => Self::SemiImplicit,
            Scheme::Overlapped => Self::Overlapped,
            Scheme::Iterated => Self::Iterated,
        }
    }
}

/// How the fluid finds the force and the motion with which an attempt begins.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum Relaxation {
    /// Aitken's dynamic factor (Küttler & Wall 2008, eq. 44), over force and motion at once.
    Aitken,
    /// Anderson's mixture of the last `depth` + 1 attempts (Walker & Ni 2011), over force and motion
    /// at once.
    #[default]
    Anderson,
}

/// `coupling.iterations`: how windows are repeated with `scheme = "iterated"`.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct Iterations {
    /// Largest change of a grain's velocity, or of radius times spin, from one attempt to the next, over
    /// the largest speed of any grain and |g| dt.
    pub tolerance: f64,
    /// Most attempts at a window. One that has not converged by then is counted and accepted.
    pub max_iterations: u64,
    /// `anderson` or `aitken`.
    pub relaxation: Relaxation,
    /// Earlier attempts that `anderson` mixes with the last.
    pub depth: usize,
    /// Repeats only windows whose first attempt departs by more than this from the motion that the windows before let
    /// expect, measured as for `tolerance`; 0: every window.
    pub repeat_above: f64,
}

impl Default for Iterations {
    fn default() -> Self {
        Self {
            tolerance: 1e-4,
            max_iterations: 20,
            relaxation: Relaxation::default(),
            depth: 5,
            repeat_above: 0.0,
        }
    }
}
