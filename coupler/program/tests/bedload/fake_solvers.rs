//! Solvers for tests of the coupler: the smallest that keep the protocol, and some that break it.
//!
//! A test executable is its own solver: the scene's `command` starts it again with the solver's
//! arguments in `FAKE_ARGS`, and the test named `fake_solver` plays the part.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use bedload_scene::{CheckedScene, SceneSource};
use protocol::channel::{Rendezvous, Wire};
use protocol::message::{Kinematics, Loads};
use protocol::participant::{Exchange, Participant, Role, SolverError, Window, WindowReport};

/// How a fake misbehaves, and in which window: `die:3`.
fn misbehaviour(role: Role) -> (String, u64) {
    let text = std::env::var(format!("FAKE_{role}")).unwrap_or_default();
    let (what, step) = text.split_once(':').unwrap_or((&text, "0"));
    (what.to_owned(), step.parse().unwrap_or(0))
}

/// What a solver itself spoils of what it sends or reports.
const SPOILT: [&str; 26] = [
    "nan",
    "miscount",
    "late",
    "quaternion",
    "outside",
    "jump",
    "overlap",
    "gap",
    "smallest-gap",
    "largest-overlap",
    "time",
    "dt-limit",
    "residual",
    "frozen",
    "drift",
    "spun",
    "gap-infinite",
    "gap-deep",
    "smallest-gap-infinite",
    "smallest-gap-far",
    "contact",
    "impact",
    "grains",
    "substeps",
    "unsent",
    "spaced",
];

/// Those that go on once they have begun.
const LASTING: [&str; 3] = ["frozen", "drift", "spun"];

/// Does what it was told to do in this window; the rest is for the solver.
fn misbehave(role: Role, step: u64) -> Result<&'static str, SolverError> {
    let (what, when) = misbehaviour(role);
    if what == "slow" {
        std::thread::sleep(std::time::Duration::from_millis(20));
    }
    if step < when || step > when && !LASTING.contains(&what.as_str()) {
        return Ok("");
    }
    match what.as_str() {
        "die" => {
            eprintln!("farewell");
            std::process::abort()
        }
        "leave" => std::process::exit(1),
        "hang" => loop {
            std::thread::sleep(std::time::Duration::from_secs(1));
        },
        "paint" => {
            eprintln!("\u{1b}]0;words\u{7}");
            Err(SolverError::Failed("\u{1b}[31mred".into()))
        }
        "fail" => Err(SolverError::Failed("the pressure solver diverged".into())),
        other => Ok(SPOILT.into_iter().find(|word| *word == other).unwrap_or("")),
    }
}

/// The report of a window.
fn report(what: &str, substeps: u64) -> WindowReport {
    let dt_limit = if what == "dt-limit" { f64::NAN } else { f64::INFINITY };
    WindowReport { dt_limit, residual: if what == "residual" { f64::NAN } else { 0.0 }, substeps }
}

/// Drags each grain towards rest: force −velocity.
struct FakeFluid {
    velocity: Vec<[f64; 3]>,
}

impl Participant for FakeFluid {
    type Incoming = Kinematics;
    type Outgoing = Loads;
    const ROLE: Role = Role::Fluid;

    fn grains(&self) -> usize {
        self.velocity.len()
    }

    fn advance(
        &mut self,
        window: &Window,
        exchange: &mut dyn Exchange<Kinematics, Loads>,
    ) -> Result<WindowReport, SolverError> {
        let what = misbehave(Role::Fluid, window.step)?;
        let sick = what == "nan";
        let velocity = &self.velocity;
        exchange.send(window.header(), &mut |out| {
            for (load, v) in out.iter_mut().zip(velocity) {
                *load = Loads { force: v.map(|v| -v), ..Loads::default() };
            }
            if sick {
                out[0].force[1] = f64::NAN;
            }
        })?;
        let velocity = &mut self.velocity;
        exchange.receive(window, &mut |_, motion| {
            for (own, grain) in velocity.iter_mut().zip(motion) {
                *own = grain.velocity;
            }
        })?;
        Ok(report(what, 0))
    }

