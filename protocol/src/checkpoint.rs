//! Checkpoint files: everything that decides the next step, framed so that a truncated or foreign file
//! is refused before it is believed.
//!
//! Layout: 8 bytes `BEDLOAD\n`, u64 version, u64 length of the payload, 32 bytes SHA-256 of the payload,
//! the payload (bincode of the identity of the scene, then of the state). Little-endian.

use std::io::Write;
use std::path::{Path, PathBuf};

use serde::Serialize;
use serde::de::DeserializeOwned;
use sha2::{Digest, Sha256};

use crate::log::codec;
use crate::participant::SolverError;

const MAGIC: [u8; 8] = *b"BEDLOAD\n";
const VERSION: u64 = 2;
const HEAD: usize = 8 + 8 + 8 + 32;

/// File of `role` in `folder`.
#[must_use]
pub fn path(folder: &Path, role: &str) -> PathBuf {
    folder.join(format!("{role}.checkpoint"))
}

/// Writes `state` of `role` whole or not at all: to a file beside, then renamed.
///
/// # Errors
/// [`SolverError::File`] if the disk refuses.
pub fn write<T: Serialize>(folder: &Path, role: &str, identity: &str, state: &T) -> Result<(), SolverError> {
    let target = path(folder, role);
    let fail = |path: &Path, source| SolverError::File { path: path.display().to_string(), source };
    let mut payload = Vec::new();
    codec::encode(&(identity, state), &mut payload)
        .map_err(|error| SolverError::Failed(format!("{}: {error}", target.display())))?;
    std::fs::create_dir_all(folder).map_err(|error| fail(folder, error))?;
    let beside = target.with_extension("partial");
    let written = std::fs::File::create(&beside).and_then(|mut file| {
        file.write_all(&MAGIC)?;
        file.write_all(&VERSION.to_le_bytes())?;
        file.write_all(&(payload.len() as u64).to_le_bytes())?;
        file.write_all(&Sha256::digest(&payload))?;
        file.write_all(&payload)?;
        file.sync_data()
    });
    written.map_err(|error| fail(&beside, error))?;
    std::fs::rename(&beside, &target).map_err(|error| fail(&target, error))
}

/// Reads what [`write()`] wrote for the same role and scene.
///
/// # Errors
/// [`SolverError`] if the file is missing, truncated, damaged, of another version or of another scene.
pub fn read<T: DeserializeOwned>(folder: &Path, role: &str, identity: &str) -> Result<T, SolverError> {
    let (scene, state) = read_any(folder, role)?;
    if scene != identity {
        return Err(SolverError::Failed(format!(
            "{}: was written by another scene: resume with the scene that wrote it, or start anew",
            path(folder, role).display()
        )));
    }
    Ok(state)
}

/// Reads what [`write()`] wrote for the same role, with the identity of its scene, whichever that is.
///
/// # Errors
/// [`SolverError`] if the file is missing, truncated, damaged or of another version.
pub fn read_any<T: DeserializeOwned>(folder: &Path, role: &str) -> Result<(String, T), SolverError> {
    let path = path(folder, role);
    let refuse = |why: &str| SolverError::Failed(format!("{}: {why}", path.display()));
    let bytes = std::fs::read(&path)
        .map_err(|source| SolverError::File { path: path.display().to_string(), source })?;
    if bytes.len() < HEAD || bytes[..8] != MAGIC {
        return Err(refuse("is not a Bedload checkpoint, or was cut short: start anew without --resume"));
    }
    let word =
        |at: usize| bytes[at..at + 8].iter().rev().fold(0u64, |sum, byte| (sum << 8) | u64::from(*byte));
    if word(8) != VERSION {
        return Err(refuse(&format!("has version {}, this build reads {VERSION}", word(8))));
    }
    let payload = &bytes[HEAD..];
    if word(16) != payload.len() as u64 || Sha256::digest(payload)[..] != bytes[24..HEAD] {
        return Err(refuse("is truncated or damaged: start anew without --resume"));
    }
    codec::decode(payload).map_err(|error| refuse(&error.to_string()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn damaged_and_foreign_files_are_refused() {
        let folder = std::env::temp_dir().join(format!("bedload-checkpoint-{}", std::process::id()));
        let state = vec![1.0f64, -0.0, 3.5];
        write(&folder, "dem", "scene-a", &state).expect("writes");
        let back: Vec<f64> = read(&folder, "dem", "scene-a").expect("reads");
        assert_eq!(
            back.iter().map(|x| x.to_bits()).collect::<Vec<_>>(),
            state.iter().map(|x| x.to_bits()).collect::<Vec<_>>()
        );
        assert!(
            read::<Vec<f64>>(&folder, "dem", "scene-b")
                .expect_err("foreign")
                .to_string()
                .contains("another scene")
        );
        assert!(read::<Vec<f64>>(&folder, "fluid", "scene-a").is_err());
        let whole = std::fs::read(path(&folder, "dem")).expect("there");
        for end in 0..whole.len() {
            std::fs::write(path(&folder, "dem"), &whole[..end]).expect("writes");
            assert!(read::<Vec<f64>>(&folder, "dem", "scene-a").is_err(), "cut at {end}");
        }
        for at in 0..whole.len() {
            let mut bytes = whole.clone();
            bytes[at] ^= 4;
            std::fs::write(path(&folder, "dem"), &bytes).expect("writes");
            assert!(read::<Vec<f64>>(&folder, "dem", "scene-a").is_err(), "flipped at {at}");
        }
        std::fs::remove_dir_all(&folder).expect("removes");
    }
}
