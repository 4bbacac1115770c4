//! Speeds that follow from a scene.

use bedload_scene::speeds::{Speeds, speed_under};
use bedload_scene::{CheckedScene, SceneSource, Shape};

fn scene(more: &str) -> CheckedScene {
    let text = format!(
        "until = 10.0\ngravity = [0.0, 0.0, -2.0]\n[domain]\ngeometry = \"space\"\nlower = [0, 0, 0]\n\
         upper = [4, 4, 8]\ncells = [8, 8, 16]\n{more}"
    );
    CheckedScene::new(SceneSource { file: "s.toml".into(), text }).expect("a scene")
}

const CLOSED: &str = "boundary = { x = \"no-slip\", y = \"no-slip\", z = \"no-slip\" }\n";
const GRAIN: &str = "[[grains]]\nposition = [2, 2, 4.5]\nradius = 0.5\ndensity = 3.0\n";

#[test]
fn drag_and_speed_are_those_of_stokes_and_of_schiller_and_naumann() {
    // Stokes: F/ρ = 3π ν D U.
    let slow = speed_under(3.0 * std::f64::consts::PI * 1e-6, Shape::Sphere, 1.0, 1.0);
    assert!((slow / 1e-6 - 1.0).abs() < 1e-4, "{slow}");
    // Ar = 800: the correlation has Re = 20.32.
    let nu = (3.0_f64 / 800.0).sqrt();
    let force = 3.0 * std::f64::consts::PI / 6.0;
    let re = speed_under(force, Shape::Sphere, 1.0, nu) / nu;
    assert!((re - 20.32).abs() < 0.01, "{re}");
    assert_eq!(speed_under(0.0, Shape::Disc, 1.0, 1.0), 0.0);
}

#[test]
fn a_dry_grain_falls_as_far_as_there_is_room_and_time() {
    // 4 m down to the floor less the radius: v² = 2 · 2 · 4.
    let falls = Speeds::of(&scene(&format!("{CLOSED}{GRAIN}")));
    assert!((falls.grain - 4.0).abs() < 1e-12, "{falls:?}");
    // Without a floor it falls to the end: 2 · 10.
    let open = CLOSED.replace("z = \"no-slip\"", "z = \"free-slip\"");
    let falls = Speeds::of(&scene(&format!("{open}{GRAIN}")));
    assert!((falls.grain - 20.0).abs() < 1e-12, "{falls:?}");
    let thrown = GRAIN.replace("density", "velocity = [30.0, 0, 0]\ndensity");
    assert_eq!(Speeds::of(&scene(&format!("{open}{thrown}"))).grain, 30.0);
    // A held grain 3 m below, surface to surface 2 m: v² = 2 · 2 · 2.
    let onto = format!("{open}{GRAIN}{}motion = \"fixed\"\n", GRAIN.replace("4.5", "1.5"));
    assert!((Speeds::of(&scene(&onto)).grain - 8.0_f64.sqrt()).abs() < 1e-12);
}

/// The surface of a disc that spins moves the fluid, not the disc against others; that of a rectangle does
/// both. A wall that slides along itself meets nothing.
#[test]
fn spin_and_sliding_walls_count_where_they_act() {
    let speeds = |grain: &str, lid: [f64; 3]| {
        let text = format!(
            "until = 1.0\n[domain]\ngeometry = \"plane\"\nlower = [0, 0]\nupper = [4, 8]\ncells = [8, 16]\n\
             [domain.boundary]\nx = \"periodic\"\nz_lower = \"no-slip\"\nz_upper = {{ type = \"no-slip\", velocity = \
             {lid:?} }}\n[medium]\ndensity = 1.0\nviscosity = 1.0\n[[grains]]\nposition = [2, 0, 4]\n{grain}\n\
             density = 2.0\nspin = [0.0, 6.0, 0.0]\nmotion = \"prescribed\"\n"
        );
        Speeds::of(&CheckedScene::new(SceneSource { file: "s.toml".into(), text }).expect("a scene"))
    };
    let disc = speeds("radius = 0.5", [0.0; 3]);
    assert_eq!((disc.undriven, disc.named_approach), (3.0, 0.0), "{disc:?}");
    let rectangle = speeds("shape = \"rectangle\"\nsides = [1.6, 1.2]", [0.0; 3]);
    assert!((rectangle.undriven - 6.0).abs() < 1e-12 && (rectangle.named_approach - 6.0).abs() < 1e-12);
    let slides = speeds("radius = 0.5", [5.0, 0.0, 0.0]);
    assert_eq!((slides.named_approach, slides.approach), (0.0, 5.0), "{slides:?}");
}

