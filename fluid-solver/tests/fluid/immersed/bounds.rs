//! The solver's own bounds, each below and above its limit.

use crate::immersed::newton::try_scene;
use fluid_solver::facts::facts;
use protocol::facts::{Level, Measure, Side, SolverBound};
use protocol::scheme::Scheme;

/// A sphere of diameter 1, 16 cells across, ν = 0.01, ρ = 1, with `[fluid]` and the sphere's velocity.
fn bounds(fluid: &str, velocity: f64) -> Vec<SolverBound> {
    let text = format!(
        "until = 100.0
gravity = [0.0, 0.0, -1.0]
[domain]
geometry = \"space\"
lower = [0.0, 0.0, 0.0]
upper = [4.0, 4.0, 4.0]
cells = [64, 64, 64]
boundary = {{ x = \"periodic\", y = \"periodic\", z = \"no-slip\" }}
[medium]
density = 1.0
viscosity = 0.01
[[grains]]
position = [2.0, 2.0, 2.0]
radius = 0.5
density = 4.0
velocity = [{velocity:?}, 0.0, 0.0]
[fluid]
{fluid}
"
    );
    facts(&try_scene(&text).expect("the shared part is right")).expect(fluid).bounds
}

fn find(bounds: &[SolverBound], name: &str) -> Option<SolverBound> {
    bounds.iter().find(|bound| bound.name == name).cloned()
}

/// Does the bound hold in windows of `dt`?
fn holds(bound: &SolverBound, dt: f64) -> bool {
    assert!(bound.side == Side::AtMost && bound.void_from.is_none());
    assert!(!bound.why.is_empty() && !bound.source.is_empty() && !bound.remedy.is_empty(), "{bound:?}");
    let measure = match bound.measure {
        Measure::One => 1.0,
        Measure::Window => dt,
        _ => panic!("{bound:?}"),
    };
    bound.factor * measure <= bound.limit
}

#[test]
fn the_cfl_number_is_bound_by_the_time_scheme() {
    // With a fixed step: the sphere's own speed times 0.01 over 0.0625.
    for (time, good, bad) in [("scheme = \"ab2\"", 3.1, 3.2), ("scheme = \"rk3\"", 7.4, 7.6)] {
        for (velocity, expected) in [(good, true), (bad, false)] {
            let bound = find(&bounds(&format!("time = {{ dt = 0.01, {time} }}"), velocity), "cfl").unwrap();
            assert_eq!(holds(&bound, 0.01), expected, "{time} {velocity}");
            assert_eq!(bound.level, Level::Refuse);
        }
    }
    // An adaptive step keeps its number, whatever the speed.
    for scheme in ["rk3", "ab2"] {
        let bound =
            find(&bounds(&format!("time = {{ cfl = 0.7, scheme = \"{scheme}\" }}"), 100.0), "cfl").unwrap();
        assert!(holds(&bound, 1.0), "{scheme}");
    }
}

#[test]
fn direct_forcing_wants_small_viscous_steps() {
    // ν dt/Δx² = 0.01 dt/0.0625².
    let direct = bounds("method = \"izard-2014\"", 0.0);
    for (name, good, bad, level) in
        [("direct-forcing", 0.78, 0.79, Level::Refuse), ("direct-forcing-accuracy", 0.39, 0.4, Level::Warn)]
    {
        let bound = find(&direct, name).expect(name);
        assert!(holds(&bound, good) && !holds(&bound, bad) && bound.level == level, "{bound:?}");
        assert!(find(&bounds("", 0.0), name).is_none(), "{name} of the carried force");
    }
}

#[test]
fn explicit_viscosity_ends_where_the_time_schemes_do() {
    // Three axes: Σ 1/Δx² = 768, so the limits are at dt = 0.0818 and 0.03255.
    for (scheme, good, bad) in [("rk3", 0.081, 0.082), ("ab2", 0.032, 0.033)] {
        let of = |viscosity: &str| {
            let time = format!("time = {{ dt = 0.01, scheme = \"{scheme}\", viscosity = \"{viscosity}\" }}");
            find(&bounds(&time, 0.0), "explicit-viscosity")
        };
        let bound = of("explicit").expect(scheme);
        assert!(holds(&bound, good) && !holds(&bound, bad) && bound.level == Level::Refuse, "{bound:?}");
        assert!(of("implicit").is_none(), "implicit viscosity has no such bound");
    }
}

/// Lowest density ratio of the sphere in windows of ν dt/D² = `number`, in an order of the exchange.
fn lowest(fluid: &str, scheme: Option<Scheme>, number: f64) -> f64 {
    let ratio = |bound: &&SolverBound| bound.name == "density-ratio" && bound.scheme == scheme;
    let bounds = bounds(fluid, 0.0);
    let bound = bounds.iter().find(ratio).expect("a free sphere");
    assert_eq!((bound.measure, bound.side, bound.level), (Measure::Window, Side::AtLeast, Level::Refuse));
    let row = bound.rows.iter().find(|row| 100.0 * number <= row.up_to).expect("a last row");
    assert_eq!(row.value, 4.0);
    row.limit
}

#[test]
fn light_grains_are_refused_by_the_maps_of_the_method() {
    let once = Some(Scheme::SemiImplicit);
    for (number, limit) in [(0.001, 0.01), (0.024, 0.01), (0.2, 0.01), (0.5, 0.3), (0.8, 0.3), (5.0, 0.3)] {
        assert_eq!(lowest("", once, number), limit, "{number}");
    }
    let repeated = Some(Scheme::Iterated);
    assert_eq!([0.001, 0.01, 0.8].map(|number| lowest("", repeated, number)), [0.01; 3]);
    // Where most windows are not repeated the limit is that of such windows.
    let selective = "[coupling]\niterations = { repeat_above = 1e-3 }";
    assert_eq!(lowest(selective, repeated, 0.8), 0.3);
    assert_eq!([0.001, 0.8].map(|number| lowest("method = \"izard-2014\"", None, number)), [2.0, 2.0]);
    let wider = bounds("", 0.0).iter().find(|bound| bound.scheme == once).and_then(|bound| bound.wider_in);
    assert_eq!(wider, repeated);
    let range = find(&bounds("", 0.0), "density-range").expect("a free sphere");
    assert!(holds(&range, 79.0) && !holds(&range, 81.0));
}

#[test]
fn a_grain_at_rest_loses_its_buoyancy_with_the_printed_loads() {
    let bound = find(&bounds("method = \"izard-2014\"", 0.0), "resting-weight").expect("a wall");
    assert!((bound.factor - 4.0 / 3.0).abs() < 1e-15 && bound.level == Level::Warn);
    assert!(find(&bounds("", 0.0), "resting-weight").is_none());
}
