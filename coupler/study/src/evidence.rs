//! The committed tables of studies, and whether this build still gives what they hold.
//!
//! A sample of each table, its cheapest rows, is made again and compared: to `ROUNDING` where a row says
//! which build made it, and so has all its digits, else to those that it has. A table whose sample differs
//! is stale. `docs/evidence.csv` says which are; the pages that show them repeat it, and `accuracy` refuses
//! them.

use std::path::{Path, PathBuf};

use bedload_output::atomic_write;
use bedload_scene::SceneSource;

use super::commands::{CASES, Options};
use super::folder::{self, content, read};
use super::kind::Kind;
use super::make::make;
use super::section::Section;
use super::study::Study;
use super::table::{Row, Table, cell, parse_csv};
use coupler::accuracy::Class;
use coupler::failure::Failure;

/// What is known of every table, seen from the root of the repository.
pub(crate) const FILE: &str = "docs/evidence.csv";

const SCENES: &str = "scenes";

/// Largest difference from a value that stands in full, over it: sums in another order make less, and pages
/// show four digits.
const ROUNDING: f64 = 1e-6;

/// Longest wall time of a run that is sampled, s.
const LONGEST: f64 = 5.0;

/// Begins the remark of a table none of whose rows can be sampled.
const NOT_SAMPLED: &str = "not sampled";

/// Pages that show tables, and of which kind.
const PAGES: [(&str, Kind); 3] = [
    ("docs/charts.md", Kind::Chart),
    ("docs/stability.md", Kind::Stability),
    ("docs/validation.md", Kind::Case),
];

/// The page that counts promises: they rest on the charts of `accuracy`.
const PROMISES: &str = "docs/promises.md";

/// Around what is written into a page.
const MARKS: [&str; 2] = ["<!-- written by bedload study --mark -->", "<!-- until here -->"];

/// A table of the repository.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Evidence {
    /// The file of its study.
    pub(super) study: PathBuf,
    pub(super) kind: Kind,
    pub(super) path: PathBuf,
}

impl Evidence {
    /// All studies of the repository, in the order in which they are made again: what `accuracy` and bounds
    /// rest on first.
    pub(super) fn all() -> Result<Vec<Self>, Failure> {
        let mut all = Vec::new();
        collect(Path::new(SCENES), &mut all)?;
        if all.is_empty() {
            let what = format!("no study in {SCENES}: run in the root of the repository");
            return Err(Failure::Input(what));
        }
        let rank = |it: &Self| match it.kind {
            Kind::Chart if it.is_promised() => 0,
            Kind::Stability => 1,
            Kind::Case => 2,
            Kind::Chart => 3,
        };
        all.sort_by_key(|it| (rank(it), it.study.clone()));
        Ok(all)
    }

    /// Does `accuracy` rest on it?
    fn is_promised(&self) -> bool {
        Class::ALL.iter().any(|class| Path::new(&class.chart_file()) == self.path)
    }

    /// Name of the table.
    fn stem(&self) -> String {
        self.path.file_stem().unwrap_or_default().to_string_lossy().into_owned()
    }

    /// The table, as it is committed; none if there is none.
    pub(super) fn table(&self) -> Result<Option<Table>, Failure> {
        if self.path.is_file() { Table::read(&self.path).map(Some) } else { Ok(None) }
    }
}

/// Studies in a folder and those below it.
fn collect(folder: &Path, all: &mut Vec<Evidence>) -> Result<(), Failure> {
    for path in folder::files(folder, "", "") {
        if path.is_dir() {
            collect(&path, all)?;
        } else if path.extension().is_some_and(|end| end == "toml") {
            let text = format!("\n{}", read(&path)?);
            let has = |kind: &&Kind| text.contains(&format!("\n[{}]\n", kind.name()));
            for kind in Kind::ALL.iter().filter(has) {
                let stem = match kind {
                    Kind::Case => Section::of_text(&SceneSource::read(&path, &[])?, Kind::Case)?.name,
                    _ => path.file_stem().unwrap_or_default().to_string_lossy().into_owned(),
                };
                let table = Path::new(kind.tables()).join(format!("{stem}.csv"));
                all.push(Evidence { study: path.clone(), kind: *kind, path: table });
            }
        }
    }
    Ok(())
}

