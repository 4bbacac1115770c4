//! The `[fluid]` section: defaults, and errors that name key, value and remedy.

use crate::immersed::newton::try_scene;
use fluid_solver::config::{FluidSection, SchemeKey};
use fluid_solver::facts::facts;
use protocol::scheme::Scheme;

fn text(density: f64, cells: &str, fluid: &str) -> String {
    format!(
        "until = 1.0
gravity = [0.0, 0.0, -1.0]
[domain]
geometry = \"space\"
lower = [0.0, 0.0, 0.0]
upper = [4.0, 4.0, 4.0]
cells = {cells}
boundary = {{ x = \"periodic\", y = \"periodic\", z = \"no-slip\" }}
[medium]
density = 1.0
viscosity = 0.01
[[grains]]
position = [2.0, 2.0, 2.0]
radius = 0.5
density = {density}
[fluid]
{fluid}
"
    )
}

/// Key and message of the error that a `[fluid]` section must give.
fn refusal(density: f64, fluid: &str) -> (String, String) {
    let scene = try_scene(&text(density, "[32, 32, 32]", fluid)).expect("the shared part is right");
    let error = facts(&scene).expect_err(fluid);
    assert!(error.line > 0 && !error.remedy.is_empty(), "{error}");
    (error.key.clone(), format!("{} {}", error.message, error.remedy))
}

#[test]
fn defaults_are_those_of_the_documentation() {
    let scene = try_scene(&text(2.0, "[32, 32, 32]", "command = [\"other\", \"solver\"]")).expect("right");
    let facts = facts(&scene).expect("right");
    assert_eq!(facts.schemes, [Scheme::SemiImplicit, Scheme::Iterated]);
    assert_eq!((facts.cells, facts.adaptive), (32 * 32 * 32, true));
    assert_eq!(facts.resolved["method"].as_str(), Some("calibrated"));
    assert!(facts.for_dem.is_empty());
    assert!(facts.dt > 0.0 && facts.dt < 0.2, "{}", facts.dt);
}

#[test]
fn the_seed_is_one_key_away() {
    let scene = try_scene(&text(2.0, "[32, 32, 32]", "method = \"izard-2014\"")).expect("right");
    let facts = facts(&scene).expect("right");
    assert_eq!(facts.schemes, [Scheme::Explicit]);
    assert_eq!(facts.resolved["method"].as_str(), Some("izard-2014"));
}

#[test]
fn errors_name_key_and_value() {
    for (density, fluid, key, part) in [
        (2.0, "time = { dt = -0.1 }", "fluid.time.dt", "-0.1"),
        (2.0, "time = { cfl = 9.0 }", "fluid.time.cfl", "9"),
        (2.0, "time = { dt = 1.0, viscosity = \"explicit\" }", "fluid.time.dt", "explicit"),
        (1.0, "method = \"izard-2014\"", "fluid.method", "grain 0"),
        (2.0, "method = \"fictitious-domain\"", "fluid.method", "plane"),
        (2.0, "method = \"sharp\"", "fluid.method", "calibrated"),
        (2.0, "immersed = { method = \"direct\" }", "fluid.immersed.method", "izard-2014"),
        (2.0, "immersed = { method = \"carried\" }", "fluid.immersed.method", "calibrated"),
        (2.0, "immersed = { width = 0.5 }", "fluid.immersed.width", "fluid.method"),
        (
            2.0,
            "immersed = { force_transport = \"advected\" }",
            "fluid.immersed.force_transport",
            "fluid.method",
        ),
        (2.0, "immersed = {}", "fluid.immersed", "fluid.method"),
        (2.0, "loads = { form = \"izard-2014\" }", "fluid.loads.form", "fluid.method"),
        (2.0, "loads = { form = \"uhlmann-2005\" }", "fluid.loads.form", "fluid.method"),
        (2.0, "loads = { virtual_mass = 0.5 }", "fluid.loads.virtual_mass", "fluid.method"),
        (2.0, "division = \"blocks\"", "fluid.division", "fluid.launcher"),
        (2.0, "time = { projections = \"once\" }", "fluid.time.projections", "each stage"),
        (2.0, "time = { dt_levels_per_octave = 4 }", "fluid.time.dt_levels_per_octave", "four"),
        (2.0, "time = { dtt = 0.1 }", "fluid.time.dtt", "unknown field"),
        (2.0, "sort = 3", "fluid.sort", "unknown field"),
    ] {
        let (found, message) = refusal(density, fluid);
        assert_eq!(found, key, "{fluid}: {message}");
        assert!(message.contains(part), "{fluid}: {message}");
    }
}

#[test]
fn more_memory_than_there_is_is_refused() {
    let scene = try_scene(&text(2.0, "[2000, 2000, 2000]", "")).expect("the shared part is right");
    let error = facts(&scene).expect_err("terabytes");
    assert_eq!(error.key, "domain.cells");
    assert!(error.message.contains("GiB"), "{}", error.message);
}

/// By a launcher a machine needs the memory of the ranks that are on it; what cannot be read is counted
/// whole.
#[test]
fn memory_follows_the_launcher() {
    let told = |words: &str| {
        let scene = try_scene(&text(2.0, "[160, 160, 160]", words)).expect("the shared part is right");
        let facts = facts(&scene).expect(words);
        let notices = facts.notices.iter().filter(|notice| notice.contains("memory"));
        (facts.memory as f64, notices.cloned().collect::<Vec<_>>())
    };
    let (whole, said) = told("");
    assert!(said.is_empty(), "{said:?}");
    let (here, said) = told("launcher = [\"mpirun\", \"-np\", \"4\"]");
    assert!(here > whole && here < 1.5 * whole && said.is_empty(), "{here} of {whole}, {said:?}");
    let (each, said) = told("launcher = [\"mpirun\", \"-np\", \"4\", \"--host\", \"a,b,c,d\"]");
    assert!((4.0 * each / here - 1.0).abs() < 1e-12 && said[0].contains("1 of 4 ranks"), "{each}, {said:?}");
    let (unread, said) = told("launcher = [\"mpirun\"]");
    assert!(unread == whole && said[0].contains("-np"), "{said:?}");
}

#[test]
fn a_launcher_is_refused_what_ranks_cannot_do() {
    let (key, what) = refusal(2.0, "launcher = [\"mpirun\", \"-np\", \"9\"]");
    assert!(key == "fluid.launcher" && what.contains("1 to 8"), "{key}: {what}");
    // Two spheres that move, four planes for each rank.
    let second = "launcher = [\"mpirun\", \"-np\", \"8\"]\n[[grains]]\nposition = [1.0, 1.0, 1.0]\nradius = \
        0.5\ndensity = 2.0";
    let (key, what) = refusal(2.0, second);
    assert!(key == "domain.cells" && what.contains("4 planes"), "{key}: {what}");
}

/// Windows of 2 Δx²/ν are the longest for one stage: docs/decisions/time-scheme.md.
#[test]
fn the_time_scheme_follows_method_and_fixed_step() {
    let scheme = |fluid: &str| {
        let scene = try_scene(&text(2.0, "[32, 32, 32]", fluid)).expect("right");
        FluidSection::read(&scene).expect(fluid).scheme()
    };
    assert_eq!(scheme(""), SchemeKey::Ab2);
    assert_eq!(scheme("method = \"izard-2014\""), SchemeKey::Rk3);
    // Δx = 1/8, ν = 0.01.
    assert_eq!(scheme("time = { dt = 3.1 }"), SchemeKey::Ab2);
    assert_eq!(scheme("time = { dt = 3.2 }"), SchemeKey::Rk3);
    assert_eq!(scheme("time = { dt = 3.2, scheme = \"ab2\" }"), SchemeKey::Ab2);
    assert_eq!(scheme("method = \"izard-2014\"\ntime = { scheme = \"ab2\" }"), SchemeKey::Ab2);
}

/// Without a fluid there may be no cells either.
#[test]
fn a_dry_scene_is_refused_with_a_fixed_step_as_without_one() {
    for fluid in ["", "time = { dt = 0.01 }"] {
        let dry = text(2.0, "[]", fluid)
            .replace("cells = []\n", "")
            .replace("[medium]\ndensity = 1.0\nviscosity = 0.01\n", "");
        let scene = try_scene(&dry).expect("a dry scene");
        assert!(scene.scene.medium.is_none() && scene.scene.domain.cells.is_empty());
        assert_eq!(FluidSection::read(&scene).expect_err(fluid).key, "medium");
    }
}
