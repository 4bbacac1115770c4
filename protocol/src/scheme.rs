//! Order of the exchange within a window: `coupling.scheme`, shared because it is part of the contract.
//!
//! | scheme | a window |
//! |---|---|
//! | `explicit` | the fluid takes its whole step with the motion known, sends the loads of it, then the DEM works |
//! | `semi-implicit` | the fluid predicts, sends the loads, waits for the new motion, and imposes it |
//! | `iterated` | as `semi-implicit`, again and again from the same start until the motion stays the same |

use serde::{Deserialize, Serialize};

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
    /// A window is repeated with the motion that it led to, until that motion stays the same.
    Iterated,
}

impl std::fmt::Display for Scheme {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::Explicit => "explicit",
            Self::SemiImplicit => "semi-implicit",
            Self::Iterated => "iterated",
        })
    }
}

/// `coupling.scheme` as typed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum SchemeKey {
    /// The fluid's own, or `iterated` where a bound of the fluid asks for it.
    #[default]
    Auto,
    /// [`Scheme::Explicit`].
    Explicit,
    /// [`Scheme::SemiImplicit`].
    SemiImplicit,
    /// [`Scheme::Iterated`].
    Iterated,
}

impl SchemeKey {
    /// The scheme that is named, if one is.
    pub fn named(self) -> Option<Scheme> {
        match self {
            Self::Auto => None,
            Self::Explicit => Some(Scheme::Explicit),
            Self::SemiImplicit => Some(Scheme::SemiImplicit),
            Self::Iterated => Some(Scheme::Iterated),
        }
    }
}

impl From<Scheme> for SchemeKey {
    fn from(scheme: Scheme) -> Self {
        match scheme {
            Scheme::Explicit => Self::Explicit,
            Scheme::SemiImplicit => Self::SemiImplicit,
            Scheme::Iterated => Self::Iterated,
        }
    }
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
    /// Repeats only windows whose first attempt departs by more than this from the motion that the windows
    /// before let expect, measured as for `tolerance`; 0: every window.
    pub repeat_above: f64,
}

impl Default for Iterations {
    fn default() -> Self {
        Self { tolerance: 1e-4, max_iterations: 20, repeat_above: 0.0 }
    }
}
