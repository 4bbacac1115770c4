//! The charts of a run against time: velocity, gap, forces, sub-steps.

use super::curves::{Chart, Line};
use super::run_files::RunFiles;
use crate::study::page::Figure;

/// Grains drawn in one chart.
const MOST_GRAINS: usize = 6;

/// The close-up around the first bounce reaches this far, in √(D/g), as figure 7 of Izard et al. (2014) does.
const CLOSEUP: (f64, f64) = (0.5, 1.5);

const AXES: [&str; 3] = ["x", "y", "z"];

/// Every chart for which the series has columns.
pub(super) fn all(run: &RunFiles) -> Vec<Figure> {
    let charts = [velocity(run), gap(run), forces(run), forces_at_bounce(run), substeps(run)];
    charts.iter().flatten().flat_map(Chart::figures).collect()
}

fn time(run: &RunFiles) -> Vec<f64> {
    run.series.time().iter().map(|t| t / run.scales.time).collect()
}

fn time_label(run: &RunFiles) -> String {
    if run.scales.by_gravity { "t / √(D/g)".into() } else { "t, s".into() }
}

fn label(run: &RunFiles, scaled: &str, plain: &str) -> String {
    if run.scales.by_gravity { scaled.to_owned() } else { plain.to_owned() }
}

/// Interval around the first contact of `grain`, in the units of the time axis.
fn around_contact(run: &RunFiles, grain: usize) -> Option<(f64, f64)> {
    let contact = run.first_contact(grain)? / run.scales.time;
    let whole = run.series.time().last()? / run.scales.time;
    let unit = if run.scales.by_gravity { 1.0 } else { 0.05 * whole };
    let span = (contact - CLOSEUP.0 * unit, contact + CLOSEUP.1 * unit);
    let rows = run.series.time().iter().filter(|t| (span.0..=span.1).contains(&(**t / run.scales.time)));
    // Nearly the whole run needs no close-up, and a few rows make none.
    (rows.count() > 10 && span.1 - span.0 < 0.6 * whole).then_some(span)
}

/// Components of a quantity that the series has for `grain`.
fn components(run: &RunFiles, quantity: &str, grain: usize) -> Vec<usize> {
    let has = |axis: &usize| run.series.column(&format!("{quantity}_{}[{grain}]", AXES[*axis])).is_some();
    (0..3).filter(has).collect()
}

fn velocity(run: &RunFiles) -> Option<Chart> {
    let grains = run.grains();
    let first = *grains.first()?;
    let along = components(run, "velocity", first);
    // One grain: its components. Several: one component each, along gravity if there is any.
    let lines: Vec<(String, String)> = if grains.len() == 1 {
        along
            .iter()
            .map(|axis| (AXES[*axis].to_owned(), format!("velocity_{}[{first}]", AXES[*axis])))
            .collect()
    } else {
        let axis = AXES[main_axis(run, &along)?];
        let named = |grain: &usize| (format!("grain {grain}"), format!("velocity_{axis}[{grain}]"));
        grains.iter().take(MOST_GRAINS).map(named).collect()
    };
    let what = if grains.len() == 1 { String::new() } else { format!("_{}", AXES[main_axis(run, &along)?]) };
    let time = time(run);
    let speed = run.scales.speed();
    let closeup = around_contact(run, first);
    let lines = lines.iter().enumerate().filter_map(|(number, (name, column))| {
        Some(Line::new(name, number, &time, &run.scaled(column, speed)?))
    });
    Some(Chart {
        caption: match &closeup {
            Some(_) => "Velocity, and a close-up of the first bounce".into(),
            None => "Velocity".into(),
        },
        x_label: time_label(run),
        y_label: label(run, &format!("v{what} / √(gD)"), &format!("v{what}, m/s")),
        lines: lines.collect(),
        log_y: false,
        closeup,
    })
}

/// The component along which gravity pulls most, or the first there is.
fn main_axis(run: &RunFiles, along: &[usize]) -> Option<usize> {
    let gravity = run.scene.as_ref().map_or([0.0; 3], |scene| scene.scene.gravity);
    let strongest = along.iter().copied().max_by(|a, b| gravity[*a].abs().total_cmp(&gravity[*b].abs()));
    strongest.filter(|axis| gravity[*axis] != 0.0).or(along.first().copied())
}

fn gap(run: &RunFiles) -> Option<Chart> {
    let grains = run.grains();
    let time = time(run);
    let lines = grains.iter().take(MOST_GRAINS).enumerate().filter_map(|(number, grain)| {
        let gap = run.scaled(&format!("gap[{grain}]"), run.scales.length)?;
        Some(Line::new(&format!("grain {grain}"), number, &time, &gap))
    });
    Some(Chart {
        caption: "Gap to the nearest wall or grain; contact at the lower edge".into(),
        x_label: time_label(run),
        y_label: label(run, "gap / D", "gap, m"),
        lines: lines.collect(),
        log_y: true,
        closeup: None,
    })
}

fn forces(run: &RunFiles) -> Option<Chart> {
    force_chart(run, None)
}

fn forces_at_bounce(run: &RunFiles) -> Option<Chart> {
    let span = around_contact(run, *run.grains().first()?)?;
    force_chart(run, Some(span))
}

/// Magnitudes of the three parts of the force on the first grain: a contact is short and orders of
/// magnitude stronger than the fluid, hence the logarithm.
fn force_chart(run: &RunFiles, span: Option<(f64, f64)>) -> Option<Chart> {
    let grain = *run.grains().first()?;
    let mut time = time(run);
    let keep: Vec<usize> = (0..time.len())
        .filter(|row| span.is_none_or(|(from, to)| (from..=to).contains(&time[*row])))
        .collect();
    time = keep.iter().map(|row| time[*row]).collect();
    let parts =
        [("fluid", "hydrodynamic_force"), ("contact", "contact_force"), ("lubrication", "lubrication_force")];
    let lines = parts.iter().enumerate().filter_map(|(number, (name, quantity))| {
        let whole = magnitude(run, quantity, grain)?;
        let part: Vec<f64> = keep.iter().map(|row| whole[*row]).collect();
        Some(Line::new(name, number, &time, &part))
    });
    let lines: Vec<Line> = lines.collect();
    let about = if span.is_some() { " around the first bounce" } else { "" };
    let drawn = keep.len() > 2 || span.is_none();
    drawn.then(|| Chart {
        caption: format!("Forces on grain {grain}{about}: means over windows; zero at the lower edge"),
        x_label: time_label(run),
        y_label: label(run, "|F| / submerged weight", "|F|, N"),
        lines,
        log_y: true,
        closeup: None,
    })
}

fn magnitude(run: &RunFiles, quantity: &str, grain: usize) -> Option<Vec<f64>> {
    let columns: Vec<Vec<f64>> = components(run, quantity, grain)
        .iter()
        .filter_map(|axis| run.scaled(&format!("{quantity}_{}[{grain}]", AXES[*axis]), run.scales.force))
        .collect();
    let rows = columns.first()?.len();
    Some((0..rows).map(|row| columns.iter().map(|column| column[row].powi(2)).sum::<f64>().sqrt()).collect())
}

fn substeps(run: &RunFiles) -> Option<Chart> {
    let column = run.series.column("substeps")?;
    Some(Chart {
        caption: "DEM sub-steps in the window at each recorded instant".into(),
        x_label: time_label(run),
        y_label: "sub-steps".into(),
        lines: vec![Line::new("sub-steps", 0, &time(run), column)],
        log_y: false,
        closeup: None,
    })
}
