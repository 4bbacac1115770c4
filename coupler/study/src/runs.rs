//! Runs as child processes, several at a time; a finished one is never repeated, one that was interrupted or
//! killed goes on.

use std::ffi::OsString;
use std::os::unix::process::ExitStatusExt;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitStatus, Stdio};
use std::sync::atomic::{AtomicUsize, Ordering};

use bedload_output::{RunStatus, Summary, atomic_write};
use bedload_program::RunOptions;
use bedload_scene::CheckedScene;
use serde::{Deserialize, Serialize};

use super::folder::{cannot, make, remove};
use coupler::accuracy;
use coupler::failure::Failure;
use protocol::checkpoints;

/// Signals by which somebody else ends a run: a hangup, an interrupt, a request to end.
const FROM_OUTSIDE: [i32; 3] = [1, 2, 15];

/// What became of a run.
#[derive(Clone, Debug)]
pub(crate) enum Outcome {
    Done(Box<Summary>),
    /// It left none, and why.
    Failed(String),
}

/// Which earlier runs are not repeated.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Reuse {
    /// Those that reached their end.
    Completed,
    /// Those that failed too: that a setting fails is a result.
    AlsoFailed,
}

impl Reuse {
    /// What a run came to, if its result is to be kept.
    fn outcome(self, summary: Summary) -> Option<Outcome> {
        match summary.status {
            RunStatus::Completed => Some(Outcome::Done(Box::new(summary))),
            RunStatus::Failed | RunStatus::Unstable if self == Self::AlsoFailed => {
                Some(Outcome::Failed(summary.error.unwrap_or_else(|| "the run failed".to_owned())))
            }
            RunStatus::Failed | RunStatus::Unstable | RunStatus::Interrupted => None,
        }
    }
}

/// One `bedload run` to make. What it says goes to a file beside its folder.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Task {
    /// Name in messages.
    pub(crate) name: String,
    pub(crate) scene: PathBuf,
    /// `KEY=VALUE` for `--set`.
    pub(crate) set: Vec<String>,
    pub(crate) folder: PathBuf,
    /// Threads of each solver.
    pub(crate) threads: usize,
}

/// Where a run was made: left beside its folder, for later studies that do not repeat it.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, Serialize)]
pub(crate) struct Origin {
    pub(crate) commit: String,
    /// Model of the processor.
    pub(crate) machine: String,
    /// Other runs that shared the machine, at most.
    pub(crate) beside: usize,
    /// [`CheckedScene::sha256`].
    #[serde(default)]
    pub(crate) scene: String,
    /// [`CheckedScene::inputs_sha256`] as it began.
    #[serde(default)]
    pub(crate) inputs: Vec<String>,
}

impl Origin {
    /// Whether what its run read is what is there now, `inputs`, of which one that is gone says nothing.
    fn read(&self, inputs: &[String]) -> bool {
        let is_same = |(now, then): (&String, &String)| now.is_empty() || now == then;
        self.inputs.len() == inputs.len() && inputs.iter().zip(&self.inputs).all(is_same)
    }
}

/// Model of this machine's processor.
fn machine() -> String {
    let text = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let model = text.lines().find_map(|line| line.strip_prefix("model name")?.split_once(':'));
    model.map_or(std::env::consts::ARCH, |(_, model)| model.trim()).to_owned()
}

/// Makes every run that is not finished, `jobs` at a time; outcomes in the order of the tasks. Fails with
/// [`Failure::Input`] if this program or the folders cannot be had; that of a run that was not carried to an
/// end, once the others have theirs. A run that fails is an outcome.
pub(crate) fn run_all(
    tasks: &[Task],
    jobs: usize,
    reuse: Reuse,
    commit: &str,
) -> Result<Vec<Outcome>, Failure> {
    run_chains(&tasks.chunks(1).collect::<Vec<_>>(), jobs, reuse, commit)
}

