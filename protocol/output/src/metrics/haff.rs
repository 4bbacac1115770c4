//! Haff's law of a cooling granular gas (Haff 1983): the kinetic energy falls as (1 + t/τ)⁻².

use bedload_scene::MetricKind;

use super::accumulator::Accumulator;
use super::outcome::{Outcome, plain, require};

/// τ of Haff's law, or how far the energy is from it.
pub(super) fn haff(kind: &MetricKind, accumulator: &Accumulator) -> Outcome {
    let Accumulator::Line(line) = accumulator else { return Err("is not a line".into()) };
    if matches!(kind, MetricKind::HaffMisfit(_)) {
        return plain(line.misfit()?);
    }
    let (start, slope) = line.fit()?;
    require(slope > 0.0, "the kinetic energy does not fall")?;
    plain(start / slope)
}
