//! `bedload pack`: fractions, overlaps, sizes, seeds, refusals.

use std::path::Path;

use bedload_scene::{CheckedScene, Grain, Motion, SceneSource};

use crate::fake_solvers::{Room, bedload};

/// What the command said, with its exit code; the table is `FOLDER/grains.csv`.
fn pack(folder: &Path, arguments: &str) -> (Option<i32>, String) {
    let out = folder.join("grains.csv");
    let words = ["pack"].into_iter().chain(arguments.split_whitespace());
    let arguments: Vec<&str> = words.chain(["--overwrite", "--out", out.to_str().unwrap()]).collect();
    let output = bedload(&arguments).output().unwrap();
    let said = [output.stdout, output.stderr].map(|bytes| String::from_utf8_lossy(&bytes).into_owned());
    (output.status.code(), said.concat())
}

/// The grains as a scene with this box reads them.
fn read(folder: &Path, size: &[f64], periodic: &str) -> Vec<Grain> {
    let (geometry, axes) = if size.len() == 3 { ("space", "xyz") } else { ("plane", "xz") };
    let face = |axis: char| {
        let kind = if periodic.contains(axis) { "periodic" } else { "no-slip" };
        format!("{axis} = \"{kind}\"")
    };
    let faces: Vec<String> = axes.chars().map(face).collect();
    let text = format!(
        "until = 1.0\n[domain]\ngeometry = \"{geometry}\"\nlower = {:?}\nupper = {size:?}\n\
         boundary = {{ {} }}\n[[grain_files]]\nfile = \"grains.csv\"\n",
        vec![0.0; size.len()],
        faces.join(", ")
    );
    let file = folder.join("scene.toml").display().to_string();
    CheckedScene::new(SceneSource { file, text }).unwrap_or_else(|error| panic!("{error}")).grains
}

fn fraction(grains: &[Grain], size: &[f64]) -> f64 {
    grains.iter().map(Grain::volume).sum::<f64>() / size.iter().product::<f64>()
}

/// Distances of all pairs, the nearest image of each.
fn distances<'a>(
    grains: &'a [Grain],
    lengths: [f64; 3],
    periodic: &'a str,
) -> impl Iterator<Item = (f64, &'a Grain, &'a Grain)> {
    let pairs = grains.iter().enumerate().flat_map(|(i, a)| grains[..i].iter().map(move |b| (a, b)));
    pairs.map(move |(a, b)| {
        let square = |axis: usize| {
            let apart = a.position[axis] - b.position[axis];
            let wraps = periodic.contains(["x", "y", "z"][axis]);
            let turn = if wraps { (apart / lengths[axis]).round() * lengths[axis] } else { 0.0 };
            (apart - turn).powi(2)
        };
        ((0..3).map(square).sum::<f64>().sqrt(), a, b)
    })
}

/// Loose, dense and near jamming, in the plane and in space, between faces and with images, over a floor.
#[test]
fn fractions_are_exact_and_no_two_grains_overlap() {
    let room = Room::new("pack");
    for (size, periodic, wanted, more) in [
        (&[6.0, 7.0, 8.0][..], "xyz", 0.05, "--spread 0.2"),
        (&[8.0, 8.0, 8.0], "xy", 0.3, ""),
        (&[8.0, 8.0, 8.0], "xy", 0.5, "--spread 0.1"),
        (&[8.0, 8.0, 8.0], "xyz", 0.62, ""),
        (&[7.0, 7.0, 7.0], "xy", 0.45, "--floor rough --spread 0.1"),
        (&[20.0, 12.0], "x", 0.5, "--spread 0.1"),
        (&[20.0, 20.0], "xz", 0.8, "--spread 0.1"),
    ] {
        let text: Vec<String> = size.iter().map(f64::to_string).collect();
        let text = text.join(" ");
        let arguments = format!(
            "--box {text} --periodic {periodic} --fraction {wanted} --diameter 1.0 --seed 7 --density 2.5 {more}"
        );
        let (code, said) = pack(&room.0, &arguments);
        assert_eq!(code, Some(0), "{said}");
        let grains = read(&room.0, size, periodic);
        assert!((fraction(&grains, size) - wanted).abs() < 1e-12, "{arguments}: {said}");
        let lengths = if size.len() == 3 { [size[0], size[1], size[2]] } else { [size[0], 1.0, size[1]] };
        for (distance, a, b) in distances(&grains, lengths, periodic) {
            assert!(distance >= (a.radius + b.radius) * (1.0 - 1e-9), "{arguments}: {a:?} {b:?}");
        }
        for grain in &grains {
            assert_eq!(grain.density, 2.5);
            for axis in (0..3).filter(|axis| size.len() == 3 || *axis != 1) {
                let wraps = periodic.contains(["x", "y", "z"][axis]);
                let room = if wraps { 0.0 } else { grain.radius * (1.0 - 1e-9) };
                let place = grain.position[axis];
                assert!(room <= place && place <= lengths[axis] - room, "{arguments}: {grain:?}");
            }
        }
        let fixed: Vec<&Grain> = grains.iter().filter(|grain| grain.motion == Motion::Fixed).collect();
        if more.contains("floor") {
            assert!(fixed.iter().all(|grain| grain.position[2] <= 1.51 * grain.radius), "{fixed:?}");
            // Random discs fill up to 0.547 of a plane (Feder 1980).
            let covered: f64 = fixed.iter().map(|grain| std::f64::consts::PI * grain.radius.powi(2)).sum();
            assert!((0.38..0.56).contains(&(covered / (size[0] * size[1]))), "{covered}");
            assert!(said.contains(&format!("{} of them fixed", fixed.len())), "{said}");
        } else {
            assert!(fixed.is_empty());
        }
    }
}

