//! `--quiet` and `--verbose`, the same for all programs.

use std::path::Path;

use protocol::loudness;

/// How much a program says.
#[derive(Clone, Copy, Debug, clap::Args)]
pub struct Loudness {
    /// Say nothing but warnings, errors and the path of the result
    #[arg(short, long, global = true, conflicts_with = "verbose")]
    quiet: bool,
    /// Say more: the plan, what the solvers say of themselves, the commands that are started, checkpoints
    #[arg(short, long, global = true)]
    verbose: bool,
}

impl Loudness {
    /// From here on.
    pub fn set(self) {
        loudness::set(self.quiet, self.verbose);
    }

    /// The option that asks another of our programs for as much.
    pub fn option() -> Option<&'static str> {
        [(loudness::is_quiet(), "--quiet"), (loudness::is_verbose(), "--verbose")]
            .into_iter()
            .find_map(|(is, option)| is.then_some(option))
    }
}

/// Says where the result is; quietly the path alone, on stdout.
pub fn done(program: &str, folder: &Path, more: &str) {
    if loudness::is_quiet() {
        protocol::show!("{}", folder.display());
    } else {
        protocol::say!("{program}: done, see {}{more}", folder.display());
    }
}
