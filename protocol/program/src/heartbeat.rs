//! A solver that runs by itself tells the `bedload` that started it that it goes on: a datagram for a window,
//! at most ten a second, to a socket that the environment names. It never waits, and a lost one does no harm.

use std::io;
use std::os::linux::net::SocketAddrExt as _;
use std::os::unix::net::{SocketAddr, UnixDatagram};
use std::time::{Duration, Instant, SystemTime};

/// Variable with the name of the socket, which no file stands for.
const SOCKET: &str = "BEDLOAD_HEARTBEAT";

/// Shortest time between two datagrams.
const EVERY: Duration = Duration::from_millis(100);

/// Where the heartbeats of a solver arrive.
#[derive(Debug)]
pub struct Heartbeats {
    socket: UnixDatagram,
    name: String,
}

impl Heartbeats {
    /// Listens from now on.
    ///
    /// # Errors
    /// The system's, if there is no socket to be had.
    pub fn listen() -> io::Result<Self> {
        let now = SystemTime::now().duration_since(SystemTime::UNIX_EPOCH).unwrap_or_default();
        let name = format!("bedload-heartbeat-{}-{}", std::process::id(), now.as_nanos());
        let socket = UnixDatagram::bind_addr(&SocketAddr::from_abstract_name(&name)?)?;
        socket.set_nonblocking(true)?;
        Ok(Self { socket, name })
    }

    /// The variable that tells a solver where to send: name and value.
    pub fn variable(&self) -> (&str, &str) {
        (SOCKET, &self.name)
    }

    /// Has one come since it was asked last?
    pub fn any(&self) -> bool {
        let mut any = false;
        while self.socket.recv(&mut [0]).is_ok() {
            any = true;
        }
        any
    }
}

/// The sender; it sends nothing where nobody listens.
#[derive(Debug)]
pub(crate) struct Heartbeat {
    socket: Option<UnixDatagram>,
    sent: Instant,
}

impl Heartbeat {
    /// To the socket that the environment names.
    pub(crate) fn new() -> Self {
        let connected = || {
            let name = std::env::var(SOCKET).ok()?;
            let socket = UnixDatagram::unbound().ok()?;
            socket.connect_addr(&SocketAddr::from_abstract_name(&name).ok()?).ok()?;
            socket.set_nonblocking(true).ok()?;
            socket.send(&[]).ok()?;
            Some(socket)
        };
        Self { socket: connected(), sent: Instant::now() }
    }

    /// The solver goes on.
    pub(crate) fn beat(&mut self) {
        if let Some(socket) = self.socket.as_ref().filter(|_| self.sent.elapsed() >= EVERY) {
            // A full queue says as much as one datagram more.
            let _ = socket.send(&[]);
            self.sent = Instant::now();
        }
    }
}
