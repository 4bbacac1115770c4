//! Work in a pool of threads.

use crate::failure::Failure;

/// Runs `work` in a pool of as many threads as asked.
pub(crate) fn with_threads<T: Send>(threads: usize, work: impl FnOnce() -> T + Send) -> Result<T, Failure> {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().map_err(|error| {
        let remedy = "`--threads` asks for fewer, `ulimit -u` limits them";
        Failure::Run(format!("cannot start {threads} threads: {error}; {remedy}"))
    })?;
    Ok(pool.install(work))
}