/// Gravity of one length that turns: the speed along each axis is that of its own largest component, in both
/// directions.
#[test]
fn turned_gravity_has_components_of_its_own() {
    let turns = |rows: &str| {
        let mut scene = scene(&format!("{CLOSED}{GRAIN}"));
        scene.scene.gravity = toml::from_str::<std::collections::BTreeMap<String, _>>(&format!("g = {rows}"))
            .expect("a table")
            .remove("g")
            .expect("gravity");
        Speeds::of(&scene).grain
    };
    // 4 m down, and 1.5 m along x to the wall: v² = 4 · 4 + 2 · 1.6 · 1.5.
    let speed = turns("[[0.0, [0.0, 0.0, -2.0]], [1.0, [1.6, 0.0, -1.2]]]");
    assert!((speed - 20.8_f64.sqrt()).abs() < 1e-12, "{speed}");
    // Up, too, where there are 3 m.
    let speed = turns("[[0.0, [0.0, 0.0, -2.0]], [1.0, [0.0, 0.0, 4.0]]]");
    assert!((speed - 24.0_f64.sqrt()).abs() < 1e-12, "{speed}");
}

#[test]
fn a_driven_flow_is_as_fast_as_walls_time_and_held_grains_let_it_be() {
    let open = "boundary = { x = \"periodic\", y = \"periodic\", z = \"periodic\" }\n";
    let channel = open.replace("z = \"periodic\"", "z = \"no-slip\"");
    let medium = "[medium]\ndensity = 1.0\nviscosity = 1.0\nbody_force = [0.5, 0, 0]\n";
    // Laminar: 0.5 · 8²/(8 · 1).
    let speed = |text: &str| Speeds::of(&scene(text)).flow;
    assert!((speed(&format!("{channel}{medium}")) - 4.0).abs() < 1e-12);
    // Free along z too, gravity drives it as well: |(0.5, 0, −2)| · 10.
    assert!((speed(&format!("{open}{medium}")) - 10.0 * 4.25_f64.sqrt()).abs() < 1e-9);
    let held = format!("{channel}{medium}{GRAIN}motion = \"fixed\"\n");
    let alone = speed_under(0.5 * 128.0, Shape::Sphere, 1.0, 1.0);
    assert!(speed(&held) <= alone && speed(&held) > 0.0);
}

#[test]
fn a_grain_falls_as_far_as_to_the_next_held_one_in_its_way() {
    let at = |x: f64, y: f64, z: f64, motion: &str| {
        format!(
            "[[grains]]\nposition = [{x}, {y}, {z}]\nradius = 0.3\ndensity = 3.0\nmotion = \"{motion}\"\n"
        )
    };
    let held: Vec<[f64; 3]> = (0..12)
        .map(|n| [0.3 + 0.3 * f64::from(n), 1.9 - 0.1 * f64::from(n % 3), 1.0 + 0.2 * f64::from(n % 2)])
        .collect();
    let text: String = held.iter().map(|[x, y, z]| at(*x, *y, *z, "fixed")).collect();
    for free in [
        [0.4, 1.6, 6.0],
        [1.15, 1.6, 6.0],
        [1.9, 2.3, 6.0],
        [2.65, 1.3, 6.0],
        [3.4, 1.0, 6.0],
        [1.9, 3.0, 6.0],
    ] {
        let scene = scene(&format!("{CLOSED}{text}{}", at(free[0], free[1], free[2], "free")));
        let aside = |held: &&[f64; 3]| (held[0] - free[0]).hypot(held[1] - free[1]) < 0.6;
        let ways = held.iter().filter(aside).map(|held| free[2] - held[2] - 0.6);
        // To the floor at most.
        let way = ways.fold(free[2] - 0.3, f64::min);
        let falls = Speeds::of(&scene).grain;
        assert!((falls - (2.0 * 2.0 * way).sqrt()).abs() < 1e-12, "{free:?}: {falls}");
    }
}
