//! Cases that are wrong.

use bedload_scene::SceneError;
use study::kind::Kind;
use study::section::Expected;
use study::study::Study;

const GOOD: &str = r#"
[case]
name = "fall"
title = "A fall"
source = "nobody, never"
quick = true
[[case.runs]]
label = "coarse-8"
scene = "falling-sphere.toml"
set = ["domain.cells=[52, 320]"]
quick = true
at = 8
[[case.checks]]
run = "coarse-*"
metric = "terminal_reynolds"
reference = 19.6
tolerance = 0.01
kind = "agrees"
[[case.checks]]
run = "coarse-8"
metric = "e"
reference = "exp(-35/stokes)"
kind = "reported"
"#;

/// The case of this text, of a scene of the repository.
fn read(text: &str) -> Result<Study, SceneError> {
    let scene = concat!(env!("CARGO_MANIFEST_DIR"), "/../../scenes/falling-sphere.toml");
    let file = std::env::temp_dir().join(format!("bedload-case-{}.toml", std::process::id()));
    std::fs::write(&file, text.replace("falling-sphere.toml", scene)).unwrap();
    let case = Study::read(&file, Kind::Case, false);
    std::fs::remove_file(&file).unwrap();
    case
}

fn refusal(from: &str, to: &str) -> String {
    assert!(GOOD.contains(from));
    read(&GOOD.replacen(from, to, 1)).expect_err(to).to_string()
}

#[test]
fn a_wrong_case_is_refused_with_what_is_wrong() {
    let case = read(GOOD).unwrap().section;
    assert_eq!((case.runs[0].at, case.metrics()), (Some(8.0), vec!["terminal_reynolds", "e"]));
    assert_eq!(case.checks[1].reference, Some(Expected::Formula("exp(-35/stokes)".into())));
    assert!(refusal("tolerance = 0.01", "").contains("needs a tolerance"));
    assert!(refusal("reference = 19.6", "").contains("no reference"));
    assert!(refusal("coarse-*", "fine-*").contains("there are coarse-8"));
    assert!(refusal("\"coarse-8\"", "\"../../x\"").contains("becomes a folder"));
    assert!(refusal("exp(-35/stokes)", "exp(-35/").contains("formula"));
    assert!(refusal("quick = true", "quik = true").contains("quik"));
    assert!(refusal("quick = true", "signal = \"x\"").contains("a key of [stability]"));
    let axes = "title = \"\"\nx = { label = \"\" }\ny = { label = \"\" }\n";
    let twice = read(&format!("{GOOD}[case.figure]\n{axes}[[case.figures]]\n{axes}"));
    assert!(twice.expect_err("two without a name").to_string().contains("becomes a file"));
    let columns = "file = \"\"\nx = \"\"\ny = \"\"\n";
    for (run, is_meant) in [("coarse-*", true), ("*-8", false)] {
        let of = format!("name = \"\"\nrun = {run:?}\n");
        let figure = format!("{GOOD}[case.figure]\n{axes}");
        let differences =
            format!("[[case.differences]]\nname = \"\"\nruns = [\"coarse-8\", {run:?}]\n{columns}");
        for of_runs in [
            format!("{figure}[[case.figure.series]]\n{of}"),
            format!("{figure}[[case.figure.tables]]\n{of}{columns}"),
            format!("{GOOD}{differences}"),
        ] {
            let found = read(&of_runs).err().map(|error| error.to_string());
            let of_none = found.as_ref().is_some_and(|error| error.contains("is of no run"));
            assert_eq!((of_none, found.is_none()), (!is_meant, is_meant), "{run}: {found:?}");
        }
    }
    let pictures = "[[case.pictures]]\nname = \"grains\"\ntitle = \"\"\nrun = \"fine-8\"\n";
    let of_none = read(&format!("{GOOD}{pictures}")).expect_err("no such run").to_string();
    assert!(of_none.contains("of no run"), "{of_none}");
    let runs = "runs = [\"coarse-8\", \"coarse-8\", \"coarse-8\"]";
    let three = format!("{GOOD}[[case.differences]]\nname = \"\"\n{runs}\n{columns}");
    let too_many = read(&three).expect_err("a run more than two").to_string();
    assert!(too_many.contains("3 entries") && too_many.contains("allowed: 2"), "{too_many}");
    let within =
        format!("{GOOD}[[case.differences]]\nname = \"d\"\nruns = [\"coarse-8\", \"coarse-8\"]\n{columns}");
    let turned = read(&format!("{within}within = [0.2, 0.0]\n")).expect_err("turned").to_string();
    assert!(turned.contains("within 0.2 to 0"), "{turned}");
    let figure = format!("{GOOD}[case.figure]\n{}", axes.replacen("label", "range = [5.0, 1.0], label", 1));
    let range = read(&figure).expect_err("turned").to_string();
    assert!(range.contains("range 5 to 1 along x"), "{range}");
    let over = "[[case.figure.series]]\nname = \"s\"\nrun = \"*\"\nover = 0.0\n";
    let nought = read(&format!("{GOOD}[case.figure]\n{axes}{over}")).expect_err("over 0").to_string();
    assert!(nought.contains("by 0"), "{nought}");
}
