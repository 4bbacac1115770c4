//! `bedload film`: frames and a film of a run, on any machine.

use tests::harness::{Folder, bedload, program, said};

/// A disc that falls in a box, with fields at five instants.
pub(crate) const SCENE: &str = r#"
until = 0.4
gravity = [0.0, 0.0, -1.0]
[domain]
geometry = "plane"
lower = [0.0, 0.0]
upper = [4.0, 6.0]
cells = [32, 48]
boundary = { x = "periodic", z = "no-slip" }
[medium]
density = 1.0
viscosity = 0.1
[[grains]]
position = [0.2, 0.0, 4.0]
radius = 0.5
density = 2.0
[dem.contact]
law = "linear-spring-dashpot"
restitution = 0.9
contact_time = 0.02
[observe]
fields_every = 0.1
"#;

/// Width and height in the header of a PNG or a GIF.
fn size(bytes: &[u8]) -> (u32, u32) {
    match bytes {
        [0x89, b'P', b'N', b'G', ..] => {
            let word = |at: usize| u32::from_be_bytes(bytes[at..at + 4].try_into().expect("four bytes"));
            (word(16), word(20))
        }
        _ => {
            assert!(bytes.starts_with(b"GIF89a"));
            let word = |at: usize| u32::from(u16::from_le_bytes([bytes[at], bytes[at + 1]]));
            (word(6), word(8))
        }
    }
}

#[test]
fn a_film_has_a_frame_for_every_instant_and_says_what_it_cannot_show() {
    let folder = Folder::new("film");
    let (scene, out) = (folder.write("falls.toml", SCENE), folder.join("out"));
    let out = out.to_str().expect("UTF-8");
    let run = bedload(&["run", scene.to_str().expect("UTF-8"), "--out", out]);
    assert!(run.status.success(), "{}", said(&run));
    let instants = std::fs::read_dir(folder.join("out/fields")).expect("fields").flatten();
    let instants = instants.filter(|entry| entry.file_name().to_string_lossy().ends_with(".vtr")).count();
    assert!(instants >= 4, "{instants}");
    for field in ["speed", "vorticity", "pressure", "grains"] {
        let film = bedload(&["film", out, "--field", field, "--width", "200"]);
        assert!(film.status.success(), "{}", said(&film));
        let frames = std::fs::read_dir(folder.join("out/film")).expect("frames").flatten().count();
        assert_eq!(frames, instants);
        let first = std::fs::read(folder.join("out/film/frame_00000.png")).expect("a frame");
        let film = std::fs::read(folder.join("out/film.gif")).expect("a film");
        assert_eq!(size(&first), (200, 289), "six over four, and the margins");
        assert_eq!(size(&film), size(&first));
    }
    for (bad, word) in [
        (["--field", "colour"], "vorticity"),
        (["--field", "vorticity-x"], "vorticity-x: a run with geometry \"plane\" has no such field"),
        (["--slice", "y=0"], "no extent along y: leave"),
        (["--slice", "x=1"], "no extent along y: choose"),
        (["--slice", "w"], "not a plane"),
        (["--width", "10"], "160"),
    ] {
        let film = bedload(&["film", out, bad[0], bad[1]]);
        assert_eq!(film.status.code(), Some(2), "{bad:?}: {}", said(&film));
        assert!(said(&film).contains(word), "{bad:?}: {}", said(&film));
    }
}

/// With an `ffmpeg` on the `PATH`, here one that writes down what it was asked, there is a film for players,
/// too; with one that fails the GIF stays.
#[test]
fn an_ffmpeg_makes_a_film_for_players() {
    use std::os::unix::fs::PermissionsExt;
    let folder = Folder::new("film-mp4");
    let (scene, out) = (folder.write("falls.toml", SCENE), folder.join("out"));
    let out = out.to_str().expect("UTF-8");
    let run = bedload(&["run", scene.to_str().expect("UTF-8"), "--out", out]);
    assert!(run.status.success(), "{}", said(&run));
    let others = std::env::var("PATH").unwrap_or_default();
    let path = format!("{}:{others}", folder.join("").display());
    let film = |text: &str| {
        let encoder = folder.write("ffmpeg", text);
        std::fs::set_permissions(&encoder, std::fs::Permissions::from_mode(0o755)).expect("its mode");
        let mut command = std::process::Command::new(program("bedload"));
        let made = command.args(["film", out, "--rate", "7"]).env("PATH", &path).output().expect("starts");
        assert!(made.status.success(), "{}", said(&made));
        (said(&made), std::fs::read_to_string(folder.join("out/film.mp4")))
    };
    let writes = "#!/bin/sh\nfor last; do :; done\n(ls frame_00000.png; echo \"$*\") > \"$last\"\n";
    let (told, made) = film(writes);
    let made = made.expect("a film");
    let asked = "-framerate 7 -i frame_%05d.png";
    assert!(made.starts_with("frame_00000.png\n") && made.contains(asked), "{made}");
    assert!(told.contains("film.gif") && told.contains("film.mp4"), "{told}");
    let (told, made) = film("#!/bin/sh\necho no such encoder >&2\nexit 1\n");
    assert!(made.is_err() && told.contains("no film.mp4: ffmpeg: no such encoder"), "{told}");
}