    fn save(&mut self) {}
    fn restore(&mut self) {}

    fn write_checkpoint(&self, folder: &Path) -> Result<(), SolverError> {
        protocol::checkpoint::write(folder, "fluid", "fake", &self.velocity)
    }

    fn read_checkpoint(&mut self, folder: &Path) -> Result<(), SolverError> {
        self.velocity = protocol::checkpoint::read(folder, "fluid", "fake")?;
        Ok(())
    }

    fn write_fields(&mut self, _: &Window) -> Result<(), SolverError> {
        Ok(())
    }

    fn solver_seconds(&self) -> f64 {
        0.0
    }
}

/// Symplectic Euler on unit masses.
struct FakeDem {
    /// Does it report one grain more?
    miscounts: bool,
    position: Vec<[f64; 3]>,
    velocity: Vec<[f64; 3]>,
    gravity: [f64; 3],
}

impl FakeDem {
    fn step(&mut self, dt: f64, forces: &[[f64; 3]]) {
        for (grain, force) in forces.iter().enumerate() {
            let (velocity, position) = (&mut self.velocity[grain], &mut self.position[grain]);
            for (axis, push) in force.iter().enumerate() {
                velocity[axis] += dt * (push + self.gravity[axis]);
                position[axis] += dt * velocity[axis];
            }
        }
    }
}

impl Participant for FakeDem {
    type Incoming = Loads;
    type Outgoing = Kinematics;
    const ROLE: Role = Role::Dem;

    fn grains(&self) -> usize {
        self.position.len() + usize::from(self.miscounts)
    }

    fn advance(
        &mut self,
        window: &Window,
        exchange: &mut dyn Exchange<Loads, Kinematics>,
    ) -> Result<WindowReport, SolverError> {
        let (what, when) = (misbehave(Role::Dem, window.step)?, misbehaviour(Role::Dem).1);
        self.miscounts = what == "grains";
        let mut forces = Vec::new();
        exchange.receive(window, &mut |_, loads| forces = loads.iter().map(|load| load.force).collect())?;
        for _ in 0..window.substeps {
            self.step(window.dt / window.substeps as f64, &forces);
        }
        let mut header = window.header();
        header.substeps = window.substeps - u64::from(what == "miscount");
        match what {
            "smallest-gap" => header.smallest_gap = f64::NAN,
            "largest-overlap" => header.largest_overlap = f64::NAN,
            "smallest-gap-infinite" => header.smallest_gap = f64::NEG_INFINITY,
            "smallest-gap-far" => header.smallest_gap = 1e308,
            "time" => header.time += 0.5 * window.dt,
            // As if it had done the window after.
            "spaced" => header.step += 1,
            "unsent" => return Ok(report(what, window.substeps)),
            _ => {}
        }
        exchange.send(header, &mut |out| {
            for (grain, motion) in out.iter_mut().enumerate() {
                *motion = Kinematics {
                    position: self.position[grain],
                    velocity: self.velocity[grain],
                    orientation: [1.0, 0.0, 0.0, 0.0],
                    ..Kinematics::default()
                };
            }
            match what {
                "nan" => out[1].velocity[2] = f64::NAN,
                "quaternion" => out[1].orientation = [0.0; 4],
                "outside" => out[1].position[2] = 4.6,
                "jump" => out[1].position[0] += 0.3,
                "overlap" => out[1].position = [2.0, 2.0, 2.8],
                "gap" => out[1].gap = f64::NAN,
                "gap-infinite" => out[1].gap = f64::NEG_INFINITY,
                "gap-deep" => out[1].gap = -1e300,
                "contact" => out[1].contact_force[0] = 1e300,
                "impact" => out[1].impact_speed = -1e300,
                "frozen" => out[0].position[0] = 2.0 + 0.25 * 0.01 * when as f64,
                // 0.08 R in each window beside its velocity.
                "drift" => out[0].position[0] -= 0.04 * (window.step + 1 - when) as f64,
                "spun" => out[0].spin[1] = 50.0,
                _ => {}
            }
        })?;
        if what == "late" {
            // The fluid has the motion, and goes on.
            std::thread::sleep(std::time::Duration::from_millis(50));
        }
        Ok(report(what, if what == "substeps" { 0 } else { window.substeps }))
    }

