//! The commands over studies: `chart`, `stability`, `validate`.

use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};

use bedload_output::{Claim, atomic_write};
use bedload_scene::SceneSource;

use super::folder::{self, cannot, cores};
use super::kind::Kind;
use super::make::{How, make};
use super::stability::counts::Counts;
use super::study::Study;
use super::table::Table;
use super::{case, chart, stability};
use coupler::failure::Failure;

/// Where cases are, seen from the root of the repository.
pub(super) const CASES: &str = "scenes/validation";

/// How a study is made.
#[derive(Clone, Debug, Default)]
pub struct Options {
    /// Folder of runs, table, figure and page; by default out/NAME-KIND, out/validation of cases.
    pub out: Option<PathBuf>,
    /// Runs at a time; by default one for a chart, so that costs are timings, else as many as there are
    /// cores.
    pub jobs: Option<NonZeroUsize>,
    /// Commit of this build.
    pub commit: &'static str,
}

impl Options {
    /// `--out`, or `out/NAME`.
    pub(super) fn folder(&self, name: &str) -> PathBuf {
        self.out.clone().unwrap_or_else(|| Path::new("out").join(name))
    }

    pub(super) fn how(&self, kind: Kind) -> How {
        let jobs = if kind == Kind::Chart { 1 } else { cores() };
        How { jobs: self.jobs.map_or(jobs, usize::from), threads: 1, commit: self.commit }
    }
}

/// Makes the runs of a chart or map that are missing, its table, figure and page; returns the table and its
/// folder.
fn of_scene(scene: &Path, kind: Kind, options: &Options) -> Result<(Table, PathBuf), Failure> {
    let study = Study::read(scene, kind, false)?;
    let out = options.folder(&format!("{}-{}", study.name(), kind.name()));
    let _claim = folder::open(&out, &study.source)?;
    let how = options.how(kind);
    let mut made = make(&[(&study, out.clone())], how)?;
    let table = made.remove(0).table(how.jobs)?;
    atomic_write(&out.join(kind.table()), table.csv().as_bytes())?;
    Ok((table, out))
}

/// Charts a scene, and prints what was found.
///
/// # Errors
/// [`Failure`]; a run that fails is none, unless all do.
pub fn chart(scene: &Path, options: &Options) -> Result<(), Failure> {
    let (table, out) = of_scene(scene, Kind::Chart, options)?;
    let (page, words) = chart::draw(&out)?;
    let csv = out.join(Kind::Chart.table());
    protocol::show!("{words}\n{}\n{}", csv.display(), page.display());
    match table.rows.iter().any(|row| row.point().is_some()) {
        true => Ok(()),
        false => Err(Failure::Run(format!("no run gave an error; the remarks in {} say why", csv.display()))),
    }
}

/// Maps where a scene is stable, and prints how that and the bound go together.
///
/// # Errors
/// [`Failure`]: a wrong section, runs that cannot begin, or a bound that lets failures pass.
pub fn stability(scene: &Path, options: &Options) -> Result<(), Failure> {
    let (table, out) = of_scene(scene, Kind::Stability, options)?;
    let page = stability::draw(&out)?;
    let counts = Counts::of(&table.rows);
    protocol::show!("{counts}\n{}", page.display());
    if counts.failed_accepted > 0 {
        let (failed, page) = (counts.failed_accepted, page.display());
        let what = format!("`check` accepts {failed} of {} runs that failed; see {page}", counts.runs);
        return Err(Failure::Run(what));
    }
    Ok(())
}

/// Runs cases, by name or file (none: all there are), prints their page and writes it with figures and
/// tables. `quick`: only quick runs of quick cases.
///
/// # Errors
/// [`Failure`] if a case is wrong, a file cannot be written or a check failed.
pub fn validate(cases: &[String], quick: bool, options: &Options) -> Result<(), Failure> {
    let studies = chosen(cases, quick)?;
    for (place, study) in studies.iter().enumerate() {
        if let Some(other) = studies[..place].iter().find(|other| other.name() == study.name()) {
            let (name, file) = (study.name(), &other.source.file);
            let what = format!("is {name:?}, as it is in {file}: one would overwrite the other's files");
            return Err(study.source.error("case.name", what, "give each case a name of its own").into());
        }
        if study.points.is_empty() {
            let what = format!("has no run of --quick in {:?}", study.name());
            return Err(study.source.error("case.runs", what, "leave --quick out").into());
        }
    }
    let out = options.folder("validation");
    folder::not_of_a_run(&out)?;
    folder::make(&out)?;
    let _claim = Claim::of(&out)?;
    let folders: Vec<(&Study, PathBuf)> =
        studies.iter().map(|study| (study, out.join(study.name()))).collect();
    for (_, folder) in &folders {
        folder::make(folder)?;
    }
    let runs: usize = studies.iter().map(|study| study.points.len()).sum();
    let how = options.how(Kind::Case);
    let jobs = how.jobs.clamp(1, runs.max(1));
    let made = make(&folders, How { jobs, threads: (cores() / jobs).max(1), ..how })?;
    for made in &made {
        atomic_write(&made.folder.join(Kind::Case.table()), made.table(jobs)?.csv().as_bytes())?;
    }
    let (compared, page) = case::draw(&made, quick, &out)?;
    let path = out.join("validation.md");
    protocol::show!("{page}");
    let case::Compared { checks, misses, failed } = compared;
    if failed > 0 {
        return Err(Failure::Run(format!("{failed} of {checks} checks failed; see {}", path.display())));
    }
    let agree = checks - misses;
    protocol::show!(
        "{agree} of {checks} checks agree, {misses} miss as known, none differs; {}",
        path.display()
    );
    Ok(())
}

/// The cases asked for; with `quick` and no names, the quick ones.
fn chosen(cases: &[String], quick: bool) -> Result<Vec<Study>, Failure> {
    let read = |path: &Path| Study::read(path, Kind::Case, quick).map_err(Failure::from);
    if cases.is_empty() {
        let folder = Path::new(CASES);
        std::fs::read_dir(folder).map_err(cannot(
            "find cases (run in the root of the repository, or name case files) in",
            folder,
        ))?;
        let is_wanted = |path: &PathBuf| -> Result<bool, Failure> {
            let section = super::section::Section::of_text(&SceneSource::read(path, &[])?, Kind::Case)?;
            Ok(section.quick || !quick)
        };
        let mut studies = Vec::new();
        for path in folder::files(folder, "", ".toml") {
            if is_wanted(&path)? {
                studies.push(read(&path)?);
            }
        }
        return Ok(studies);
    }
    let path = |name: &String| match name.strip_suffix(".toml") {
        Some(_) => PathBuf::from(name),
        None => Path::new(CASES).join(format!("{name}.toml")),
    };
    cases.iter().map(|name| read(&path(name))).collect()
}

/// Makes figure and page of a study's folder again; returns the page. None: the folder holds no study.
pub(crate) fn redraw(dir: &Path) -> Option<Result<PathBuf, Failure>> {
    let holds = |kind: Kind| dir.join(kind.table()).exists();
    match (holds(Kind::Chart), holds(Kind::Stability)) {
        (true, _) => Some(chart::draw(dir).map(|(page, _)| page)),
        (_, true) => Some(stability::draw(dir)),
        _ => None,
    }
}
