//! Solver processes as children: started, watched, and ended whatever happens.
//!
//! Each child has a thread that sleeps until it exits (without reaping it, so that its process id
//! stays its own until the parent lets go), and one that keeps the last lines of its stderr. Every
//! child leads a process group of its own: Ctrl-C reaches the coupler alone, which ends the run in
//! order.

use std::collections::VecDeque;
use std::ffi::OsString;
use std::io::{BufRead, BufReader};
use std::os::unix::process::{CommandExt, ExitStatusExt};
use std::process::{Child, Command, ExitStatus, Stdio};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use bedload_program::Heartbeats;
use clap::builder::{PossibleValuesParser, TypedValueParser};
use protocol::participant::Role;
use rustix::process::{Pid, Signal, WaitId, WaitIdOptions, kill_process, waitid};

/// Lines of stderr kept as last words.
const LAST_LINES: usize = 20;
/// Bytes of a line of stderr that are kept: a bar that a solver draws has no line break.
const LONGEST_LINE: usize = 4096;
/// How often a wait looks.
const LOOK_EVERY: Duration = Duration::from_millis(2);

/// What became of a child.
#[derive(Clone, Debug)]
pub(crate) struct Exit {
    pub(crate) role: Role,
    /// How it ended; none if the system would not tell.
    pub(crate) status: Option<ExitStatus>,
}

impl Exit {
    pub(crate) fn was_killed(&self) -> bool {
        self.status.is_none_or(|status| status.signal().is_some())
    }

    /// Exit code, if it left by itself.
    pub(crate) fn code(&self) -> Option<i32> {
        self.status.and_then(|status| status.code())
    }
}

impl std::fmt::Display for Exit {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let process = program(self.role);
        match (self.code(), self.status.and_then(|status| status.signal())) {
            (Some(code), _) => write!(f, "{process} left with exit code {code}"),
            (None, Some(signal)) => write!(f, "{process} was killed by signal {signal}"),
            (None, None) => write!(f, "{process} is gone"),
        }
    }
}

/// Name of our solver in a role.
pub(crate) fn program(role: Role) -> &'static str {
    match role {
        Role::Fluid => "bedload-fluid",
        Role::Dem => "bedload-dem",
    }
}

/// A command of an executable with its leading arguments, and others.
pub(crate) fn command_of(program: &[String], arguments: &[OsString]) -> std::io::Result<Command> {
    let empty = || std::io::Error::new(std::io::ErrorKind::InvalidInput, "the command is empty");
    let (executable, leading) = program.split_first().ok_or_else(empty)?;
    let mut command = Command::new(executable);
    command.args(leading).args(arguments);
    Ok(command)
}

/// A role as a command line names it.
pub(crate) fn role() -> impl TypedValueParser<Value = Role> {
    PossibleValuesParser::new(["fluid", "dem"])
        .map(|name| if name == "fluid" { Role::Fluid } else { Role::Dem })
}

/// Where a child's words go.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum StderrMode {
    /// To the coupler's stderr line by line, the last ones kept.
    Kept,
    /// The last ones kept, and nothing else.
    Quiet,
    /// The child speaks for itself: stdin, stdout and stderr are the coupler's.
    Own,
}

struct Watched {
    role: Role,
    child: Arc<Mutex<Child>>,
    words: Arc<Mutex<VecDeque<String>>>,
}

/// Exits in the order in which they were seen.
type Exits = Arc<Mutex<Vec<Exit>>>;

fn locked<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    // A panic in a watching thread must not hide what it saw.
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// The children of a run. Dropped, it kills those that still live.
#[derive(Default)]
pub(crate) struct Supervisor {
    children: Vec<Watched>,
    exits: Exits,
    /// Of children that run by themselves.
    heartbeats: Option<Heartbeats>,
}

impl Supervisor {
    /// Of a child that runs by itself, whose heartbeats are listened to where the system has sockets.
    pub(crate) fn listening() -> Self {
        Self { children: Vec::new(), exits: Exits::default(), heartbeats: Heartbeats::listen().ok() }
    }

    /// Did a child send a heartbeat since this was asked last?
    pub(crate) fn heard(&self) -> bool {
        self.heartbeats.as_ref().is_some_and(Heartbeats::any)
    }

