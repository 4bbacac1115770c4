//! Starting this test binary again in another role, and looking at what is left of a run.

use std::io::Read;
use std::path::PathBuf;
use std::process::{Child, Command as Process, Stdio};
use std::time::{Duration, Instant};

use protocol::channel::{CONNECT_VARIABLE, CouplerLink, Event, Rendezvous};
use protocol::message::{Command, Order, State, Status};
use protocol::participant::{ExchangeError, Role};

use super::participants::Fault;

/// Long enough for a loaded machine; no passing test waits this long.
pub(crate) const PATIENCE: Duration = Duration::from_secs(20);

/// A child in some role, killed when the test fails before its end.
#[derive(Debug)]
pub(crate) struct Participant(pub(crate) Child);

impl Participant {
    /// Starts this binary again; `as_child` plays `role`.
    pub(crate) fn start(rendezvous: &Rendezvous, role: &str, fault: Option<Fault>) -> Self {
        let mut process = Process::new(std::env::current_exe().unwrap());
        process
            .args(["channel::as_child", "--exact", "--nocapture", "--test-threads=1"])
            .env(CONNECT_VARIABLE, rendezvous.token())
            .env("TOY_ROLE", role)
            .env("TOY_OUT", out_dir(rendezvous))
            .env_remove("TOY_FAULT")
            .stdin(Stdio::null())
            .stdout(Stdio::null())
            .stderr(Stdio::piped());
        if let Some(fault) = fault {
            process.env("TOY_FAULT", fault.write());
        }
        Self(process.spawn().unwrap())
    }

    pub(crate) fn kill(&mut self) {
        self.0.kill().unwrap();
        self.0.wait().unwrap();
    }

    /// Waits for its end: whether it ended well, and its last words.
    pub(crate) fn end(&mut self) -> (bool, String) {
        let start = Instant::now();
        while self.0.try_wait().unwrap().is_none() {
            assert!(start.elapsed() < PATIENCE, "child does not end");
            std::thread::sleep(Duration::from_millis(1));
        }
        let mut text = String::new();
        self.0.stderr.take().unwrap().read_to_string(&mut text).unwrap();
        (self.0.wait().unwrap().success(), text)
    }
}

impl Drop for Participant {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

pub(crate) fn out_dir(rendezvous: &Rendezvous) -> PathBuf {
    std::env::temp_dir().join(format!("bedload-test-{}", rendezvous.run))
}

/// A run with both toys joined and ready.
///
/// The participants go before the link, so that a failed test cleans up too.
pub(crate) struct Stage {
    pub(crate) fluid: Participant,
    pub(crate) dem: Participant,
    pub(crate) link: CouplerLink,
    pub(crate) rendezvous: Rendezvous,
}

impl Stage {
    pub(crate) fn open(rendezvous: Rendezvous, fluid: Option<Fault>, dem: Option<Fault>) -> Self {
        let mut link = CouplerLink::create(&rendezvous).unwrap();
        let fluid = Participant::start(&rendezvous, "fluid", fluid);
        let dem = Participant::start(&rendezvous, "dem", dem);
        let ready = link.wait_ready(&mut || Ok(())).unwrap();
        assert_eq!(ready.len(), 2);
        Self { link, fluid, dem, rendezvous }
    }

    pub(crate) fn order(&mut self, order: Order, step: u64, attempt: u64) {
        self.link.order(command(order, step, attempt)).unwrap();
    }

    /// Takes events until both solvers have answered everything, or until the first error.
    pub(crate) fn settle(&mut self) -> Result<Vec<(Role, Status)>, ExchangeError> {
        let mut reports = Vec::new();
        while self.link.unanswered() > 0 {
            if let Event::Status(role, status) = self.link.next(PATIENCE, &mut || Ok(()))? {
                reports.push((role, status));
            }
        }
        Ok(reports)
    }

    /// Does windows `0..count` one by one.
    pub(crate) fn advance(&mut self, count: u64) {
        for step in 0..count {
            self.order(Order::Advance, step, 0);
            let reports = self.settle().unwrap();
            assert!(reports.iter().all(|(_, status)| status.state == State::Done as u64));
        }
    }

    /// Stops both solvers and leaves; nothing must be left.
    pub(crate) fn close(mut self, step: u64) {
        self.order(Order::Stop, step, 0);
        for (role, status) in self.settle().unwrap() {
            assert_eq!(status.state, State::Stopped as u64, "{role}: {}", status.text());
        }
        for participant in [&mut self.fluid, &mut self.dem] {
            let (well, text) = participant.end();
            assert!(well, "{text}");
        }
        drop(self.link);
        assert_gone(&self.rendezvous);
    }

    /// The error that ends a run in which a solver broke down.
    pub(crate) fn first_error(&mut self, limit: Duration) -> ExchangeError {
        let start = Instant::now();
        loop {
            match self.link.next(limit, &mut || Ok(())) {
                Err(error) => return error,
                Ok(_) => assert!(start.elapsed() < PATIENCE, "no error"),
            }
        }
    }
}

pub(crate) fn command(order: Order, step: u64, attempt: u64) -> Command {
    Command { order: order as u64, step, attempt, time: step as f64 * 0.5, dt: 0.5, substeps: 20, output: 0 }
}

/// Segments of the run that still exist.
pub(crate) fn segments(rendezvous: &Rendezvous) -> Vec<String> {
    std::fs::read_dir("/dev/shm")
        .unwrap()
        .flatten()
        .filter_map(|entry| entry.file_name().into_string().ok())
        .filter(|name| name.starts_with(&rendezvous.prefix))
        .collect()
}

/// Nothing of the run is left in shared memory or in its folder.
pub(crate) fn assert_gone(rendezvous: &Rendezvous) {
    assert_eq!(segments(rendezvous), Vec::<String>::new());
    assert!(!rendezvous.root.exists(), "{} is left", rendezvous.root.display());
    let _ = std::fs::remove_dir_all(out_dir(rendezvous));
}

/// The same within [`PATIENCE`], where another process cleans up.
pub(crate) fn assert_goes(rendezvous: &Rendezvous) {
    let start = Instant::now();
    while start.elapsed() < PATIENCE && (rendezvous.root.exists() || !segments(rendezvous).is_empty()) {
        std::thread::sleep(Duration::from_millis(2));
    }
    assert_gone(rendezvous);
}
