//! Which grains are too light for the calibrated method.

use crate::methods::limits::{Limits, density_ratio};
use bedload_scene::{CheckedScene, Medium};
use protocol::facts::SolverBound;
use protocol::scheme::Iterations;

/// One exchange per window.
const ONCE: Limits = Limits {
    alone: [
        // Mapped down to 0.01. A run whose sphere is let go in windows of ν dt/D² = 0.8 ends as unstable in
        // the first at 0.1, not at 0.3.
        ([0.01, 0.01, 0.01, 0.01, 0.3], "docs/maps/light-axisymmetric.csv"),
        ([0.01, 0.01, 0.01, 0.01, 0.3], "docs/maps/light-space.csv"),
        // A disc that turns; one that does not is stable from 0.01 on (light-plane).
        ([0.01, 0.01, 0.3, 0.3, 0.8], "docs/maps/light-rotation.csv"),
    ],
    // Discs; what moves together drags more fluid along than C_v knows of.
    together: Some(([0.01, 0.01, 0.3, 0.3, 0.8], "docs/maps/light-bed.csv")),
    at_walls: None,
    bodies: Some(([0.1, 0.01, 0.01, 0.01, 0.01], "docs/maps/bodies.csv")),
};

/// Windows repeated.
const REPEATED: Limits = Limits {
    alone: [
        ([0.01; 5], "docs/maps/schemes-axisymmetric.csv"),
        ([0.01; 5], "docs/maps/schemes-space.csv"),
        ([0.1, 0.01, 0.01, 0.01, 0.01], "docs/maps/schemes-plane.csv"),
    ],
    together: None,
    at_walls: None,
    bodies: None,
};

/// The bounds of a scene.
pub(in crate::methods) fn bounds(
    scene: &CheckedScene,
    medium: &Medium,
    iterations: &Iterations,
) -> Vec<SolverBound> {
    // Where most windows are not repeated the limit is that of such windows.
    let repeated = if iterations.repeat_above == 0.0 { &REPEATED } else { &ONCE };
    let remedy = "use coupling.scheme = \"iterated\", heavier grains, or a smaller dt";
    density_ratio(scene, medium, &ONCE, Some(repeated), remedy)
}
