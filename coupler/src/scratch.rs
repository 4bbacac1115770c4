//! A folder for the time of one question, which nobody else can have made before.

use std::fs::Permissions;
use std::os::unix::fs::PermissionsExt;

/// A new one among the temporary files, ours alone. It goes when this is dropped.
pub(crate) fn scratch() -> Result<tempfile::TempDir, String> {
    let folder =
        tempfile::Builder::new().prefix("bedload-").permissions(Permissions::from_mode(0o700)).tempdir();
    folder.map_err(|error| format!("cannot make a folder: {error}"))
}
