//! The solver's own bounds, each below and above its limit.

use crate::newton::try_scene;
use fluid_solver::facts::facts;
use protocol::facts::{Level, Measure, Side, SolverBound};

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
fn the_cfl_number_is_bound_by_time_scheme_and_projections() {
    // With a fixed step: the sphere's own speed times 0.01 over 0.0625.
    for (time, good, bad) in [
        ("scheme = \"ab2\"", 3.1, 3.2),
        ("scheme = \"rk3\", projections = \"once\"", 3.1, 3.2),
        ("scheme = \"rk3\"", 7.4, 7.6),
    ] {
        for (velocity, expected) in [(good, true), (bad, false)] {
            let bound = find(&bounds(&format!("time = {{ dt = 0.01, {time} }}"), velocity), "cfl").unwrap();
            assert_eq!(holds(&bound, 0.01), expected, "{time} {velocity}");
            assert_eq!(bound.level, Level::Refuse);
        }
    }
    // An adaptive step keeps its number, whatever the speed.
    for (projections, expected) in [("each-stage", true), ("once", false)] {
        let fluid = format!("time = {{ cfl = 1.0, scheme = \"rk3\", projections = \"{projections}\" }}");
        let bound = find(&bounds(&fluid, 100.0), "cfl").unwrap();
        assert_eq!(holds(&bound, 1.0), expected, "{projections}");
    }
}

#[test]
fn direct_forcing_wants_small_viscous_steps() {
    // ν dt/Δx² = 0.01 dt/0.0625².
    let direct = bounds("immersed = { method = \"direct\" }", 0.0);
    for (name, good, bad, level) in
        [("direct-forcing", 0.78, 0.79, Level::Refuse), ("direct-forcing-accuracy", 0.39, 0.4, Level::Warn)]
    {
        let bound = find(&direct, name).expect(name);
        assert!(holds(&bound, good) && !holds(&bound, bad) && bound.level == level, "{bound:?}");
        assert!(find(&bounds("", 0.0), name).is_none(), "{name} of the carried forcing");
    }
}

#[test]
fn explicit_viscosity_ends_where_the_time_schemes_do() {
    // Three axes: Σ 1/Δx² = 768, so the limits are at dt = 0.0818 and 0.03255.
    let explicit = bounds("time = { dt = 0.01, viscosity = \"explicit\" }", 0.0);
    for (name, good, bad, level) in [
        ("explicit-viscosity", 0.081, 0.082, Level::Refuse),
        ("explicit-viscosity-ab2", 0.032, 0.033, Level::Warn),
    ] {
        let bound = find(&explicit, name).expect(name);
        assert!(holds(&bound, good) && !holds(&bound, bad) && bound.level == level, "{bound:?}");
        let implicit = bounds("time = { dt = 0.01, viscosity = \"implicit\" }", 0.0);
        assert!(find(&implicit, name).is_none(), "implicit viscosity has no such bound");
    }
}

#[test]
fn the_local_solve_wants_steps_that_the_grain_bears() {
    // 60 n + 5.6 √n = 2 (4 + 1) at n = ν dt/D² = 0.1327.
    let advected = "immersed = { force_transport = \"advected\", viscous_sweeps = 4 }";
    let bound = find(&bounds(advected, 0.1), "local-viscosity").expect("advected");
    assert!(holds(&bound, 13.2) && !holds(&bound, 13.4) && bound.level == Level::Refuse, "{bound:?}");
    for without in ["", "immersed = { force_transport = \"advected\" }"] {
        assert!(find(&bounds(without, 0.1), "local-viscosity").is_none(), "{without}");
    }
}