    fn save(&mut self) {}
    fn restore(&mut self) {}

    fn write_checkpoint(&self, folder: &Path) -> Result<(), SolverError> {
        protocol::checkpoint::write(folder, "dem", "fake", &(&self.position, &self.velocity))
    }

    fn read_checkpoint(&mut self, folder: &Path) -> Result<(), SolverError> {
        (self.position, self.velocity) = protocol::checkpoint::read(folder, "dem", "fake")?;
        Ok(())
    }

    fn write_fields(&mut self, _: &Window) -> Result<(), SolverError> {
        Ok(())
    }

    fn solver_seconds(&self) -> f64 {
        0.0
    }
}

/// The part of a solver, if this process was started to play one; it does not return then.
pub(crate) fn play() {
    let (Ok(arguments), Ok(role)) = (std::env::var("FAKE_ARGS"), std::env::var("FAKE_ROLE")) else { return };
    let words: Vec<&str> = arguments.split('\n').collect();
    if words.first() != Some(&"serve") {
        std::process::exit(64);
    }
    let value = |name: &str| {
        words
            .iter()
            .position(|word| *word == name)
            .and_then(|place| words.get(place + 1))
            .map(|word| (*word).to_owned())
    };
    if misbehaviour(if role == "fluid" { Role::Fluid } else { Role::Dem }).0 == "absent" {
        std::thread::sleep(std::time::Duration::from_secs(60));
    }
    let rendezvous = Rendezvous::parse(&value("--connect").expect("a token")).expect("a good token");
    let out = PathBuf::from(value("--out").expect("a folder"));
    let source = SceneSource::read(Path::new(words[1]), &[]).expect("the resolved scene");
    let scene = CheckedScene::new(source).expect("the resolved scene is good");
    let checkpoint = value("--checkpoint").map(PathBuf::from);
    let n = scene.grains.len();
    let outcome = if role == "fluid" {
        let velocity = scene.grains.iter().map(|grain| grain.velocity.start()).collect();
        serve(FakeFluid { velocity }, &rendezvous, n, &out, checkpoint.as_deref())
    } else {
        let position = scene.grains.iter().map(|grain| grain.position).collect();
        let velocity = scene.grains.iter().map(|grain| grain.velocity.start()).collect();
        serve(
            FakeDem { miscounts: false, position, velocity, gravity: scene.scene.gravity.start() },
            &rendezvous,
            n,
            &out,
            checkpoint.as_deref(),
        )
    };
    match outcome {
        Ok(()) => std::process::exit(0),
        Err(error) => {
            eprintln!("{error}");
            let lost = matches!(error, SolverError::Exchange(_));
            std::process::exit(if lost { 3 } else { 1 });
        }
    }
}

fn serve<P>(
    mut solver: P,
    rendezvous: &Rendezvous,
    grains: usize,
    out: &Path,
    checkpoint: Option<&Path>,
) -> Result<(), SolverError>
where
    P: Participant,
    P::Incoming: Wire<Answer = P::Outgoing>,
{
    if let Some(folder) = checkpoint {
        solver.read_checkpoint(folder)?;
    }
    let mut link = P::Incoming::join(rendezvous, P::ROLE, grains)?;
    protocol::serve::serve(&mut solver, &mut *link, out)
}

