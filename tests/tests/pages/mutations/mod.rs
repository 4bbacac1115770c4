//! Whatever stands in a file: no panic, no hang, no gigabyte asked for, and an error that names the file.
//!
//! Right files (scenes of this tree, a table of grains, a log and checkpoints of a run) are changed at
//! random, in bytes, lines and numbers, and read again.

mod edits;
mod files;

use std::panic::AssertUnwindSafe;
use std::path::Path;
use std::time::Duration;

use bedload_program::{RunOptions, Solver};
use bedload_scene::CheckedScene;
use dem_solver::participant::DemParticipant;
use fluid_solver::participant::Fluid;
use proptest::prelude::*;
use proptest::test_runner::{Config, TestRunner};
use protocol::checkpoint;
use protocol::log::{LogReader, Topic, flip_bit, repair};
use protocol::participant::Participant;
use tests::harness::Folder;

use edits::{Edit, apply, edits};

/// Address space that reading may take beyond what the test has at its start, bytes.
const MORE: u64 = 1 << 30;
/// What takes longer hangs.
const HANGS: Duration = Duration::from_secs(300);

/// Variable with the factor by which more cases are tried than in a quick test.
const FACTOR: &str = "BEDLOAD_MUTATIONS";

/// Checks `property` with `cases` lists of edits in a thread that has a limit of time, in a process that has
/// one of memory.
fn holds(cases: u32, property: impl Fn(&[Edit]) -> Result<(), TestCaseError> + Send + 'static) {
    limit_memory();
    let factor = std::env::var(FACTOR).ok().and_then(|text| text.parse::<u32>().ok()).unwrap_or(1);
    let (tell, told) = std::sync::mpsc::channel();
    std::thread::spawn(move || {
        let cases = cases * factor;
        // A failure is told with its edits; files of failures in the tree would be of one machine.
        let config = Config { cases, failure_persistence: None, max_shrink_iters: 200, ..Config::default() };
        let run = || TestRunner::new(config).run(&edits(), |edits| property(&edits));
        let outcome = std::panic::catch_unwind(AssertUnwindSafe(run));
        let _ = tell.send(outcome.map_err(|_| "a panic outside of a case".to_owned()));
    });
    match told.recv_timeout(HANGS * factor).expect("no case hangs").expect("runs") {
        Ok(()) => {}
        Err(failure) => panic!("{failure}"),
    }
}

/// Beyond [`MORE`] an allocation fails, which ends the test's process.
fn limit_memory() {
    use rustix::process::{Resource, getrlimit, setrlimit};
    static ONCE: std::sync::Once = std::sync::Once::new();
    ONCE.call_once(|| {
        let text = std::fs::read_to_string("/proc/self/statm").expect("Linux");
        let pages: u64 = text.split_whitespace().next().and_then(|word| word.parse().ok()).expect("pages");
        let limit = getrlimit(Resource::As);
        // Each thread of the tests reserves addresses for its stack and its heap.
        let threads = 64 << 20;
        setrlimit(
            Resource::As,
            rustix::process::Rlimit { current: Some(pages * 4096 + MORE + 16 * threads), ..limit },
        )
        .expect("a lower limit");
    });
}

/// What was refused names the file that is wrong.
fn names(error: &str, file: &Path) -> Result<(), TestCaseError> {
    let name = file.file_name().and_then(|name| name.to_str()).expect("UTF-8");
    prop_assert!(error.contains(name), "`{error}` does not name {name}");
    Ok(())
}

/// Reads a scene as `check` does, without another process.
fn read_scene(path: &Path) -> Result<(), String> {
    let scene = RunOptions::of_scene(path).read_scene().map_err(|error| error.to_string())?;
    let fluid = scene.scene.medium.is_some().then(|| Fluid::facts(&scene)).transpose();
    let dem = scene.has_free_grains().then(|| DemParticipant::facts(&scene)).transpose();
    fluid.map_err(|error| error.to_string())?;
    dem.map_err(|error| error.to_string())?;
    Ok(())
}

#[test]
fn a_scene_of_any_text_is_read_or_refused() {
    let scenes = files::scenes();
    let folder = Folder::new("mutated-scenes");
    let path = folder.join("mutated.toml");
    holds(400, move |edits| {
        let base = &scenes[edits.first().map_or(0, |edit| edit.place as usize) % scenes.len()];
        std::fs::write(&path, apply(base, edits)).expect("a file");
        let _keep = &folder;
        read_scene(&path).or_else(|error| names(&error, &path))
    });
}

#[test]
fn a_table_of_grains_of_any_bytes_is_read_or_refused() {
    let folder = Folder::new("mutated-grains");
    let (scene, table) = (folder.write("scene.toml", files::WITH_TABLE), folder.join("mutated.csv"));
    holds(600, move |edits| {
        std::fs::write(&table, apply(files::TABLE.as_bytes(), edits)).expect("a file");
        let _keep = &folder;
        // Where the grains of the table do not go with each other or with the scene, the scene is named.
        read_scene(&scene).or_else(|error| names(&error, &table).or_else(|_| names(&error, &scene)))
    });
}