/// The same of chains of runs, each of which starts from the one before: what a chain came to is what its
/// last run did, or the first that failed.
pub(crate) fn run_chains(
    chains: &[&[Task]],
    jobs: usize,
    reuse: Reuse,
    commit: &str,
) -> Result<Vec<Outcome>, Failure> {
    let program = std::env::current_exe().map_err(cannot("find", Path::new("bedload")))?;
    for folder in chains.iter().copied().flatten().filter_map(|task| task.folder.parent()) {
        make(folder)?;
    }
    let beside = jobs.min(chains.len()).max(1) - 1;
    let origin = Origin { commit: commit.to_owned(), machine: machine(), beside, ..Origin::default() };
    let outcomes = at_a_time(jobs, chains, |chain| in_turn(chain, &program, reuse, &origin));
    let missing = || Ok(Outcome::Failed("the run was not made".to_owned()));
    outcomes.into_iter().map(|outcome| outcome.unwrap_or_else(missing)).collect()
}

fn in_turn(chain: &[Task], program: &Path, reuse: Reuse, origin: &Origin) -> Result<Outcome, Failure> {
    let mut last = Outcome::Failed("there is no run".to_owned());
    for (place, task) in chain.iter().enumerate() {
        let later = &chain[place + 1..];
        // What started from an earlier state of this run is nothing to keep.
        if !later.is_empty() && !matches!(task.finished(reuse), Ok(Some(_))) {
            for task in later {
                remove(&task.folder.join("summary.json"))?;
            }
        }
        last = match task.outcome(program, reuse, origin)? {
            Outcome::Failed(why) if !later.is_empty() => {
                return Ok(Outcome::Failed(format!("{}: {why}", task.name)));
            }
            outcome => outcome,
        };
    }
    Ok(last)
}

/// What `work` makes of each item, in their order, `jobs` at a time; none where it panicked.
pub(super) fn at_a_time<T: Sync, R: Send>(
    jobs: usize,
    items: &[T],
    work: impl Fn(&T) -> R + Sync,
) -> Vec<Option<R>> {
    let next = AtomicUsize::new(0);
    let worker = || {
        let mut made = Vec::new();
        while let number = next.fetch_add(1, Ordering::Relaxed)
            && let Some(item) = items.get(number)
        {
            made.push((number, work(item)));
        }
        made
    };
    let mut all: Vec<Option<R>> = items.iter().map(|_| None).collect();
    std::thread::scope(|scope| {
        let workers: Vec<_> = (0..jobs.clamp(1, items.len().max(1))).map(|_| scope.spawn(worker)).collect();
        for (number, result) in workers.into_iter().flat_map(|worker| worker.join().unwrap_or_default()) {
            all[number] = Some(result);
        }
    });
    all
}

impl Outcome {
    /// The result, if it left one.
    pub(super) fn summary(&self) -> Option<&Summary> {
        match self {
            Self::Done(summary) => Some(summary),
            Self::Failed(_) => None,
        }
    }
}

impl Task {
    /// What its run reads: with the settings that `accuracy` chooses, where its scene asks for one.
    pub(crate) fn options(&self) -> Result<RunOptions, Failure> {
        let written = RunOptions { overrides: self.set.clone(), ..RunOptions::of_scene(&self.scene) };
        accuracy::resolve(&written).map(|(options, _)| options)
    }

    /// What the same run of the same version left, if it is to be kept.
    pub(crate) fn finished(&self, reuse: Reuse) -> Result<Option<Outcome>, Failure> {
        let scene = self.options()?.read_scene()?;
        Ok(self.left(&scene, &scene.inputs_sha256()).and_then(|summary| reuse.outcome(summary)))
    }

    /// The summary that a run of the same scene, inputs and version left in the folder. An input that is gone
    /// says nothing against it.
    fn left(&self, scene: &CheckedScene, inputs: &[String]) -> Option<Summary> {
        self.summary(scene).filter(|_| self.origin().read(inputs))
    }

    /// Whether a run of `origin` that ended on the way goes on: it left a checkpoint, and began with this
    /// build, scene and inputs.
    fn goes_on(&self, left: Option<&Summary>, origin: &Origin) -> bool {
        let began = self.origin();
        let same = began.commit == origin.commit && began.scene == origin.scene && began.read(&origin.inputs);
        let ended = match left {
            Some(left) => left.status == RunStatus::Interrupted,
            None => !self.folder.join("summary.json").exists(),
        };
        same && ended && checkpoints::newest(&self.folder.join("checkpoint")).is_some()
    }

