//! Tests of whole scenes: random placement with and without periodic axes, names that become files.

use bedload_scene::{CheckedScene, SceneError, SceneSource, SplitMix64, is_file_name};

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

/// A scene in a box of 4 × 4 × 4, periodic along x and y.
fn boxed(more: &str) -> Result<CheckedScene, SceneError> {
    let text = format!(
        "until = 1.0\n[domain]\ngeometry = \"space\"\nlower = [0, 0, 0]\nupper = [4, 4, 4]\n\
         cells = [16, 16, 16]\nboundary = {{ x = \"periodic\", y = \"periodic\", z = \"no-slip\" }}\n{more}"
    );
    CheckedScene::new(SceneSource { file: "s.toml".into(), text })
}

fn grains(places: &[[f64; 3]]) -> String {
    places
        .iter()
        .map(|place| format!("[[grains]]\nposition = {place:?}\nradius = 0.5\ndensity = 2.0\n"))
        .collect()
}

#[test]
fn a_run_goes_on_from_the_overlaps_that_another_may_have_ended_with() {
    let apart = |overlap: f64| grains(&[[2.0, 2.0, 1.0], [2.0, 2.0, 2.0 - overlap]]);
    let sunk = |overlap: f64| grains(&[[2.0, 2.0, 0.5 - overlap]]);
    let state = "[dem]\ninitial_state = \"out\"\n";
    let fluid = "[medium]\ndensity = 1.0\nviscosity = 0.1\n";
    let force = "[coupling]\nforce = [\"overlap\"]\n";
    for scene in [apart, sunk] as [fn(f64) -> String; 2] {
        let error = boxed(&scene(0.02)).unwrap_err();
        assert!(error.message.contains("allowed: 1 % of R"), "{error}");
        assert!(error.remedy.contains("dem.initial_state"), "{}", error.remedy);
        assert!(boxed(&format!("{}{state}", scene(0.04))).is_ok());
        assert!(boxed(&format!("{}{state}{fluid}", scene(0.04))).is_ok());
        let deep = scene(0.1);
        assert!(boxed(&format!("{deep}{state}")).is_ok(), "a dry run goes on with any overlap");
        let error = boxed(&format!("{deep}{state}{fluid}")).unwrap_err();
        assert!(error.message.contains("10 % of the largest radius"), "{error}");
        assert!(boxed(&format!("{deep}{state}{fluid}{force}")).is_ok());
    }
    assert!(boxed(&format!("{}{state}{fluid}{force}", apart(0.9))).is_err(), "one lies in the other");
}

#[test]
fn beyond_a_periodic_face_the_image_in_the_box_is_named() {
    let error = boxed(&grains(&[[-0.25, 2.0, 2.0]])).unwrap_err();
    assert!(error.remedy.contains("x is periodic") && error.remedy.contains("x = 3.75"), "{}", error.remedy);
    let error = boxed(&grains(&[[2.0, 2.0, 4.25]])).unwrap_err();
    assert!(error.remedy.contains("enlarge [domain]"), "{}", error.remedy);
}

#[test]
fn counts_are_bounded_together_and_before_anything_is_made() {
    let bed = |name: &str, count: usize, more: &str| {
        format!(
            "[[{name}]]\ncount = {count}\nlower = [0, 0, 0]\nupper = [4, 4, 4]\nradius = 0.001\n\
             density = 1.0\nseed = 1\n{more}"
        )
    };
    let inserted = bed("insertions", 6_000_000, "rate = 1.0\n");
    let error = boxed(&format!("{}{inserted}", bed("groups", 6_000_000, ""))).unwrap_err();
    assert_eq!(error.key, "insertions");
    assert!(error.message.contains("10000000 grains in all"), "{error}");
    let file = std::env::temp_dir().join(format!("bedload-copies-{}.csv", std::process::id()));
    std::fs::write(&file, "x,y,z,radius,density\n2,2,1,0.5,2\n").unwrap();
    let table = |copies: usize, shift: [f64; 3]| {
        boxed(&format!("[[grain_files]]\nfile = {file:?}\ncopies = {copies}\nshift = {shift:?}\n"))
    };
    let error = table(5_000_000, [0.0, 0.0, 0.1]).unwrap_err();
    assert_eq!(error.key, "grain_files[0].shift");
    assert!(error.message.contains("each copy lies in the one before it"), "{error}");
    let error = table(20_000_000, [0.0, 0.0, 2.0]).unwrap_err();
    assert_eq!(error.key, "grain_files[0].copies");
    assert_eq!(table(2, [0.0, 0.0, 1.5]).unwrap().grains.len(), 2);
    std::fs::remove_file(&file).unwrap();
}

