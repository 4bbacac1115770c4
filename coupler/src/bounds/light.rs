//! Lowest density ratios of the maps. Each number is the least sampled ρ_p/ρ from which on every sampled
//! run of that column was stable, as counted by `tests/tests/maps.rs`.

use protocol::facts::Forcing::{self, Carried, Direct};
use protocol::facts::LoadsForm::{self, F1, F2, F3, F5, F5b};

/// Columns of the maps: ν dt/D².
pub(super) const COLUMNS: [f64; 5] = [0.0024, 0.024, 0.08, 0.2, 0.8];

/// Method (how the motion is imposed, form of the loads, C_v = ½?, displaced mass?) and its limits at
/// [`COLUMNS`].
pub(super) type Row = (Forcing, LoadsForm, bool, bool, [f64; 5]);

/// A sphere on the axis, D/Δx = 10: docs/maps/light-axisymmetric.csv.
pub(super) const AXISYMMETRIC: [Row; 15] = [
    (Direct, F1, false, false, [2.0, 2.0, 2.0, 2.0, 1.5]),
    (Carried, F1, false, false, [2.0, 2.0, 2.0, 2.0, 2.0]),
    (Direct, F2, false, false, [0.3, 0.2, 0.5, 0.8, 0.8]),
    (Direct, F2, true, false, [0.01, 0.2, 0.5, 0.8, 0.8]),
    (Carried, F2, false, false, [1.001, 2.0, 3.0, 4.0, 8.0]),
    (Carried, F2, true, false, [0.8, 1.5, 3.0, 4.0, 8.0]),
    (Direct, F3, false, false, [0.5, 0.8, 1.001, 1.001, 1.2]),
    (Direct, F3, true, false, [0.3, 0.8, 1.001, 1.001, 1.2]),
    (Carried, F3, false, false, [1.001, 1.5, 2.0, 3.0, 8.0]),
    (Carried, F3, true, false, [0.8, 1.5, 3.0, 4.0, 8.0]),
    (Carried, F5, false, false, [0.8, 1.001, 1.2, 1.5, 1.5]),
    (Carried, F5, true, false, [0.01, 0.01, 0.2, 0.5, 0.5]),
    (Carried, F5b, false, false, [0.8, 1.001, 1.2, 1.2, 1.5]),
    (Carried, F5b, true, false, [0.01, 0.01, 0.2, 0.3, 0.5]),
    (Carried, F5b, true, true, [0.01, 0.01, 0.01, 0.01, 0.01]),
];

/// A disc that falls and turns, D/Δx = 8; methods that were sampled there: docs/maps/light-plane.csv.
pub(super) const PLANE: [Row; 8] = [
    (Direct, F1, false, false, [2.0, 2.0, 2.0, 2.0, 2.0]),
    (Direct, F2, false, false, [0.8, 0.8, 0.8, 0.8, 1.001]),
    (Direct, F2, true, false, [0.01, 0.8, 0.8, 0.8, 1.001]),
    (Direct, F3, false, false, [0.8, 0.8, 1.001, 1.001, 1.5]),
    (Carried, F5, false, false, [0.8, 1.001, 1.5, 2.0, 4.0]),
    (Carried, F5b, false, false, [0.8, 1.001, 1.5, 2.0, 4.0]),
    (Carried, F5b, true, false, [0.01, 0.1, 0.3, 0.8, 1.5]),
    (Carried, F5b, true, true, [0.01, 0.01, 0.01, 0.01, 0.01]),
];