/// What the sample of a table says.
#[derive(Clone, Debug, PartialEq)]
struct Sampled {
    labels: Vec<String>,
    /// What differs; nothing where the table is what this build gives.
    stale: String,
}

/// Makes the sample of every table again, and prints which are stale. Writes that into `docs/evidence.csv`
/// and the pages where `mark`; else what is there must say the same.
///
/// # Errors
/// [`Failure::Run`] where it does not; other [`Failure`]s if something cannot be read.
pub fn sample(mark: bool, options: &Options) -> Result<(), Failure> {
    let all = Evidence::all()?;
    let out = options.folder("study-sample");
    let mut lines = vec!["table,study,rows,commit,sample,stale".to_owned()];
    let mut stale: Vec<(Evidence, String)> = Vec::new();
    for evidence in &all {
        let (rows, commit, sampled) = match evidence.table()? {
            None => (0, String::new(), Sampled { labels: Vec::new(), stale: "there is no table".into() }),
            Some(table) => {
                let commit = table.rows.first().map_or(String::new(), |row| row.commit.clone());
                (table.rows.len(), commit, compared(evidence, &table, &out, options)?)
            }
        };
        let state = if sampled.stale.is_empty() { "current" } else { &sampled.stale };
        println!("{}: {state}", evidence.path.display());
        let cells = [
            &evidence.path.display().to_string(),
            &evidence.study.display().to_string(),
            &rows.to_string(),
            &commit,
            &sampled.labels.join(" "),
            &sampled.stale,
        ];
        lines.push(cells.map(|text| cell(text)).join(","));
        if !sampled.stale.is_empty() {
            stale.push((evidence.clone(), sampled.stale));
        }
    }
    let unknown = stale.iter().filter(|(_, why)| why.starts_with(NOT_SAMPLED)).count();
    println!("{} of {} tables are stale, {unknown} not sampled", stale.len() - unknown, all.len());
    let text = lines.join("\n") + "\n";
    if mark {
        atomic_write(Path::new(FILE), text.as_bytes())?;
        return pages(&all, &stale);
    }
    let known = read(Path::new(FILE))?;
    let differs = text.lines().find(|line| !known.lines().any(|other| other == *line));
    differs.map_or(Ok(()), |line| {
        let table = line.split(',').next().unwrap_or_default();
        Err(Failure::Run(format!(
            "{FILE} does not say of {table} what its sample gives: `{line}`; make the table again (bedload study FILE) \
             or mark it: bedload study --mark"
        )))
    })
}

/// Makes the sample of a table again.
fn compared(evidence: &Evidence, table: &Table, out: &Path, options: &Options) -> Result<Sampled, Failure> {
    let labels = chosen(table);
    let sampled = |stale: String| Sampled { labels: labels.clone(), stale };
    let mut study = match Study::read(&evidence.study, evidence.kind, false) {
        Ok(study) => study,
        Err(error) => return Ok(sampled(format!("its study is refused: {}: {}", error.key, error.message))),
    };
    study.points.retain(|point| labels.contains(&point.label));
    study.section.repeat = 1;
    if labels.is_empty() {
        return Ok(sampled(format!("{NOT_SAMPLED}: no row with a result took at most {LONGEST} s")));
    }
    if study.points.len() < labels.len() {
        return Ok(sampled("its rows are not those of its study".into()));
    }
    let out = out.join(format!("{}-{}", study.name(), study.kind.name()));
    folder::make(&out)?;
    let mut made = make(&[(&study, out)], options.how(Kind::Case))?;
    let now = match made.remove(0).table(1) {
        Ok(now) => now,
        Err(failure) => return Ok(sampled(failure.to_string())),
    };
    let (header, cells) = parse_csv(&read(&evidence.path)?).map_err(content(&evidence.path))?;
    let label = header.iter().position(|name| name == "label").unwrap_or(0);
    for row in &now.rows {
        let Some(known) = cells.iter().find(|cells| cells[label] == row.label) else { continue };
        let text = |name: &str| -> String {
            let place = header.iter().position(|column| column == name);
            place.map_or_else(String::new, |place| known[place].clone())
        };
        if let Some(what) = difference(&now, row, &text) {
            return Ok(sampled(format!("{}: {what}", row.label)));
        }
    }
    Ok(sampled(String::new()))
}

