//! Runs of the real programs: small scenes, folders that clean up after themselves, processes found
//! and killed. Whatever does not go as a test expects panics.

use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::{Duration, Instant};

/// A program of the workspace, as cargo built it beside this one.
pub fn program(name: &str) -> PathBuf {
    let own = std::env::current_exe().expect("this program has a path");
    // A test lies in target/<profile>/deps, an example in target/<profile>/examples.
    let mut places = own.ancestors().skip(1).take(2).map(|folder| folder.join(name));
    let missing = "is missing: `cargo build --release` or `cargo test --workspace` builds it";
    places.find(|path| path.is_file()).unwrap_or_else(|| panic!("{name} {missing}"))
}

/// Is a table of the repository stale, by docs/evidence.csv?
pub fn is_stale(table: &str) -> bool {
    let evidence = Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/evidence.csv");
    let text = std::fs::read_to_string(evidence).expect("docs/evidence.csv");
    let line = text.lines().find(|line| line.starts_with(&format!("{table},"))).expect(table);
    !line.ends_with(',')
}

/// A folder that goes when the test ends well.
pub struct Folder(PathBuf);

impl Folder {
    /// An empty folder of its own for the test `name`; tests of one program run at the same time.
    pub fn new(name: &str) -> Self {
        static COUNT: AtomicUsize = AtomicUsize::new(0);
        let own = format!("{}-{}", std::process::id(), COUNT.fetch_add(1, Ordering::Relaxed));
        let path = std::env::temp_dir().join(format!("bedload-test-{name}-{own}"));
        let _ = std::fs::remove_dir_all(&path);
        std::fs::create_dir_all(&path).expect("a folder for the test");
        Self(path)
    }

    /// A path in it.
    pub fn join(&self, name: &str) -> PathBuf {
        self.0.join(name)
    }

    /// Writes a file in it.
    pub fn write(&self, name: &str, text: &str) -> PathBuf {
        let path = self.join(name);
        std::fs::write(&path, text).expect("a file for the test");
        path
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        if !std::thread::panicking() {
            let _ = std::fs::remove_dir_all(&self.0);
        }
    }
}

/// Runs `bedload` with arguments to its end.
pub fn bedload<S: AsRef<std::ffi::OsStr>>(arguments: &[S]) -> Output {
    Command::new(program("bedload")).args(arguments).output().expect("bedload starts")
}

/// Starts `bedload` with arguments, its output captured.
pub fn start<S: AsRef<std::ffi::OsStr>>(arguments: &[S]) -> Child {
    Command::new(program("bedload"))
        .args(arguments)
        .stdin(Stdio::null())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("bedload starts")
}

/// What a program said, for assertions.
pub fn said(output: &Output) -> String {
    format!("{}{}", String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr))
}

/// What headless Chromium says of a page in a window of this size, without network; none where there is no
/// such browser, which is said.
pub fn browse(page: &Path, (width, height): (u32, u32), arguments: &[&str]) -> Option<String> {
    let browser = ["/usr/bin/chromium", "/usr/bin/chromium-browser", "/usr/bin/google-chrome"]
        .into_iter()
        .find(|path| Path::new(path).exists());
    let Some(browser) = browser else {
        println!("no Chromium here: the page was not opened");
        return None;
    };
    let folder = Folder::new("browser");
    let output = Command::new(browser)
        .args(["--headless", "--no-sandbox", "--disable-gpu", "--enable-logging=stderr"])
        .arg(format!("--window-size={width},{height}"))
        .arg(format!("--user-data-dir={}", folder.join("profile").display()))
        .arg("--host-resolver-rules=MAP * ~NOTFOUND")
        .args(arguments)
        .arg(format!("file://{}", page.display()))
        .output()
        .expect("the browser starts");
    Some(said(&output))
}

/// A metric of `summary.json`.
pub fn metric(folder: &Path, name: &str) -> f64 {
    let value = &summary(folder)["metrics"][name]["value"];
    value.as_f64().unwrap_or_else(|| panic!("{name} is {value} in {}", folder.display()))
}

/// `summary.json`.
pub fn summary(folder: &Path) -> serde_json::Value {
    let text = std::fs::read_to_string(folder.join("summary.json")).expect("summary.json");
    serde_json::from_str(&text).expect("summary.json is JSON")
}

/// Runs a scene into `out` with further arguments, to its end.
pub fn complete(scene: &Path, out: &Path, more: &[&str]) {
    let mut arguments = vec!["run", scene.to_str().expect("UTF-8"), "--out", out.to_str().expect("UTF-8")];
    arguments.extend(more);
    let output = bedload(&arguments);
    assert_eq!(output.status.code(), Some(0), "{}", said(&output));
}