    pub(crate) fn start(
        &mut self,
        role: Role,
        program: &[String],
        arguments: &[OsString],
        words: StderrMode,
    ) -> std::io::Result<()> {
        let mut command = command_of(program, arguments)?;
        command.process_group(0);
        protocol::detail!("bedload: starts {command:?}");
        command.env(bedload_program::PARENT, bedload_program::parent_name());
        command.envs(self.heartbeats.as_ref().map(Heartbeats::variable));
        if words != StderrMode::Own {
            command.stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::piped());
        }
        let mut child = command.spawn()?;
        let stderr = child.stderr.take();
        let kept: Arc<Mutex<VecDeque<String>>> = Arc::default();
        let child = Arc::new(Mutex::new(child));
        // Watched from here on: where a thread cannot be started, the child ends with the supervisor.
        self.children.push(Watched { role, child: child.clone(), words: kept.clone() });
        if let Some(stderr) = stderr {
            let say = words == StderrMode::Kept;
            std::thread::Builder::new()
                .spawn(move || keep_words(role, BufReader::new(stderr), &kept, say))?;
        }
        let exits = self.exits.clone();
        std::thread::Builder::new().spawn(move || await_exit(role, &child, &exits))?;
        Ok(())
    }

    /// Children that have exited, in the order in which that was seen.
    pub(crate) fn exits(&self) -> Vec<Exit> {
        locked(&self.exits).clone()
    }

    /// Has any child exited? Costs a lock, so that it can be asked every few milliseconds.
    pub(crate) fn any_exit(&self) -> bool {
        !locked(&self.exits).is_empty()
    }

    /// Last lines that a solver wrote to stderr.
    pub(crate) fn last_words(&self, role: Role) -> String {
        let of_role = self.children.iter().find(|watched| watched.role == role);
        of_role.map_or_else(String::new, |watched| {
            let words = locked(&watched.words);
            words.iter().map(String::as_str).collect::<Vec<_>>().join("\n")
        })
    }

    /// Waits at most `limit` until every child has exited.
    pub(crate) fn wait_all(&self, limit: Duration) -> bool {
        wait_for(limit, || locked(&self.exits).len() >= self.children.len())
    }

    /// Waits at most `limit` until the one child has left.
    pub(crate) fn leaves(&self, limit: Duration) -> Result<Exit, String> {
        if !self.wait_all(limit) {
            return Err(format!("was still there after {:.1} s", limit.as_secs_f64()));
        }
        self.exits().pop().ok_or_else(|| "is gone, and nobody knows how".into())
    }

    /// Waits at most `limit` until a child has exited.
    pub(crate) fn wait_any(&self, limit: Duration) {
        wait_for(limit, || self.any_exit());
    }

    /// Sends `signal` to every child that lives.
    pub(crate) fn signal(&self, signal: Signal) {
        for watched in &self.children {
            let mut child = locked(&watched.child);
            // Not yet reaped, so the number is still this child's.
            if let (Ok(None), Some(pid)) = (child.try_wait(), pid_of(&child)) {
                let _ = kill_process(pid, signal);
            }
        }
    }

    /// Ends every child: SIGTERM, and SIGKILL after `grace`.
    pub(crate) fn end(&self, grace: Duration) {
        self.signal(Signal::TERM);
        // A stopped process takes SIGTERM only when it goes on.
        self.signal(Signal::CONT);
        if !self.wait_all(grace) {
            self.signal(Signal::KILL);
            self.wait_all(Duration::from_secs(5));
        }
    }
}

impl Drop for Supervisor {
    fn drop(&mut self) {
        if !self.wait_all(Duration::ZERO) {
            self.signal(Signal::KILL);
            self.wait_all(Duration::from_secs(5));
        }
    }
}

/// Waits at most `limit` until `done`; says whether it was.
pub(crate) fn wait_for(limit: Duration, done: impl Fn() -> bool) -> bool {
    let start = Instant::now();
    while !done() {
        if start.elapsed() >= limit {
            return false;
        }
        std::thread::sleep(LOOK_EVERY);
    }
    true
}

fn pid_of(child: &Child) -> Option<Pid> {
    Pid::from_raw(i32::try_from(child.id()).ok()?)
}

/// Sleeps until the child exits, then reaps it under the lock.
fn await_exit(role: Role, child: &Mutex<Child>, exits: &Mutex<Vec<Exit>>) {
    let pid = pid_of(&locked(child));
    if let Some(pid) = pid {
        // WNOWAIT leaves it to be reaped below; an error means that `try_wait` has reaped it.
        let _ = waitid(WaitId::Pid(pid), WaitIdOptions::EXITED | WaitIdOptions::NOWAIT);
    }
    let status = locked(child).wait().ok();
    locked(exits).push(Exit { role, status });
}

