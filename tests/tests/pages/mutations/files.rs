//! The right files that are changed.

use std::path::{Path, PathBuf};

use sha2::{Digest, Sha256};
use tests::harness::{Folder, SMALL_BOUNCE, bedload, said};

/// Scenes of this tree that name no other file, of every geometry and with every section.
const SCENES: [&str; 10] = [
    "bouncing-sphere.toml",
    "settling-square.toml",
    "drafting-discs.toml",
    "settling-discs.toml",
    "haff.toml",
    "settling-disc.toml",
    "repose.toml",
    "settling-rectangle.toml",
    "settling-sphere.toml",
    "silo-small.toml",
];

/// Their texts.
pub(crate) fn scenes() -> Vec<Vec<u8>> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenes");
    SCENES.iter().map(|name| crate::mutations::scene_text(&folder.join(name))).collect()
}

/// A scene whose grains stand in `mutated.csv`.
pub(crate) const WITH_TABLE: &str = r#"
until = 1.0
gravity = [0.0, 0.0, -1.0]

[domain]
geometry = "space"
lower = [0.0, 0.0, 0.0]
upper = [4.0, 4.0, 4.0]
boundary = { x = "no-slip", y = "no-slip", z = "no-slip" }

[[grain_files]]
file = "mutated.csv"

[dem.contact]
law = "linear-spring-dashpot"
restitution = 0.9
contact_time = 0.02
"#;

/// A table as a run leaves it.
pub(crate) const TABLE: &str = "\
# grains: 4
x,y,z,radius,density,vx,vy,vz,wx,wy,wz,motion
1.0,1.0,1.0,0.25,2.0,0.0,0.0,-0.5,0.0,0.0,0.0,free
2.0,1.0,1.0,0.25,2.0,0.0,0.0,-0.5,0.0,0.0,1.0,free
1.0,2.0,1.0,0.25,2.0,0.0,0.0,0.0,0.0,0.0,0.0,fixed
2.0,2.0,1.0,0.25,2.0,1e-3,0.0,-0.5,0.0,0.0,0.0,free
";

/// Runs a small scene to its end in `folder`; its output folder, with log and checkpoints.
pub(crate) fn run(folder: &Folder) -> PathBuf {
    let scene = folder.write("scene.toml", &SMALL_BOUNCE.replace("until = 3.0", "until = 0.1"));
    let out = folder.join("out");
    let output = bedload(&["run", scene.to_str().expect("UTF-8"), "--out", out.to_str().expect("UTF-8")]);
    assert_eq!(output.status.code(), Some(0), "{}", said(&output));
    out
}

/// The bytes of a checkpoint with the length and the digest of the payload that they have now.
pub(crate) fn with_digest(mut bytes: Vec<u8>) -> Vec<u8> {
    if bytes.len() < 56 {
        return bytes;
    }
    let (length, digest) = ((bytes.len() - 56) as u64, Sha256::digest(&bytes[56..]));
    bytes[16..24].copy_from_slice(&length.to_le_bytes());
    bytes[24..56].copy_from_slice(&digest);
    bytes
}