/// Names and times in a list of files over time.
fn listed(list: &str) -> Vec<(f64, String)> {
    let part = |line: &str, key: &str| Some(line.split_once(key)?.1.split('"').next()?.to_owned());
    let entry = |line: &str| Some((part(line, "timestep=\"")?.parse().ok()?, part(line, "file=\"")?));
    list.lines().filter_map(entry).collect()
}

/// Both lists name every file, at the same times; the script for ParaView knows the folder.
#[test]
fn paraview_is_given_lists_over_time_and_a_script() {
    let folder = Folder::new("export");
    let (scene, out) = (folder.write("falls.toml", SCENE), folder.join("it's\"here"));
    let out = out.to_str().expect("UTF-8");
    let export = || bedload(&["export", out, "--paraview"]);
    for more in ["observe.fields_every=0.0", "observe.fields_every=0.1"] {
        let run = ["run", scene.to_str().expect("UTF-8"), "--out", out, "--overwrite", "--set", more];
        let run = bedload(&run);
        assert!(run.status.success(), "{}", said(&run));
        if more.ends_with("=0.0") {
            assert_eq!(export().status.code(), Some(2), "{}", said(&export()));
            assert!(said(&export()).contains("fields_every"), "{}", said(&export()));
        }
    }
    assert!(export().status.success(), "{}", said(&export()));
    let out = std::path::Path::new(out);
    let read = |name: &str| std::fs::read_to_string(out.join(name)).expect("a file");
    let [fluid, grains] = ["fields/fluid.pvd", "fields/grains.pvd"].map(|list| listed(&read(list)));
    let times = |list: &[(f64, String)]| list.iter().map(|(time, _)| *time).collect::<Vec<_>>();
    assert!(fluid.len() >= 4 && times(&fluid) == times(&grains), "{fluid:?} {grains:?}");
    assert!(fluid.iter().chain(&grains).all(|(_, name)| out.join("fields").join(name).is_file()));
    assert!(
        read("open_fields.py").contains("it's\\\"here\", \"fields\""),
        "the folder as a string of Python"
    );
}

#[test]
fn a_film_of_a_dry_run_shows_the_box_while_its_grains_move() {
    let folder = Folder::new("film-dry");
    let medium = "[medium]\ndensity = 1.0\nviscosity = 0.1\n";
    let dry = SCENE.replace(medium, "").replace("cells = [32, 48]\n", "");
    let (scene, out) = (folder.write("falls.toml", &dry), folder.join("out"));
    let out = out.to_str().expect("UTF-8");
    let run = bedload(&["run", scene.to_str().expect("UTF-8"), "--out", out]);
    assert!(run.status.success(), "{}", said(&run));
    let film = bedload(&["film", out, "--field", "pressure"]);
    assert_eq!(film.status.code(), Some(2), "{}", said(&film));
    assert!(
        said(&film).contains("--field pressure") && said(&film).contains("only grains"),
        "{}",
        said(&film)
    );
    let film = bedload(&["film", out, "--width", "200"]);
    assert!(film.status.success(), "{}", said(&film));
    let frames: Vec<_> = std::fs::read_dir(folder.join("out/film"))
        .expect("frames")
        .flatten()
        .map(|entry| entry.path())
        .collect();
    assert!(frames.len() >= 4, "{}", frames.len());
    for frame in frames {
        assert_eq!(
            size(&std::fs::read(frame).expect("a frame")),
            (200, 289),
            "six over four, and the margins"
        );
    }
}
