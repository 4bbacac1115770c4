//! `bedload new`: every template's commands work as they are printed, and nothing is overwritten.

use std::path::Path;
use std::process::{Command, Output};

use tests::harness::{Folder, program, said, summary};

const KINDS: [&str; 7] = ["falling", "bounce", "bed", "column", "silo", "couette", "suspension"];

fn bedload_in(folder: &Path, arguments: &[&str]) -> Output {
    Command::new(program("bedload")).current_dir(folder).args(arguments).output().expect("bedload starts")
}

fn ends_well(output: &Output) -> String {
    assert!(output.status.success(), "{}", said(output));
    String::from_utf8_lossy(&output.stdout).into_owned()
}

/// What stands after `bedload` in the commands that `new` printed.
fn commands(printed: &str) -> Vec<Vec<String>> {
    let lines = printed.lines().filter_map(|line| line.strip_prefix("  bedload "));
    lines.map(|line| line.split_whitespace().map(str::to_owned).collect()).collect()
}

#[test]
fn each_kind_of_the_help_is_tried() {
    let help = ends_well(&bedload_in(Path::new("."), &["new", "--help"]));
    let listed = help.lines().filter_map(|line| line.trim_start().strip_prefix("- ")?.split_once(':'));
    assert_eq!(listed.map(|(kind, _)| kind).collect::<Vec<_>>(), KINDS);
}

/// Runs end early, and beds are made to their end; an ensemble of them is made in `ensemble.rs`.
#[test]
fn the_printed_commands_of_every_template_work() {
    for kind in KINDS {
        let room = Folder::new(&format!("new-{kind}"));
        let printed = ends_well(&bedload_in(&room.join(""), &["new", "it is/mine", "--like", kind]));
        assert!(printed.contains("  cd 'it is/mine'"), "{printed}");
        let (folder, commands) = (room.join("it is/mine"), commands(&printed));
        assert!(commands.len() >= 3, "{printed}");
        for command in commands.iter().filter(|command| command[0] != "ensemble") {
            let mut words: Vec<&str> = command.iter().map(String::as_str).collect();
            let is_bed = ["settle.toml", "fill.toml"].contains(&words[1]);
            if words[0] == "run" && !is_bed {
                let checked = bedload_in(&folder, &["check", words[1]]);
                assert!(!ends_well(&checked).contains("warning"), "{kind}: {}", said(&checked));
                words.extend(["--until", "0.02", "--set", "observe.fields_every=0.01"]);
            }
            let _ = ends_well(&bedload_in(&folder, &words));
            if let ["run", scene, ..] = words[..] {
                let out = folder.join("out").join(scene.trim_end_matches(".toml"));
                assert_eq!(summary(&out)["status"], "completed", "{kind}");
            }
        }
    }
}

#[test]
fn what_is_there_stays() {
    let room = Folder::new("new-twice");
    let scene = room.join("mine/falling.toml");
    let new = |name: &str| bedload_in(&room.join(""), &["new", name, "--like", "falling"]);
    let _ = ends_well(&new("mine"));
    std::fs::write(&scene, "changed").expect("a file");
    for (name, words) in [("mine", "nothing is overwritten"), ("mine/falling.toml/x", "remedy"), ("", "NAME")]
    {
        let output = new(name);
        assert_eq!(output.status.code(), Some(2), "{}", said(&output));
        assert!(said(&output).contains(words), "{}", said(&output));
    }
    assert_eq!(std::fs::read_to_string(scene).expect("the scene"), "changed");
    let quiet = bedload_in(&room.join(""), &["new", "quiet", "--like", "falling", "-q"]);
    assert_eq!(ends_well(&quiet), "quiet\n");
}
