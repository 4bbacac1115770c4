//! `bedload validate`: what a case asks of its runs and does not get is an error, not an empty figure.

use std::path::Path;

use tests::harness::{Folder, bedload, said};

/// A grain that falls onto a floor and comes up again.
const SCENE: &str = r#"
until = 0.2
gravity = [0.0, 0.0, -9.81]
[domain]
geometry = "plane"
lower = [0.0, 0.0]
upper = [1.0, 1.0]
boundary = { x = "no-slip", z = "no-slip" }
[[grains]]
position = [0.5, 0.0, 0.12]
radius = 0.05
density = 1.0
[dem.contact]
law = "linear-spring-dashpot"
restitution = 0.5
contact_time = 0.01
[observe]
every = 0.01
[[metrics]]
name = "z"
kind = "final"
column = "position_z[0]"
"#;

const CASE: &str = r#"
[case]
name = "fall"
title = "A fall"
source = "nobody"
scene = "fall.toml"
[[case.runs]]
label = "a"
[[case.checks]]
run = "*"
metric = "z"
kind = "reported"
"#;

/// What `bedload validate` says of the case with more in it.
fn validated(folder: &Folder, more: &str) -> (Option<i32>, String) {
    folder.write("fall.toml", SCENE);
    let case = folder.write("case.toml", &format!("{CASE}{more}"));
    validate(folder, &[&case])
}

fn validate(folder: &Folder, cases: &[&Path]) -> (Option<i32>, String) {
    let mut words = vec!["validate".as_ref()];
    words.extend(cases.iter().map(|case| case.as_os_str()));
    let out = folder.join("out");
    words.extend(["--out".as_ref(), out.as_os_str()]);
    let output = bedload(&words);
    (output.status.code(), said(&output))
}

#[test]
fn a_difference_without_a_common_place_and_a_figure_without_a_point_are_errors() {
    let folder = Folder::new("case-nothing");
    let difference = |x: &str, within: &str| {
        format!(
            "[[case.differences]]\nname = \"self\"\nruns = [\"a\", \"a\"]\nfile = \"series.csv\"\nx = {x:?}\n\
             y = \"velocity_z[0]\"\n{within}"
        )
    };
    let figure = |x: &str, more: &str| {
        format!(
            "[case.figure]\ntitle = \"F\"\nx = {{ label = \"x\"{x} }}\ny = {{ label = \"z\", metric = \"z\" }}\n\
             series = [{{ name = \"s\", run = \"*\" }}]\n{more}"
        )
    };
    let missing = "points = [{ name = \"p\", file = \"none.csv\", x = \"a\", y = \"b\", source = \"S\" }]\n";
    let (code, text) = validated(&folder, &difference("t", ""));
    assert_eq!(code, Some(0), "{text}");
    for (more, words) in [
        (difference("position_z[0]", ""), "position_z[0] does not ascend"),
        (difference("t", "within = [5.0, 6.0]\n"), "no place that both sides share"),
        (figure(", metric = \"Z\"", ""), "none of its runs has the metric \"Z\""),
        (figure("", ""), "none of its runs has `at`"),
        (figure(", metric = \"z\"", missing), "none.csv"),
        ("[[case.pictures]]\nname = \"g\"\ntitle = \"G\"\nrun = \"a\"\n".to_owned(), "no files of grains"),
    ] {
        let (code, text) = validated(&folder, &more);
        assert_eq!(code, Some(2), "{more}: {text}");
        assert!(text.contains(words), "{more}: {text}");
    }
}

#[test]
fn two_cases_of_one_name_are_refused() {
    let folder = Folder::new("case-twice");
    folder.write("fall.toml", SCENE);
    let cases = ["one.toml", "two.toml"].map(|name| folder.write(name, CASE));
    let (code, text) = validate(&folder, &[&cases[0], &cases[1]]);
    assert_eq!(code, Some(2), "{text}");
    assert!(text.contains("case.name") && text.contains("one.toml"), "{text}");
}

/// A run that fails fails its case, though no check is about it.
#[test]
fn a_run_that_fails_is_named_without_a_check_of_it() {
    let folder = Folder::new("case-unchecked");
    folder.write("fall.toml", SCENE);
    let text = CASE.replace("run = \"*\"", "run = \"a\"").replace(
        "label = \"a\"\n",
        "label = \"a\"\n[[case.runs]]\nlabel = \"b\"\nset = [\"dem.contact.contact_time=0\"]\n",
    );
    let case = folder.write("case.toml", &text);
    let (code, text) = validate(&folder, &[&case]);
    assert_eq!(code, Some(1), "{text}");
    assert!(text.contains("fall/b failed: ") && text.contains("contact_time"), "{text}");
}
