//! Light grains: where an exchange of forces once per window is stable (docs/stability.md).

use bedload_scene::{Freedom, Geometry, Grain, Shape};
use protocol::facts::{FluidFacts, Forcing, LoadsForm, Side};
use protocol::scheme::Scheme;

use super::bound::Bound;
use super::facts::Facts;
use super::light::{self, COLUMNS, Row};
use super::names::{DENSITY_RATIO, SINGULAR};
use crate::number::Short;

/// A value this near to a column, relative, is in it: ν dt/D² is a product of rounded numbers.
const SAME: f64 = 1e-9;

/// How the force on a grain is formed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Method {
    /// How the motion is imposed.
    pub forcing: Forcing,
    /// Form of the loads.
    pub loads: LoadsForm,
    /// C_v ≥ ½? Smaller virtual masses were not mapped and count as none.
    pub half: bool,
    /// Is the mass taken off that the grain displaces on the grid?
    pub displaced: bool,
}

impl Method {
    /// Of a fluid. What was not mapped counts as the next that was: a virtual mass with izard-2014 as none, the
    /// displaced mass without yu-shao-fixed-point and C_v = ½ as if it were not there.
    #[must_use]
    pub fn of(fluid: &FluidFacts) -> Self {
        let loads = fluid.loads;
        let half = fluid.virtual_mass >= 0.5 && loads != LoadsForm::Izard2014;
        Self {
            forcing: match fluid.forcing {
                Forcing::Direct if loads.is_semi_implicit() => Forcing::Carried,
                forcing => forcing,
            },
            loads,
            half,
            displaced: loads == LoadsForm::YuShaoFixedPoint && half && fluid.displaced_mass,
        }
    }

    /// Limits at the columns of a table, if it has this method.
    fn row(&self, table: &[Row]) -> Option<[f64; 5]> {
        let is_ours = |row: &&Row| {
            (row.0, row.1, row.2, row.3) == (self.forcing, self.loads, self.half, self.displaced)
        };
        table.iter().find(is_ours).map(|row| row.4)
    }

    /// Limits at the columns for grains that touch each other, if it was mapped for them.
    fn row_of_bed(&self) -> Option<[f64; 5]> {
        let mapped = self.loads == LoadsForm::YuShaoFixedPoint && self.half;
        mapped.then_some(if self.displaced { light::BED_DISPLACED } else { light::BED })
    }
}

/// What a grain is and may do, as far as the maps tell it apart.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Motion {
    /// A sphere that does not turn.
    Sphere,
    /// A sphere that may turn, in space: it fails earlier.
    TurningSphere,
    /// A disc.
    Disc,
}

impl Motion {
    fn of(grain: &Grain, geometry: Geometry) -> Self {
        use Freedom::{SpinX, SpinY, SpinZ};
        match grain.shape {
            Shape::Sphere if is_any(grain, geometry, [SpinX, SpinY, SpinZ]) => Self::TurningSphere,
            Shape::Sphere => Self::Sphere,
            _ => Self::Disc,
        }
    }

    /// Limits of a method at the columns. What was not mapped for discs and turning spheres counts as for spheres
    /// on the axis; turning spheres that were mapped have the stricter limit of the two, without virtual mass where
    /// they were not mapped with it.
    fn row(self, method: Method) -> Option<[f64; 5]> {
        let sphere = method.row(&light::AXISYMMETRIC);
        match self {
            Self::Sphere => sphere,
            Self::TurningSphere => {
                let plain = Method { half: false, displaced: false, ..method };
                let turning = method.row(&light::SPACE).or(plain.row(&light::SPACE));
                let (sphere, turning) = (sphere?, turning.or(sphere)?);
                Some(std::array::from_fn(|k| sphere[k].max(turning[k])))
            }
            Self::Disc => method.row(&light::PLANE).or(sphere),
        }
    }

    fn source(self) -> &'static str {
        match self {
            Self::Sphere => "docs/maps/light-axisymmetric.csv",
            Self::TurningSphere => "docs/maps/light-space.csv",
            Self::Disc => "docs/maps/light-plane.csv",
        }
    }
}

/// Lowest density ratio above which every sampled run was stable. Between two columns the stricter one
/// counts; beyond the last one nothing was measured, and `density-range` says so. Infinite for a method
/// that was not mapped.
#[must_use]
pub fn lowest_density_ratio(method: Method, motion: Motion, nu_dt_over_d2: f64) -> f64 {
    motion.row(method).map_or(f64::INFINITY, |row| lowest_in(row, nu_dt_over_d2))
}

fn lowest_in(row: [f64; 5], nu_dt_over_d2: f64) -> f64 {
    let right = COLUMNS.iter().position(|column| nu_dt_over_d2 <= *column * (1.0 + SAME));
    match right {
        Some(0) => row[0],
        Some(right) if nu_dt_over_d2 >= COLUMNS[right] * (1.0 - SAME) => row[right],
        Some(right) => row[right - 1].max(row[right]),
        None => row[3].max(row[4]),
    }
}

