//! Sub-steps against contact and lubrication (numerics.md §3).

use super::{Bound, Facts, Side};

pub(super) fn add(facts: &Facts<'_>, bounds: &mut Vec<Bound>) {
    let Some(dem) = facts.dem else { return };
    let ladder = facts.ladder;
    if ladder.contact_time.is_finite() {
        add_contact(ladder.contact_time / ladder.dt_dem, dem.coarse_dt, bounds);
        if facts.fluid.is_some() {
            add_window(facts, bounds);
        }
    }
    if dem.lubrication_dt.is_finite() {
        bounds.push(
            Bound::new("explicit-lubrication", "dt_dem", ladder.dt_dem, Side::AtMost, dem.lubrication_dt)
                .because(
                    "explicit lubrication is stable only for dt < 2(η+δ)m/(6πμR²)",
                    "numerics §3",
                    "make the lubrication implicit, raise the roughness η, or lower the DEM's dt",
                ),
        );
    }
}

/// `coarse`: the DEM's user asked for it.
fn add_contact(steps: f64, coarse: bool, bounds: &mut Vec<Bound>) {
    let bound = Bound::new("contact-steps", "t_c/dt_dem", steps, Side::AtLeast, 10.0).because(
        "a contact of so few sub-steps gives wrong rebounds (1 % at 10, 3 % at 5, nonsense at 2)",
        "dem-solver/tests/restitution.rs",
        "raise coupling.steps_per_contact, or lower the DEM's dt",
    );
    bounds.push(if coarse { bound.warning() } else { bound });
    bounds.push(Bound::new("contact-accuracy", "t_c/dt_dem", steps, Side::AtLeast, 20.0).warning().because(
        "a contact is accurate from 20 sub-steps on",
        "numerics §3",
        "raise coupling.steps_per_contact, or lower the DEM's dt",
    ));
}

fn add_window(facts: &Facts<'_>, bounds: &mut Vec<Bound>) {
    let ratio = facts.ladder.dt_fluid / facts.ladder.contact_time;
    let most = facts.coupling.max_dt_over_contact_time;
    bounds.push(Bound::new("window-over-contact", "dt_fluid/t_c", ratio, Side::AtMost, most).because(
        "the fluid sees a rebound only at the end of a window; up to 100 contact times heights change by 4–8 %",
        "numerics §3",
        "lower the fluid's dt, raise the contact time, or raise coupling.max_dt_over_contact_time",
    ));
}
