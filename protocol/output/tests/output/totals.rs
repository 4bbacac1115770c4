//! Columns of `observe.totals`: sums over grains by hand, numbers of the solvers where they belong.

use std::f64::consts::PI;

use bedload_output::totals::{dem_values, fluid_values};
use bedload_output::{Columns, Sample, Sides};
use bedload_scene::CheckedScene;
use protocol::message::Kinematics;

use crate::stage::{Watch, scene, window};

/// A layer of four discs that touch, on the floor of a channel with a lid.
fn bed(medium: &str, more: &str) -> CheckedScene {
    let disc = |i: usize| {
        let motion = if i == 3 { "fixed" } else { "free" };
        format!(
            "[[grains]]\nposition = [{}.5, 0.0, 0.5]\nradius = 0.5\ndensity = 2.0\nmotion = \"{motion}\"\n",
            i
        )
    };
    let discs: String = (0..4).map(disc).collect();
    scene(&format!(
        "until = 1.0\ngravity = [0.0, 0.0, -10.0]\n\
         [domain]\ngeometry = \"plane\"\nlower = [0.0, 0.0]\nupper = [4.0, 3.0]\ncells = [32, 24]\n\
         boundary = {{ x = \"periodic\", z = \"no-slip\" }}\n\
         [medium]\ndensity = 1.0\nviscosity = 0.5\n{medium}\n{discs}\
         [observe]\ngrains = []\n\
         totals = {{ columns = [\"grain-flux\", \"fluid-flux\", \"bed-height\", \"moving-grains\", \"shields\", \
         \"coordination-number\", \"wall-force\", \"wall-stress\", \"velocity-flux\"], speed = 0.1 }}\n{more}"
    ))
}

/// The grains at rest but two, one of which is barely slow enough to count as resting.
fn motion(scene: &CheckedScene) -> Vec<Kinematics> {
    let mut motion: Vec<Kinematics> =
        scene.grains.iter().map(|grain| Kinematics::at_rest(grain.position)).collect();
    motion[0].velocity = [0.2, 0.0, 0.0];
    motion[1].velocity = [0.0, 0.0, 0.0999];
    motion
}

/// What the solvers give: mean velocity; forces on floor and lid; contacts; forces of contacts, and of films.
const GIVEN: [f64; 14] = [0.7, 0.01, 0.02, 0.03, 0.04, 2.5, 0.05, 0.06, 0.07, 0.08, 0.1, 0.2, 0.3, 0.4];

const NAMES: [&str; 19] = [
    "grain_flux_x",
    "fluid_flux_x",
    "bed_height",
    "moving_grains",
    "shields",
    "coordination_number",
    "wall_force_z_lower_x",
    "wall_force_z_lower_z",
    "wall_force_z_upper_x",
    "wall_force_z_upper_z",
    "wall_contact_force_z_lower_x",
    "wall_contact_force_z_lower_z",
    "wall_contact_force_z_upper_x",
    "wall_contact_force_z_upper_z",
    "wall_stress_z_lower_x",
    "wall_stress_z_lower_z",
    "wall_stress_z_upper_x",
    "wall_stress_z_upper_z",
    "velocity_flux_x",
];

/// Where the exact solid fraction of the layer, 2 (R² − (z − R)²)^½, falls to 0.3.
fn surface() -> f64 {
    0.5 + (0.25_f64 - 0.15 * 0.15).sqrt()
}

