//! Which grains are too light for one exchange of forces per window, as data for the coupler
//! (docs/stability.md).
//!
//! A method has the lowest density ratios that were found stable at five ν dt/D². With the sizes of the
//! grains these become a table over the length of the window, which the coupler looks up.

use bedload_scene::{CheckedScene, Freedom, Geometry, Grain, Medium, Shape};
use protocol::facts::{BoundRow, Measure, Side, SolverBound};
use std::collections::{BTreeMap, BTreeSet};

/// ν dt/D² of the maps.
const COLUMNS: [f64; 5] = [0.0024, 0.024, 0.08, 0.2, 0.8];

/// A value this near to a column, relative, is in it: ν dt/D² is a product of rounded numbers.
const SAME: f64 = 1e-9;

/// Longest body that was measured: length over least width, the diagonal counted.
const SLENDER: f64 = 4.2;

/// Solid fraction of the grains' bounding box from which a bed counts as dense.
const DENSE: f64 = 0.3;

/// Fewer grains than this are no bed.
const FEWEST_OF_A_BED: usize = 8;

/// Lowest density ratios at [`COLUMNS`] from which on every sampled run was stable, as counted by
/// `tests/tests/maps.rs`, and the map that they come from.
pub(crate) type Row = ([f64; 5], &'static str);

/// The limits of a method; of those that apply to a grain the largest counts.
pub(crate) struct Limits {
    /// A sphere that does not turn, a sphere that may turn, a disc.
    pub(crate) alone: [Row; 3],
    /// Where two grains or more may move.
    pub(crate) together: Option<Row>,
    /// Where the box has walls.
    pub(crate) at_walls: Option<Row>,
    /// For bodies that are not round.
    pub(crate) bodies: Option<Row>,
}

/// Of the calibrated method with one exchange per window.
pub(super) const ONCE: Limits = Limits {
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

/// Where windows are repeated.
pub(super) const REPEATED: Limits = Limits {
    alone: [
        ([0.01; 5], "docs/maps/schemes-axisymmetric.csv"),
        ([0.01; 5], "docs/maps/schemes-space.csv"),
        ([0.1, 0.01, 0.01, 0.01, 0.01], "docs/maps/schemes-plane.csv"),
    ],
    together: None,
    at_walls: None,
    bodies: None,
};

/// Of the fictitious-domain method, alone.
const DISC: Row = ([0.1, 0.3, 0.3, 0.8, 0.8], "docs/maps/fictitious-domain.csv");

/// Of the fictitious-domain method: discs with C_v = ½, along a wall with the virtual mass by the gap;
/// rectangles of 2:1 and 4:1, D being that of the disc of the same area.
pub(super) const FICTITIOUS: Limits = Limits {
    alone: [DISC; 3],
    together: Some(([0.01, 0.01, 0.1, 0.5, 0.2], "docs/maps/fictitious-domain-bed.csv")),
    at_walls: Some(([0.01, 0.3, 0.8, 1.001, 1.5], "docs/maps/light-wall.csv")),
    bodies: Some(([0.8; 5], "docs/maps/bodies.csv")),
};

/// One interval of ν dt/D²: its end, limit and source.
type Piece = (f64, f64, &'static str);

/// The intervals of one row: each column by itself, between two columns the larger of their limits, beyond
/// the last the larger of the last two (`density-range` says that nothing was measured there).
fn pieces((row, source): Row) -> Vec<Piece> {
    let mut pieces = vec![(COLUMNS[0] * (1.0 + SAME), row[0], source)];
    for k in 1..COLUMNS.len() {
        pieces.push((COLUMNS[k] * (1.0 - SAME), row[k - 1].max(row[k]), source));
        pieces.push((COLUMNS[k] * (1.0 + SAME), row[k], source));
    }
    pieces.push((f64::INFINITY, row[3].max(row[4]), source));
    pieces
}

/// Grains that the fluid can move.
pub(super) fn free_grains(scene: &CheckedScene) -> impl Iterator<Item = &Grain> {
    use Freedom::{SpinX, SpinY, SpinZ, X, Y, Z};
    let geometry = scene.scene.domain.geometry;
    scene.grains.iter().filter(move |grain| is_any(grain, geometry, &[X, Y, Z, SpinX, SpinY, SpinZ]))
}

fn is_any(grain: &Grain, geometry: Geometry, freedoms: &[Freedom]) -> bool {
    freedoms.iter().any(|freedom| grain.is_free(*freedom, geometry))
}

/// Grains for which the same limits hold at the same dt.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct Class {
    /// Index into [`Limits::alone`].
    alone: usize,
    round: bool,
    slender: bool,
    /// Bits of ρ_p/ρ and of D²/ν, s.
    ratio: u64,
    time: u64,
}

impl Class {
    fn of(grain: &Grain, geometry: Geometry, medium: &Medium) -> Self {
        use Freedom::{SpinX, SpinY, SpinZ};
        let turns = is_any(grain, geometry, &[SpinX, SpinY, SpinZ]);
        let alone = match grain.shape {
            Shape::Sphere if turns => 1,
            Shape::Sphere => 0,
            _ => 2,
        };
        let round = grain.shape.is_round();
        Self {
            alone,
            round,
            slender: !round && 2.0 * grain.radius > SLENDER * grain.thickness(),
            ratio: (grain.density / medium.density).to_bits(),
            time: (grain.equivalent_diameter().powi(2) / medium.kinematic_viscosity()).to_bits(),
        }
    }

    fn pieces(&self, limits: &Limits, together: bool, at_walls: bool) -> Vec<Piece> {
        if self.slender {
            return vec![(f64::INFINITY, f64::INFINITY, "docs/maps/bodies.csv")];
        }
        let mut found = pieces(limits.alone[self.alone]);
        let more = [
            limits.together.filter(|_| together),
            limits.at_walls.filter(|_| at_walls),
            limits.bodies.filter(|_| !self.round),
        ];
        for row in more.into_iter().flatten() {
            for (piece, other) in found.iter_mut().zip(pieces(row)) {
                if other.1 > piece.1 {
                    *piece = other;
                }
            }
        }
        found
    }
}

/// Value and limit of the grain that is worst off, by the length of the window.
fn rows(scene: &CheckedScene, medium: &Medium, limits: &Limits) -> Vec<BoundRow> {
    let domain = &scene.scene.domain;
    let at_walls = (0..domain.dimensions()).any(|axis| domain.has_wall(axis));
    let together = free_grains(scene).nth(1).is_some();
    let classes: BTreeSet<Class> =
        free_grains(scene).map(|grain| Class::of(grain, domain.geometry, medium)).collect();
    let mut known: BTreeMap<Class, Vec<Piece>> = BTreeMap::new();
    let classes: Vec<(f64, f64, Vec<Piece>)> = classes
        .into_iter()
        .map(|class| {
            let kind = Class { ratio: 0, time: 0, ..class };
            let pieces = known.entry(kind).or_insert_with(|| kind.pieces(limits, together, at_walls)).clone();
            (f64::from_bits(class.ratio), f64::from_bits(class.time), pieces)
        })
        .collect();
    // Where each class goes from one of its pieces to the next.
    let mut ends: Vec<(f64, usize)> = Vec::new();
    for (index, (_, time, pieces)) in classes.iter().enumerate() {
        ends.extend(pieces.iter().map(|(end, ..)| (end * time, index)).filter(|(end, _)| end.is_finite()));
    }
    ends.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    // Margins are not negative, so that their bits have their order.
    let margin = |index: usize, at: usize| (classes[index].0 / classes[index].2[at].1).to_bits();
    let mut at = vec![0; classes.len()];
    let mut margins: BTreeSet<(u64, usize)> =
        (0..classes.len()).map(|index| (margin(index, 0), index)).collect();
    let mut rows: Vec<BoundRow> = Vec::new();
    for (up_to, moving) in
        ends.into_iter().map(|(end, index)| (end, Some(index))).chain([(f64::INFINITY, None)])
    {
        let Some(&(_, worst)) = margins.first() else { break };
        let (value, (_, limit, source)) = (classes[worst].0, classes[worst].2[at[worst]]);
        match rows.last_mut() {
            Some(last) if (last.value, last.limit, last.source.as_str()) == (value, limit, source) => {
                last.up_to = up_to;
            }
            Some(last) if last.up_to == up_to => {}
            _ => rows.push(BoundRow { up_to, value, limit, source: source.to_owned() }),
        }
        if let Some(index) = moving {
            margins.remove(&(margin(index, at[index]), index));
            at[index] += 1;
            margins.insert((margin(index, at[index]), index));
        }
    }
    rows
}

/// `density-ratio` and `density-range` of a method; `repeated`: its limits where windows are repeated, if it
/// can.
pub(super) fn density_ratio(
    scene: &CheckedScene,
    medium: &Medium,
    limits: &Limits,
    repeated: Option<&Limits>,
    remedy: &str,
) -> Vec<SolverBound> {
    use protocol::scheme::Scheme::{Iterated, SemiImplicit};
    let Some(smallest) = free_grains(scene).map(Grain::equivalent_diameter).reduce(f64::min) else {
        return Vec::new();
    };
    const ONCE: &str = "lighter grains were found unstable, or were not measured, at this ν dt/D²: the loads \
                        answer the motion a window late";
    const REPEATED: &str = "lighter grains were found unstable in repeated windows, or were not measured, at \
                            this ν dt/D²";
    let bound = |limits: &Limits, why: &str, remedy: &str| SolverBound {
        rows: rows(scene, medium, limits),
        ..SolverBound::new("density-ratio", "ρ_p/ρ", (0.0, Measure::Window), Side::AtLeast, 0.0).because(
            why,
            "docs/stability.md",
            remedy,
        )
    };
    let mut bounds = match repeated {
        None => vec![bound(limits, ONCE, remedy)],
        Some(repeated) => vec![
            SolverBound {
                scheme: Some(SemiImplicit),
                wider_in: Some(Iterated),
                ..bound(limits, ONCE, remedy)
            },
            SolverBound {
                scheme: Some(Iterated),
                ..bound(repeated, REPEATED, "use heavier grains, or another dt")
            },
        ],
    };
    let value = (medium.kinematic_viscosity() / smallest.powi(2), Measure::Window);
    bounds.push(SolverBound::new("density-range", "ν dt/D²", value, Side::AtMost, COLUMNS[4]).because(
        "no exchange of forces with grains that move was measured beyond it: what is stable there is unknown",
        "docs/stability.md",
        "lower the fluid's dt",
    ));
    bounds
}

/// A dense bed against the window, for a carried force; `viscous`: ν/Δx², 1/s.
pub(super) fn dense_bed(scene: &CheckedScene, viscous: f64) -> Option<SolverBound> {
    if scene.grains.len() < FEWEST_OF_A_BED {
        return None;
    }
    let domain = &scene.scene.domain;
    let extent = |axis: usize| {
        let component = domain.geometry.component(axis);
        let lower = scene.grains.iter().map(|grain| grain.position[component] - grain.radius);
        let upper = scene.grains.iter().map(|grain| grain.position[component] + grain.radius);
        upper.fold(f64::NEG_INFINITY, f64::max) - lower.fold(f64::INFINITY, f64::min)
    };
    let size: f64 = (0..domain.dimensions()).map(extent).product();
    let solid = scene.grains.iter().map(Grain::volume).sum::<f64>();
    let bound = || {
        let value = (viscous, Measure::Window);
        SolverBound::new("dense-bed-forcing", "ν dt/Δx²", value, Side::AtMost, 2.0).warning().because(
            "the carried force of a dense bed converges slowly (340 steps to 1 % at φ = 0.52 and 16)",
            "docs/numerics.md, Forcing and viscosity",
            "lower the fluid's dt",
        )
    };
    (solid > DENSE * size).then(bound)
}

#[cfg(test)]
mod tests {
    use super::*;
    use bedload_scene::SceneSource;

    const LIMITS: Limits = Limits {
        alone: [([0.1, 0.2, 0.3, 0.8, 0.5], "sphere"), ([1.0; 5], "turning"), ([2.0; 5], "disc")],
        together: Some(([0.0, 0.4, 0.0, 0.0, 0.0], "bed")),
        at_walls: None,
        bodies: None,
    };

    /// Spheres on an axis of given radius and density, ρ = 1, ν = 0.01.
    fn scene(grains: &[[f64; 2]]) -> CheckedScene {
        let mut text = "until = 1.0\n[domain]\ngeometry = \"axisymmetric\"\nlower = [0.0, 0.0]\nupper = [9.0, 99.0]\n\
                        cells = [90, 990]\nboundary = { r_upper = \"free-slip\", z = \"free-slip\" }\n[medium]\n\
                        density = 1.0\nviscosity = 0.01\n"
            .to_owned();
        for (k, [radius, density]) in grains.iter().enumerate() {
            let z = 10.0 * (k + 1) as f64;
            text +=
                &format!("[[grains]]\nposition = [0.0, 0.0, {z}]\nradius = {radius}\ndensity = {density}\n");
        }
        CheckedScene::new(SceneSource { file: "test.toml".into(), text }).expect("a good scene")
    }

    fn found(scene: &CheckedScene, dt: f64) -> (f64, f64) {
        let medium = scene.scene.medium.as_ref().expect("a fluid");
        let rows = rows(scene, medium, &LIMITS);
        assert!(rows.windows(2).all(|pair| pair[0].up_to < pair[1].up_to), "{rows:?}");
        let row = rows.iter().find(|row| dt <= row.up_to).expect("the last row has no end");
        (row.value, row.limit)
    }

    #[test]
    fn between_columns_the_larger_limit_counts_and_in_a_column_its_own() {
        // D²/ν = 100 s.
        let alone = scene(&[[0.5, 4.0]]);
        for (number, limit) in [
            (1e-4, 0.1),
            (0.0024, 0.1),
            (0.01, 0.2),
            (0.1, 0.8),
            (0.2, 0.8),
            (0.5, 0.8),
            (0.8, 0.5),
            (7.0, 0.8),
        ] {
            for rounding in [1.0 - 1e-14, 1.0, 1.0 + 1e-14] {
                assert_eq!(found(&alone, 100.0 * number * rounding), (4.0, limit), "{number}");
            }
        }
    }

    /// Against the margin of each grain by itself.
    #[test]
    fn the_grain_that_is_worst_off_counts_at_every_dt() {
        let grains = [[0.5, 4.0], [0.5, 3.0], [1.0, 0.5], [2.0, 0.45], [2.5, 0.2], [0.7, 8.0]];
        let all = scene(&grains);
        let limit = |number: f64| {
            let lowest = |row: [f64; 5]| {
                let right = COLUMNS.iter().position(|column| number <= *column).unwrap_or(4);
                if right == 0 { row[0] } else { row[right - 1].max(row[right]) }
            };
            lowest(LIMITS.alone[0].0).max(lowest([0.0, 0.4, 0.0, 0.0, 0.0]))
        };
        for step in 0..200 {
            let dt = 0.01 * 1.06_f64.powi(step);
            let margin = |[radius, density]: &[f64; 2]| density / limit(0.01 * dt / (4.0 * radius * radius));
            let expected = grains.iter().map(margin).fold(f64::INFINITY, f64::min);
            let (value, limit) = found(&all, dt);
            assert!((value / limit - expected).abs() < 1e-12, "dt = {dt}: {value}/{limit}, {expected}");
        }
    }

    /// 27 touching spheres fill π/6 of their box.
    #[test]
    fn a_dense_bed_wants_small_viscous_steps() {
        let bed = |spheres: usize| {
            let mut text = String::from(
                "until = 1.0\n[domain]\ngeometry = \"space\"\nlower = [0.0, 0.0, 0.0]\nupper = [4.0, 4.0, 4.0]\n\
                 cells = [64, 64, 64]\nboundary = { x = \"periodic\", y = \"periodic\", z = \"no-slip\" }\n\
                 [medium]\ndensity = 1.0\nviscosity = 0.01\n",
            );
            for n in 0..spheres {
                let [x, y, z] = [n % 3, n / 3 % 3, n / 9].map(|i| 0.5 + i as f64);
                text +=
                    &format!("[[grains]]\nposition = [{x:?}, {y:?}, {z:?}]\nradius = 0.5\ndensity = 4.0\n");
            }
            CheckedScene::new(SceneSource { file: "bed.toml".into(), text }).expect("a good scene")
        };
        let bound = dense_bed(&bed(27), 2.56).expect("a bed");
        assert_eq!((bound.factor, bound.limit, bound.measure), (2.56, 2.0, Measure::Window));
        assert!(dense_bed(&bed(1), 2.56).is_none(), "one grain is no bed");
    }

    /// Thousands of sizes make few rows: the limits change where the smallest or the largest grain passes a
    /// column.
    #[test]
    fn many_sizes_make_few_rows() {
        let grains: Vec<[f64; 2]> = (0..8).map(|k| [1.0 + 0.05 * f64::from(k), 2.0]).collect();
        let all = scene(&grains);
        let medium = all.scene.medium.as_ref().expect("a fluid");
        assert!(rows(&all, medium, &LIMITS).len() < 10);
    }
}
