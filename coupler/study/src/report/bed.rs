//! The charts of a bed: its totals over time, and both phases and their stresses over height.

use bedload_output::planes::{PARTS, Plane, Planes};

use super::curves::{Chart, line};
use super::run_files::RunFiles;
use crate::page::Figure;
use coupler::number::AXES;

/// Charts of `observe.totals`: caption, unit, and what the names of their columns begin with.
const TOTALS: [(&str, &str, &[&str]); 8] = [
    ("Volume flux per width", "q, m²/s", &["grain_flux_", "fluid_flux_"]),
    ("Velocity of the grains across the bed", "q_v, m²/s", &["velocity_flux_"]),
    ("Height of the bed", "h, m", &["bed_height"]),
    ("Grains that move", "number", &["moving_grains"]),
    ("Shields number of the total stress", "θ", &["shields"]),
    ("Contacts per free grain", "number", &["coordination_number"]),
    ("Forces on the walls", "F, N", &["wall_force_", "wall_contact_force_"]),
    ("Stress on the walls", "τ, Pa", &["wall_stress_"]),
];

/// Every chart for which the run has columns or planes.
pub(super) fn all(run: &RunFiles) -> Vec<Figure> {
    let time = run.series.time();
    let total = |(caption, y_label, begins): &(&str, &str, &[&str])| {
        let names =
            run.series.names().iter().filter(|name| begins.iter().any(|begin| name.starts_with(begin)));
        let columns = names.enumerate().filter_map(|(number, name)| {
            let column = run.series.column(name)?;
            // What stays zero, such as a force along a wall that nothing drags, is left out of many lines.
            let moves = begins.len() < 2 || column.iter().any(|value| *value != 0.0);
            moves.then(|| line(name, number, time, column))
        });
        Chart::new(caption, ["t, s", y_label], columns.collect())
    };
    let charts = TOTALS.iter().map(total);
    let profiles = run.planes.iter().flat_map(|planes| profiles(run, planes));
    charts.chain(profiles).flat_map(|chart| chart.figures()).collect()
}

/// Means over time on the planes, along the component in which the fluid is fastest.
fn profiles(run: &RunFiles, planes: &Planes) -> Vec<Chart> {
    let asked = run.scene.as_ref().and_then(|scene| scene.scene.observe.planes.as_ref());
    let y_label = format!("{}, m", asked.map_or("z", |asked| asked.axis.name()));
    let fastest = |c: usize| planes.planes.iter().map(|p| p.fluid_velocity[c].abs()).fold(0.0, f64::max);
    let c = (0..3).max_by(|a, b| fastest(*a).total_cmp(&fastest(*b))).unwrap_or(0);
    let height: Vec<f64> = planes.planes.iter().map(|p| p.at).collect();
    let over = |name: &str, number: usize, value: &dyn Fn(&Plane) -> f64| {
        line(name, number, &planes.planes.iter().map(value).collect::<Vec<_>>(), &height)
    };
    let there = |is: bool, value: f64| if is { value } else { f64::NAN };
    let solid = vec![over("φ", 0, &|p| p.solid_fraction)];
    let speeds = vec![
        over("fluid", 0, &|p| there(p.solid_fraction < 1.0, p.fluid_velocity[c])),
        over("grains", 1, &|p| there(p.solid_fraction > 0.0, p.grain_velocity[c])),
    ];
    let mut charts = vec![
        Chart::new("Solid fraction, mean over time", ["φ", &y_label], solid),
        Chart::new("Velocities, mean over time", [&format!("u_{}, m/s", AXES[c]), &y_label], speeds),
    ];
    if planes.planes.iter().all(|p| p.stresses.is_some()) {
        let parts = |p: &Plane| p.stresses.unwrap_or_default().parts.map(|part| part[c]);
        let sum = over("sum", PARTS.len(), &|p| parts(p).iter().sum());
        let lines = PARTS.iter().enumerate().map(|(i, name)| over(name, i, &|p| parts(p)[i])).chain([sum]);
        let labels = [&format!("τ_{}, Pa", AXES[c]), y_label.as_str()];
        charts.push(Chart::new("Stress, mean over time", labels, lines.collect()));
        let temperature = over("T", 0, &|p| p.stresses.unwrap_or_default().temperature);
        charts.push(Chart::new("Granular temperature", ["T, m²/s²", &y_label], vec![temperature]));
    }
    charts
}
