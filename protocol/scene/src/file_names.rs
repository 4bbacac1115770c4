//! Names in a scene that become names of files.

/// Most characters of a name.
const MOST: usize = 100;

/// Files and folders that a run or a command on it writes in the output folder itself.
pub const OUTPUT_FILES: [&str; 23] = [
    "scene.toml",
    "scene.toml.tmp",
    "scene-in-full.toml",
    "summary.json",
    "series.csv",
    "grains.csv",
    "profile.csv",
    "planes.csv",
    "exchange.mcap",
    "plan.json",
    "report.html",
    "film.gif",
    "film.mp4",
    "film",
    "divergence.csv",
    "divergence.svg",
    "oblique.csv",
    "deposit.csv",
    "heap.csv",
    "coarse-grain.csv",
    "coarse-grain.vti",
    "fields",
    "checkpoint",
];

/// What a name of a file may be, in words.
pub const FILE_NAME: &str =
    "1 to 100 letters (a to z, A to Z), digits, `-`, `_` and `.`, not beginning with `.`";

/// Is this the name of a file in one folder, whatever the system: [`FILE_NAME`]?
pub fn is_file_name(name: &str) -> bool {
    let sign = |sign: char| sign.is_ascii_alphanumeric() || "-_.".contains(sign);
    (1..=MOST).contains(&name.len()) && !name.starts_with('.') && name.chars().all(sign)
}

/// Has the output folder a file of its own of this name? Some systems make no difference between small and
/// capital letters.
pub(crate) fn is_taken(name: &str) -> bool {
    OUTPUT_FILES.iter().any(|own| own.eq_ignore_ascii_case(name))
}
