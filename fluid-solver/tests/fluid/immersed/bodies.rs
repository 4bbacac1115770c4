//! Bodies of the plane that are not round, with both methods.

use crate::immersed::newton::{Run, try_scene};

const METHODS: [&str; 2] = ["", "method = \"fictitious-domain\""];

/// A neutral body in the middle of a shear flow of rate 1 without inertia, walls 10 long half-axes apart.
fn shear(body: &str, degrees: f64, method: &str) -> Run {
    let half = 0.5 * degrees.to_radians();
    let mut run = Run::new(&format!(
        "until = 1.0
        [domain]
        geometry = \"plane\"
        lower = [0.0, 0.0]
        upper = [8.0, 8.0]
        cells = [128, 128]
        boundary.x = \"periodic\"
        boundary.z_lower = {{ type = \"no-slip\", velocity = [-4.0, 0.0, 0.0] }}
        boundary.z_upper = {{ type = \"no-slip\", velocity = [4.0, 0.0, 0.0] }}
        [medium]
        density = 1.0
        viscosity = 20.0
        initial = {{ type = \"shear\", direction = \"x\", gradient = \"z\", rate = 1.0, origin = 4.0 }}
        [[grains]]
        {body}
        position = [4.0, 0.0, 4.0]
        orientation = [{}, 0.0, {}, 0.0]
        density = 1.0
        [fluid]
        time = {{ scheme = \"ab2\", dt = 0.0005, convection = false, viscosity = \"implicit\" }}
        {method}
        ",
        half.cos(),
        half.sin(),
    ));
    run.windows(600);
    run
}

/// Jeffery's orbit of an elliptic cylinder: ω = γ (a² sin² + b² cos²)/(a² + b²) by the angle between long
/// axis and flow (Jeffery 1922; Ding & Aidun 2000, J. Fluid Mech. 423, 317).
#[test]
fn an_ellipse_in_shear_turns_as_in_jefferys_orbit() {
    let ellipse = "shape = \"ellipse\"\nsemi_axes = [0.8, 0.4]";
    for method in METHODS {
        for degrees in [0.0_f64, 30.0, 90.0] {
            let run = shear(ellipse, degrees, method);
            let motion = &run.newton.motions[0];
            let angle = 2.0 * motion.orientation[2].atan2(motion.orientation[0]);
            let exact = (0.64 * angle.sin().powi(2) + 0.16 * angle.cos().powi(2)) / 0.8;
            println!("{method:?} {degrees}: spin {:.4}, Jeffery {exact:.4}", motion.spin[1]);
            assert!(
                (motion.spin[1] - exact).abs() < 0.03,
                "{method} {degrees}: {} for {exact}",
                motion.spin[1]
            );
        }
    }
}

/// A body is where its sides and its angle together say.
#[test]
fn sides_and_angle_say_together_where_a_body_is() {
    for method in METHODS {
        let spin = |sides: &str, degrees| {
            shear(&format!("shape = \"rectangle\"\nsides = {sides}"), degrees, method).newton.motions[0].spin
                [1]
        };
        let (long, tall) = (spin("[1.6, 0.8]", 0.0), spin("[0.8, 1.6]", 90.0));
        assert!((long / tall - 1.0).abs() < 1e-9, "{method}: {long} and {tall}");
        let across = spin("[0.8, 1.6]", 0.0);
        assert!(across > 2.0 * long, "{method}: {across} across, {long} along");
    }
}

/// A polygon of many corners is a disc.
#[test]
fn a_polygon_of_many_corners_turns_like_a_disc() {
    let corners: Vec<String> = (0..48)
        .map(|k| std::f64::consts::TAU * f64::from(k) / 48.0)
        .map(|angle| format!("[{}, {}]", 0.6 * angle.cos(), 0.6 * angle.sin()))
        .collect();
    let polygon = format!("shape = \"polygon\"\nvertices = [{}]", corners.join(", "));
    for method in METHODS {
        let [many, disc] =
            [polygon.as_str(), "radius = 0.6"].map(|body| shear(body, 0.0, method).newton.motions[0].spin[1]);
        println!("{method:?}: {many:.5}, disc {disc:.5}");
        assert!((many / disc - 1.0).abs() < 2e-3, "{method}: {many}, disc {disc}");
    }
}

#[test]
fn bodies_that_cannot_be_are_refused_with_key_and_remedy() {
    let scene = |geometry: &str, grain: &str| {
        let (size, walls) = if geometry == "space" {
            (
                "lower = [0.0, 0.0, 0.0]\nupper = [4.0, 4.0, 4.0]\ncells = [32, 32, 32]",
                "x = \"periodic\", y = \"periodic\", z = \"no-slip\"",
            )
        } else {
            ("lower = [0.0, 0.0]\nupper = [4.0, 4.0]\ncells = [32, 32]", "x = \"periodic\", z = \"no-slip\"")
        };
        let text = format!(
            "until = 1.0\n[domain]\ngeometry = \"{geometry}\"\n{size}\nboundary = {{ {walls} }}\n\
             [medium]\ndensity = 1.0\nviscosity = 1.0\n[[grains]]\nposition = [2.0, 0.0, 2.0]\ndensity = 2.0\n{grain}\n"
        );
        try_scene(&text).map(|_| ())
    };
    let polygon = |vertices: &str| format!("shape = \"polygon\"\nvertices = {vertices}");
    for (geometry, grain, key, words) in [
        ("plane", polygon("[[0, 0], [1, 0]]"), "vertices", "3 to 64"),
        ("plane", polygon("[[0, 0], [1, 0], [2, 0]]"), "vertices", "no area"),
        ("plane", polygon("[[0, 0], [1, 1], [1, 0], [0, 1]]"), "vertices", "cross"),
        ("plane", polygon("[[0, 0], [2, 0], [0.5, 0.5], [0, 2]]"), "vertices", "not convex"),
        ("plane", "shape = \"polygon\"".into(), "vertices", "missing"),
        ("plane", "shape = \"rectangle\"\nsides = [1.0, 0.0]".into(), "sides", "> 0"),
        ("plane", "shape = \"rectangle\"".into(), "sides", "missing"),
        ("plane", "shape = \"rectangle\"\nsides = [1.0, 1.0]\nradius = 0.5".into(), "radius", "no radius"),
        ("plane", "shape = \"ellipse\"\nsides = [1.0, 1.0]".into(), "sides", "rectangle"),
        ("plane", "shape = \"sphere\"\nradius = 0.5".into(), "shape", "cylinders"),
        (
            "plane",
            "shape = \"rectangle\"\nsides = [1.0, 1.0]\norientation = [0.8, 0.6, 0.0, 0.0]".into(),
            "orientation",
            "out of the plane",
        ),
        (
            "plane",
            "shape = \"rectangle\"\nsides = [1.0, 1.0]\norientation = [1.0, 0.0, 0.5, 0.0]".into(),
            "orientation",
            "unit quaternion",
        ),
        ("space", "shape = \"disc\"\nradius = 0.5".into(), "shape", "body of the plane"),
        ("space", "shape = \"rectangle\"\nsides = [1.0, 1.0]".into(), "shape", "body of the plane"),
    ] {
        let error = scene(geometry, &grain).expect_err(&grain);
        assert_eq!(error.key, format!("grains[0].{key}"), "{grain}: {error}");
        assert!(format!("{error} {}", error.remedy).contains(words), "{grain}: {error}");
        assert!(!error.remedy.is_empty());
    }
    let thin = scene("plane", "shape = \"rectangle\"\nsides = [1.0, 0.2]").expect_err("thin");
    assert_eq!(thin.key, "domain.cells");
    assert!(thin.remedy.contains("0.1"), "{}", thin.remedy);
}

/// Bodies may lie nearer to each other and to walls than the circles around them.
#[test]
fn bodies_overlap_where_their_outlines_do() {
    let scene = |apart: f64, height: f64| {
        let plate = "shape = \"rectangle\"\nsides = [1.0, 0.25]\ndensity = 2.0";
        try_scene(&format!(
            "until = 1.0\n[domain]\ngeometry = \"plane\"\nlower = [0.0, 0.0]\nupper = [4.0, 4.0]\ncells = [32, 32]\n\
             boundary = {{ x = \"periodic\", z = \"no-slip\" }}\n[medium]\ndensity = 1.0\nviscosity = 1.0\n\
             [[grains]]\nposition = [2.0, 0.0, {height}]\n{plate}\n\
             [[grains]]\nposition = [2.0, 0.0, {}]\n{plate}\n",
            height + apart
        ))
        .map(|_| ())
    };
    scene(0.26, 0.13).expect("plates on each other and on the floor");
    assert!(scene(0.2, 0.13).expect_err("plates in each other").message.contains("overlap"));
    assert!(scene(0.26, 0.1).expect_err("a plate in the floor").message.contains("into the wall"));
}
