//! Who lives: iceoryx2's nodes, and the coupler as the solvers' parent process.
//!
//! Nobody is told that a process died, so everyone who waits looks, every [`LOOK_EVERY`]: at the processes,
//! which costs a microsecond each, and every [`COUNT_EVERY`], or when one has gone, at the nodes, which costs
//! some 0.3 ms.

use std::os::unix::process::parent_id;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use iceoryx2::config::Config;
use iceoryx2::identifiers::UniqueNodeId;
use iceoryx2::node::NodeView;
use iceoryx2::prelude::*;

use crate::participant::{ExchangeError, Role};

/// How often a waiting process looks whether the others live.
pub(crate) const LOOK_EVERY: Duration = Duration::from_millis(10);

/// How often it looks at the nodes: they alone show a node that a living process has left.
const COUNT_EVERY: Duration = Duration::from_millis(100);

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
            Self::Solver(role) => 1 + role as usize,
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
    process: [Option<u32>; 3],
}

/// Nodes of the members, once they were seen: a later look that cannot read a node's details still
/// knows whose it is.
type Known = [Option<UniqueNodeId>; 3];

fn census(config: &Config, known: &mut Known) -> Option<Census> {
    let mut census = Census::default();
    let listed = Node::<ipc::Service>::list(config, |state| {
        let details = match &state {
            NodeState::Alive(view) => view.details().as_ref(),
            NodeState::Dead(view) => view.details().as_ref(),
            _ => None,
        };
        let member = Member::ALL.into_iter().find(|member| {
            known[member.seat()] == Some(*state.node_id())
                || details.is_some_and(|details| details.name().as_str() == member.node_name())
        });
        let Some(member) = member else { return CallbackProgression::Continue };
        known[member.seat()] = Some(*state.node_id());
        if matches!(state, NodeState::Dead(_)) {
            census.dead[member.seat()] = true;
        } else {
            census.alive[member.seat()] = true;
            let process = details.map(|details| details.process_id().value());
            census.process[member.seat()] = process.and_then(|process| u32::try_from(process).ok());
        }
        CallbackProgression::Continue
    });
    listed.ok().map(|()| census)
}

/// Whether any process still has a node in the run.
pub(crate) fn anyone_alive(root: &Path, prefix: &str) -> bool {
    let Ok(config) = config_of(root, prefix) else { return false };
    let mut alive = false;
    let listed = Node::<ipc::Service>::list(&config, |state| {
        alive |= matches!(state, NodeState::Alive(_));
        CallbackProgression::Continue
    });
    listed.is_ok() && alive
}

/// Whether there is no such process. One that has ended and was not waited for is still there; its node
/// tells.
fn is_gone(process: u32) -> bool {
    !Path::new("/proc").join(process.to_string()).exists()
}

/// Looks after the other processes of the run. Clones share what they have seen.
#[derive(Clone, Debug)]
pub(crate) struct Watch {
    config: Config,
    /// Every member has joined, so one that is absent has left.
    complete: Arc<AtomicBool>,
    known: Known,
    /// Their processes, once they were seen.
    processes: [Option<u32>; 3],
    /// When the nodes were looked at last.
    counted: Instant,
    /// The coupler's process, if it is this process's parent.
    parent: Option<u32>,
}

impl Watch {
    pub(crate) fn new(config: &Config) -> Self {
        let mut known = Known::default();
        let first = census(config, &mut known).unwrap_or_default();
        Self {
            config: config.clone(),
            complete: Arc::new(AtomicBool::new(false)),
            known,
            processes: first.process,
            counted: Instant::now(),
            parent: first.process[Member::Coupler.seat()].filter(|process| *process == parent_id()),
        }
    }

    /// From now on absence is death, for all clones.
    pub(crate) fn everyone_joined(&self) {
        self.complete.store(true, Ordering::Relaxed);
    }

    /// Fails if one of `members` has died or left.
    pub(crate) fn check(&mut self, members: &[Member], step: u64) -> Result<(), ExchangeError> {
        let Some(member) = self.first_dead(members) else { return Ok(()) };
        Err(ExchangeError::PeerDied { peer: member.to_string(), step })
    }

    /// The solver of `roles` that has no node.
    pub(crate) fn absent(&mut self, roles: &[Role]) -> Option<Role> {
        let now = census(&self.config, &mut self.known)?;
        roles.iter().find(|role| !now.alive[Member::Solver(**role).seat()]).copied()
    }

    /// The member that died; one killed goes before one that left, which may have left because of it.
    fn first_dead(&mut self, members: &[Member]) -> Option<Member> {
        let orphan = self.parent.is_some_and(|process| process != parent_id());
        if orphan && members.contains(&Member::Coupler) {
            return Some(Member::Coupler);
        }
        let gone = |member: &Member| self.processes[member.seat()].is_some_and(is_gone);
        if self.counted.elapsed() < COUNT_EVERY && !members.iter().any(gone) {
            return None;
        }
        let now = census(&self.config, &mut self.known)?;
        self.counted = Instant::now();
        for (process, seen) in self.processes.iter_mut().zip(now.process) {
            *process = seen.or(*process);
        }
        let killed = members.iter().find(|member| now.dead[member.seat()]);
        killed.or_else(|| self.first_left(members, &now)).copied()
    }

    /// A member known to have joined and absent twice: reading a folder while others change it may
    /// pass over an entry.
    fn first_left<'a>(&mut self, members: &'a [Member], now: &Census) -> Option<&'a Member> {
        let complete = self.complete.load(Ordering::Relaxed);
        let joined = |seat: usize| complete || self.known[seat].is_some();
        let left = members.iter().find(|member| joined(member.seat()) && !now.alive[member.seat()])?;
        let again = census(&self.config, &mut self.known)?;
        (!again.alive[left.seat()]).then_some(left)
    }
}
