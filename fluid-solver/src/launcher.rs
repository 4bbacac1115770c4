//! How many ranks a launcher starts, as far as its words tell: for the memory that a machine must have.

use std::path::Path;

/// What the words of a launcher say.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Launch {
    /// Ranks in all.
    pub ranks: usize,
    /// Ranks on each machine.
    pub on_each: usize,
}

/// Words before the number of ranks.
const RANKS: [&str; 5] = ["-np", "-n", "--np", "--n", "--ntasks"];

/// Words before the number of ranks of each machine.
const ON_EACH: [&str; 5] = ["-npernode", "--npernode", "-ppn", "--ppn", "--ntasks-per-node"];

/// Words that name machines.
const MACHINES: [&str; 7] =
    ["-H", "-host", "--host", "-hostfile", "--hostfile", "-machinefile", "--machinefile"];

/// Launchers that start all ranks on the machine where they are called, unless they are told others.
const LOCAL: [&str; 3] = ["mpirun", "mpiexec", "orterun"];

/// Reads the words of a launcher; nothing if they do not say how many ranks there are.
///
/// ```
/// use fluid_solver::launcher::{Launch, read};
///
/// let words = |text: &str| text.split(' ').map(str::to_owned).collect::<Vec<_>>();
/// assert_eq!(read(&words("mpirun -np 4")), Some(Launch { ranks: 4, on_each: 4 }));
/// assert_eq!(read(&words("mpirun -np 4 --host a,b --npernode 2")), Some(Launch { ranks: 4, on_each: 2 }));
/// assert_eq!(read(&words("srun --ntasks=64")), Some(Launch { ranks: 64, on_each: 1 }));
/// assert_eq!(read(&words("mpirun --bind-to core")), None);
/// ```
pub fn read(words: &[String]) -> Option<Launch> {
    let ranks = number(words, &RANKS)?;
    let named = |word: &String| MACHINES.contains(&word.split('=').next().unwrap_or(word));
    let program = words.first().and_then(|word| Path::new(word).file_name()?.to_str());
    let local = program.is_some_and(|program| LOCAL.contains(&program)) && !words.iter().any(named);
    let on_each = number(words, &ON_EACH).or_else(|| mapped(words));
    Some(Launch { ranks, on_each: on_each.unwrap_or(if local { ranks } else { 1 }).min(ranks) })
}

/// The number after one of `names`, or behind its `=`.
fn number(words: &[String], names: &[&str]) -> Option<usize> {
    let after = words.windows(2).find(|pair| names.contains(&pair[0].as_str())).map(|pair| pair[1].as_str());
    let behind =
        || words.iter().filter_map(|word| word.split_once('=')).find(|(name, _)| names.contains(name));
    after.or_else(|| behind().map(|(_, value)| value))?.parse().ok().filter(|number| *number > 0)
}

/// Ranks of each machine by `ppr:<number>:node`.
fn mapped(words: &[String]) -> Option<usize> {
    let policy = words.iter().find_map(|word| word.split_once("ppr:"))?.1;
    policy.strip_suffix(":node")?.parse().ok().filter(|number| *number > 0)
}

/// Ranks of this run on this machine, if the launcher that started it says so.
pub fn on_this_machine() -> Option<usize> {
    let names = ["OMPI_COMM_WORLD_LOCAL_SIZE", "MPI_LOCALNRANKS"];
    names.iter().find_map(|name| std::env::var(name).ok()?.parse().ok()).filter(|number| *number > 0)
}
