//! The committed tables against this build: a sample of each is made again, and docs/evidence.csv says which
//! are stale.

use std::path::Path;
use std::process::Command;

use tests::harness::{Folder, program, said};

fn root() -> &'static Path {
    Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/.."))
}

fn study(at: &Path, arguments: &[&str]) -> (Option<i32>, String) {
    let output = Command::new(program("bedload")).arg("study").args(arguments).current_dir(at).output();
    let output = output.expect("bedload starts");
    (output.status.code(), said(&output))
}

#[test]
fn every_table_is_what_the_build_gives_or_marked_as_stale() {
    let folder = Folder::new("evidence");
    let out = folder.join("out");
    let (code, words) = study(root(), &["--sample", "--out", out.to_str().expect("UTF-8")]);
    assert_eq!(code, Some(0), "{words}");
    // Pages say it by themselves.
    let page = std::fs::read_to_string(root().join("docs/stability.md")).expect("the page");
    assert!(page.contains("written by bedload study --mark"), "{page}");
}

#[test]
fn a_table_with_another_value_is_stale_until_it_is_made_again() {
    let folder = Folder::new("evidence-changed");
    let copy = |from: &str| {
        let to = folder.join(from);
        std::fs::create_dir_all(to.parent().expect("a folder")).expect("made");
        std::fs::copy(root().join(from), to).expect("copied");
    };
    copy("scenes/oblique-collision.toml");
    copy("scenes/reference/oblique_linear_model.csv");
    copy("docs/charts/oblique-collision.csv");
    let at = folder.join("");
    let (code, words) = study(&at, &["--mark"]);
    assert!(code == Some(0) && words.contains("0 of 1 tables are stale, 0 not sampled"), "{words}");
    assert_eq!(study(&at, &["--sample", "--out", "again"]).0, Some(0));
    let (_, words) = study(&at, &["--all", "--list"]);
    assert!(words.contains("scenes/oblique-collision.toml -> docs/charts/oblique-collision.csv"), "{words}");

    // Another value in the cheapest row.
    let path = folder.join("docs/charts/oblique-collision.csv");
    let text = std::fs::read_to_string(&path).expect("the table");
    let (header, rows) = text.split_once('\n').expect("a header");
    let columns: Vec<&str> = header.split(',').collect();
    let at_column = |name: &str| columns.iter().position(|column| *column == name).expect(name);
    let (value, wall) = (at_column("value"), at_column("wall_s"));
    let time =
        |row: &str| row.split(',').nth(wall).and_then(|cell| cell.parse().ok()).unwrap_or(f64::INFINITY);
    let cheapest = rows.lines().min_by(|a, b| time(a).total_cmp(&time(b))).expect("a row");
    let mut cells: Vec<String> = cheapest.split(',').map(str::to_owned).collect();
    let changed: f64 = cells[value].parse().expect("a value");
    cells[value] = f64::from_bits(changed.to_bits() + 16).to_string();
    std::fs::write(&path, text.replace(cheapest, &cells.join(","))).expect("written");
    let (code, words) = study(&at, &["--sample", "--out", "changed"]);
    assert_eq!(code, Some(1), "{words}");
    assert!(
        words.contains("docs/charts/oblique-collision.csv") && words.contains("bedload study --mark"),
        "{words}"
    );
    assert_eq!(study(&at, &["--mark", "--out", "marked"]).0, Some(0));
    let evidence = std::fs::read_to_string(folder.join("docs/evidence.csv")).expect("the evidence");
    assert!(evidence.contains("value is"), "{evidence}");
}
