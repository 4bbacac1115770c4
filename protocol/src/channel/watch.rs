//! Who lives: iceoryx2's nodes, and the coupler as the solvers' parent process.
//!
//! Nobody is told that a process died, so everyone who waits looks, every [`LOOK_EVERY`].

use std::os::unix::process::parent_id;
use std::path::Path;
use std::time::Duration;

use iceoryx2::config::Config;
use iceoryx2::node::NodeView;
use iceoryx2::prelude::*;

use crate::participant::{ExchangeError, Role};

/// How often a waiting process looks whether the others live.
pub(crate) const LOOK_EVERY: Duration = Duration::from_millis(10);

/// A process of a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Member {
    /// Master of time.
    Coupler,
    /// A solver.
    Solver(Role),
}

impl Member {
    pub(crate) const ALL: [Self; 3] = [Self::Coupler, Self::Solver(Role::Fluid), Self::Solver(Role::Dem)];

    /// Name of its iceoryx2 node.
    #[must_use]
    pub fn node_name(self) -> &'static str {
        match self {
            Self::Coupler => "coupler",
            Self::Solver(Role::Fluid) => "fluid",
            Self::Solver(Role::Dem) => "dem",
        }
    }

    fn seat(self) -> usize {
        match self {
            Self::Coupler => 0,
            Self::Solver(Role::Fluid) => 1,
            Self::Solver(Role::Dem) => 2,
        }
    }
}

/// The name in messages.
impl std::fmt::Display for Member {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Coupler => f.write_str("bedload (coupler)"),
            Self::Solver(role) => role.fmt(f),
        }
    }
}

/// iceoryx2's settings of a run: its own prefix and root folder, and no clean-up by iceoryx2 itself,
/// because the run is removed as a whole by the last process ([`super::folder`]).
pub(crate) fn config_of(root: &Path, prefix: &str) -> Result<Config, ExchangeError> {
    let refused = |what: &str| ExchangeError::Transport(format!("iceoryx2 does not accept {what}"));
    let mut config = Config::default();
    let bytes = root.as_os_str().as_encoded_bytes();
    let path = iceoryx2::prelude::Path::new(bytes)
        .map_err(|_| refused(&format!("the folder {}", root.display())))?;
    config.global.set_root_path(&path);
    config.global.prefix =
        FileName::new(prefix.as_bytes()).map_err(|_| refused(&format!("the prefix {prefix:?}")))?;
    config.global.service.cleanup_dead_nodes_on_open = false;
    config.global.node.cleanup_dead_nodes_on_creation = false;
    config.global.node.cleanup_dead_nodes_on_destruction = false;
    Ok(config)
}

/// What one look at the nodes showed, by seat.
#[derive(Clone, Copy, Debug, Default)]
struct Census {
    alive: [bool; 3],
    dead: [bool; 3],
    coupler: Option<u32>,
}

fn census(config: &Config) -> Option<Census> {
    let mut census = Census::default();
    let listed = Node::<ipc::Service>::list(config, |state| {
        let (details, alive) = match &state {
            NodeState::Alive(view) => (view.details(), true),
            NodeState::Dead(view) => (view.details(), false),
            _ => return CallbackProgression::Continue,
        };
        let Some(details) = details else {
            return CallbackProgression::Continue;
        };
        for member in Member::ALL {
            if details.name().as_str() == member.node_name() {
                let seats = if alive { &mut census.alive } else { &mut census.dead };
                seats[member.seat()] = true;
                if alive && member == Member::Coupler {
                    census.coupler = u32::try_from(details.process_id().value()).ok();
                }
            }
        }
        CallbackProgression::Continue
    });
    listed.ok().map(|()| census)
}

/// Whether any process still has a node in the run.
pub(crate) fn anyone_alive(root: &Path, prefix: &str) -> bool {
    let Ok(config) = config_of(root, prefix) else {
        return false;
    };
    let mut alive = false;
    let listed = Node::<ipc::Service>::list(&config, |state| {
        alive |= matches!(state, NodeState::Alive(_));
        CallbackProgression::Continue
    });
    listed.is_ok() && alive
}

/// Looks after the other processes of the run.
#[derive(Clone, Debug)]
pub(crate) struct Watch {
    config: Config,
    /// Members seen alive once: their absence is then a death too.
    seen: [bool; 3],
    /// The coupler's process, if it is this process's parent.
    parent: Option<u32>,
}

impl Watch {
    pub(crate) fn new(config: &Config) -> Self {
        let first = census(config).unwrap_or_default();
        Self {
            config: config.clone(),
            seen: first.alive,
            parent: first.coupler.filter(|process| *process == parent_id()),
        }
    }

    /// Fails if one of `members` has died or left.
    pub(crate) fn check(&mut self, members: &[Member], step: u64) -> Result<(), ExchangeError> {
        match self.first_dead(members) {
            None => Ok(()),
            Some(member) => Err(ExchangeError::PeerDied { peer: member.to_string(), step }),
        }
    }

    /// The member that died; one killed goes before one that left, which may have left because of it.
    fn first_dead(&mut self, members: &[Member]) -> Option<Member> {
        let orphan = self.parent.is_some_and(|process| process != parent_id());
        if orphan && members.contains(&Member::Coupler) {
            return Some(Member::Coupler);
        }
        let now = census(&self.config)?;
        let seen = self.seen;
        for (seat, alive) in now.alive.iter().enumerate() {
            self.seen[seat] |= alive;
        }
        let killed = |member: &&Member| now.dead[member.seat()];
        let left = |member: &&Member| seen[member.seat()] && !now.alive[member.seat()];
        members.iter().find(killed).or_else(|| members.iter().find(left)).copied()
    }
}
