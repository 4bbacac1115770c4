//! Checkpoint files: everything that decides the next step, framed so that a truncated or foreign file
//! is refused before it is believed.
//!
//! Layout: 8 bytes `BEDLOAD\n`, u64 version, u64 length of the payload, 32 bytes SHA-256 of the payload,
//! the payload (bincode of the identity of the scene, then of the state). Little-endian.

use std::fs::File;
use std::io::{self, BufReader, BufWriter, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

use serde::Serialize;
use serde::de::DeserializeOwned;

use crate::log::codec;
use crate::new_file::{Digested, new_file};
use crate::participant::SolverError;

const MAGIC: [u8; 8] = *b"BEDLOAD\n";
const VERSION: u64 = 15;
const HEAD: usize = 8 + 8 + 8 + 32;

/// Bytes that are read or written at once.
const CHUNK: usize = 1 << 16;

/// Most bytes of the identity of a scene, which is a digest as text.
const MOST_IDENTITY: u64 = 1 << 10;

/// SHA-256 of a payload: tells a file that belongs to another from one that only has its name.
pub type Digest = [u8; 32];

/// File of `role` in `folder`.
pub fn path(folder: &Path, role: &str) -> PathBuf {
    folder.join(format!("{role}.checkpoint"))
}

/// Writes `state` of `role` whole or not at all: to a file beside, then renamed. It goes to the file as it is
/// encoded, so that a state may borrow what is large and no second copy of it is made.
///
/// # Errors
/// [`SolverError::File`] if the disk refuses.
pub fn write<T: Serialize>(folder: &Path, role: &str, identity: &str, state: &T) -> Result<(), SolverError> {
    write_part(folder, role, identity, state).map(drop)
}

/// [`write()`], and the digest by which another file can name this one.
///
/// # Errors
/// As [`write()`].
pub fn write_part<T: Serialize>(
    folder: &Path,
    role: &str,
    identity: &str,
    state: &T,
) -> Result<Digest, SolverError> {
    let target = path(folder, role);
    let fail = |path: &Path, source| SolverError::File { path: path.display().to_string(), source };
    // Its parent is the run's: where that is gone, the run is.
    match std::fs::create_dir(folder) {
        Err(error) if error.kind() != io::ErrorKind::AlreadyExists => return Err(fail(folder, error)),
        _ => {}
    }
    let beside = target.with_extension("partial");
    let written = new_file(&beside)
        .and_then(|file| frame(file, &(identity, state)))
        .and_then(|digest| std::fs::rename(&beside, &target).map(|()| digest))
        .and_then(|digest| File::open(folder)?.sync_all().map(|()| digest));
    written.map_err(|error| {
        // Half a file keeps a full disk full.
        let _ = std::fs::remove_file(&beside);
        fail(&target, error)
    })
}

/// Head and payload. Length and digest, which stand before the payload, are known after it.
fn frame(mut file: File, payload: &impl Serialize) -> io::Result<Digest> {
    file.write_all(&[0; HEAD])?;
    let mut out = BufWriter::with_capacity(CHUNK, Digested::new(file));
    // an error of the file is kept: what the codec makes of it is a text
    if let Err(error) = codec::encode(payload, &mut out) {
        return Err(out.flush().err().unwrap_or_else(|| io::Error::other(error)));
    }
    let written = out.into_inner().map_err(io::IntoInnerError::into_error)?;
    let (digest, length) = (written.digest(), written.length);
    let mut file = written.to;
    file.seek(SeekFrom::Start(0))?;
    let head = [&MAGIC[..], &VERSION.to_le_bytes(), &length.to_le_bytes(), &digest].concat();
    file.write_all(&head)?;
    file.sync_data()?;
    Ok(digest)
}

/// Reads what [`write()`] wrote for the same role and scene.
///
/// # Errors
/// [`SolverError`] if the file is missing, truncated, damaged, of another version or of another scene.
pub fn read<T: DeserializeOwned>(folder: &Path, role: &str, identity: &str) -> Result<T, SolverError> {
    let mut payload = open(folder, role, identity)?;
    let state = payload.part()?;
    payload.end()?;
    Ok(state)
}

/// Reads what [`write()`] wrote for the same role, with the identity of its scene, whichever that is.
///
/// # Errors
/// [`SolverError`] if the file is missing, truncated, damaged or of another version.
pub fn read_any<T: DeserializeOwned>(folder: &Path, role: &str) -> Result<(String, T), SolverError> {
    let mut payload = Payload::open(path(folder, role))?;
    let whole = (payload.identity()?, payload.part()?);
    payload.end()?;
    Ok(whole)
}

/// Opens what [`write()`] wrote for the same role and scene, to be taken part by part. It was read once, and
/// is whole.
///
/// # Errors
/// As [`read`].
pub fn open(folder: &Path, role: &str, identity: &str) -> Result<Payload, SolverError> {
    let (written_by, payload) = open_any(folder, role)?;
    if written_by != identity {
        let why = "was written by another scene: resume with the scene that wrote it, or start anew";
        return Err(payload.refuse(why));
    }
    Ok(payload)
}

/// Opens what [`write()`] wrote for the same role, with the identity of its scene, whichever that is.
///
/// # Errors
/// As [`read_any`].
pub fn open_any(folder: &Path, role: &str) -> Result<(String, Payload), SolverError> {
    let mut payload = Payload::open(path(folder, role))?;
    Ok((payload.identity()?, payload))
}

/// The digest of what [`write()`] wrote for a role, by its head alone; none where there is no such file.
pub fn digest(folder: &Path, role: &str) -> Option<Digest> {
    let mut head = [0; HEAD];
    crate::input_file::open(&path(folder, role)).ok()?.read_exact(&mut head).ok()?;
    head[24..].try_into().ok()
}

/// The payload of a checkpoint, read from its file part by part: the fields of a struct are parts, as are the
/// number of entries of a list and each of them.
#[derive(Debug)]
pub struct Payload {
    path: PathBuf,
    file: BufReader<File>,
    left: u64,
    digest: Digest,
}

impl Payload {
    /// Checks the frame and stands at the payload's beginning.
    fn open(path: PathBuf) -> Result<Self, SolverError> {
        let file = crate::input_file::open(&path);
        let file = file.map_err(|source| SolverError::File { path: path.display().to_string(), source })?;
        let mut payload =
            Self { path, file: BufReader::with_capacity(CHUNK, file), left: 0, digest: [0; 32] };
        let mut head = [0; HEAD];
        if payload.file.read_exact(&mut head).is_err() || head[..8] != MAGIC {
            let why = "is not a Bedload checkpoint, or was cut short: start anew without --resume";
            return Err(payload.refuse(why));
        }
        let word = |at: usize| u64::from_le_bytes(std::array::from_fn(|k| head[at + k]));
        if word(8) != VERSION {
            return Err(payload.refuse(&format!("has version {}, this build reads {VERSION}", word(8))));
        }
        let mut digested = Digested::new(io::sink());
        let whole = io::copy(&mut payload.file, &mut digested);
        whole.and_then(|_| payload.file.seek(SeekFrom::Start(HEAD as u64))).map_err(|e| payload.fail(e))?;
        payload.left = word(16);
        payload.digest = digested.digest();
        if digested.length != payload.left || payload.digest[..] != head[24..] {
            return Err(payload.refuse("is truncated or damaged: start anew without --resume"));
        }
        Ok(payload)
    }

    /// The first part. A text is as long as it says, so that is looked at before memory is asked for.
    fn identity(&mut self) -> Result<String, SolverError> {
        let length: u64 = self.part()?;
        if length > MOST_IDENTITY.min(self.left) {
            let why = format!("names its scene in {length} bytes: start anew without --resume");
            return Err(self.refuse(&why));
        }
        let mut bytes = vec![0; length as usize];
        self.file.read_exact(&mut bytes).map_err(|error| self.fail(error))?;
        self.left -= length;
        String::from_utf8(bytes).map_err(|error| self.refuse(&error.to_string()))
    }

    /// The next part.
    ///
    /// # Errors
    /// [`SolverError`] if it is not a `T`.
    pub fn part<T: DeserializeOwned>(&mut self) -> Result<T, SolverError> {
        let mut rest = (&mut self.file).take(self.left);
        let part = codec::decode_from(&mut rest);
        self.left = rest.limit();
        part.map_err(|error| self.refuse(&error.to_string()))
    }

    /// The next part, a list of `count` numbers: those from number `from` on go to `values`, the others are
    /// passed over.
    ///
    /// # Errors
    /// [`SolverError`] if the list has another length, or ends before `values` does.
    pub fn fill(&mut self, values: &mut [f64], count: usize, from: usize) -> Result<(), SolverError> {
        let (stored, wanted) = (self.part::<u64>()?, count as u64);
        let Some(behind) = count.checked_sub(from + values.len()).filter(|_| stored == wanted) else {
            let why = format!("holds a field of {stored} numbers where {wanted} are asked for: start anew");
            return Err(self.refuse(&why));
        };
        if self.left / 8 < wanted {
            return Err(self.refuse(&format!("ends within a field of {wanted} numbers: start anew")));
        }
        self.pass_over(from)?;
        self.numbers(values)?;
        self.pass_over(behind)?;
        self.left -= 8 * wanted;
        Ok(())
    }

    /// The next part, a list of numbers, however many.
    ///
    /// # Errors
    /// [`SolverError`] if the payload ends before the list does.
    pub fn list(&mut self) -> Result<Vec<f64>, SolverError> {
        let count: u64 = self.part()?;
        if self.left / 8 < count {
            return Err(self.refuse(&format!("ends within a field of {count} numbers: start anew")));
        }
        let mut values = vec![0.0; count as usize];
        self.numbers(&mut values)?;
        self.left -= 8 * count;
        Ok(values)
    }

    /// Reads as many numbers as there is room for.
    fn numbers(&mut self, values: &mut [f64]) -> Result<(), SolverError> {
        let mut chunk = [0; 4096];
        for values in values.chunks_mut(chunk.len() / 8) {
            let bytes = &mut chunk[..8 * values.len()];
            self.file.read_exact(bytes).map_err(|error| self.fail(error))?;
            for (value, bytes) in values.iter_mut().zip(bytes.as_chunks::<8>().0) {
                *value = f64::from_le_bytes(*bytes);
            }
        }
        Ok(())
    }

    fn pass_over(&mut self, numbers: usize) -> Result<(), SolverError> {
        self.file.seek_relative(8 * numbers as i64).map_err(|error| self.fail(error))
    }

    /// To be called after the last part.
    ///
    /// # Errors
    /// [`SolverError`] if something is left.
    pub fn end(&self) -> Result<(), SolverError> {
        match self.left {
            0 => Ok(()),
            left => Err(self.refuse(&format!("{left} bytes are left over"))),
        }
    }

    /// Digest of the payload.
    pub fn digest(&self) -> &Digest {
        &self.digest
    }

    fn fail(&self, source: io::Error) -> SolverError {
        SolverError::File { path: self.path.display().to_string(), source }
    }

    /// The error that this file is no good, and why.
    pub fn refuse(&self, why: &str) -> SolverError {
        SolverError::Failed(format!("{}: {why}", self.path.display()))
    }
}
