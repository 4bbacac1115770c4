//! The charts of a run against time: velocity, gap, forces, sub-steps.

use super::curves::{Chart, line};
use super::run_files::{RunFiles, column};
use crate::page::Figure;
use crate::plot::Series;
use coupler::number::AXES;

/// Grains drawn in one chart.
const MOST_GRAINS: usize = 6;

/// The close-up around the first bounce reaches this far, in √(D/g), as figure 7 of Izard et al. (2014) does.
const CLOSEUP: (f64, f64) = (0.5, 1.5);

/// The parts of the force on a grain: a contact is short and orders of magnitude stronger than the fluid,
/// hence the logarithm.
const FORCES: [(&str, &str); 3] =
    [("fluid", "hydrodynamic_force"), ("contact", "contact_force"), ("lubrication", "lubrication_force")];

/// A run, its instants in the unit of the time axis, and the grains that its series has.
struct Plots<'a> {
    run: &'a RunFiles,
    time: Vec<f64>,
    grains: Vec<usize>,
}

/// Every chart for which the series has columns.
pub(super) fn all(run: &RunFiles) -> Vec<Figure> {
    let time = run.series.time().iter().map(|t| t / run.scales.time).collect();
    let plots = Plots { run, time, grains: run.grains() };
    let bounce = plots.grains.first().and_then(|first| plots.around_contact(*first));
    let at_bounce = bounce.and_then(|span| plots.forces(Some(span)));
    let charts = [plots.velocity(bounce), plots.gap(), plots.forces(None), at_bounce, plots.substeps()];
    charts.iter().flatten().flat_map(Chart::figures).collect()
}

impl Plots<'_> {
    /// Lines against time; the label of y depends on the scales.
    fn chart(&self, caption: &str, (scaled, plain): (&str, &str), lines: Vec<Series>) -> Chart {
        let by_gravity = self.run.scales.by_gravity;
        let labels = if by_gravity { ["t / √(D/g)", scaled] } else { ["t, s", plain] };
        Chart::new(caption, labels, lines)
    }

    /// Interval around the first contact of `grain`, in the units of the time axis.
    fn around_contact(&self, grain: usize) -> Option<(f64, f64)> {
        let contact = self.run.first_contact(grain)? / self.run.scales.time;
        let whole = *self.time.last()?;
        let unit = if self.run.scales.by_gravity { 1.0 } else { 0.05 * whole };
        let span = (contact - CLOSEUP.0 * unit, contact + CLOSEUP.1 * unit);
        let rows = self.time.iter().filter(|t| (span.0..=span.1).contains(*t));
        // Nearly the whole run needs no close-up, and a few rows make none.
        (rows.count() > 10 && span.1 - span.0 < 0.6 * whole).then_some(span)
    }

    /// Components of a quantity that the series has for `grain`.
    fn components(&self, quantity: &str, grain: usize) -> Vec<usize> {
        let has = |axis: &usize| self.run.series.column(&column(quantity, *axis, grain)).is_some();
        (0..3).filter(has).collect()
    }

    /// With a close-up of the bounce.
    fn velocity(&self, closeup: Option<(f64, f64)>) -> Option<Chart> {
        let first = *self.grains.first()?;
        let along = self.components("velocity", first);
        // One grain: its components. Several: one component each, along gravity if there is any.
        let (what, named): (String, Vec<(String, String)>) = if self.grains.len() == 1 {
            let named = |axis: &usize| (AXES[*axis].to_owned(), column("velocity", *axis, first));
            (String::new(), along.iter().map(named).collect())
        } else {
            let axis = self.main_axis(&along)?;
            let named = |grain: &usize| (format!("grain {grain}"), column("velocity", axis, *grain));
            (format!("_{}", AXES[axis]), self.grains.iter().take(MOST_GRAINS).map(named).collect())
        };
        let drawn_line = |(number, (name, column)): (usize, &(String, String))| {
            Some(line(name, number, &self.time, &self.run.scaled(column, self.run.scales.speed())?))
        };
        let lines = named.iter().enumerate().filter_map(drawn_line).collect();
        let labels = (format!("v{what} / √(gD)"), format!("v{what}, m/s"));
        let chart = self.chart("Velocity", (&labels.0, &labels.1), lines);
        Some(Chart { closeup, ..chart })
    }

    /// The component along which gravity pulls most, or the first there is.
    fn main_axis(&self, along: &[usize]) -> Option<usize> {
        let gravity =
            self.run.scene.as_ref().map_or([0.0; 3], |scene| scene.scene.gravity.longest(scene.scene.until));
        let strongest = along.iter().copied().max_by(|a, b| gravity[*a].abs().total_cmp(&gravity[*b].abs()));
        strongest.filter(|axis| gravity[*axis] != 0.0).or(along.first().copied())
    }

    fn gap(&self) -> Option<Chart> {
        let drawn_line = |(number, grain): (usize, &usize)| {
            let gap = self.run.scaled(&format!("gap[{grain}]"), self.run.scales.length)?;
            Some(line(&format!("grain {grain}"), number, &self.time, &gap))
        };
        let lines = self.grains.iter().take(MOST_GRAINS).enumerate().filter_map(drawn_line).collect();
        let caption = "Gap to the nearest wall or grain; contact at the lower edge";
        Some(Chart { log_y: true, ..self.chart(caption, ("gap / D", "gap, m"), lines) })
    }

    /// Magnitudes of the parts of the force on the first grain, in a part of the time.
    fn forces(&self, span: Option<(f64, f64)>) -> Option<Chart> {
        let grain = *self.grains.first()?;
        let inside = |time: f64| span.is_none_or(|(from, to)| (from..=to).contains(&time));
        let keep: Vec<usize> = (0..self.time.len()).filter(|row| inside(self.time[*row])).collect();
        let part = |whole: &[f64]| keep.iter().map(|row| whole[*row]).collect::<Vec<_>>();
        let time = part(&self.time);
        let drawn_line = |(number, (name, quantity)): (usize, &(&str, &str))| {
            Some(line(name, number, &time, &part(&self.magnitude(quantity, grain)?)))
        };
        let lines: Vec<Series> = FORCES.iter().enumerate().filter_map(drawn_line).collect();
        let about = if span.is_some() { " around the first bounce" } else { "" };
        let caption = format!("Forces on grain {grain}{about}: means over windows; zero at the lower edge");
        let drawn = keep.len() > 2 || span.is_none();
        let chart = self.chart(&caption, ("|F| / submerged weight", "|F|, N"), lines);
        drawn.then_some(Chart { log_y: true, ..chart })
    }

    fn magnitude(&self, quantity: &str, grain: usize) -> Option<Vec<f64>> {
        let scaled = |axis: &usize| self.run.scaled(&column(quantity, *axis, grain), self.run.scales.force);
        let columns: Vec<Vec<f64>> = self.components(quantity, grain).iter().filter_map(scaled).collect();
        let square = |row: usize| columns.iter().map(|column| column[row].powi(2)).sum::<f64>();
        Some((0..columns.first()?.len()).map(|row| square(row).sqrt()).collect())
    }

    fn substeps(&self) -> Option<Chart> {
        // One in each window says nothing.
        let counts = self.run.series.column("substeps")?;
        counts.iter().find(|count| **count != 1.0)?;
        let lines = vec![line("sub-steps", 0, &self.time, counts)];
        let caption = "DEM sub-steps in the window at each recorded instant";
        Some(self.chart(caption, ("sub-steps", "sub-steps"), lines))
    }
}
