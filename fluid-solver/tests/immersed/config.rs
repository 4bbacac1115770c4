//! The `[fluid]` section: defaults, and errors that name key, value and remedy.

use crate::newton::try_scene;
use fluid_solver::facts::facts;
use protocol::facts::{Forcing, LoadsForm};

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
    (error.key.clone(), error.message)
}

#[test]
fn defaults_are_those_of_the_documentation() {
    let scene = try_scene(&text(2.0, "[32, 32, 32]", "command = [\"other\", \"solver\"]")).expect("right");
    let facts = facts(&scene).expect("right");
    assert_eq!((facts.loads, facts.forcing), (LoadsForm::YuShaoFixedPoint, Forcing::Carried));
    assert_eq!((facts.virtual_mass, facts.cells, facts.adaptive), (0.5, 32 * 32 * 32, true));
    assert_eq!(facts.resolved["immersed"]["width"].as_float(), Some(0.5));
    assert_eq!(facts.resolved["immersed"]["mask"].as_str(), Some("parameter-free"));
    assert!(facts.dt > 0.0 && facts.dt < 0.2, "{}", facts.dt);
}

#[test]
fn the_seed_is_one_key_away() {
    let seed = "immersed = { method = \"direct\" }";
    let scene = try_scene(&text(2.0, "[32, 32, 32]", seed)).expect("right");
    let facts = facts(&scene).expect("right");
    assert_eq!((facts.loads, facts.virtual_mass), (LoadsForm::Izard2014, 0.0));
    assert_eq!(facts.resolved["immersed"]["mask"].as_str(), Some("izard-2014"));
    assert_eq!(facts.resolved["immersed"]["width"].as_float(), Some(1.0));
}

#[test]
fn errors_name_key_and_value() {
    for (density, fluid, key, part) in [
        (2.0, "time = { dt = -0.1 }", "fluid.time.dt", "-0.1"),
        (2.0, "time = { cfl = 9.0 }", "fluid.time.cfl", "9"),
        (2.0, "time = { dt = 1.0, viscosity = \"explicit\" }", "fluid.time.dt", "explicit"),
        (2.0, "immersed = { width = 0.0 }", "fluid.immersed.width", "0"),
        (2.0, "loads = { virtual_mass = -1.0 }", "fluid.loads.virtual_mass", "-1"),
        (1.0, "loads = { form = \"izard-2014\" }", "fluid.loads.form", "grain 0"),
        (
            2.0,
            "immersed = { method = \"direct\" }\nloads = { form = \"yu-shao-fixed-point\" }",
            "fluid.loads.form",
            "direct",
        ),
        (
            2.0,
            "loads = { form = \"uhlmann-2005\", displaced_mass = \"as-mass\" }",
            "fluid.loads.displaced_mass",
            "uhlmann-2005",
        ),
        (
            2.0,
            "immersed = { force_transport = \"advected\" }\nloads = { form = \"kempe-froehlich-2012\" }",
            "fluid.immersed.force_transport",
            "kempe-froehlich-2012",
        ),
        (2.0, "loads = { form = \"F5b\" }", "fluid.loads.form", "yu-shao-fixed-point"),
        (2.0, "time = { dt_levels_per_octave = 3 }", "fluid.time.dt_levels_per_octave", "3"),
        (2.0, "immersed = { mask = \"seed\" }", "fluid.immersed.mask", "izard-2014"),
        (2.0, "time = { rungs = 4 }", "fluid.time.rungs", "dt_levels_per_octave"),
        (2.0, "immersed = { carry = \"with-grains\" }", "fluid.immersed.carry", "force_transport"),
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

/// By a launcher a machine needs the memory of the ranks that are on it; what cannot be read is counted whole.
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
    let (key, _) = refusal(2.0, "launcher = [\"mpirun\", \"-np\", \"2\"]\ndivision = \"whole\"");
    assert_eq!(key, "fluid.division");
    let (key, _) = refusal(
        2.0,
        "launcher = [\"mpirun\", \"-np\", \"8\"]\nimmersed = { force_transport = \"advected\", viscous_sweeps = 6 }",
    );
    assert_eq!(key, "fluid.immersed.viscous_sweeps");
}
