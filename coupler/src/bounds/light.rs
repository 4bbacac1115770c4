//! Lowest density ratios of the maps. Each number is the least sampled ρ_p/ρ from which on every sampled
//! run of that column was stable, as counted by `tests/tests/pages/maps.rs`.

use protocol::facts::Forcing::{self, Carried, Direct, FictitiousDomain};
use protocol::facts::LoadsForm::{
    self, Izard2014, KempeFroehlich2012, Uhlmann2005, YuShao2007, YuShaoFixedPoint,
};

/// Columns of the maps: ν dt/D².
pub(super) const COLUMNS: [f64; 5] = [0.0024, 0.024, 0.08, 0.2, 0.8];

/// Method (how the motion is imposed, form of the loads, C_v = ½?, displaced mass?) and its limits at
/// [`COLUMNS`].
pub(super) type Row = (Forcing, LoadsForm, bool, bool, [f64; 5]);

/// A sphere on the axis, D/Δx = 10: docs/maps/light-axisymmetric.csv.
pub(super) const AXISYMMETRIC: [Row; 15] = [
    (Direct, Izard2014, false, false, [2.0, 2.0, 2.0, 2.0, 1.5]),
    (Carried, Izard2014, false, false, [2.0, 2.0, 2.0, 2.0, 2.0]),
    (Direct, KempeFroehlich2012, false, false, [0.3, 0.2, 0.5, 0.8, 0.8]),
    (Direct, KempeFroehlich2012, true, false, [0.01, 0.2, 0.5, 0.8, 0.8]),
    (Carried, KempeFroehlich2012, false, false, [1.001, 2.0, 3.0, 4.0, 8.0]),
    (Carried, KempeFroehlich2012, true, false, [0.8, 1.5, 3.0, 4.0, 8.0]),
    (Direct, Uhlmann2005, false, false, [0.5, 0.8, 1.001, 1.001, 1.2]),
    (Direct, Uhlmann2005, true, false, [0.3, 0.8, 1.001, 1.001, 1.2]),
    (Carried, Uhlmann2005, false, false, [1.001, 1.5, 2.0, 3.0, 8.0]),
    (Carried, Uhlmann2005, true, false, [0.8, 1.5, 3.0, 4.0, 8.0]),
    (Carried, YuShao2007, false, false, [0.8, 1.001, 1.2, 1.5, 1.5]),
    (Carried, YuShao2007, true, false, [0.01, 0.01, 0.2, 0.5, 0.5]),
    (Carried, YuShaoFixedPoint, false, false, [0.8, 1.001, 1.2, 1.2, 1.5]),
    (Carried, YuShaoFixedPoint, true, false, [0.01, 0.01, 0.2, 0.3, 0.5]),
    (Carried, YuShaoFixedPoint, true, true, [0.01, 0.01, 0.01, 0.01, 0.01]),
];

/// A sphere that falls and turns in space, D/Δx = 8; methods that were sampled there: docs/maps/light-space.csv.
pub(super) const SPACE: [Row; 9] = [
    (Direct, Izard2014, false, false, [2.0, 2.0, 2.0, 2.0, 2.0]),
    (Direct, KempeFroehlich2012, false, false, [0.5, 0.5, 0.8, 0.8, 1.001]),
    (Direct, KempeFroehlich2012, true, false, [0.01, 0.5, 0.8, 1.001, 1.001]),
    (Direct, Uhlmann2005, false, false, [0.8, 0.8, 1.001, 1.5, 1.5]),
    (Carried, YuShao2007, false, false, [0.8, 1.5, 2.0, 4.0, 4.0]),
    (Carried, YuShao2007, true, false, [0.01, 0.3, 0.8, 1.5, 2.0]),
    (Carried, YuShaoFixedPoint, false, false, [0.8, 1.001, 2.0, 2.0, 4.0]),
    (Carried, YuShaoFixedPoint, true, false, [0.01, 0.1, 0.8, 1.001, 2.0]),
    (Carried, YuShaoFixedPoint, true, true, [0.01, 0.01, 0.01, 0.01, 0.01]),
];

