//! `bedload check`: a scene validated, and its plan.

use std::time::Duration;

use bedload_program::RunOptions;
use protocol::loudness::is_quiet;
use protocol::participant::Role;
use serde_json::Value;

use crate::accuracy;
use crate::bounds::{Bound, Level, Side};
use crate::failure::Failure;
use crate::number::Short;
use crate::prepare::Prepared;
use crate::proposals;
use crate::solvers::Solver;

/// Prints the plan, and fails with the names of the bounds that it breaks.
pub fn check(options: &RunOptions, json: bool) -> Result<(), Failure> {
    let (options, expected) = &accuracy::resolve(options)?;
    let prepared = Prepared::new(options)?;
    if json {
        let text =
            serde_json::to_string_pretty(&prepared.plan).map_err(|error| Failure::Run(error.to_string()))?;
        println!("{text}");
    } else if is_quiet() {
        prepared.tell();
    } else {
        prepared.table().iter().for_each(|line| protocol::show!("{line}"));
        prepared.notices().iter().for_each(|notice| protocol::show!("\n  {notice}"));
        if let Some(expected) = expected {
            protocol::show!("\n  {expected}");
        }
        for proposal in proposals::all(&prepared, options) {
            protocol::show!("\n  cheaper: {}", proposal.line());
        }
    }
    prepared.refuse_broken()
}

/// Prints the scene of a cheaper model; fails if there is no proposal of this name.
pub fn cheaper(options: &RunOptions, name: &str) -> Result<(), Failure> {
    print!("{}", proposals::cheaper(&Prepared::new(options)?, options, name)?);
    Ok(())
}

impl Prepared {
    /// The plan and its bounds, line by line.
    pub(crate) fn table(&self) -> Vec<String> {
        let lines = self.plan.lines().into_iter().map(|line| format!("  {line}"));
        let head = format!("\n  {:<8}{:<39}{:>11}    {:>11}{:>9}", "bound", "", "value", "limit", "margin");
        let bounds = self.plan.bounds.iter().map(|bound| format!("  {}", row(bound, &self.plan.forced)));
        [self.scene.source.file.clone()].into_iter().chain(lines).chain([head]).chain(bounds).collect()
    }
}

fn row(bound: &Bound, forced: &[String]) -> String {
    let state = match (bound.holds, bound.level, bound.refuses(forced)) {
        (true, ..) => "ok",
        (false, Level::Warn, _) => "warn",
        (false, _, true) => "BROKEN",
        (false, _, false) => "forced",
    };
    let sign = if bound.side == Side::AtLeast { '≥' } else { '≤' };
    let (value, limit, margin) = (Short(bound.value), Short(bound.limit), Short(bound.margin));
    format!(
        "{state:<8}{:<25}{:<14}{:>11}  {sign} {:>11}{:>8}x",
        bound.name,
        bound.quantity,
        value.to_string(),
        limit.to_string(),
        format!("{margin:.3}")
    )
}

/// The JSON Schema of a solver's own section, from our solver of this role; none where it is not found.
pub fn section_schema(role: Role) -> Option<Value> {
    Solver::ours(role).schema(Duration::from_secs(10))
}
