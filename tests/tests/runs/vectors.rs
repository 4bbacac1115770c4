//! Runs give the same bits whatever vectors a machine has.

use std::path::Path;
use std::process::Command;

use tests::harness::{Folder, program, said};

/// Scene and what shortens it: r–z with a film and contacts, plane with points, space with many grains, a dry
/// packing, a bed with films.
const RUNS: [(&str, &[&str]); 5] = [
    ("bouncing-sphere-izard.toml", &["until=0.5"]),
    ("drafting-discs.toml", &["until=0.2", "fluid.method=fictitious-domain"]),
    ("bench/spheres-200.toml", &["until=0.02"]),
    ("bench/packing-8000.toml", &["until=0.002"]),
    ("inclined-bed.toml", &["until=0.02"]),
];

/// What limits the vectors of our kernels.
const LIMITS: [&[(&str, &str)]; 3] =
    [&[], &[("BEDLOAD_VECTORS", "avx2")], &[("BEDLOAD_VECTORS", "baseline")]];

#[test]
fn every_instruction_set_gives_the_same_bits() {
    let scenes = Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenes");
    let folder = Folder::new("vectors");
    let mut differ = Vec::new();
    for (scene, overrides) in RUNS {
        let mut results = LIMITS.iter().enumerate().map(|(k, limits)| {
            let out = folder.join(&format!("{k}"));
            let mut command = Command::new(program("bedload"));
            command.arg("run").arg(scenes.join(scene)).arg("--out").arg(&out);
            command
                .args(["--overwrite", "--no-record", "--set", "observe.every=0.0"])
                .envs(limits.iter().copied());
            command.args(overrides.iter().flat_map(|set| ["--set", set]));
            let output = command.output().expect("bedload starts");
            assert_eq!(output.status.code(), Some(0), "{scene}: {}", said(&output));
            std::fs::read_to_string(out.join("series.csv")).expect("a series")
        });
        let first = results.next().expect("a run");
        assert!(first.lines().count() > 2, "{scene}: {first}");
        for (limits, series) in LIMITS[1..].iter().zip(results) {
            if series != first {
                differ.push(format!("{scene} with {limits:?}"));
            }
        }
    }
    assert!(differ.is_empty(), "{differ:#?}");
}

#[test]
fn vectors_that_are_not_known_are_refused() {
    let mut command = Command::new(program("bedload-dem"));
    let output = command.arg("schema").env("BEDLOAD_VECTORS", "sse9").output().expect("it starts");
    assert_eq!(output.status.code(), Some(2));
    assert!(
        said(&output).contains("BEDLOAD_VECTORS is \"sse9\"; allowed: baseline, avx2"),
        "{}",
        said(&output)
    );
}
