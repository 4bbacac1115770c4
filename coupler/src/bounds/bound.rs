//! One bound of a plan: a value, a limit and a direction.

use protocol::facts::{BoundRow, Level, Measure, Side, SolverBound};
use protocol::scheme::Scheme;
use serde::Serialize;

use super::facts::TimeSteps;
use crate::failure::Failure;
use crate::number::Short;

/// One bound of a plan.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Bound {
    /// Name: one of [`super::NAMES`], or of a foreign solver's own.
    pub name: String,
    /// What is compared, as a formula.
    pub quantity: String,
    /// Its value in this plan.
    pub value: f64,
    /// Side of the limit.
    pub side: Side,
    /// Limit.
    pub limit: f64,
    /// By what factor the value keeps the limit: 1 at the limit, less where it is broken.
    pub margin: f64,
    /// Is it kept?
    pub holds: bool,
    /// What happens if not.
    pub level: Level,
    /// What goes wrong beyond it.
    pub why: String,
    /// Where the limit comes from.
    pub source: String,
    /// What to do.
    pub remedy: String,
}

impl Bound {
    /// A bound that the value keeps or breaks; a limit is met with a tolerance of rounding.
    pub fn new(name: &str, quantity: &str, value: f64, side: Side, limit: f64) -> Self {
        let margin = match side {
            Side::AtLeast => value / limit,
            Side::AtMost => limit / value,
        };
        // 0/0 at a value and limit of zero is a bound met; any other NaN is not.
        let holds = value == limit || margin >= 1.0 - 1e-9;
        Self {
            name: name.to_owned(),
            quantity: quantity.to_owned(),
            value,
            side,
            limit,
            margin,
            holds,
            level: Level::Refuse,
            why: String::new(),
            source: String::new(),
            remedy: String::new(),
        }
    }

    /// A solver's bound with order of exchange and time steps of a plan; none where these make it void.
    pub fn of_solver(bound: &SolverBound, scheme: Option<Scheme>, steps: &TimeSteps) -> Option<Self> {
        let void = bound.void_from.is_some_and(|(measure, number)| steps.measure(measure) >= number);
        if void || bound.scheme.is_some() && bound.scheme != scheme {
            return None;
        }
        let measure = steps.measure(bound.measure);
        let (value, limit, source) = if bound.rows.is_empty() {
            (bound.factor * measure, bound.limit, &bound.source)
        } else {
            let row = bound.rows.iter().find(|row| measure <= row.up_to)?;
            (row.value, row.limit, &row.source)
        };
        let found = Self::new(&bound.name, &bound.quantity, value, bound.side, limit);
        let found = found.because(bound.why.as_str(), source.as_str(), bound.remedy.as_str());
        Some(Self { level: bound.level, ..found })
    }

    /// Longest window that keeps a solver's bound if these steps do, s.
    pub(crate) fn longest_window(bound: &SolverBound, scheme: Option<Scheme>, steps: &TimeSteps) -> f64 {
        let kept = Self::of_solver(bound, scheme, steps).is_some_and(|found| found.holds);
        if !kept || bound.measure != Measure::Window {
            return f64::INFINITY;
        }
        let dt = steps.dt_fluid;
        match bound.side {
            _ if !bound.rows.is_empty() => {
                let holds = |row: &&BoundRow| Self::new("", "", row.value, bound.side, row.limit).holds;
                let rows = bound.rows.iter().skip_while(|row| row.up_to < dt).take_while(holds);
                rows.map(|row| row.up_to).fold(dt, f64::max)
            }
            Side::AtMost => dt.max(bound.limit / bound.factor),
            Side::AtLeast => f64::INFINITY,
        }
    }

    /// Only a warning.
    pub fn warning(mut self) -> Self {
        self.level = Level::Warn;
        self
    }

    /// With what goes wrong, where that is known from, and what to do.
    pub fn because(
        mut self,
        why: impl Into<String>,
        source: impl Into<String>,
        remedy: impl Into<String>,
    ) -> Self {
        self.why = why.into();
        self.source = source.into();
        self.remedy = remedy.into();
        self
    }

    /// Does it stop a run whose scene forces `forced`?
    pub fn refuses(&self, forced: &[String]) -> bool {
        !self.holds && self.level == Level::Refuse && !forced.contains(&self.name)
    }

    /// `value ≤ limit` as text.
    pub fn relation(&self) -> String {
        let sign = if self.side == Side::AtLeast { '≥' } else { '≤' };
        format!("{} = {:.4}, must be {sign} {:.4}", self.quantity, Short(self.value), Short(self.limit))
    }
}

impl Bound {
    /// The bounds that a plan breaks, each with its remedy.
    pub fn broken(bounds: &[&Self]) -> Failure {
        let mut text = String::from("the plan breaks a stability bound");
        for bound in bounds {
            text += &format!(
                "\n  {}: {}\n    why: {} ({})\n    remedy: {}",
                bound.name,
                bound.relation(),
                bound.why,
                bound.source,
                bound.remedy
            );
        }
        let names: Vec<String> = bounds.iter().map(|bound| format!("{:?}", bound.name)).collect();
        text += &format!("\n  to run all the same: --set 'coupling.force=[{}]'", names.join(", "));
        Failure::Bounds(text)
    }
}