    /// The summary that a run of the same scene and version left in the folder.
    fn summary(&self, scene: &CheckedScene) -> Option<Summary> {
        let left = Summary::read(&self.folder.join("summary.json")).ok()?;
        (left.scene_sha256 == scene.sha256() && left.version == env!("CARGO_PKG_VERSION")).then_some(left)
    }

    fn outcome(&self, program: &Path, reuse: Reuse, origin: &Origin) -> Result<Outcome, Failure> {
        let scene = match self.options().and_then(|options| Ok(options.read_scene()?)) {
            Ok(scene) => scene,
            Err(failure) => return Ok(Outcome::Failed(failure.to_string())),
        };
        let inputs = scene.inputs_sha256();
        let left = self.left(&scene, &inputs);
        let mut origin = Origin { scene: scene.sha256(), inputs, ..origin.clone() };
        let resume = self.goes_on(left.as_ref(), &origin);
        if left.is_none() && self.folder.join("summary.json").exists() {
            protocol::tell!(
                "bedload: {}: its scene, a file that it reads or the version has changed",
                self.name
            );
        }
        if let Some(outcome) = left.and_then(|summary| reuse.outcome(summary)) {
            let gone = if origin.inputs.iter().any(String::is_empty) {
                "; a state or table that it read is gone"
            } else {
                ""
            };
            protocol::tell!("bedload: {}: finished before{gone}", self.name);
            return Ok(outcome);
        }
        if resume {
            // What goes on began with what was there then.
            origin.inputs = self.origin().inputs;
        }
        self.make(program, reuse, resume, &scene, &origin)
    }

    fn make(
        &self,
        program: &Path,
        reuse: Reuse,
        resume: bool,
        scene: &CheckedScene,
        origin: &Origin,
    ) -> Result<Outcome, Failure> {
        let name = &self.name;
        protocol::tell!("bedload: {name}: {}", if resume { "goes on" } else { "runs" });
        let said = self.beside("log");
        let note = toml::to_string(origin).unwrap_or_default();
        if let Err(error) = atomic_write(&self.beside("origin"), note.as_bytes()) {
            return Ok(Outcome::Failed(error.to_string()));
        }
        let status = match self.start(program, &said, resume) {
            Ok(status) => status,
            Err(error) => return Ok(Outcome::Failed(error.to_string())),
        };
        if let Some(failure) = self.not_carried_out(status, &said) {
            protocol::say!("bedload: {failure}");
            return Err(failure);
        }
        // Only what this run wrote is taken for its result: there was nothing to reuse before it.
        let outcome = match self.summary(scene).and_then(|summary| reuse.outcome(summary)) {
            Some(Outcome::Done(summary)) if status.success() => {
                protocol::tell!("bedload: {name}: done in {:.1} s", summary.cost.wall_s);
                Outcome::Done(summary)
            }
            left => {
                protocol::say!("bedload: {name}: failed, see {}", said.display());
                let plain = || format!("the run ended with {status}, see {}", said.display());
                match left {
                    Some(Outcome::Failed(why)) => Outcome::Failed(why),
                    _ if reuse == Reuse::AlsoFailed => {
                        Outcome::Failed(self.reason(&said).unwrap_or_else(plain))
                    }
                    _ => Outcome::Failed(plain()),
                }
            }
        };
        Ok(outcome)
    }

    /// A run that was not carried to an end says nothing about its scene: neither a check nor a setting
    /// failed.
    fn not_carried_out(&self, status: ExitStatus, said: &Path) -> Option<Failure> {
        let kind = match (status.code(), status.signal()) {
            (Some(5), _) => Failure::Full,
            (Some(7), _) => Failure::InUse,
            // From outside, too, before it could answer.
            (Some(130), _) => Failure::Interrupted,
            (_, Some(signal)) if FROM_OUTSIDE.contains(&signal) => Failure::Interrupted,
            _ => return None,
        };
        let text = std::fs::read_to_string(said).unwrap_or_default();
        let why = text.lines().last().unwrap_or_default();
        let name = &self.name;
        Some(kind(format!("the run {name} was not carried out, so that nothing is judged: {why}")))
    }