#[test]
fn the_same_seed_is_the_same_packing() {
    let room = Room::new("pack-seed");
    let arguments = "-q --box 6 6 6 --periodic xyz --fraction 0.5 --diameter 1 --seed";
    let made = |seed: u32| {
        let (code, said) = pack(&room.0, &format!("{arguments} {seed}"));
        let table = room.0.join("grains.csv");
        assert_eq!((code, said), (Some(0), format!("{}\n", table.display())));
        std::fs::read(table).unwrap()
    };
    let first = made(7);
    assert_eq!(first, made(7));
    assert_ne!(first, made(8));
}

/// At a fraction of 0.1 hard spheres have g = (1 − φ/2)/(1 − φ)³ = 1.30 in contact (Carnahan & Starling
/// 1969), and 1 at a distance of some diameters. 2,900 pairs in the first bin.
#[test]
fn loose_grains_are_as_far_apart_as_hard_spheres() {
    let room = Room::new("pack-g");
    let (code, said) = pack(&room.0, "--box 40 40 40 --periodic xyz --fraction 0.1 --diameter 1 --seed 3");
    assert_eq!(code, Some(0), "{said}");
    let grains = read(&room.0, &[40.0; 3], "xyz");
    let mut counts = [0.0; 50];
    for (distance, ..) in distances(&grains, [40.0; 3], "xyz") {
        if let Some(count) = counts.get_mut((distance * 10.0) as usize) {
            *count += 1.0;
        }
    }
    let number = grains.len() as f64;
    let density = number * number / 2.0 / 40f64.powi(3);
    let g = |bin: usize| {
        let (a, b) = (bin as f64 / 10.0, (bin + 1) as f64 / 10.0);
        counts[bin] / (density * 4.0 / 3.0 * std::f64::consts::PI * (b.powi(3) - a.powi(3)))
    };
    assert_eq!(counts[..9].iter().sum::<f64>(), 0.0);
    assert!((1.15..1.40).contains(&g(10)), "{}", g(10));
    assert!((30..50).all(|bin| (g(bin) - 1.0).abs() < 0.05), "{:?}", (30..50).map(g).collect::<Vec<_>>());
}

/// By mass a half of each size is 8 small spheres to a large one.
#[test]
fn sizes_come_from_a_distribution() {
    let room = Room::new("pack-sizes");
    let sizes = room.0.join("sizes.csv");
    for (column, small) in [("mass", 8.0 / 9.0), ("number", 0.5)] {
        std::fs::write(&sizes, format!("# sieves\ndiameter,{column}\n0.5,1\n1.0,1\n")).unwrap();
        let arguments = format!("--box 12 12 12 --periodic xyz --fraction 0.2 --sizes {}", sizes.display());
        let (code, said) = pack(&room.0, &arguments);
        assert_eq!(code, Some(0), "{said}");
        let grains = read(&room.0, &[12.0; 3], "xyz");
        let share = grains.iter().filter(|grain| grain.radius < 0.4).count() as f64 / grains.len() as f64;
        // Three deviations of a draw of some 1,000.
        assert!((share - small).abs() < 0.05, "{column}: {share} of {}", grains.len());
        assert!((fraction(&grains, &[12.0; 3]) - 0.2).abs() < 1e-12);
    }
    std::fs::write(&sizes, "diameter,share\n1,1\n").unwrap();
    let (code, said) = pack(&room.0, &format!("--box 9 9 --fraction 0.2 --sizes {}", sizes.display()));
    assert_eq!(code, Some(2), "{said}");
    assert!(said.contains("sizes.csv") && said.contains("`number` or `mass`"), "{said}");
    std::fs::write(&sizes, "diameter,mass\n-1,1\n").unwrap();
    let (code, said) = pack(&room.0, &format!("--box 9 9 --fraction 0.2 --sizes {}", sizes.display()));
    assert_eq!(code, Some(2), "{said}");
    assert!(said.contains("-1,1") && said.contains("above 0"), "{said}");
    for (text, words) in [
        ("diameter,number,foo\n1,1,2\n", "`foo`, which is not read"),
        ("diameter,number\n1,1,7\n", "`7` in column 3 is past the last column"),
        ("diameter,number,number\n1,1,7\n", "has the name of column 2"),
    ] {
        std::fs::write(&sizes, text).unwrap();
        let (code, said) = pack(&room.0, &format!("--box 9 9 --fraction 0.2 --sizes {}", sizes.display()));
        assert!(code == Some(2) && said.contains(words), "{said}");
    }
    // Thousands of small ones about each large one.
    std::fs::write(&sizes, "diameter,number\n0.05,1000\n2.0,1\n").unwrap();
    let wide = format!("--box 9 9 9 --fraction 0.5 --sizes {}", sizes.display());
    let (code, said) = pack(&room.0, &wide);
    assert!(
        code == Some(2) && said.contains("--sizes is too wide") && said.contains("smaller --box"),
        "{said}"
    );
}