/// Labels of the rows that are sampled: the cheapest; of a map, whose older rows have no times, the first of
/// each class.
fn chosen(table: &Table) -> Vec<String> {
    let time = |row: &&Row| row.wall.map_or(f64::INFINITY, |wall| wall.median);
    let mut rows: Vec<&Row> = table.rows.iter().collect();
    if table.kind == Kind::Stability {
        let mut classes = Vec::new();
        rows.sort_by(|a, b| time(a).total_cmp(&time(b)));
        rows.retain(|row| {
            !classes.contains(&row.class) && {
                classes.push(row.class);
                true
            }
        });
    } else {
        rows.retain(|row| row.measured.iter().any(Option::is_some) || row.error.is_some());
        rows.sort_by(|a, b| time(a).total_cmp(&time(b)));
        rows.truncate(1);
        rows.retain(|row| time(row) <= LONGEST);
    }
    rows.iter().map(|row| row.label.clone()).collect()
}

/// What a row that was made again has otherwise than the table, `text` being what stands there in a column.
fn difference(table: &Table, row: &Row, text: &dyn Fn(&str) -> String) -> Option<String> {
    let full = !text("commit").is_empty();
    let compare = |name: &str, value: Option<f64>| {
        let known = text(name);
        let now = value.map_or_else(String::new, |value| value.to_string());
        (!agrees(&known, value, full)).then(|| format!("{name} is {now:?} for {known:?}"))
    };
    if let Some(class) = row.class.filter(|class| class.to_string() != text("verdict")) {
        return Some(format!("is {class} for {}", text("verdict")));
    }
    let values = table.metrics.iter().zip(&row.measured).map(|(name, value)| (name.as_str(), *value));
    let others = match table.kind {
        Kind::Stability => vec![("growth", row.growth)],
        // Of a curve there are errors alone.
        Kind::Chart | Kind::Case => Vec::new(),
    };
    // A case of an older build does not have every value of a run.
    let known = |(name, _): &(&str, Option<f64>)| table.kind != Kind::Case || !text(name).is_empty();
    values.chain(others).filter(known).find_map(|(name, value)| compare(name, value))
}

/// Is a value what stands in a table: to [`ROUNDING`] where it stands there in full, else to the digits that
/// it has?
fn agrees(text: &str, value: Option<f64>, full: bool) -> bool {
    let Ok(known) = text.parse::<f64>() else { return text.is_empty() && value.is_none() };
    let Some(value) = value else { return false };
    if value == known || full {
        return value == known || (value - known).abs() <= ROUNDING * known.abs();
    }
    let (digits, power) = text.split_once('e').unwrap_or((text, "0"));
    let places = digits.split_once('.').map_or(0, |(_, places)| places.len() as i32);
    let unit = 10.0_f64.powi(power.parse::<i32>().unwrap_or(0) - places);
    (value - known).abs() <= 0.5 * unit * (1.0 + 1e-9)
}

/// Says at the head of each page which of its tables are stale.
fn pages(all: &[Evidence], stale: &[(Evidence, String)]) -> Result<(), Failure> {
    let write = |page: &str, of: &dyn Fn(&Evidence) -> bool| {
        let path = Path::new(page);
        if !path.is_file() {
            return Ok(());
        }
        let count = all.iter().filter(|it| of(it)).count();
        let named = |sampled: bool| -> Vec<String> {
            let wanted = |(it, why): &&(Evidence, String)| of(it) && why.starts_with(NOT_SAMPLED) != sampled;
            let name = |(it, _): &(Evidence, String)| format!("`{}`", it.stem());
            stale.iter().filter(wanted).map(name).collect()
        };
        let (differ, unknown) = (named(true), named(false));
        let mut line = if differ.is_empty() {
            format!("Of {count} tables of this page a sample was made again: it is what the build gives")
        } else {
            format!(
                "**Stale**: for a sample of {} of the {count} tables of this page the build gives other values \
                 (`bedload study FILE` makes a table again): {}",
                differ.len(),
                differ.join(", ")
            )
        };
        if !unknown.is_empty() {
            line += &format!("; not sampled, as no run is short enough: {}", unknown.join(", "));
        }
        line += ". What differs: [evidence.csv](evidence.csv).";
        atomic_write(path, with_line(&read(path)?, &folded(&line)).as_bytes())?;
        Ok::<(), Failure>(())
    };
    for (page, kind) in PAGES {
        write(page, &|it: &Evidence| it.kind == kind)?;
    }
    write(PROMISES, &Evidence::is_promised)
}

