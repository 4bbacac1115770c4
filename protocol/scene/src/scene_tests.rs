//! Tests of whole scenes: random placement with and without periodic axes, names that become files.

use crate::checked::CheckedScene;
use crate::error::SceneError;
use crate::random::SplitMix64;
use crate::source::SceneSource;

/// `count` grains of radius ½ placed at random in a box of `side`, periodic or between walls.
fn placed(plane: bool, face: &str, side: f64, count: usize, seed: u64) -> Result<CheckedScene, SceneError> {
    let corner = |x: f64| if plane { format!("[{x:?}, {x:?}]") } else { format!("[{x:?}, {x:?}, {x:?}]") };
    let (geometry, y) = if plane { ("plane", String::new()) } else { ("space", format!("y = \"{face}\"")) };
    let text = format!(
        "until = 1.0\n[domain]\ngeometry = \"{geometry}\"\nlower = {}\nupper = {}\n[domain.boundary]\n\
         x = \"{face}\"\n{y}\nz = \"{face}\"\n[[groups]]\ncount = {count}\nlower = [0.0, 0.0, 0.0]\n\
         upper = [{side:?}, {side:?}, {side:?}]\nradius = 0.5\ndensity = 1.0\nseed = {seed}\n",
        corner(0.0),
        corner(side)
    );
    CheckedScene::new(SceneSource { file: "s.toml".into(), text })
}

/// Grains of radius ½ that make this solid fraction.
fn count(plane: bool, side: f64, fraction: f64) -> usize {
    use std::f64::consts::PI;
    let cells = if plane { side.powi(2) / (0.25 * PI) } else { side.powi(3) / (PI / 6.0) };
    (fraction * cells).floor() as usize
}

#[test]
fn centres_are_as_dense_at_a_periodic_face_as_elsewhere() {
    let (side, count, seeds) = (8.0, 240, 20);
    // Centres within ½ of a face: an eighth of the box along each axis, none at a wall.
    let mut near = [0.0f64; 3];
    for seed in 0..seeds {
        let scene = placed(false, "periodic", side, count, seed).expect("room");
        for grain in &scene.grains {
            assert!(grain.position.iter().all(|x| (0.0..side).contains(x)), "{:?}", grain.position);
            for (near, x) in near.iter_mut().zip(grain.position) {
                *near += f64::from(u8::from(!(0.5..side - 0.5).contains(&x)));
            }
        }
    }
    let mean = f64::from(u32::try_from(seeds).unwrap()) * count as f64 / 8.0;
    // Spheres that do not overlap spread less than independent points, whose error is √mean.
    for near in near {
        assert!((near - mean).abs() < 3.0 * mean.sqrt(), "{near} centres, {mean} were to be expected");
    }
}

#[test]
fn images_count_as_neighbours_in_boxes_of_any_width() {
    for side in [1.5, 2.5, 3.5] {
        for plane in [true, false] {
            let scene = placed(plane, "periodic", side, count(plane, side, 0.2).max(1), 3).expect("room");
            for (i, a) in scene.grains.iter().enumerate() {
                for b in &scene.grains[..i] {
                    let square = |axis: usize| {
                        let apart = (a.position[axis] - b.position[axis]).abs();
                        apart.min(side - apart).powi(2)
                    };
                    assert!((0..3).map(square).sum::<f64>() >= 1.0, "{side}: {a:?} {b:?}");
                }
            }
        }
    }
}

/// As grains were placed before periodic axes were spanned: whole within the region, one by one.
#[test]
fn a_region_that_does_not_span_the_axis_keeps_its_places() {
    let text = "until = 1.0\n[domain]\ngeometry = \"space\"\nlower = [0.0, 0.0, 0.0]\n\
                upper = [4.0, 4.0, 4.0]\nboundary = { x = \"periodic\", y = \"no-slip\", z = \"free-slip\" }\n\
                [[groups]]\ncount = 25\nlower = [0.25, 0.0, 0.0]\nupper = [4.0, 4.0, 4.0]\nradius = 0.4\n\
                radius_spread = 0.25\ndensity = 1.0\nseed = 7\n";
    let source = SceneSource { file: "s.toml".into(), text: text.into() };
    let scene = CheckedScene::new(source).expect("room");
    let (mut random, mut expected) = (SplitMix64(7), Vec::<([f64; 3], f64)>::new());
    for _ in 0..25 {
        let radius = random.about(0.4, 0.25);
        let place = loop {
            let place = [0.25, 0.0, 0.0].map(|lower: f64| {
                let (lower, upper) = (lower + radius, 4.0 - radius);
                lower + (upper - lower) * random.unit()
            });
            let square = |other: &[f64; 3]| (0..3).map(|k| (place[k] - other[k]).powi(2)).sum::<f64>();
            if expected.iter().all(|(other, r)| square(other) >= (radius + r).powi(2)) {
                break place;
            }
        };
        expected.push((place, radius));
    }
    let grains: Vec<_> = scene.grains.iter().map(|grain| (grain.position, grain.radius)).collect();
    assert_eq!(grains, expected);
}

