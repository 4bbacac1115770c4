//! A case: values of published cases, compared with their references.
//!
//! A case is data, `scenes/validation/NAME.toml`: scenes with overrides, numbers to compare, figures.
//!
//! | file | what it holds |
//! |---|---|
//! | `check` | the `[case]` section |
//! | `formula` | references and curves given as formulas |
//! | `compare` | a measured value against its reference |
//! | `differences` | two runs of a case, or means over runs, against each other |
//! | `page` | the Markdown page |
//! | `figure` | the SVG figures of a case |
//! | `profile` | two columns of a table that runs left |
//! | `pictures` | the grains of a run at some instants |

pub(crate) mod check;
mod compare;
mod differences;
mod figure;
mod formula;
mod page;
mod pictures;
mod profile;

use std::path::Path;

use bedload_output::atomic_write;

use crate::folder;
use crate::make::Made;
use crate::runs::Outcome;
use crate::section::matches;
use compare::Comparison;
use coupler::failure::Failure;
use page::Drawing;

/// What comparing the values of some cases came to.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Compared {
    /// Values that were compared.
    pub(crate) checks: usize,
    /// Those outside their tolerance by as much as is known.
    pub(crate) misses: usize,
    /// Those that differ, or are missing.
    pub(crate) failed: usize,
}

/// Compares all values, draws the figures into `out/figures`, and writes `out/validation.md`; returns the
/// page, too.
pub(crate) fn draw(all: &[Made<'_>], quick: bool, out: &Path) -> Result<(Compared, String), Failure> {
    let figures = out.join("figures");
    folder::make(&figures)?;
    let mut sections = Vec::new();
    let mut compared = Compared::default();
    for made in all {
        let rows = compare::lines(made);
        let count = |of: &dyn Fn(Comparison) -> bool| rows.iter().filter(|row| of(row.comparison)).count();
        compared.failed += count(&Comparison::is_failure);
        compared.misses += count(&|comparison| comparison == Comparison::Misses);
        compared.checks += count(&|comparison| comparison != Comparison::Reported);
        let unchecked =
            |label: &str| !made.study.section.checks.iter().any(|check| matches(&check.run, label));
        for (point, outcome) in made.runs().filter(|(point, _)| unchecked(&point.label)) {
            if let Outcome::Failed(why) = outcome {
                protocol::say!("bedload: {}/{} failed: {why}", made.study.name(), point.label);
                (compared.failed, compared.checks) = (compared.failed + 1, compared.checks + 1);
            }
        }
        let drawings = drawings(made)?;
        for drawing in &drawings {
            atomic_write(&figures.join(&drawing.file), drawing.svg.as_bytes())?;
        }
        sections.push(page::case(made, &rows, &differences::measured(made)?, drawings));
    }
    let page = page::page(quick, &sections)?;
    atomic_write(&out.join("validation.md"), page.as_bytes())?;
    Ok((compared, page))
}

/// What could be drawn of a case.
fn drawings(made: &Made<'_>) -> Result<Vec<Drawing>, Failure> {
    let section = &made.study.section;
    let mut drawn = Vec::new();
    let mut add = |name: &str, title: &str, svg: Option<String>| {
        let (file, title) = (section.file(name), title.to_owned());
        drawn.extend(svg.map(|svg| Drawing { title, file, svg }));
    };
    for figure in section.drawn() {
        add(&figure.name, &figure.title, figure::draw(made, figure)?);
    }
    for wanted in &section.pictures {
        add(&wanted.name, &wanted.title, pictures::draw(made, wanted)?);
    }
    Ok(drawn)
}