fn keep_words(role: Role, mut stderr: impl BufRead, kept: &Mutex<VecDeque<String>>, say: bool) {
    let mut line = Vec::new();
    while read_line(&mut stderr, &mut line) {
        // Lossy, because a foreign solver may write what it likes.
        let text = String::from_utf8_lossy(&line).trim_end().to_owned();
        line.clear();
        if text.is_empty() {
            continue;
        }
        if say && (!protocol::loudness::is_quiet() || is_grave(&text)) {
            protocol::say!("{role}: {text}");
        }
        let mut kept = locked(kept);
        if kept.len() == LAST_LINES {
            kept.pop_front();
        }
        kept.push_back(text);
    }
}

/// Is a line of a solver, which may be one of others, a warning or an error?
fn is_grave(line: &str) -> bool {
    let line = line.to_lowercase();
    ["warn", "error", "fail"].iter().any(|word| line.contains(word))
}

/// Reads up to a line break, of which the first [`LONGEST_LINE`] bytes are put into `line`; false at the end.
fn read_line(from: &mut impl BufRead, line: &mut Vec<u8>) -> bool {
    loop {
        let there = match from.fill_buf() {
            Ok([]) => return !line.is_empty(),
            Ok(there) => there,
            Err(error) if error.kind() == std::io::ErrorKind::Interrupted => continue,
            Err(_) => return false,
        };
        let end = there.iter().position(|byte| *byte == b'\n');
        let part = &there[..end.unwrap_or(there.len())];
        line.extend_from_slice(&part[..part.len().min(LONGEST_LINE.saturating_sub(line.len()))]);
        let read = part.len() + usize::from(end.is_some());
        from.consume(read);
        if end.is_some() {
            return true;
        }
    }
}

#[cfg(test)]
mod tests {
    use std::io::Read as _;

    use super::*;

    fn shell(script: &str) -> Vec<String> {
        ["sh", "-c", script].map(str::to_owned).to_vec()
    }

    #[test]
    fn a_child_that_ignores_sigterm_is_killed_after_the_grace() {
        let mut supervisor = Supervisor::default();
        supervisor
            .start(Role::Fluid, &shell("trap '' TERM; while :; do sleep 0.05; done"), &[], StderrMode::Kept)
            .unwrap();
        std::thread::sleep(Duration::from_millis(100));
        let start = Instant::now();
        supervisor.end(Duration::from_millis(200));
        assert!(start.elapsed() < Duration::from_secs(1), "{:?}", start.elapsed());
        assert!(supervisor.exits()[0].was_killed());
    }

    #[test]
    fn a_stopped_child_is_ended_too() {
        let mut supervisor = Supervisor::default();
        supervisor.start(Role::Fluid, &["sleep".into(), "60".into()], &[], StderrMode::Kept).unwrap();
        supervisor.signal(Signal::STOP);
        assert!(!supervisor.wait_all(Duration::from_millis(50)), "stopping is no exit");
        supervisor.end(Duration::from_millis(500));
        assert!(supervisor.any_exit());
    }

    #[test]
    fn a_line_without_an_end_is_cut() {
        let endless = std::io::repeat(b'z').take(1 << 30);
        let kept = Mutex::default();
        let begun = protocol::memory::peak_rss_bytes();
        keep_words(Role::Dem, BufReader::new(endless.chain(&b"\nlast\nwords"[..])), &kept, false);
        let kept: Vec<String> = locked(&kept).iter().cloned().collect();
        assert_eq!((kept[0].len(), &kept[1..]), (LONGEST_LINE, &["last".to_owned(), "words".to_owned()][..]));
        assert!(protocol::memory::peak_rss_bytes() < begun + (256 << 20));
    }

    #[test]
    fn the_order_of_exits_is_kept() {
        let mut supervisor = Supervisor::default();
        supervisor.start(Role::Fluid, &shell("sleep 0.3"), &[], StderrMode::Kept).unwrap();
        supervisor.start(Role::Dem, &shell("exit 3"), &[], StderrMode::Kept).unwrap();
        assert!(supervisor.wait_all(Duration::from_secs(5)));
        let roles: Vec<Role> = supervisor.exits().iter().map(|exit| exit.role).collect();
        assert_eq!(roles, [Role::Dem, Role::Fluid]);
    }
}