#[test]
fn the_fractions_of_the_manual_are_reached() {
    for (plane, face, side, fraction) in [
        (false, "periodic", 8.0, 0.35),
        (true, "periodic", 20.0, 0.5),
        (false, "no-slip", 8.0, 0.30),
        (true, "no-slip", 20.0, 0.48),
    ] {
        for seed in 1..=5 {
            let count = count(plane, side, fraction);
            assert!(placed(plane, face, side, count, seed).is_ok(), "{face} {fraction} {seed}");
        }
    }
}

#[test]
fn grains_appear_at_a_periodic_face_as_often_as_elsewhere() {
    let text = "until = 1.0\n[domain]\ngeometry = \"space\"\nlower = [0.0, 0.0, 0.0]\n\
                upper = [0.016, 0.064, 0.2]\n\
                boundary = { x = \"periodic\", y = \"periodic\", z = \"no-slip\" }\n[[insertions]]\n\
                count = 400\nlower = [0.0, 0.001, 0.17]\nupper = [0.016, 0.064, 0.2]\nradius = 0.002\n\
                density = 2500.0\nseed = 1\nrate = 500.0\n";
    let scene = CheckedScene::new(SceneSource { file: "s.toml".into(), text: text.into() }).expect("fits");
    let insertion = &scene.scene.insertions[0];
    let places: Vec<_> = (0..4000).map(|k| insertion.place(&scene.scene.domain, 0.002, k, 1, 0)).collect();
    let share = |range: std::ops::Range<f64>| {
        places.iter().filter(|place| range.contains(&place[0])).count() as f64 / 4000.0
    };
    // An eighth of the width each, with an error of 0.005.
    for part in [0.0..0.002, 0.006..0.008, 0.014..0.016] {
        assert!((share(part.clone()) - 0.125).abs() < 0.02, "{part:?}: {}", share(part.clone()));
    }
    // It does not span y, and ends at walls along z.
    assert!(places.iter().all(|place| (0.003..=0.062).contains(&place[1])));
    assert!(places.iter().all(|place| (0.172..=0.198).contains(&place[2])));
}

#[test]
fn a_metric_whose_name_becomes_a_file_has_the_name_of_one() {
    let scene = |name: &str, kind: &str| {
        let text = format!(
            "until = 1.0\n[domain]\ngeometry = \"plane\"\nlower = [0.0, 0.0]\nupper = [1.0, 1.0]\n\
             cells = [8, 8]\nboundary = {{ x = \"periodic\", z = \"no-slip\" }}\n[medium]\ndensity = 1.0\n\
             viscosity = 1.0\n[[metrics]]\nname = \"{name}\"\n{kind}\n"
        );
        CheckedScene::new(SceneSource { file: "s.toml".into(), text })
    };
    let profile = "kind = \"velocity-difference\"\ncomponent = \"x\"\nalong = \"z\"\nthrough = [0.5, 0.0, 0.5]\n\
                   file = \"u.csv\"\ncolumn = \"u\"";
    for name in ["/tmp/u", "../../u", ".u", "", "a/b", "series", "Grains", "deposit"] {
        let error = scene(name, profile).expect_err(name);
        assert_eq!((error.key.as_str(), error.line), ("metrics[0].name", 12), "{error}");
        assert!(
            error.message.contains(&format!("is {name:?}")) && error.message.contains("allowed"),
            "{error}"
        );
        assert!(error.remedy.contains("u_difference"), "{}", error.remedy);
    }
    assert!(scene("u-difference.1", profile).is_ok());
    // A name that is only a label may be any text.
    assert!(scene("V_C/V_T", "kind = \"final\"\ncolumn = \"dt\"").is_ok());
}