#[test]
fn a_log_of_any_bytes_is_read_or_refused() {
    let folder = Folder::new("mutated-log");
    let log = files::run(&folder).join("exchange.mcap");
    let bytes = std::fs::read(&log).expect("a log");
    let (path, mended) = (folder.join("mutated.mcap"), folder.join("mended.mcap"));
    holds(400, move |edits| {
        std::fs::write(&path, apply(&bytes, edits)).expect("a file");
        let _keep = &folder;
        read_log(&path)?;
        match repair(&path, &mended) {
            // What is repaired is whole, if it has its beginning.
            Ok(_) => read_log(&mended),
            Err(error) => names(&error.to_string(), &path),
        }
    });
}

fn read_log(path: &Path) -> Result<(), TestCaseError> {
    match LogReader::open_any(path) {
        Ok(reader) => reader.filter_map(Result::err).try_for_each(|error| names(&error.to_string(), path)),
        Err(error) => names(&error.to_string(), path),
    }
}

#[test]
fn a_payload_of_any_bits_is_read_or_refused_though_its_checksums_are_right() {
    let folder = Folder::new("flipped-log");
    let log = files::run(&folder).join("exchange.mcap");
    let path = folder.join("flipped.mcap");
    holds(60, move |edits| {
        let _keep = &folder;
        for edit in edits.iter().take(1) {
            let topics = [Topic::Command, Topic::Loads, Topic::Kinematics, Topic::Status];
            let (topic, bit) = (topics[edit.place as usize % 4], edit.value as usize % 800);
            if flip_bit(&log, &path, topic, edit.place % 10, 0, bit).is_ok() {
                read_log(&path)?;
            }
        }
        Ok(())
    });
}

#[test]
fn a_checkpoint_of_any_bytes_is_refused() {
    checkpoints("mutated-checkpoint", 300, |bytes| bytes);
}

#[test]
fn a_checkpoint_of_any_payload_is_taken_or_refused_though_its_digest_is_right() {
    checkpoints("forged-checkpoint", 300, files::with_digest);
}

/// Reads changed checkpoints of both solvers, after `mend`.
fn checkpoints(name: &str, cases: u32, mend: fn(Vec<u8>) -> Vec<u8>) {
    let folder = Folder::new(name);
    let out = files::run(&folder);
    let from = protocol::checkpoints::newest(&out.join("checkpoint")).expect("a checkpoint");
    let whole = ["fluid", "dem"].map(|role| std::fs::read(checkpoint::path(&from, role)).expect("a file"));
    let mutated = folder.join("mutated");
    std::fs::create_dir_all(&mutated).expect("a folder");
    let scene = RunOptions::of_scene(&folder.join("scene.toml")).read_scene().expect("reads");
    holds(cases, move |edits| {
        let fluid = Fluid::new(&scene, &folder.join("out")).expect("a fluid");
        read_checkpoint(fluid, "fluid", &whole[0], edits, mend, &mutated)?;
        let dem = DemParticipant::new(&scene, &folder.join("out")).expect("a DEM");
        read_checkpoint(dem, "dem", &whole[1], edits, mend, &mutated)
    });
}

fn read_checkpoint(
    mut solver: impl Participant,
    role: &str,
    whole: &[u8],
    edits: &[Edit],
    mend: fn(Vec<u8>) -> Vec<u8>,
    folder: &Path,
) -> Result<(), TestCaseError> {
    let bytes = mend(apply(whole, edits));
    let (path, same) = (checkpoint::path(folder, role), bytes == whole);
    std::fs::write(&path, &bytes).expect("a file");
    match solver.read_checkpoint(folder) {
        Ok(()) => prop_assert!(same || mend(whole.to_vec()) == whole, "taken for a checkpoint"),
        Err(error) => names(&error.to_string(), &path)?,
    }
    Ok(())
}

/// The scene of a path, for the modules of this test.
pub(crate) fn scene_text(path: &Path) -> Vec<u8> {
    std::fs::read(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

/// A scene that is right is read: else the tests above would prove nothing.
#[test]
fn unchanged_files_are_read() {
    let folder = Folder::new("unchanged");
    for (number, scene) in files::scenes().iter().enumerate() {
        let path = folder.join(&format!("{number}.toml"));
        std::fs::write(&path, scene).expect("a file");
        assert_eq!(read_scene(&path), Ok(()), "{}", String::from_utf8_lossy(&scene[..60]));
    }
    let scene = folder.write("scene.toml", files::WITH_TABLE);
    let _ = folder.write("mutated.csv", files::TABLE);
    assert_eq!(read_scene(&scene), Ok(()));
    let read: Result<CheckedScene, _> = RunOptions::of_scene(&scene).read_scene();
    assert_eq!(read.expect("reads").grains.len(), 4);
}
