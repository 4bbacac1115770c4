//! What a run of the DEM alone leaves at its end: `grains.csv`, `profile.csv`, metrics of a silo and of a
//! dense flow.

use std::collections::BTreeMap;

use crate::contacts::is_free;
use crate::output::flow::{exponent, inertial_number, stress_ratio};
use crate::output::grain_files;
use crate::output::janssen::{Measured, Silo, direct, plateau};
use crate::output::profile::Profile;
use crate::outside::Outside;
use crate::solver::Dem;
use crate::spec::DemSpec;
use bedload_output::{MetricValue, OutputFolder, atomic_write};
use bedload_scene::{CheckedScene, InRange, MetricKind};
use protocol::participant::SolverError;

/// Writes the files and measures; `spec` has all grains, also those that were not inserted.
pub(crate) fn finish(
    (dem, spec): (&Dem, &DemSpec),
    profile: Option<&Profile>,
    outside: &Outside,
    scene: &CheckedScene,
    folder: &OutputFolder,
) -> Result<BTreeMap<String, MetricValue>, SolverError> {
    let table = grain_files::table(dem.time(), &dem.grains, spec, &outside.sum_up(&dem.grains));
    atomic_write(&folder.grains(), table.as_bytes())?;
    let there = dem.grains.len();
    if let Some(next) = scene.inserted.get(there - scene.present()) {
        let (waiting, time, entry) = (spec.grains.len() - there, next.time, next.insertion);
        let why = if time <= dem.time() {
            format!(
                "grain {there} of insertions[{entry}], due at t = {time} s, has found no place yet, or its batch is \
                 to come: those after it wait"
            )
        } else {
            format!("the next is due at t = {time} s, after the end")
        };
        protocol::say!("bedload-dem: {waiting} grains were not inserted: {why}");
    }
    let Some(profile) = profile else { return Ok(BTreeMap::new()) };
    let gravity = spec.gravity.at(dem.time())[profile.axis];
    let fit = scene.scene.metrics.iter().find_map(|metric| match metric.kind {
        MetricKind::JanssenFit(InRange { range }) => {
            let silo = Silo::new(profile, range, gravity)?;
            Some((silo, silo.fit(profile, range)?))
        }
        _ => None,
    });
    let curves = fit.map_or_else(Vec::new, |(silo, fit)| curves(profile, &silo, fit.value));
    atomic_write(&folder.profile(), profile.table(&curves).as_bytes())?;
    Ok(metrics(scene, profile, gravity, mean_diameter(dem)))
}

/// Janssen's and the hydrostatic pressure beside the measured one.
fn curves(profile: &Profile, silo: &Silo, k: f64) -> Vec<(&'static str, Vec<f64>)> {
    let along =
        |of: &dyn Fn(f64) -> f64| (0..profile.cells.len()).map(|slab| of(profile.middle(slab))).collect();
    vec![("janssen", along(&|z| silo.pressure(z, k))), ("hydrostatic", along(&|z| silo.hydrostatic(z)))]
}

/// Mean diameter of the free grains, m.
fn mean_diameter(dem: &Dem) -> f64 {
    let free = (0..dem.grains.len()).filter(|&i| is_free(&dem.grains, i));
    let (count, sum) = free.fold((0.0, 0.0), |(n, sum), i| (n + 1.0, sum + 2.0 * dem.grains.radius[i]));
    sum / f64::max(count, 1.0)
}

fn metrics(
    scene: &CheckedScene,
    profile: &Profile,
    gravity: f64,
    diameter: f64,
) -> BTreeMap<String, MetricValue> {
    let mut values = BTreeMap::new();
    for metric in &scene.scene.metrics {
        let (measured, unit) = match metric.kind {
            MetricKind::JanssenFit(InRange { range }) => {
                (Silo::new(profile, range, gravity).and_then(|silo| silo.fit(profile, range)), "-")
            }
            MetricKind::JanssenDirect(InRange { range }) => (direct(profile, range), "-"),
            MetricKind::PlateauPressure(InRange { range }) => (plateau(profile, range), "Pa"),
            MetricKind::StressRatio(InRange { range }) => (stress_ratio(profile, range), "-"),
            MetricKind::InertialNumber(InRange { range }) => (inertial_number(profile, range, diameter), "-"),
            MetricKind::ShearExponent(InRange { range }) => (exponent(profile, range, gravity), "-"),
            _ => continue,
        };
        let told =
            |Measured { value, spread, slabs }| (value, Some(format!("± {spread:.3} over {slabs} slabs")));
        let none = "no slab in `range` holds grains that press, or no value fits them best".to_owned();
        let outcome = measured.map(told).ok_or(none);
        values.insert(metric.name.clone(), MetricValue::of(metric, unit, outcome));
    }
    values
}
