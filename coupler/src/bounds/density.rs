//! Light grains: where an exchange of forces once per window is stable (numerics.md §1).

use protocol::facts::{FluidFacts, LoadsForm};
use protocol::scene::{Freedom, Geometry, Grain, Shape};
use protocol::scheme::Scheme;

use super::{Bound, Facts, SINGULAR, Side};

/// Columns of the measured table: ν dt/D².
const COLUMNS: [f64; 4] = [0.0024, 0.024, 0.08, 0.8];

/// Lowest ρ_r = ρ_p/ρ found stable (sphere, D/Δx = 10) at each of [`COLUMNS`]; a cell that was not
/// measured takes the larger of its neighbours.
fn row(loads: LoadsForm, virtual_mass: f64) -> [f64; 4] {
    let half = virtual_mass >= 0.5;
    match loads {
        LoadsForm::F1 => [1.7, 1.7, 1.7, 1.5],
        LoadsForm::F2 if half => [0.1, 0.5, 0.8, 0.8],
        LoadsForm::F2 => [0.3, 0.5, 0.5, 0.8],
        LoadsForm::F3 => [1.0, 1.2, 1.2, 1.5],
        LoadsForm::F5 | LoadsForm::F5b if half => [0.01, 0.1, 0.3, 0.8],
        LoadsForm::F5 | LoadsForm::F5b => [0.8, 0.8, 0.8, 1.0],
    }
}

/// Lowest ρ_r tried, and bounded, at every one of [`COLUMNS`] with windows repeated (docs/coupling.md, Schemes).
const ITERATED: f64 = 0.01;

/// Lowest ρ_r found stable with both solvers at once, the force a window late (sphere, D/Δx = 8, 120 windows;
/// `lowest_density_ratio_of_overlapped_solvers` in fluid-solver/tests/immersed/schemes.rs): none at the last.
fn overlapped_row(virtual_mass: f64) -> [f64; 4] {
    if virtual_mass >= 2.0 { [0.1, 1.5, 4.0, f64::INFINITY] } else { [0.8, 2.0, 4.0, f64::INFINITY] }
}

/// Lowest density ratio that is known to be stable. Between two columns the stricter one counts;
/// beyond the last one nothing was measured, and `density-range` says so.
#[must_use]
pub fn lowest_density_ratio(loads: LoadsForm, virtual_mass: f64, nu_dt_over_d2: f64) -> f64 {
    lowest_in(row(loads, virtual_mass), nu_dt_over_d2)
}

fn lowest_in(row: [f64; 4], nu_dt_over_d2: f64) -> f64 {
    let right = COLUMNS.iter().position(|column| nu_dt_over_d2 <= *column);
    match right {
        Some(0) => row[0],
        Some(right) => row[right - 1].max(row[right]),
        None => row[2].max(row[3]),
    }
}

/// The same for the scheme: a form of the loads fails earlier where the force is a window late, later
/// where windows are repeated.
fn lowest_by_scheme(scheme: Option<Scheme>, fluid: &FluidFacts, nu_dt_over_d2: f64) -> f64 {
    match scheme {
        Some(Scheme::Iterated) => ITERATED,
        Some(Scheme::Overlapped) => lowest_in(overlapped_row(fluid.virtual_mass), nu_dt_over_d2),
        _ => lowest_density_ratio(fluid.loads, fluid.virtual_mass, nu_dt_over_d2),
    }
}

/// Every grain that can move, with its ratio and limit.
fn judge(facts: &Facts<'_>) -> Vec<Judged> {
    let (Some(fluid), Some(medium), Some(nu)) = (facts.fluid, &facts.scene.scene.medium, facts.viscosity())
    else {
        return Vec::new();
    };
    let geometry = facts.scene.scene.domain.geometry;
    let judged = facts.scene.grains.iter().filter(|grain| can_move(grain, geometry)).map(|grain| {
        let nu_dt_over_d2 = nu * facts.ladder.dt_fluid / (2.0 * grain.radius).powi(2);
        Judged {
            ratio: grain.density / medium.density,
            limit: limit_of(grain, facts, fluid, nu_dt_over_d2),
            nu_dt_over_d2,
        }
    });
    judged.collect()
}

/// Density ratio and limit of the grain that is worst off.
pub(crate) fn lightest(facts: &Facts<'_>) -> Option<(f64, f64)> {
    let judged = judge(facts).into_iter().min_by(|a, b| a.margin().total_cmp(&b.margin()));
    judged.map(|worst| (worst.ratio, worst.limit))
}