#[test]
fn what_is_held_has_no_random_velocity() {
    let group = |more: &str| {
        boxed(&format!(
            "[[groups]]\ncount = 3\nlower = [0, 0, 0]\nupper = [4, 4, 4]\nradius = 0.3\ndensity = 1.0\nseed = 1\n\
             velocity_deviation = 2.0\n{more}"
        ))
    };
    for held in ["motion = \"fixed\"\n", "locked = [\"x\", \"y\", \"z\"]\n"] {
        let error = group(held).unwrap_err();
        assert_eq!(error.key, "groups[0].velocity_deviation");
        assert!(error.message.contains("held along every axis"), "{error}");
    }
    assert!(group("locked = [\"z\"]\n").is_ok());
}

#[test]
fn a_name_leads_to_no_other_folder() {
    for name in ["u", "u_difference", "Re-100.x", &"a".repeat(100)] {
        assert!(is_file_name(name), "{name}");
    }
    let wrong =
        ["", ".", "..", ".hidden", "/etc/u", "../../u", "a/b", "a\\b", "C:u", "a b", "é", "a\0", "a\n"];
    for name in wrong.into_iter().chain([&*"a".repeat(101)]) {
        assert!(!is_file_name(name), "{name}");
    }
}

/// As grains were placed before periodic axes were spanned: whole within the region, one by one.
#[test]
fn a_region_that_does_not_span_the_axis_keeps_its_places() {
    let text = "until = 1.0\n[domain]\ngeometry = \"space\"\nlower = [0.0, 0.0, 0.0]\n\
                upper = [4.0, 4.0, 4.0]\n\
                boundary = { x = \"periodic\", y = \"no-slip\", z = \"free-slip\" }\n\
                [[groups]]\ncount = 25\nlower = [0.25, 0.0, 0.0]\nupper = [4.0, 4.0, 4.0]\nradius = 0.4\n\
                radius_spread = 0.25\ndensity = 1.0\nseed = 7\n";
    let scene = CheckedScene::new(SceneSource { file: "s.toml".into(), text: text.into() }).expect("room");
    let (mut random, mut expected) = (SplitMix64::new(7), Vec::<([f64; 3], f64)>::new());
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
fn what_would_have_no_effect_is_refused() {
    let grain = "[[grains]]\nposition = [2.0, 2.0, 2.0]\nradius = 0.5\ndensity = 2.0\n";
    let fluid = "[medium]\ndensity = 1.0\nviscosity = 0.1\n";
    let metric =
        |kind: &str, more: &str| format!("{grain}{fluid}[[metrics]]\nname = \"m\"\nkind = {kind:?}\n{more}");
    let line = |through: &str| {
        let axes = "component = \"x\"\nalong = \"z\"\nfile = \"u.csv\"\ncolumn = \"u\"\n";
        metric("velocity-difference", &format!("{axes}through = {through}\n"))
    };
    let named = |name: &str| {
        format!("{grain}[[metrics]]\nname = {name:?}\nkind = \"final\"\ncolumn = \"kinetic_energy\"\n")
    };
    let layer = |lower: &str, upper: &str| {
        format!("{grain}[[rough_walls]]\nlower = {lower}\nupper = {upper}\nradius = 0.2\ndensity = 1.0\n")
    };
    let planes = "[observe]\nplanes = { axis = \"z\", every = 0.1, at = [-0.5] }\n";
    let fixed = format!("{grain}motion = \"fixed\"\n");
    for (text, key, words) in [
        (line("[7.0, 2.0, 0.0]"), "metrics[0].through", "7 along x; allowed: a place in the box, 0 to 4"),
        (named("superficial_velocity_x"), "metrics[0].name", "superficial_velocity_"),
        (named(""), "metrics[0].name", "allowed"),
        (format!("{}reference = nan\n", named("e")), "metrics[0].reference", "NaN"),
        (metric("haff-time", "from = 3.0\nto = 1.0\n"), "metrics[0].to", "from 3 to 1"),
        (format!("{grain}[observe]\ngrains = [0, 0]\n"), "observe.grains", "0 twice"),
        (format!("{grain}{fluid}{planes}"), "observe.planes.at", "-0.5"),
        (layer("[0, 0, 0.6]", "[4, 4, 0.3]"), "rough_walls[0].upper", "do not span a rectangle"),
        (format!("{fixed}velocity = [1.0, 0.0, 0.0]\n"), "grains[0].velocity", "grain 0 is fixed or locked"),
        (format!("{fixed}spin = [0.0, 1.0, 0.0]\n"), "grains[0].spin", "grain 0 is fixed or locked"),
        (
            format!("{grain}locked = [\"x\"]\nvelocity = [1.0, 0.0, 0.0]\n"),
            "grains[0].velocity",
            "grain 0 is fixed or locked",
        ),
        (
            format!("{grain}motion = \"prescribed\"\nlocked = [\"x\"]\n"),
            "grains[0].locked",
            "moves as `velocity` and `spin` say",
        ),
    ] {
        let error = boxed(&text).expect_err(key);
        assert_eq!(error.key, key, "{error}");
        assert!(error.message.contains(words) && !error.remedy.is_empty(), "{error}");
    }
    let outlet = |more: &str| {
        let text = format!(
            "until = 1.0\n[domain]\ngeometry = \"plane\"\nlower = [0, 0]\nupper = [4, 4]\ncells = [16, 16]\n\
             [domain.boundary]\nx_lower = {{ type = \"inflow\", velocity = [1.0, 0.0, 0.0] }}\n\
             x_upper = \"outflow\"\nz = \"free-slip\"\n{fluid}[[grains]]\nposition = [3.7, 0.0, 2.0]\n\
             radius = 0.5\ndensity = 2.0\n{more}"
        );
        CheckedScene::new(SceneSource { file: "s.toml".into(), text })
    };
    for stands in ["motion = \"fixed\"\n", "motion = \"prescribed\"\n", "locked = [\"x\"]\n"] {
        let error = outlet(stands).expect_err(stands);
        assert!(error.key == "grains[0].position" && error.message.contains("outflow"), "{error}");
    }
    assert!(outlet("").is_ok(), "what moves goes out");
    assert!(boxed(&line("[4.0, 2.0, 9.0]")).is_ok(), "along z the line has no place");
    assert!(boxed(&format!("{grain}locked = [\"x\"]\nvelocity = [0.0, 1.0, 0.0]\n")).is_ok());
}

#[test]
fn a_table_none_of_whose_grains_is_taken_is_told() {
    let file = std::env::temp_dir().join(format!("bedload-none-{}.csv", std::process::id()));
    std::fs::write(&file, "x,y,z,radius,density\n2,2,1,0.5,2\n").unwrap();
    let grain = grains(&[[2.0, 2.0, 3.0]]);
    let table = |more: &str| boxed(&format!("{grain}[[grain_files]]\nfile = {file:?}\n{more}"));
    assert_eq!(table("copies = 0\n").unwrap_err().key, "grain_files[0].copies");
    assert_eq!(table("below = nan\n").unwrap_err().key, "grain_files[0].below");
    let none = table("below = 1.2\n").expect("the other grain");
    assert!(none.notes.iter().any(|note| note.contains("none of 1 grains")), "{:?}", none.notes);
    std::fs::remove_file(&file).unwrap();
}

#[test]
fn what_a_geometry_has_not_is_refused_of_spins_and_insertions() {
    let plane = |more: &str| {
        let text = format!(
            "until = 1.0\n[domain]\ngeometry = \"plane\"\nlower = [0.0, 0.0]\nupper = [4.0, 4.0]\n\
             boundary = {{ x = \"no-slip\", z = \"no-slip\" }}\n{more}"
        );
        CheckedScene::new(SceneSource { file: "s.toml".into(), text })
    };
    let grain = "[[grains]]\nposition = [2.0, 0.0, 2.0]\nradius = 0.5\ndensity = 2.0\n";
    assert!(plane(&format!("{grain}spin = [0.0, 3.0, 0.0]\n")).is_ok());
    for spin in ["[3.0, 0.0, 0.0]", "[0.0, 0.0, 3.0]"] {
        let error = plane(&format!("{grain}spin = {spin}\n")).unwrap_err();
        assert!(error.key == "grains[0].spin", "{error}");
    }
    let insertion = "[[insertions]]\ncount = 3\nlower = [0.0, 0.0, 2.0]\nupper = [4.0, 0.0, 4.0]\n\
        radius = 0.1\ndensity = 1.0\nseed = 1\nrate = 1.0\n";
    assert!(plane(insertion).is_ok(), "{:?}", plane(insertion).err());
    for key in ["velocity", "rise"] {
        let error = plane(&format!("{insertion}{key} = [0.0, 0.5, 0.0]\n")).unwrap_err();
        assert!(error.key == format!("insertions[0].{key}"), "{error}");
    }
    let gate = "[[walls]]\npoint = [1.0, 0.0, 0.0]\nnormal = [1.0, 0.0, 0.0]\nuntil = 0.5\n[[rough_walls]]\n\
        lower = [0.5, 0.0, 0.5]\nupper = [0.5, 0.0, 3.0]\nradius = 0.25\ndensity = 1.0\nwall = 0\n";
    assert_eq!(plane(gate).unwrap_err().key, "rough_walls[0].wall");
    assert!(plane(&gate.replace("until = 0.5\n", "")).is_ok());
}
