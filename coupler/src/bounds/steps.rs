//! Sub-steps against contact and lubrication (docs/numerics.md), and what windows do to contacts.

use protocol::facts::DemFacts;
use protocol::scene::Motion;

use super::{Bound, Facts, Ladder, Side, choice};

/// Least ρ_p/ρ at which a bed of discs without a tangential dashpot stayed quiet: at 1.5 the forces on some grew by 6 % a
/// window. docs/maps/bed.csv
const UNDAMPED: f64 = 2.5;
/// From this dt_fluid/t_c on it stayed quiet at every ratio. docs/maps/bed.csv
const UNDAMPED_WINDOW: f64 = 10.0;
/// γ_t/γ_n that keeps such a bed quiet (docs/stability.md).
const DASHPOT: f64 = 0.1;

pub(super) fn add(facts: &Facts<'_>, bounds: &mut Vec<Bound>) {
    let Some(dem) = facts.dem else { return };
    let ladder = facts.ladder;
    if ladder.contact_time.is_finite() {
        add_contact(ladder.contact_time / ladder.dt_dem, dem.coarse_dt, bounds);
        add_packing(&ladder, dem, bounds);
        if facts.fluid.is_some() {
            add_window(facts, bounds);
            add_dashpot(facts, dem, bounds);
        }
    }
    if dem.lubrication_dt.is_finite() {
        bounds.push(
            Bound::new("explicit-lubrication", "dt_dem", ladder.dt_dem, Side::AtMost, dem.lubrication_dt)
                .because(
                    "explicit lubrication is stable only for dt < 2(η+δ)m/(6πμR²)",
                    "docs/numerics.md, Lubrication",
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
        "docs/numerics.md, Contact and sub-steps",
        "raise coupling.steps_per_contact, or lower the DEM's dt",
    ));
}

/// The tangential dashpots of all contacts of a grain act on its spin at once, each as it was before the sub-step:
/// with z contacts and neighbours that turn against it that is stable up to 2/3 z (m R²/I) γ_t dt/m = 1, which for six
/// contacts of spheres is γ_t dt/m_e = 0.2.
fn add_packing(ladder: &Ladder, dem: &DemFacts, bounds: &mut Vec<Bound>) {
    let Some(number) = dem.dashpot_number(ladder.dt_dem) else { return };
    let most = DemFacts::MOST_DASHPOT;
    let needed = (dem.tangential_rate * ladder.contact_time / most).ceil();
    bounds.push(Bound::new("contact-dashpot", "γ_t dt/m_e", number, Side::AtMost, most).because(
        "the tangential dashpots of all contacts of a grain together turn it too far: a packing never comes to rest",
        "docs/maps/packing.csv",
        format!(
            "give {needed} sub-steps per contact time (coupling.steps_per_contact, dem.steps_per_contact), or a \
             smaller dem.contact.damping_ratio"
        ),
    ));
}

fn add_window(facts: &Facts<'_>, bounds: &mut Vec<Bound>) {
    let ratio = facts.ladder.dt_fluid / facts.ladder.contact_time;
    let most = facts.coupling.max_dt_over_contact_time;
    bounds.push(Bound::new("window-over-contact", "dt_fluid/t_c", ratio, Side::AtMost, most).because(
        "the fluid sees a rebound only at the end of a window; up to 100 contact times heights change by 4–8 %",
        "docs/numerics.md, Windows longer than a contact",
        "lower the fluid's dt, raise the contact time, or raise coupling.max_dt_over_contact_time",
    ));
}

/// Springs without damping between grains that touch, fed by a force that stays the same for a window.
fn add_dashpot(facts: &Facts<'_>, dem: &DemFacts, bounds: &mut Vec<Bound>) {
    let contact = |key: &str| choice(&dem.resolved, "contact", key)?.as_float();
    let (Some(dashpot), Some(friction)) = (contact("damping_ratio"), contact("friction")) else { return };
    let Some(medium) = &facts.scene.scene.medium else { return };
    let free = || facts.scene.grains.iter().filter(|grain| grain.motion == Motion::Free);
    let long = facts.ladder.dt_fluid >= UNDAMPED_WINDOW * facts.ladder.contact_time;
    if friction == 0.0 || dashpot >= DASHPOT || long || free().count() < 2 {
        return;
    }
    let lightest = free().map(|grain| grain.density / medium.density).fold(f64::INFINITY, f64::min);
    bounds.push(Bound::new("tangential-dashpot", "ρ_p/ρ", lightest, Side::AtLeast, UNDAMPED).because(
        "in a bed of light grains tangential springs without a dashpot make noise grow from window to window",
        "docs/maps/bed.csv",
        "give dem.contact.damping_ratio 0.1 or more (the default is 1), or windows of ten contact times",
    ));
}
