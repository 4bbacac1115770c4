//! The work that a storm falls upon: small, of some tenths of a second, with a checkpoint every 20 ms.

use crate::harness::SMALL_BOUNCE;

/// What is started.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Work {
    Run,
    /// The fluid is driven from the log of a run, and compared.
    Replay,
    /// Three seeds, two at a time.
    Ensemble,
}

/// A kind of work.
#[derive(Debug)]
pub struct Kind {
    /// Its name.
    pub name: &'static str,
    pub(super) work: Work,
    /// Processes that may be killed.
    pub victims: &'static [&'static str],
    text: &'static str,
    replace: &'static [(&'static str, &'static str)],
}

impl Kind {
    /// The scene.
    pub fn scene(&self) -> String {
        let text = self.replace.iter().fold(self.text.to_owned(), |text, (from, to)| text.replace(from, to));
        text + "\n[coupling]\ncheckpoint_every = 0.02\n"
            + if self.name == "coupled, iterated" { ITERATED } else { "" }
    }
}

const ITERATED: &str = "scheme = \"iterated\"\n";

/// All kinds.
pub const KINDS: [Kind; 6] = [
    Kind {
        name: "coupled",
        work: Work::Run,
        victims: &["coupler", "fluid", "dem"],
        text: SMALL_BOUNCE,
        replace: &[("until = 3.0", "until = 20.0")],
    },
    Kind {
        name: "coupled, iterated",
        work: Work::Run,
        victims: &["coupler", "fluid", "dem"],
        text: SMALL_BOUNCE,
        replace: &[("until = 3.0", "until = 6.0")],
    },
    Kind { name: "dry", work: Work::Run, victims: &["coupler", "dem"], text: FALL, replace: &[] },
    Kind { name: "fluid alone", work: Work::Run, victims: &["coupler", "fluid"], text: CAVITY, replace: &[] },
    Kind {
        name: "replay",
        work: Work::Replay,
        victims: &["coupler", "fluid"],
        text: SMALL_BOUNCE,
        replace: &[("until = 3.0", "until = 60.0")],
    },
    Kind { name: "ensemble", work: Work::Ensemble, victims: &["coupler", "dem"], text: FALL, replace: &[] },
];

/// Spheres that fall on a floor.
const FALL: &str = include_str!("../scenes/fall.toml");

/// A driven cavity.
const CAVITY: &str = include_str!("../scenes/cavity.toml");