/// A page with a line below its title, in place of the one that stands there.
fn with_line(page: &str, line: &str) -> String {
    let [begin, end] = MARKS;
    let rest = match (page.find(begin), page.find(end)) {
        (Some(from), Some(to)) if from < to => {
            format!("{}{}", &page[..from], page[to + end.len()..].trim_start_matches('\n'))
        }
        _ => page.to_owned(),
    };
    let (title, rest) = rest.split_once('\n').unwrap_or((&rest, ""));
    format!("{title}\n\n{begin}\n{line}\n{end}\n\n{}", rest.trim_start_matches('\n'))
}

/// Makes the studies of these files; of none, all of the repository in their order, and puts what comes of
/// them into `docs`. Finished runs are not repeated.
///
/// # Errors
/// [`Failure`] of the first study that cannot be made, after all others.
pub fn study(files: &[PathBuf], options: &Options) -> Result<(), Failure> {
    let mut failed = None;
    if files.is_empty() {
        for evidence in Evidence::all()?.iter().filter(|it| it.kind != Kind::Case) {
            let out =
                Path::new("out/study").join(evidence.path.strip_prefix("docs").unwrap_or(&evidence.path));
            let of = Options { out: Some(out.with_extension("")), ..options.clone() };
            let made = one(&evidence.study, evidence.kind, &of)
                .and_then(|()| install(evidence, &out.with_extension("")));
            failed = failed.or(made.err());
        }
        let out = PathBuf::from("out/study/validation");
        let made =
            super::commands::validate(&[], false, &Options { out: Some(out.clone()), ..options.clone() });
        failed = failed.or(made.err()).or(install_cases(&out).err());
        return failed.map_or(Ok(()), Err);
    }
    // Of several files, each has a folder of its own in that of --out.
    let own = |file: &Path| match (&options.out, file.file_stem()) {
        (Some(out), Some(stem)) if files.len() > 1 => {
            Options { out: Some(out.join(stem)), ..options.clone() }
        }
        _ => options.clone(),
    };
    for (place, file) in files.iter().enumerate() {
        let same = |other: &&PathBuf| other.file_stem() == file.file_stem();
        if let Some(other) = files[..place].iter().find(same).filter(|_| options.out.is_some()) {
            let what = format!("has the name of {}: both would write into one folder", other.display());
            return Err(content(file)(what));
        }
        let source = SceneSource::read(file, &[])?;
        let mut any = false;
        for kind in Kind::ALL {
            if Section::find(&source, kind)?.is_some() {
                any = true;
                failed = failed.or(one(file, kind, &own(file)).err());
            }
        }
        if !any {
            let what = "holds no study: it has none of [chart], [stability] and [case]".to_owned();
            return Err(content(file)(what));
        }
    }
    failed.map_or(Ok(()), Err)
}

fn one(file: &Path, kind: Kind, options: &Options) -> Result<(), Failure> {
    match kind {
        Kind::Chart => super::commands::chart(file, options),
        Kind::Stability => super::commands::stability(file, options),
        Kind::Case => super::commands::validate(&[file.display().to_string()], false, options),
    }
}

/// Puts table and figure of a chart or map into `docs`.
fn install(evidence: &Evidence, out: &Path) -> Result<(), Failure> {
    let stem = evidence.stem();
    let (name, figure) = match evidence.kind {
        Kind::Stability => ("stability.svg", format!("docs/figures/map-{stem}.svg")),
        Kind::Chart | Kind::Case => ("chart.svg", format!("docs/figures/chart-{stem}.svg")),
    };
    copy(&out.join(evidence.kind.table()), &evidence.path)?;
    copy(&out.join(name), Path::new(&figure))
}

