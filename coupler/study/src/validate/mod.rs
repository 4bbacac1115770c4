//! `bedload validate`: published cases, run and compared with their references.
//!
//! A case is data, `scenes/validation/NAME.toml`: scenes with overrides, numbers to compare,
//! figures. Each run is a `bedload run` of its own, whose output folder stays; a run that is already
//! finished there, of the same scene and version, is not repeated.
//!
//! | file | what it holds |
//! |---|---|
//! | `case`, `case_file` | what a case file holds; read and checked |
//! | `formula` | references and curves given as formulas |
//! | `runs` | the runs of a case, several at a time |
//! | `verdict` | a measured value against its reference |
//! | `differences` | two runs of a case against each other |
//! | `table` | the Markdown page |
//! | `figure` | the SVG figures of a case |
//! | `pictures` | the grains of a run at some instants |

mod case;
mod case_file;
mod differences;
mod figure;
mod formula;
mod pictures;
mod runs;
mod table;
mod verdict;

use std::path::{Path, PathBuf};

use bedload_output::{Claim, atomic_write};

use crate::folder::{self, cannot};
use case::Case;
use coupler::failure::Failure;
use runs::Made;
pub use runs::Validate;
use table::{Drawing, Section};
use verdict::Verdict;

/// Where cases are, seen from the root of the repository.
const CASES: &str = "scenes/validation";

/// Runs the cases, prints the page and writes it with the figures.
///
/// # Errors
/// [`Failure`] if a case is wrong, a file cannot be written or a check failed.
pub fn validate(options: &Validate) -> Result<(), Failure> {
    let cases = chosen(options)?;
    folder::make(&options.out)?;
    let _claim = Claim::of(&options.out)?;
    let figures = options.out.join("figures");
    folder::make(&figures)?;
    let mut sections = Vec::new();
    let (mut failed, mut judged) = (0, 0);
    let all = runs::run_all(&cases, options)?;
    for made in &all {
        let rows = verdict::rows(made);
        failed += rows.iter().filter(|row| row.verdict.is_failure()).count();
        judged += rows.iter().filter(|row| row.verdict != Verdict::Reported).count();
        let drawings = drawings(made)?;
        for drawing in &drawings {
            atomic_write(&figures.join(&drawing.file), drawing.svg.as_bytes())?;
        }
        let apart = differences::measured(made)?;
        sections.push(Section::new(made, &rows, &apart, drawings));
    }
    let page = table::page(options.quick, &sections)?;
    let path = options.out.join("validation.md");
    atomic_write(&path, page.as_bytes())?;
    println!("{page}");
    if failed > 0 {
        return Err(Failure::Run(format!("{failed} of {judged} checks failed; see {}", path.display())));
    }
    println!("{judged} checks passed; {}", path.display());
    Ok(())
}

/// What could be drawn of a case.
fn drawings(made: &Made<'_>) -> Result<Vec<Drawing>, Failure> {
    let mut drawn = Vec::new();
    let mut add = |name: &str, title: &str, svg: Option<String>| {
        let (file, title) = (made.case.file(name), title.to_owned());
        drawn.extend(svg.map(|svg| Drawing { title, file, svg }));
    };
    for figure in made.case.drawn() {
        add(&figure.name, &figure.title, figure::draw(made, figure)?);
    }
    for wanted in &made.case.pictures {
        add(&wanted.name, &wanted.title, pictures::draw(made, wanted)?);
    }
    Ok(drawn)
}

/// The cases asked for; with `--quick` and no names, the quick ones.
fn chosen(options: &Validate) -> Result<Vec<Case>, Failure> {
    if options.cases.is_empty() {
        let folder = Path::new(CASES);
        let entries = std::fs::read_dir(folder).map_err(cannot(
            "find cases (run in the root of the repository, or name case files) in",
            folder,
        ))?;
        let is_case = |path: &PathBuf| path.extension().is_some_and(|end| end == "toml");
        let mut paths: Vec<PathBuf> = entries.flatten().map(|entry| entry.path()).filter(is_case).collect();
        paths.sort();
        let cases: Vec<Case> = paths.iter().map(|path| Case::read(path)).collect::<Result<_, _>>()?;
        return Ok(cases.into_iter().filter(|case| case.quick || !options.quick).collect());
    }
    let path = |name: &String| match name.strip_suffix(".toml") {
        Some(_) => PathBuf::from(name),
        None => Path::new(CASES).join(format!("{name}.toml")),
    };
    options.cases.iter().map(|name| Case::read(&path(name))).collect()
}