/// Limit of a grain under the plan's scheme, and where it was found: a form of the loads fails earlier where the force is a window
/// late or where grains touch each other, later where windows are repeated.
fn limit_of(
    motion: Motion,
    in_company: bool,
    facts: &Facts<'_>,
    fluid: &FluidFacts,
    nu_dt_over_d2: f64,
) -> (f64, &'static str) {
    let of = |table: light::ByMotion| {
        (lowest_in(table[motion as usize], nu_dt_over_d2), "docs/stability.md, Schemes")
    };
    if fluid.forcing == Forcing::FictitiousDomain {
        return limit_of_points(in_company, facts, fluid, nu_dt_over_d2);
    }
    match facts.scheme {
        // Where most windows are not repeated the limit is that of such windows.
        Some(Scheme::Iterated) if facts.coupling.iterations.repeat_above == 0.0 => {
            return of(light::ITERATED);
        }
        Some(Scheme::Overlapped) if fluid.virtual_mass >= 2.0 => return of(light::OVERLAPPED_HEAVY),
        Some(Scheme::Overlapped) => return of(light::OVERLAPPED),
        _ => {}
    }
    let method = Method::of(fluid);
    let alone = lowest_density_ratio(method, motion, nu_dt_over_d2);
    let together = method.row_of_bed().map(|row| lowest_in(row, nu_dt_over_d2));
    match together {
        Some(limit) if in_company && limit > alone => (limit, "docs/maps/light-bed.csv"),
        _ => (alone, motion.source()),
    }
}

/// The same of a disc with the fictitious-domain method: the largest of the limits that were found for one disc, for a bed
/// and along a wall.
fn limit_of_points(
    in_company: bool,
    facts: &Facts<'_>,
    fluid: &FluidFacts,
    nu_dt_over_d2: f64,
) -> (f64, &'static str) {
    const ALONE: &str = "docs/maps/fictitious-domain.csv";
    let domain = &facts.scene.scene.domain;
    let walls = (0..domain.dimensions()).any(|axis| domain.has_wall(axis));
    let half = fluid.virtual_mass >= 0.5;
    if facts.scheme == Some(Scheme::Overlapped) {
        let limit = lowest_in(light::OVERLAPPED_FICTITIOUS, nu_dt_over_d2);
        return (if half && !walls { limit } else { f64::INFINITY }, ALONE);
    }
    let mut found = (lowest_density_ratio(Method::of(fluid), Motion::Disc, nu_dt_over_d2), ALONE);
    for (applies, row, source) in [
        (in_company, light::BED_FICTITIOUS, "docs/maps/fictitious-domain-bed.csv"),
        (walls, light::WALL_FICTITIOUS, "docs/maps/light-wall.csv"),
    ] {
        // These two were made with a virtual mass.
        let limit = if half { lowest_in(row, nu_dt_over_d2) } else { f64::INFINITY };
        if applies && limit > found.0 {
            found = (limit, source);
        }
    }
    found
}

/// The limit that a body that is not round has beyond that of a disc; infinite where nothing was measured.
fn limit_of_body(
    grain: &Grain,
    facts: &Facts<'_>,
    fluid: &FluidFacts,
    nu_dt_over_d2: f64,
) -> Option<(f64, &'static str)> {
    const SOURCE: &str = "docs/maps/bodies.csv";
    if grain.shape.is_round() {
        return None;
    }
    if 2.0 * grain.radius > light::BODIES_SLENDER * grain.thickness() {
        return Some((f64::INFINITY, SOURCE));
    }
    if fluid.forcing != Forcing::FictitiousDomain {
        return None;
    }
    let overlapped = facts.scheme == Some(Scheme::Overlapped);
    let row = if overlapped { light::BODIES_OVERLAPPED } else { light::BODIES_FICTITIOUS };
    let limit = if fluid.virtual_mass >= 0.5 { lowest_in(row, nu_dt_over_d2) } else { f64::INFINITY };
    Some((limit, SOURCE))
}

/// Every grain that can move, with its ratio and limit.
fn judge(facts: &Facts<'_>) -> Vec<Judged> {
    // The maps are of our fluid.
    let fluid = facts.fluid.filter(|fluid| !fluid.foreign);
    let (Some(fluid), Some(medium), Some(nu)) = (fluid, &facts.scene.scene.medium, facts.viscosity()) else {
        return Vec::new();
    };
    let geometry = facts.scene.scene.domain.geometry;
    let free = || facts.scene.grains.iter().filter(|grain| can_move(grain, geometry));
    let in_company = free().nth(1).is_some();
    let judged = free().map(|grain| {
        let nu_dt_over_d2 = nu * facts.steps.dt_fluid / grain.equivalent_diameter().powi(2);
        let motion = Motion::of(grain, geometry);
        let round = limit_of(motion, in_company, facts, fluid, nu_dt_over_d2);
        let body = limit_of_body(grain, facts, fluid, nu_dt_over_d2);
        let (limit, source) = body.filter(|(limit, _)| *limit > round.0).unwrap_or(round);
        Judged { ratio: grain.density / medium.density, limit, nu_dt_over_d2, source }
    });
    judged.collect()
}

