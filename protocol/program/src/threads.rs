//! Work in a pool of threads.

use protocol::participant::SolverError;

use crate::error::ProgramError;

/// Runs `work` in a pool of as many threads as asked.
pub(crate) fn with_threads<T: Send>(
    threads: usize,
    work: impl FnOnce() -> T + Send,
) -> Result<T, ProgramError> {
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(threads)
        .build()
        .map_err(|error| SolverError::Failed(format!("cannot start {threads} threads: {error}")))?;
    Ok(pool.install(work))
}
