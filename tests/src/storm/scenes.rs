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
const FALL: &str = r#"
title = "Spheres that fall on a floor"
until = 12.0
gravity = [0.0, 0.0, -1.0]

[domain]
geometry = "space"
lower = [0.0, 0.0, 0.0]
upper = [6.0, 6.0, 8.0]
boundary = { x = "no-slip", y = "no-slip", z = "no-slip" }

[[groups]]
count = 60
lower = [0.5, 0.5, 0.5]
upper = [5.5, 5.5, 7.5]
radius = 0.4
density = 1.0
seed = 1

[dem.contact]
law = "linear-spring-dashpot"
restitution = 0.6
contact_time = 0.01
friction = 0.3

[observe]
every = 0.05
"#;

/// A driven cavity.
const CAVITY: &str = r#"
title = "Driven cavity"
until = 12.0

[domain]
geometry = "plane"
lower = [0.0, 0.0]
upper = [1.0, 1.0]
cells = [24, 24]
boundary = { x = "no-slip", z_lower = "no-slip", z_upper = { type = "no-slip", velocity = [1.0, 0.0, 0.0] } }

[medium]
density = 1.0
viscosity = 0.01

[fluid.time]
dt = 0.005

[observe]
every = 0.05
"#;
