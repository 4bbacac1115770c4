//! What touches do to the step where few grains move (docs/decisions/time-step.md).
//!
//! The viscous force of the window of a touch is that of the approach: the step shortens before a touch, and
//! begins anew after it.

use crate::immersed::body::Motion;
use crate::methods::grains::{Grains, Memory};
use crate::methods::loads::GrainLoads;

/// Grains that may move: among more, one touches something all the time.
pub(super) const FEW: usize = 8;

/// Least part of the step that is allowed with which a touch is met, and the part after it.
const TO_A_TOUCH: f64 = 0.25;
const AFTER_A_TOUCH: f64 = 0.1;

/// Steps, of the length that is allowed, over which a touch is foreseen.
const STEPS_AHEAD: f64 = 4.0;

/// Way of a grain in such a step, over Δx, from which on touches count.
const FAST: f64 = 0.05;

/// Largest ν dt/Δx² while all grains rest, for so many windows after the last has come to rest: what the
/// approach left of the force in narrow pores goes in some 17 ν dt/Δx² windows and more.
const AT_REST: f64 = 0.15;
const UNTIL_FORGOTTEN: u8 = 128;

/// Part of the step `allowed`, s, that grains leave of it which have all just come to rest; `spacing`:
/// smallest cell, m.
pub(super) fn part_at_rest<const D: usize>(
    loads: &GrainLoads,
    grains: &Grains<D>,
    allowed: f64,
    spacing: f64,
) -> f64 {
    let part = AT_REST * spacing * spacing / (grains.model.viscosity * allowed);
    if part < 1.0 && loads.have_come_to_rest(grains, UNTIL_FORGOTTEN, spacing / allowed) { part } else { 1.0 }
}

/// Part of the step `allowed`, s, that a touch in the last window leaves of it, or one that is near;
/// `spacing`: smallest cell, m.
pub(super) fn part_at_touches<const D: usize>(
    loads: &mut GrainLoads,
    grains: &Grains<D>,
    allowed: f64,
    spacing: f64,
) -> f64 {
    let fast = FAST * spacing / allowed;
    let norm = |v: &[f64; 3]| v.iter().map(|v| v * v).sum::<f64>().sqrt();
    let Memory { jumps, before, .. } = &grains.memory;
    let turns = |(jump, before): (&[f64; 3], &Motion)| {
        let speed = before.speed();
        speed > fast && norm(jump) > 0.5 * speed
    };
    if jumps.iter().zip(before).any(turns) {
        return AFTER_A_TOUCH;
    }
    let ahead = STEPS_AHEAD * allowed;
    (loads.until_touch(grains, ahead, fast) / ahead).max(TO_A_TOUCH)
}
