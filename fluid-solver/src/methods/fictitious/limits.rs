//! Which bodies are too light for the fictitious-domain method.

use crate::methods::limits::{Limits, density_ratio};
use bedload_scene::{CheckedScene, Medium};
use protocol::facts::SolverBound;

const DISC: ([f64; 5], &str) = ([0.1, 0.3, 0.3, 0.8, 0.8], "docs/maps/fictitious-domain.csv");

/// Discs with C_v = ½, along a wall with the virtual mass by the gap; rectangles of 2:1 and 4:1, D being that
/// of the disc of the same area.
const LIMITS: Limits = Limits {
    alone: [DISC; 3],
    together: Some(([0.1, 0.5, 0.1, 0.5, 0.8], "docs/maps/fictitious-domain-bed.csv")),
    at_walls: Some(([0.01, 0.3, 0.8, 1.001, 1.5], "docs/maps/light-wall.csv")),
    bodies: Some(([0.8; 5], "docs/maps/bodies.csv")),
};

/// The bounds of a scene.
pub(in crate::methods) fn bounds(scene: &CheckedScene, medium: &Medium) -> Vec<SolverBound> {
    let remedy =
        "use fluid.method = \"calibrated\", which can repeat windows, heavier grains, or a smaller dt";
    density_ratio(scene, medium, &LIMITS, None, remedy)
}