/// A disc that falls and turns, D/Δx = 8; methods that were sampled there: docs/maps/light-plane.csv, fictitious-domain.csv.
pub(super) const PLANE: [Row; 10] = [
    (Direct, Izard2014, false, false, [2.0, 2.0, 2.0, 2.0, 2.0]),
    (Direct, KempeFroehlich2012, false, false, [0.8, 0.8, 0.8, 0.8, 1.001]),
    (Direct, KempeFroehlich2012, true, false, [0.01, 0.8, 0.8, 0.8, 1.001]),
    (Direct, Uhlmann2005, false, false, [0.8, 0.8, 1.001, 1.001, 1.5]),
    (Carried, YuShao2007, false, false, [0.8, 1.001, 1.5, 2.0, 4.0]),
    (Carried, YuShaoFixedPoint, false, false, [0.8, 1.001, 1.5, 2.0, 4.0]),
    (Carried, YuShaoFixedPoint, true, false, [0.01, 0.1, 0.3, 0.8, 1.5]),
    (Carried, YuShaoFixedPoint, true, true, [0.01, 0.01, 0.01, 0.01, 0.01]),
    (FictitiousDomain, YuShaoFixedPoint, false, false, [0.8, 0.8, 0.8, 0.8, 0.8]),
    (FictitiousDomain, YuShaoFixedPoint, true, false, [0.1, 0.3, 0.3, 0.8, 0.8]),
];

/// Discs that touch in a bed, D/Δx = 9.5, at [`COLUMNS`], yu-shao-fixed-point with C_v = ½: docs/maps/light-bed.csv. What moves together drags
/// more fluid along than C_v knows of.
pub(super) const BED: [f64; 5] = [0.01, 0.1, 0.5, 0.5, 0.8];

/// The same with the displaced mass.
pub(super) const BED_DISPLACED: [f64; 5] = [0.2, 0.01, 0.01, 0.2, 0.5];

/// The same with the fictitious-domain method: docs/maps/fictitious-domain-bed.csv.
pub(super) const BED_FICTITIOUS: [f64; 5] = [0.01, 0.01, 0.2, 0.5, 0.8];

/// A disc along a wall with the fictitious-domain method, the virtual mass by the gap: docs/maps/light-wall.csv.
pub(super) const WALL_FICTITIOUS: [f64; 5] = [0.01, 0.3, 0.8, 1.001, 1.5];

/// Discs far from walls with the fictitious-domain method, both solvers at once, C_v ≥ ½: docs/maps/fictitious-domain.csv.
pub(super) const OVERLAPPED_FICTITIOUS: [f64; 5] = [2.0, 2.0, 4.0, 4.0, 8.0];

/// A rectangle of 2:1 and 4:1 with the fictitious-domain method, C_v ≥ ½, D that of the disc of its area:
/// docs/maps/bodies.csv. With a mask it has the limits of a disc.
pub(super) const BODIES_FICTITIOUS: [f64; 5] = [0.8; 5];

/// The same with both solvers at once.
pub(super) const BODIES_OVERLAPPED: [f64; 5] = [4.0, 4.0, 8.0, 8.0, 8.0];

/// Longest of them: length over least width, the diagonal counted.
pub(super) const BODIES_SLENDER: f64 = 4.2;

/// One row for each of [`super::Motion`]: a sphere that does not turn, one that does, a disc.
pub(super) type ByMotion = [[f64; 5]; 3];

/// At [`COLUMNS`] with windows repeated (yu-shao-fixed-point): docs/maps/schemes-axisymmetric.csv, -space.csv, -plane.csv.
pub(super) const ITERATED: ByMotion =
    [[0.01; 5], [0.5, 0.01, 0.01, 0.01, 0.01], [0.5, 0.01, 0.01, 0.01, 0.01]];

/// With both solvers at once, the force a window late, C_v = ½: the same maps. Infinite: none was found.
pub(super) const OVERLAPPED: ByMotion =
    [[0.8, 2.0, 4.0, 8.0, 8.0], [1.001, 2.0, 8.0, 8.0, f64::INFINITY], [1.5, 2.0, 4.0, 8.0, f64::INFINITY]];

/// The same with C_v = 2.
pub(super) const OVERLAPPED_HEAVY: ByMotion = [
    [0.01, 1.5, 4.0, 8.0, f64::INFINITY],
    [0.01, 2.0, 8.0, 8.0, f64::INFINITY],
    [1.001, 2.0, 4.0, 8.0, f64::INFINITY],
];
