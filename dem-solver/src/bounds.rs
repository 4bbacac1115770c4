//! Bounds on the sub-step and on windows that this solver knows of itself; the coupler puts the steps in and
//! enforces them.

use bedload_scene::{CheckedScene, Motion};
use protocol::facts::{Measure, Side, SolverBound};

use crate::spec::DemSpec;

/// Largest γ_t dt/m* at which a packing comes to rest: all dashpots of a grain act on its spin at once
/// (docs/stability.md, Dashpots in a packing).
pub(crate) const LARGEST_DASHPOT: f64 = 0.15;
/// Fewer grains than this are no packing.
const FEWEST_OF_A_PACKING: usize = 8;
/// Least ρ_p/ρ at which a bed of discs without a tangential dashpot stayed quiet: at 1.5 the forces on some
/// grew by 6 % a window. docs/maps/bed.csv
const UNDAMPED: f64 = 2.5;
/// From this dt_fluid/t_c on it stayed quiet at every ratio. docs/maps/bed.csv
const UNDAMPED_WINDOW: f64 = 10.0;
/// γ_t/γ_n that keeps such a bed quiet (docs/stability.md).
const DASHPOT: f64 = 0.1;

/// Every bound that applies to the scene; `contact_time` is that of the shortest contact, s, infinite where
/// nothing can touch, `tangential_rate` the largest γ_t/m* between free grains, 1/s.
pub(crate) fn of(
    scene: &CheckedScene,
    spec: &DemSpec,
    contact_time: f64,
    tangential_rate: f64,
) -> Vec<SolverBound> {
    if !contact_time.is_finite() {
        return Vec::new();
    }
    let rate = packing_rate(tangential_rate, spec.grains.len());
    let dashpot = rate.map(|rate| packing(rate, contact_time));
    dashpot.into_iter().chain(undamped(scene, spec)).collect()
}

/// γ_t/m* that sub-steps must bear, 1/s, where there are enough grains for a packing.
pub(crate) fn packing_rate(tangential_rate: f64, grains: usize) -> Option<f64> {
    (tangential_rate > 0.0 && grains >= FEWEST_OF_A_PACKING).then_some(tangential_rate)
}

/// The tangential dashpots of all contacts of a grain act on its spin at once, each as it was before the
/// sub-step: with z contacts and neighbours that turn against it that is stable up to 2/3 z (m R²/I) γ_t
/// dt/m = 1, which for six contacts of spheres is γ_t dt/m_e = 0.2.
fn packing(rate: f64, contact_time: f64) -> SolverBound {
    let needed = (rate * contact_time / LARGEST_DASHPOT).ceil();
    let value = (rate, Measure::Substep);
    SolverBound::new("contact-dashpot", "γ_t dt/m_e", value, Side::AtMost, LARGEST_DASHPOT).because(
        "the tangential dashpots of all contacts of a grain together turn it too far: a packing never comes to rest",
        "docs/maps/packing.csv",
        format!(
            "give {needed} sub-steps per contact time (coupling.steps_per_contact, dem.steps_per_contact), or a \
             smaller dem.contact.damping_ratio"
        ),
    )
}

/// Springs without damping between grains that touch, fed by a force that stays the same for a window.
fn undamped(scene: &CheckedScene, spec: &DemSpec) -> Option<SolverBound> {
    let medium = scene.scene.medium.as_ref()?;
    let law = spec.contact.linear()?;
    let free = || scene.grains.iter().filter(|grain| grain.motion == Motion::Free);
    if law.friction == 0.0 || law.damping_ratio >= DASHPOT || free().count() < 2 {
        return None;
    }
    let lightest = free().map(|grain| grain.density / medium.density).fold(f64::INFINITY, f64::min);
    let value = (lightest, Measure::One);
    let bound = SolverBound::new("tangential-dashpot", "ρ_p/ρ", value, Side::AtLeast, UNDAMPED).because(
        "in a bed of light grains tangential springs without a dashpot make noise grow from window to window",
        "docs/maps/bed.csv",
        "give dem.contact.damping_ratio 0.1 or more (the default is 1), or windows of ten contact times",
    );
    Some(SolverBound { void_from: Some((Measure::WindowOverContact, UNDAMPED_WINDOW)), ..bound })
}
