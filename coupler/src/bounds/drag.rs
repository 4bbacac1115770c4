//! The error of the drag that cells leave, from the chart of a sphere that is towed over the grid.

use bedload_scene::{CheckedScene, Motion};
use serde::{Deserialize, Serialize};

/// The chart, as `drag.toml` has it; a test of the studies makes it from docs/charts/towed-sphere.csv.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct DragErrors {
    /// Reynolds numbers U D/ν, rising.
    pub reynolds: Vec<f64>,
    /// Cells per diameter, rising.
    pub resolution: Vec<f64>,
    /// Of each Reynolds number the relative error at each resolution: the largest of the grids up to half a cell
    /// per diameter finer or coarser, since it depends on where the surface lies between the nodes.
    pub errors: Vec<Vec<f64>>,
}

impl DragErrors {
    /// The file.
    pub const TEXT: &str = include_str!("drag.toml");

    /// From its text.
    ///
    /// # Errors
    /// What is wrong with the text.
    pub fn parse(text: &str) -> Result<Self, String> {
        toml::from_str(text).map_err(|error| error.to_string())
    }

    /// At a Reynolds number and D/Δx, between the charted ones along straight lines; beyond them as at the last.
    #[must_use]
    pub fn at(&self, reynolds: f64, resolution: f64) -> f64 {
        let (row, part) = place(&self.reynolds, reynolds);
        let along = |errors: &[f64]| {
            let (column, part) = place(&self.resolution, resolution);
            between(errors[column], errors[(column + 1).min(errors.len() - 1)], part)
        };
        let next = (row + 1).min(self.errors.len() - 1);
        between(along(&self.errors[row]), along(&self.errors[next]), part)
    }
}

/// The last of rising `values` that is not above `x`, and the part of the way to the next one.
fn place(values: &[f64], x: f64) -> (usize, f64) {
    let at = values.partition_point(|value| *value <= x).clamp(1, values.len()) - 1;
    let Some(next) = values.get(at + 1) else { return (at, 0.0) };
    (at, ((x - values[at]) / (next - values[at])).clamp(0.0, 1.0))
}

fn between(low: f64, high: f64, part: f64) -> f64 {
    low + part * (high - low)
}

/// Largest U D/ν of a sphere or disc of the scene, where U is its largest speed against the fluid that follows
/// from the scene: what it falls and is thrown with, and for one that is held or driven that of the fluid, too.
/// None without grains or without convection.
pub(super) fn reynolds(scene: &CheckedScene, flow: f64, grain: f64) -> Option<f64> {
    let nu = scene.scene.medium.as_ref()?.kinematic_viscosity();
    let held = scene.grains.iter().any(|grain| grain.motion != Motion::Free);
    let diameter = scene.grains.iter().map(|grain| 2.0 * grain.radius).reduce(f64::max)?;
    let speed = if held { flow.max(grain) } else { grain };
    (nu > 0.0).then(|| speed * diameter / nu)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn errors_lie_between_the_charted_ones() {
        let errors = DragErrors {
            reynolds: vec![0.0, 100.0],
            resolution: vec![8.0, 16.0],
            errors: vec![vec![0.01, 0.002], vec![0.05, 0.01]],
        };
        assert!((errors.at(50.0, 12.0) - 0.018).abs() < 1e-12, "{}", errors.at(50.0, 12.0));
        assert_eq!([errors.at(0.0, 6.0), errors.at(300.0, 40.0)], [0.01, 0.01]);
    }

    #[test]
    fn the_file_reads_and_finer_grids_err_less() {
        let errors = DragErrors::parse(DragErrors::TEXT).unwrap();
        assert!(errors.errors.iter().all(|row| row.len() == errors.resolution.len()));
        assert!(errors.at(150.0, 16.0) < errors.at(150.0, 8.0));
    }
}