/// The same of all cases, with their page.
fn install_cases(out: &Path) -> Result<(), Failure> {
    for path in folder::files(Path::new(CASES), "", ".toml") {
        let name = Section::of_text(&SceneSource::read(&path, &[])?, Kind::Case)?.name;
        let table = Path::new(Kind::Case.tables()).join(format!("{name}.csv"));
        copy(&out.join(name).join(Kind::Case.table()), &table)?;
    }
    for figure in folder::files(&out.join("figures"), "", ".svg") {
        copy(&figure, &Path::new("docs/figures").join(figure.file_name().unwrap_or_default()))?;
    }
    copy(&out.join("validation.md"), Path::new("docs/validation.md"))
}

fn copy(from: &Path, to: &Path) -> Result<(), Failure> {
    Ok(atomic_write(to, read(from)?.as_bytes())?)
}

/// Prints all studies of the repository in their order, with the time that making each takes by its rows.
pub fn list() -> Result<(), Failure> {
    let (mut total, mut unknown) = (0.0, 0);
    println!("{:>6} {:>9}  study -> table", "runs", "minutes");
    for evidence in Evidence::all()? {
        let table = evidence.table()?;
        let seconds = table.as_ref().and_then(Table::seconds);
        let rows = table.map_or(0, |table| table.rows.len());
        match seconds {
            Some(seconds) => total += seconds,
            None => unknown += rows.max(1),
        }
        let minutes = seconds.map_or_else(|| "?".to_owned(), |seconds| format!("{:.1}", seconds / 60.0));
        println!("{rows:>6} {minutes:>9}  {} -> {}", evidence.study.display(), evidence.path.display());
    }
    println!(
        "{:.1} hours of runs one after the other; of {unknown} runs the time is not known",
        total / 3600.0
    );
    Ok(())
}

/// A paragraph in lines of at most 110 characters, where words allow it.
fn folded(text: &str) -> String {
    let mut lines = vec![String::new()];
    for word in text.split_whitespace() {
        let line = lines.last_mut().expect("one line at least");
        if line.is_empty() {
            line.push_str(word);
        } else if line.chars().count() + 1 + word.chars().count() <= 110 {
            *line += &format!(" {word}");
        } else {
            lines.push(word.to_owned());
        }
    }
    lines.join("\n")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_value_agrees_to_the_digits_that_stand_there_and_in_full_but_for_rounding() {
        for (text, value) in [("19.75", 19.7512), ("2.000e-5", 2.0004e-5), ("0.1", 0.1), ("1250", 1250.3)] {
            assert!(agrees(text, Some(value), false), "{text}");
        }
        for (text, value) in [("19.75", 19.7551), ("2.000e-5", 2.0006e-5), ("", 1.0), ("1250", 1251.0)] {
            assert!(!agrees(text, Some(value), false), "{text}");
        }
        assert!(agrees("0.1", Some(0.1 * (1.0 + 0.9e-6)), true));
        assert!(!agrees("0.1", Some(0.1 * (1.0 + 1.1e-6)), true));
        assert!(agrees("", None, true) && !agrees("0.1", None, false));
    }

    #[test]
    fn a_page_has_one_line_below_its_title() {
        let once = with_line("# Charts\n\nText.\n", "A.");
        assert_eq!(once, format!("# Charts\n\n{}\nA.\n{}\n\nText.\n", MARKS[0], MARKS[1]));
        assert_eq!(with_line(&with_line(&once, "B."), "A."), once);
    }

    #[test]
    fn the_cheapest_row_is_sampled_and_of_a_map_one_of_each_class() {
        let chart = super::super::table::tests::chart(&[
            (8.0, "a", 2.0, 0.1),
            (4.0, "a", 1.0, 0.2),
            (16.0, "a", 9.0, 0.0),
        ]);
        assert_eq!(chosen(&chart), ["a-4"]);
        let map = "x,verdict,growth,bound_margin,label,note,refused\n\
                   1,stable,0,,a,,0\n2,stable,0,,b,,0\n3,failed,1,,c,,1\n";
        assert_eq!(chosen(&Table::parse(map).unwrap()), ["a", "c"]);
    }
}