/// What stands at `--out` stays, unless it is a file that may be replaced.
#[test]
fn nothing_is_replaced_unasked() {
    let room = Room::new("pack-out");
    let (out, link) = (room.0.join("mine.toml"), room.0.join("link"));
    std::fs::write(&out, "mine").unwrap();
    std::os::unix::fs::symlink(&out, &link).unwrap();
    let words = "pack --box 9 9 9 --fraction 0.2 --diameter 1 --out".split(' ').collect::<Vec<_>>();
    for (path, more, what) in
        [(&out, "", "exists"), (&link, "", "no plain file"), (&link, "--overwrite", "no plain file")]
    {
        let more = Some(more).filter(|more| !more.is_empty());
        let path = path.to_str().unwrap();
        let arguments: Vec<&str> = words.iter().copied().chain([path]).chain(more).collect();
        let output = bedload(&arguments).output().unwrap();
        assert_eq!(output.status.code(), Some(2));
        assert!(String::from_utf8_lossy(&output.stderr).contains(what), "{output:?}");
        assert_eq!(std::fs::read_to_string(&out).unwrap(), "mine");
    }
}

#[test]
fn what_cannot_be_is_refused_by_name() {
    let room = Room::new("pack-refused");
    for (arguments, code, words) in [
        ("--box 0 9 --fraction 0.2 --diameter 1", 2, "--box has 0; allowed: lengths above 0"),
        (
            "--box 9 9 --fraction 0.2 --diameter 1 --periodic xy",
            2,
            "--periodic has 'y'; allowed: letters of xz",
        ),
        ("--box 9 9 9 --fraction 0.7 --diameter 1", 2, "--fraction is 0.7; allowed: above 0, up to 0.64"),
        ("--box 9 9 9 --fraction nan --diameter 1", 2, "--fraction is NaN"),
        ("--box 9 9 9 --fraction 0.2 --diameter 0", 2, "--diameter is 0; allowed: above 0"),
        ("--box 9 9 9 --fraction 0.2 --diameter 1 --spread 1", 2, "--spread is 1; allowed: 0 to below 1"),
        ("--box 9 9 9 --fraction 0.2 --diameter 1 --density -1", 2, "--density is -1; allowed: above 0"),
        ("--box 9 1.5 --fraction 0.2 --diameter 1 --periodic z", 2, "--box is 1.5 along z; allowed: from"),
        ("--box 9 9 --fraction 0.2 --diameter 30", 2, "less than half a grain"),
        ("--box 9 9 9 --fraction 0.2 --diameter 1e-3", 2, "more than 2e6 grains"),
        (
            "--box 9 9 9 --fraction 0.2 --diameter 1 --periodic z --floor rough",
            2,
            "--floor needs a lower z face",
        ),
        ("--box 9 9 9 --fraction 0.02 --diameter 1 --floor rough", 2, "too little to cover the floor"),
        ("--box 9 9 9 --fraction 0.2", 2, "--diameter"),
        // Five fit side by side, and no more.
        ("--box 5.1 1.1 --fraction 0.83 --diameter 1 --seed 1", 1, "was not reached"),
    ] {
        let (found, said) = pack(&room.0, arguments);
        assert_eq!(found, Some(code), "{arguments}: {said}");
        assert!(said.contains(words), "{arguments}: {said}");
        assert!(!said.contains("panicked") && !room.0.join("grains.csv").exists(), "{arguments}: {said}");
    }
}
