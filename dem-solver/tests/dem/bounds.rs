//! The solver's own bounds, each below and above its limit.

use bedload_scene::{CheckedScene, SceneSource};
use dem_solver::config::Config;
use protocol::facts::{Level, Measure, Side, SolverBound};

/// Grains in a row in a box of a fluid of density 1, by density, with `[dem]`.
fn bounds(densities: &[f64], dem: &str) -> Vec<SolverBound> {
    let grain = |(index, density): (usize, &f64)| {
        let z = 0.5 + 0.1 * index as f64;
        format!("[[grains]]\nposition = [2.0, 2.0, {z:?}]\nradius = 0.04\ndensity = {density:?}\n")
    };
    let grains: String = densities.iter().enumerate().map(grain).collect();
    let text = format!(
        "until = 1.0\ngravity = [0.0, 0.0, -1.0]\n[domain]\ngeometry = \"space\"\nlower = [0.0, 0.0, 0.0]\n\
         upper = [4.0, 4.0, 4.0]\ncells = [400, 400, 400]\nboundary = {{ x = \"periodic\", y = \"periodic\", \
         z = \"no-slip\" }}\n[medium]\ndensity = 1.0\nviscosity = 0.01\n{grains}[dem]\n{dem}\n"
    );
    let scene = CheckedScene::new(SceneSource { file: "s.toml".into(), text }).expect("a good scene");
    Config::new(&scene).expect(dem).facts.bounds
}

fn find(bounds: &[SolverBound], name: &str) -> Option<SolverBound> {
    let bound = bounds.iter().find(|bound| bound.name == name).cloned()?;
    assert!(!bound.why.is_empty() && !bound.source.is_empty() && !bound.remedy.is_empty(), "{bound:?}");
    assert_eq!(bound.level, Level::Refuse);
    Some(bound)
}

fn law(keys: &str) -> String {
    format!("contact = {{ law = \"linear-spring-dashpot\", restitution = 0.3, contact_time = 1e-3, {keys} }}")
}

#[test]
fn dashpots_in_a_packing_want_short_sub_steps() {
    // γ_t/m* = −2 ln(e_n)/t_c, and γ_t dt/m* at most 0.15.
    let rate = 2000.0 * -(0.3_f64.ln());
    let bound = find(&bounds(&[4.0; 8], &law("friction = 0.5")), "contact-dashpot").expect("eight grains");
    assert!((bound.factor / rate - 1.0).abs() < 1e-12 && bound.measure == Measure::Substep, "{bound:?}");
    assert_eq!((bound.side, bound.limit), (Side::AtMost, 0.15));
    assert!(bound.remedy.contains("17 sub-steps"), "{}", bound.remedy);
    for (grains, keys) in
        [(7, "friction = 0.5"), (8, "friction = 0.0"), (8, "friction = 0.5, damping_ratio = 0.0")]
    {
        let bounds = bounds(&vec![4.0; grains], &law(keys));
        assert!(find(&bounds, "contact-dashpot").is_none(), "{grains} {keys}");
    }
}

#[test]
fn light_grains_in_contact_want_a_tangential_dashpot() {
    // Springs without a dashpot, in windows below ten contact times.
    let undamped = law("friction = 0.5, damping_ratio = 0.09");
    for (density, expected) in [(2.51, true), (2.49, false)] {
        let bound = find(&bounds(&[4.0, density], &undamped), "tangential-dashpot").expect("two grains");
        assert_eq!((bound.measure, bound.side), (Measure::One, Side::AtLeast));
        assert_eq!(bound.factor >= bound.limit, expected, "{bound:?}");
        assert_eq!(bound.void_from, Some((Measure::WindowOverContact, 10.0)));
    }
    for (densities, keys) in [
        (vec![2.0], "friction = 0.5, damping_ratio = 0.09"),
        (vec![2.0; 2], "friction = 0.5, damping_ratio = 0.1"),
        (vec![2.0; 2], "friction = 0.0, damping_ratio = 0.0"),
    ] {
        assert!(find(&bounds(&densities, &law(keys)), "tangential-dashpot").is_none(), "{keys}");
    }
}
