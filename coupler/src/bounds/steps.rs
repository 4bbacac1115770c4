//! Sub-steps and windows against the contact time (docs/numerics.md).

use protocol::facts::{DemFacts, Side};

use super::bound::Bound;
use super::facts::Facts;

pub(super) fn add(facts: &Facts<'_>, bounds: &mut Vec<Bound>) {
    let Some(dem) = facts.dem else { return };
    let steps = facts.steps;
    if steps.contact_time.is_finite() {
        add_contact(steps.contact_time / steps.dt_dem, dem.coarse_dt, bounds);
        if facts.fluid.is_some() {
            add_window(facts, bounds);
        }
    }
}

/// `coarse`: the DEM's user asked for it.
fn add_contact(steps: f64, coarse: bool, bounds: &mut Vec<Bound>) {
    let bound =
        Bound::new("contact-steps", "t_c/dt_dem", steps, Side::AtLeast, DemFacts::LEAST_CONTACT_STEPS)
            .because(
                "a contact of so few sub-steps gives wrong rebounds (1 % at 10, 3 % at 5, nonsense at 2)",
                "dem-solver/tests/dem/restitution.rs",
                "raise coupling.steps_per_contact, or lower the DEM's dt",
            );
    bounds.push(if coarse { bound.warning() } else { bound });
    bounds.push(Bound::new("contact-accuracy", "t_c/dt_dem", steps, Side::AtLeast, 20.0).warning().because(
        "a contact is accurate from 20 sub-steps on",
        "docs/numerics.md, Contact and sub-steps",
        "raise coupling.steps_per_contact, or lower the DEM's dt",
    ));
}

fn add_window(facts: &Facts<'_>, bounds: &mut Vec<Bound>) {
    let ratio = facts.steps.dt_fluid / facts.steps.contact_time;
    let most = facts.coupling.max_dt_over_contact_time;
    bounds.push(Bound::new("window-over-contact", "dt_fluid/t_c", ratio, Side::AtMost, most).because(
        "the fluid sees a rebound only at the end of a window; up to 100 contact times heights change by 4–8 %",
        "docs/numerics.md, Windows longer than a contact",
        "lower the fluid's dt, raise the contact time, or raise coupling.max_dt_over_contact_time",
    ));
}