/// Numbers of a column of `series.csv`.
pub fn column(out: &Path, name: &str) -> Vec<String> {
    let text = std::fs::read_to_string(out.join("series.csv")).expect("series.csv");
    let mut lines = text.lines().filter(|line| !line.starts_with('#'));
    let place = lines.next().and_then(|head| head.split(',').position(|column| column == name));
    let place = place.unwrap_or_else(|| panic!("no column {name} in {text:.300}"));
    lines.map(|line| line.split(',').nth(place).expect("a cell").to_owned()).collect()
}

/// Waits until `done`, at most `seconds`; says how long it took, if it did not take longer.
pub fn wait_until(seconds: f64, mut done: impl FnMut() -> bool) -> Result<Duration, String> {
    let begin = Instant::now();
    while !done() {
        if begin.elapsed().as_secs_f64() > seconds {
            return Err(format!("not done after {seconds} s"));
        }
        std::thread::sleep(Duration::from_millis(2));
    }
    Ok(begin.elapsed())
}

/// A solver process of a run.
#[derive(Clone, Debug)]
pub struct Solver {
    /// Process id.
    pub pid: u32,
    /// `fluid` or `dem`.
    pub role: &'static str,
    /// Folder of the run in shared memory.
    pub root: PathBuf,
    /// Prefix of its shared-memory segments.
    pub prefix: String,
}

/// The solvers that `parent` has started so far.
pub fn solvers(parent: u32) -> Vec<Solver> {
    children(parent).into_iter().filter_map(solver).collect()
}

/// Processes that a process has started, by any of its threads.
pub fn children(pid: u32) -> Vec<u32> {
    let threads = std::fs::read_dir(format!("/proc/{pid}/task")).into_iter().flatten().flatten();
    let texts =
        threads.map(|thread| std::fs::read_to_string(thread.path().join("children")).unwrap_or_default());
    let text = texts.collect::<Vec<_>>().join(" ");
    text.split_whitespace().filter_map(|pid| pid.parse().ok()).collect()
}

/// All processes that a process has started, and those started by them.
pub fn descendants(pid: u32) -> Vec<u32> {
    let own = children(pid);
    let others = own.iter().flat_map(|pid| descendants(*pid)).collect::<Vec<_>>();
    [own, others].concat()
}

fn solver(pid: u32) -> Option<Solver> {
    let line = std::fs::read(format!("/proc/{pid}/cmdline")).ok()?;
    let words: Vec<String> =
        line.split(|byte| *byte == 0).map(|word| String::from_utf8_lossy(word).into_owned()).collect();
    let role = ["fluid", "dem"].into_iter().find(|role| words[0].ends_with(&format!("bedload-{role}")))?;
    let at = words.iter().position(|word| word == "--connect")?;
    let token: serde_json::Value = serde_json::from_str(words.get(at + 1)?).ok()?;
    Some(Solver {
        pid,
        role,
        root: PathBuf::from(token["root"].as_str()?),
        prefix: token["prefix"].as_str()?.to_owned(),
    })
}

/// Does the process run (a zombie does not)?
pub fn is_alive(pid: u32) -> bool {
    let stat = std::fs::read_to_string(format!("/proc/{pid}/stat")).unwrap_or_default();
    stat.rsplit_once(") ").is_some_and(|(_, rest)| !rest.starts_with('Z') && !rest.starts_with('X'))
}

/// Sends a signal by name (`KILL`, `INT`, `STOP`).
pub fn signal(pid: u32, name: &str) {
    let _ = Command::new("kill").args([&format!("-{name}"), &pid.to_string()]).status().expect("kill");
}

/// What is left of a run in shared memory.
pub fn leftovers(solver: &Solver) -> Vec<PathBuf> {
    let segments = std::fs::read_dir("/dev/shm").into_iter().flatten().flatten().map(|entry| entry.path());
    let of_run =
        |path: &PathBuf| path.file_name().is_some_and(|name| name.to_string_lossy().contains(&solver.prefix));
    let mut left: Vec<PathBuf> = segments.filter(of_run).collect();
    if solver.root.exists() {
        left.push(solver.root.clone());
    }
    left
}

/// A sphere that falls on a wall from a small height in a small, coarse, axisymmetric box: the main
/// job in a second or two. D = g = ρ = 1, ρ_r = 8.
pub const SMALL_BOUNCE: &str = include_str!("scenes/small-bounce.toml");

/// A grain that flies to and fro for hours.
pub const LONG_FLIGHT: &str = include_str!("scenes/long-flight.toml");