pub(super) fn add(facts: &Facts<'_>, bounds: &mut Vec<Bound>) {
    let (Some(fluid), Some(_)) = (facts.fluid, facts.dem) else { return };
    let judged = judge(facts);
    let Some(worst) = judged.iter().copied().min_by(|a, b| a.margin().total_cmp(&b.margin())) else {
        return;
    };
    bounds.push(ratio_bound(worst, facts.scheme, fluid));
    let widest = judged.iter().map(|one| one.nu_dt_over_d2).fold(0.0, f64::max);
    bounds.push(Bound::new("density-range", "ν dt/D²", widest, Side::AtMost, COLUMNS[3]).warning().because(
        "the lowest stable density ratio was measured up to ν dt/D² = 0.8 only",
        "numerics §1, table",
        "lower the fluid's dt, or watch the first windows",
    ));
    if fluid.loads == LoadsForm::F1 {
        add_seed_form(facts, &judged, bounds);
    }
}

#[derive(Clone, Copy)]
struct Judged {
    ratio: f64,
    limit: f64,
    nu_dt_over_d2: f64,
}

impl Judged {
    fn margin(&self) -> f64 {
        self.ratio / self.limit
    }
}

fn can_move(grain: &Grain, geometry: Geometry) -> bool {
    use Freedom::{SpinX, SpinY, SpinZ, X, Y, Z};
    [X, Y, Z, SpinX, SpinY, SpinZ].into_iter().any(|freedom| grain.is_free(freedom, geometry))
}

fn can_rotate(grain: &Grain, geometry: Geometry) -> bool {
    use Freedom::{SpinX, SpinY, SpinZ};
    [SpinX, SpinY, SpinZ].into_iter().any(|freedom| grain.is_free(freedom, geometry))
}

fn limit_of(grain: &Grain, facts: &Facts<'_>, fluid: &FluidFacts, nu_dt_over_d2: f64) -> f64 {
    let geometry = facts.scene.scene.domain.geometry;
    let table = lowest_by_scheme(facts.scheme, fluid, nu_dt_over_d2);
    match fluid.loads {
        LoadsForm::F1 if can_rotate(grain, geometry) => table.max(2.0),
        // A disc failed at 1.05; the next ratio tried above it was stable.
        LoadsForm::F3 if grain.shape == Shape::Disc => table.max(1.1),
        _ => table,
    }
}

fn ratio_bound(worst: Judged, scheme: Option<Scheme>, fluid: &FluidFacts) -> Bound {
    let order = scheme.filter(|scheme| *scheme != Scheme::of(fluid.loads));
    let order = order.map_or(String::new(), |scheme| format!(", {scheme},"));
    let form = format!("{:?} with C_v = {}{order}", fluid.loads, fluid.virtual_mass);
    Bound::new(super::DENSITY_RATIO, "ρ_p/ρ", worst.ratio, Side::AtLeast, worst.limit).because(
        format!(
            "loads of form {form} were found unstable for lighter grains at ν dt/D² = {:.3}",
            super::Short(worst.nu_dt_over_d2)
        ),
        "numerics §1, table; docs/coupling.md, Schemes",
        "use the fluid's loads F5b with the virtual mass ½, a smaller dt, coupling.scheme = \"iterated\", or heavier grains",
    )
}

/// What only the seed's form suffers from: the factor ρρ_p/(ρ_p−ρ).
fn add_seed_form(facts: &Facts<'_>, judged: &[Judged], bounds: &mut Vec<Bound>) {
    let excess = judged.iter().map(|one| (one.ratio - 1.0).abs()).fold(f64::INFINITY, f64::min);
    bounds.push(Bound::new(SINGULAR, "|ρ_p/ρ − 1|", excess, Side::AtLeast, 1e-6).because(
        "loads of form F1 carry the factor ρρ_p/(ρ_p−ρ), which is singular for neutral grains",
        "Izard et al. 2014, eqs 5–6",
        "use another form of the loads (F5b); this bound cannot be forced",
    ));
    if !facts.ladder.contact_time.is_finite() {
        return;
    }
    let factor = judged.iter().map(|one| resting_factor(one.ratio)).fold(0.0, f64::max);
    bounds.push(Bound::new("resting-weight", "ρ_r/(ρ_r−1)", factor, Side::AtMost, 1.05).warning().because(
        "with loads of form F1 a resting grain presses this many times its submerged weight, because buoyancy is lost",
        "numerics §1",
        "use F2 or F5b where contact forces matter",
    ));
}

fn resting_factor(ratio: f64) -> f64 {
    if ratio > 1.0 { ratio / (ratio - 1.0) } else { f64::INFINITY }
}