/// What the shell does to start this executable as a solver of `role` that misbehaves as told.
pub(crate) fn script(role: &str, what: &str) -> String {
    let own = std::env::current_exe().expect("a test executable");
    format!(
        "IFS='\n'; FAKE_ARGS=\"$*\" FAKE_ROLE={role} FAKE_{role}={what} exec '{}' fake_solver --exact \
         --nocapture --quiet",
        own.display()
    )
}

/// A sphere of diameter 1 over a floor, 16 cells per diameter, ν = 0.01, ρ = 1.
pub(crate) const SPHERE: &str = r#"
until = 1.0
gravity = [0.0, 0.0, -1.0]
[domain]
geometry = "space"
lower = [0.0, 0.0, 0.0]
upper = [4.0, 4.0, 4.0]
cells = [64, 64, 64]
boundary = { x = "periodic", y = "periodic", z = "no-slip" }
[medium]
density = 1.0
viscosity = 0.01
[[grains]]
position = [2.0, 2.0, 2.0]
radius = 0.5
density = 4.0
"#;

/// A scene whose solvers are this test executable, misbehaving as told.
pub(crate) fn scene(fluid: &str, dem: &str, more: &str) -> String {
    let command =
        |role: &str, what: &str| format!("command = [\"sh\", \"-c\", {:?}, \"sh\"]", script(role, what));
    format!(
        r#"title = "fakes"
until = 0.2
gravity = [0.0, 0.0, -1.0]
[domain]
geometry = "space"
lower = [0.0, 0.0, 0.0]
upper = [4.0, 4.0, 4.0]
cells = [64, 64, 64]
boundary = {{ x = "periodic", y = "periodic", z = "no-slip" }}
[medium]
density = 1.0
viscosity = 0.01
[[grains]]
position = [2.0, 2.0, 2.0]
velocity = [0.25, 0.0, 0.0]
radius = 0.5
density = 4.0
[[grains]]
position = [1.0, 1.0, 3.0]
radius = 0.5
density = 4.0
[fluid]
dt = 0.01
{}
[dem]
dt = 0.003
contact = {{ contact_time = 0.06 }}
{}
[coupling]
deadline = 2.0
{more}
"#,
        command("fluid", fluid),
        command("dem", dem)
    )
}

/// A folder of this test alone, removed when dropped.
pub(crate) struct Room(pub(crate) PathBuf);

impl Room {
    pub(crate) fn new(name: &str) -> Self {
        let path = std::env::temp_dir().join(format!("bedload-test-{}-{name}", std::process::id()));
        std::fs::create_dir_all(&path).expect("a temporary folder");
        Self(path)
    }

    /// Writes the scene and returns its path.
    pub(crate) fn put(&self, text: &str) -> PathBuf {
        let path = self.0.join("scene.toml");
        std::fs::write(&path, text).expect("a scene");
        path
    }

    pub(crate) fn out(&self) -> PathBuf {
        self.0.join("out")
    }

    pub(crate) fn read(&self, name: &str) -> String {
        std::fs::read_to_string(self.out().join(name)).unwrap_or_else(|error| panic!("{name}: {error}"))
    }

    pub(crate) fn summary(&self) -> serde_json::Value {
        serde_json::from_str(&self.read("summary.json")).expect("JSON")
    }
}

impl Drop for Room {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

/// `bedload` with arguments.
pub(crate) fn bedload(arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_bedload"));
    command.args(arguments);
    command
}

/// `bedload run SCENE --out OUT more…`, to its end.
pub(crate) fn run(room: &Room, scene: &Path, more: &[&str]) -> Output {
    let out = room.out();
    let mut arguments = vec!["run", scene.to_str().expect("UTF-8"), "--out", out.to_str().expect("UTF-8")];
    arguments.extend(more);
    bedload(&arguments).output().expect("bedload starts")
}

pub(crate) fn stderr(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}