    /// Why it was refused, with the scene by its name alone.
    fn reason(&self, said: &Path) -> Option<String> {
        let words = last_words(&std::fs::read_to_string(said).ok()?)?;
        let name = self.scene.file_name().unwrap_or_default().to_string_lossy();
        Some(words.replace(&self.scene.display().to_string(), &name))
    }

    /// A file beside the folder: `FOLDER.log`, what the run said; `FOLDER.origin`, where it was made.
    fn beside(&self, what: &str) -> PathBuf {
        let mut path = OsString::from(&self.folder);
        path.push(format!(".{what}"));
        path.into()
    }

    /// Where it was made; nothing is known of a run of an older build.
    pub(super) fn origin(&self) -> Origin {
        let text = std::fs::read_to_string(self.beside("origin"));
        text.ok().and_then(|text| toml::from_str(&text).ok()).unwrap_or_default()
    }

    fn start(&self, program: &Path, said: &Path, resume: bool) -> Result<ExitStatus, Failure> {
        let log = std::fs::File::create(said).map_err(cannot("write", said))?;
        let mut command = Command::new(program);
        command.arg("run").arg(&self.scene);
        for value in &self.set {
            command.arg("--set").arg(value);
        }
        // A study takes numbers of its runs: fields where its scene asks for them.
        command.args(["--fields-every", "0"]);
        command.arg("--threads").arg(self.threads.to_string()).arg("--out").arg(&self.folder);
        // What is kept was looked at before: a folder of a study is the study's.
        command.arg(if resume { "--resume" } else { "--overwrite" });
        command.env(bedload_program::PARENT, bedload_program::parent_name());
        command.stdin(Stdio::null()).stdout(Stdio::null()).stderr(log);
        command.status().map_err(cannot("start", program))
    }
}

/// Why a run was refused, from what it said: the last line of `bedload`, and the next where that names
/// the bound or the key. Drawn errors begin with a cross.
fn last_words(said: &str) -> Option<String> {
    let lines: Vec<&str> = said.lines().map(str::trim).collect();
    let Some(place) = lines.iter().rposition(|line| line.starts_with("bedload: ")) else {
        return lines.iter().find_map(|line| line.strip_prefix("× ")).map(str::to_owned);
    };
    let first = lines[place].trim_start_matches("bedload: ").trim_end_matches(':');
    let goes_on = lines[place].ends_with(':') || first.ends_with("bound");
    let next = lines.get(place + 1).filter(|line| goes_on && !line.is_empty());
    let next =
        next.map(|line| line.trim_start_matches("bedload-dem: ").trim_start_matches("bedload-fluid: "));
    Some(next.map_or_else(|| first.to_owned(), |next| format!("{first}: {next}")))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_run_that_somebody_else_ended_says_nothing_of_its_scene() {
        let task = Task {
            name: "a".to_owned(),
            scene: "a.toml".into(),
            set: Vec::new(),
            folder: "a".into(),
            threads: 1,
        };
        let ended = |signal: i32| task.not_carried_out(ExitStatus::from_raw(signal), Path::new("a.log"));
        assert!(matches!(ended(15), Some(Failure::Interrupted(_))));
        assert!(matches!(ended(130 << 8), Some(Failure::Interrupted(_))));
        // Killed for want of memory, or for a fault of its own.
        assert!(ended(9).is_none() && ended(11).is_none() && ended(1 << 8).is_none());
    }

    #[test]
    fn a_refusal_is_told_with_the_bound_or_key_that_it_names() {
        let dem = "bedload: note: slow\nbedload: the dem solver refuses the scene (exit code 2):\n\
                   bedload-dem: a.toml:16: dem.dt: makes\n  remedy: shorten\n";
        let bound = "bedload: the plan breaks a stability bound\n  resolution: D/Δx = 4 ≥ 5\n    why: it\n";
        assert_eq!(
            last_words(dem).as_deref(),
            Some("the dem solver refuses the scene (exit code 2): a.toml:16: dem.dt: makes")
        );
        assert_eq!(
            last_words(bound).as_deref(),
            Some("the plan breaks a stability bound: resolution: D/Δx = 4 ≥ 5")
        );
        assert_eq!(
            last_words("\n  × a.toml:3: until: is -1\n   ╭─\n").as_deref(),
            Some("a.toml:3: until: is -1")
        );
        assert_eq!(last_words("progress\n"), None);
    }
}