/// Density ratio and limit of the grain that is worst off.
pub(crate) fn lightest(facts: &Facts<'_>) -> Option<(f64, f64)> {
    let judged = judge(facts).into_iter().min_by(|a, b| a.margin().total_cmp(&b.margin()));
    judged.map(|worst| (worst.ratio, worst.limit))
}

pub(super) fn add(facts: &Facts<'_>, bounds: &mut Vec<Bound>) {
    let (Some(fluid), Some(_)) = (facts.fluid.filter(|fluid| !fluid.foreign), facts.dem) else { return };
    let judged = judge(facts);
    let Some(worst) = judged.iter().copied().min_by(|a, b| a.margin().total_cmp(&b.margin())) else {
        return;
    };
    bounds.push(ratio_bound(worst, facts.scheme, fluid));
    let widest = judged.iter().map(|one| one.nu_dt_over_d2).fold(0.0, f64::max);
    bounds.push(Bound::new("density-range", "ν dt/D²", widest, Side::AtMost, COLUMNS[4]).because(
        "no exchange of forces with grains that move was measured beyond it: what is stable there is unknown",
        "docs/stability.md",
        "lower the fluid's dt",
    ));
    if fluid.loads == LoadsForm::Izard2014 {
        add_izard_form(facts, &judged, bounds);
    }
}

#[derive(Clone, Copy)]
struct Judged {
    ratio: f64,
    limit: f64,
    nu_dt_over_d2: f64,
    /// Where the limit was found.
    source: &'static str,
}

impl Judged {
    fn margin(&self) -> f64 {
        self.ratio / self.limit
    }
}

fn can_move(grain: &Grain, geometry: Geometry) -> bool {
    use Freedom::{SpinX, SpinY, SpinZ, X, Y, Z};
    is_any(grain, geometry, [X, Y, Z, SpinX, SpinY, SpinZ])
}

fn is_any<const N: usize>(grain: &Grain, geometry: Geometry, freedoms: [Freedom; N]) -> bool {
    freedoms.into_iter().any(|freedom| grain.is_free(freedom, geometry))
}

fn ratio_bound(worst: Judged, scheme: Option<Scheme>, fluid: &FluidFacts) -> Bound {
    let order = scheme.filter(|scheme| *scheme != Scheme::of(fluid.loads));
    let order = order.map_or(String::new(), |scheme| format!(", {scheme},"));
    let form = format!("{} with C_v = {}{order}", fluid.loads, fluid.virtual_mass);
    Bound::new(DENSITY_RATIO, "ρ_p/ρ", worst.ratio, Side::AtLeast, worst.limit).because(
        format!(
            "loads of form {form} were {} at ν dt/D² = {:.3}",
            if worst.limit.is_finite() {
                "found unstable for lighter grains"
            } else {
                "not found stable for any density of such grains"
            },
            Short(worst.nu_dt_over_d2)
        ),
        worst.source,
        "use the fluid's loads yu-shao-fixed-point with the virtual mass ½, a smaller dt, coupling.scheme = \"iterated\", \
         fluid.loads.displaced_mass = \"as-mass\", or heavier grains",
    )
}

/// What only the form of Izard et al. (2014) suffers from: the factor ρρ_p/(ρ_p−ρ).
fn add_izard_form(facts: &Facts<'_>, judged: &[Judged], bounds: &mut Vec<Bound>) {
    let excess = judged.iter().map(|one| (one.ratio - 1.0).abs()).fold(f64::INFINITY, f64::min);
    bounds.push(Bound::new(SINGULAR, "|ρ_p/ρ − 1|", excess, Side::AtLeast, 1e-6).because(
        "loads of form izard-2014 carry the factor ρρ_p/(ρ_p−ρ), which is singular for neutral grains",
        "Izard et al. 2014, eqs 5–6",
        "use another form of the loads (yu-shao-fixed-point); this bound cannot be forced",
    ));
    if !facts.steps.contact_time.is_finite() {
        return;
    }
    let factor = judged.iter().map(|one| resting_factor(one.ratio)).fold(0.0, f64::max);
    bounds.push(Bound::new("resting-weight", "ρ_r/(ρ_r−1)", factor, Side::AtMost, 1.05).warning().because(
        "with loads of form izard-2014 a resting grain presses this many times its submerged weight, because buoyancy is lost",
        "docs/numerics.md, Weight of a resting grain",
        "use kempe-froehlich-2012 or yu-shao-fixed-point where contact forces matter",
    ));
}

fn resting_factor(ratio: f64) -> f64 {
    if ratio > 1.0 { ratio / (ratio - 1.0) } else { f64::INFINITY }
}