#[test]
fn totals_are_those_of_a_layer_of_discs() {
    let metric = "[[metrics]]\nname = \"flux\"\nkind = \"mean\"\ncolumn = \"grain_flux_x\"\n";
    let scene = bed("body_force = [0.2, 0.0, 0.0]\npressure_gradient = [-0.4, 0.0, 0.0]", metric);
    assert_eq!((fluid_values(&scene).len(), dem_values(&scene).len()), (5, 9));
    let mut watch = Watch::new(&scene, 0.1);
    let row = watch.feed_all(&[], &window(0, 0.1).header(), &motion(&scene), &GIVEN);
    watch.feed_all(&[], &window(1, 0.1).header(), &motion(&scene), &GIVEN);
    let value = |name: &str| row[watch.columns.find(name).unwrap_or_else(|| panic!("{name}")).0];
    let flux = 0.2 * PI * 0.25 / 4.0;
    assert!((value("grain_flux_x") - flux).abs() < 1e-15);
    assert!((value("fluid_flux_x") - (0.7 * 3.0 - flux)).abs() < 1e-14);
    assert_eq!((value("moving_grains"), value("coordination_number")), (1.0, 2.5));
    let height = value("bed_height");
    assert!((height - surface()).abs() < 0.01, "{height} for {}", surface());
    // the drive on what is above, and what the lid takes, over (ρ_p − ρ) g D
    let stress = (0.2 + 0.4) * (3.0 - height) - (0.03 + 0.07) / 4.0;
    assert!((value("shields") - stress / 10.0).abs() < 1e-15, "{} for {stress}", value("shields"));
    for (name, given) in NAMES[6..].iter().zip(GIVEN[1..5].iter().chain(&GIVEN[6..10])) {
        assert_eq!(value(name), *given, "{name}");
    }
    for (k, name) in NAMES[14..18].iter().enumerate() {
        let stress = (GIVEN[1 + k] + GIVEN[6 + k] + GIVEN[10 + k]) / 4.0;
        assert!((value(name) - stress).abs() < 1e-15, "{name}");
    }
    // The centres of all four lie in the first bin, of height R, and one of them moves at 0.2.
    assert!((value("velocity_flux_x") - 0.5 * 0.2 / 4.0).abs() < 1e-14, "{}", value("velocity_flux_x"));
    let first = watch.columns.names().iter().position(|name| name == NAMES[0]).expect("the first");
    assert_eq!(watch.columns.names()[first..], NAMES);
    assert!((watch.value("flux") - flux).abs() < 1e-15);
    // what has left through an open face counts no more
    let mut left = motion(&scene);
    left[0].position[2] = 3.01;
    let row = watch.feed_all(&[], &window(2, 0.1).header(), &left, &GIVEN);
    let value = |name: &str| row[watch.columns.find(name).unwrap_or_else(|| panic!("{name}")).0];
    assert_eq!(["grain_flux_x", "velocity_flux_x", "moving_grains"].map(value), [0.0; 3]);
}

#[test]
fn a_flow_rate_that_is_held_drives_too_and_stands_before_them() {
    let scene = bed("flow_rate = { axis = \"x\", mean_velocity = 0.7 }", "");
    let mut watch = Watch::new(&scene, 0.1);
    let given: Vec<f64> = [-0.5].into_iter().chain(GIVEN).collect();
    let row = watch.feed_all(&[], &window(0, 0.1).header(), &motion(&scene), &given);
    let value = |name: &str| row[watch.columns.find(name).unwrap_or_else(|| panic!("{name}")).0];
    assert_eq!((value("pressure_gradient_x"), value("wall_force_z_upper_z")), (-0.5, 0.04));
    let stress = 0.5 * (3.0 - value("bed_height")) - (0.03 + 0.07) / 4.0;
    assert!((value("shields") - stress / 10.0).abs() < 1e-15);
}

/// A solver of others that gives no numbers leaves NaN; a fluid alone has no contacts.
#[test]
fn what_is_not_there_is_no_number() {
    let scene = bed("", "");
    let (motion, window) = (motion(&scene), window(0, 0.1));
    let header = window.header();
    let sample =
        |extras| Sample { window: &window, loads: &[], header: &header, kinematics: &motion, extras };
    let mut columns = Columns::new(&scene, Sides::coupled());
    let row = columns.fill(&sample(&[])).to_vec();
    let value = |name: &str| row[columns.find(name).expect("a column").0];
    assert!(["fluid_flux_x", "shields", "coordination_number"].iter().all(|name| value(name).is_nan()));
    assert!(value("bed_height") > 0.9 && value("grain_flux_x") > 0.0);
    let mut alone = Columns::new(&scene, Sides::fluid_alone(true));
    let row = alone.fill(&sample(&GIVEN[..5])).to_vec();
    let stress = -0.03 / 4.0 / 10.0;
    assert_eq!(alone.find("coordination_number"), None);
    assert!((row[alone.find("shields").expect("shields").0] - f64::abs(stress)).abs() < 1e-15);
}
