//! What the coupling itself costs: three processes, idle solvers, µs per window.
//!
//! ```text
//! cargo run --release -p bedload-protocol --example exchange_cost -- [--windows N] [--grains N,N,…]
//! ```
//!
//! One window is `Advance` → loads → kinematics → `Done` of both solvers, each record written and
//! read once in every process. The program starts itself again in the two roles. The last line says
//! how soon the coupler notices that a solver was killed.

use std::error::Error;
use std::path::{Path, PathBuf};
use std::process::{Child, Command as Process, Stdio};
use std::time::{Duration, Instant};

use protocol::channel::{CONNECT_VARIABLE, ConductorLink, Event, Rendezvous, Waiting};
use protocol::message::{Command, Kinematics, Loads, Order, State};
use protocol::participant::{Exchange, ExchangeError, Participant, Role, SolverError, Window, WindowReport};
use protocol::serve::Invitation;

type Outcome<T> = Result<T, Box<dyn Error>>;

fn main() -> Outcome<()> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    if let Some(rendezvous) = Rendezvous::from_environment()? {
        return Ok(play(rendezvous, arguments.first().map_or("", String::as_str))?);
    }
    let value = |name: &str, default: &str| {
        let place = arguments.iter().position(|argument| argument == name);
        place.and_then(|place| arguments.get(place + 1)).map_or_else(|| default.to_owned(), Clone::clone)
    };
    let windows: u64 = value("--windows", "5000").parse()?;
    let grains: Vec<usize> =
        value("--grains", "1,200,10000").split(',').map(str::parse).collect::<Result<_, _>>()?;
    let cores = std::thread::available_parallelism()?;
    println!("{cores} cores, 3 processes, {windows} windows, idle solvers");
    println!("grains  waiting       ahead  us/window  exchange us/window (fluid, dem)");
    for grains in grains {
        for (name, waiting, spin_us) in
            [("event", Waiting::Event, 0), ("yield+event", Waiting::Event, 50), ("spin", Waiting::Spin, 50)]
        {
            for ahead in [1, 4] {
                let mut rendezvous = Rendezvous::new(grains)?;
                rendezvous.waiting = waiting;
                rendezvous.spin_us = spin_us;
                rendezvous.ahead = ahead;
                let (wall, exchange) = measure(&rendezvous, windows)?;
                println!(
                    "{grains:6}  {name:12}  {ahead:5}  {wall:9.1}  {:.1}, {:.1}",
                    exchange[0], exchange[1]
                );
            }
        }
    }
    let mut noticed = (0..9).map(|_| notice_a_kill()).collect::<Outcome<Vec<f64>>>()?;
    noticed.sort_by(f64::total_cmp);
    println!("killed solver noticed after {:.1} ms (median of 9, worst {:.1})", noticed[4], noticed[8]);
    Ok(())
}

/// Kills the DEM while the coupler waits; ms until the coupler says so.
fn notice_a_kill() -> Outcome<f64> {
    let rendezvous = Rendezvous::new(200)?;
    let mut link = ConductorLink::create(&rendezvous)?;
    let mut fluid = start(&rendezvous, Role::Fluid)?;
    let mut dem = start(&rendezvous, Role::Dem)?;
    link.wait_ready(&mut || Ok(()))?;
    let start = Instant::now();
    dem.kill()?;
    let heard = link.next(Duration::from_secs(10), &mut || Ok(()));
    let milliseconds = start.elapsed().as_secs_f64() * 1e3;
    link.order(command(Order::Stop, 0))?;
    fluid.wait()?;
    dem.wait()?;
    match heard {
        Err(ExchangeError::PeerDied { .. }) => Ok(milliseconds),
        other => Err(format!("expected a death, heard {other:?}").into()),
    }
}

/// Runs `windows` windows; µs per window: wall, and each solver's own exchange time.
fn measure(rendezvous: &Rendezvous, windows: u64) -> Outcome<(f64, [f64; 2])> {
    let mut link = ConductorLink::create(rendezvous)?;
    let mut children = Vec::new();
    for role in &rendezvous.roles {
        children.push(start(rendezvous, *role)?);
    }
    link.wait_ready(&mut || Ok(()))?;
    let limit = Duration::from_secs(10);
    let (mut given, mut done, mut seen, mut sum) = (0, [0u64; 2], 0u64, 0.0);
    let mut exchange = [0.0; 2];
    let start = Instant::now();
    while done[0].min(done[1]) < windows {
        while given < windows && link.unanswered() < rendezvous.ahead as u64 {
            link.order(command(Order::Advance, given))?;
            given += 1;
        }
        match link.next(limit, &mut || Ok(()))? {
            Event::Loads(lent) => {
                seen += 1;
                sum += lent.records().iter().map(|load| load.force[2]).sum::<f64>();
            }
            Event::Kinematics(lent) => {
                seen += 1;
                sum += lent.records().iter().map(|grain| grain.position[2]).sum::<f64>();
            }
            Event::Status(role, status) if status.state == State::Done as u64 => {
                let solver = usize::from(role == Role::Dem);
                done[solver] += 1;
                exchange[solver] = status.exchange_s;
            }
            Event::Status(role, status) => return Err(format!("{role}: {}", status.text()).into()),
        }
    }
    let wall = start.elapsed().as_secs_f64();
    link.order(command(Order::Stop, windows))?;
    for mut child in children {
        if !child.wait()?.success() {
            return Err("a solver failed".into());
        }
    }
    let expected = 2 * windows;
    if seen != expected || !sum.is_finite() {
        return Err(format!("observed {seen} of {expected} messages, sum {sum}").into());
    }
    let per_window = 1e6 / windows as f64;
    Ok((wall * per_window, exchange.map(|seconds| seconds * per_window)))
}

fn command(order: Order, step: u64) -> Command {
    Command { order: order as u64, step, dt: 1e-3, substeps: 10, ..Command::default() }
}

fn start(rendezvous: &Rendezvous, role: Role) -> Outcome<Child> {
    Ok(Process::new(std::env::current_exe()?)
        .arg(role.to_string())
        .env(CONNECT_VARIABLE, rendezvous.token())
        .stdin(Stdio::null())
        .spawn()?)
}

fn play(rendezvous: Rendezvous, role: &str) -> Result<(), SolverError> {
    let grains = rendezvous.grains;
    let invitation =
        Invitation { scene: PathBuf::new(), rendezvous, out: PathBuf::from("."), checkpoint: None };
    match role {
        "fluid" => invitation.serve(&mut IdleFluid(grains)),
        _ => invitation.serve(&mut IdleDem(grains)),
    }
}

const REPORT: WindowReport = WindowReport { dt_limit: f64::INFINITY, residual: 0.0, substeps: 0 };

struct IdleFluid(usize);
struct IdleDem(usize);

macro_rules! stateless {
    () => {
        fn grains(&self) -> usize {
            self.0
        }
        fn save(&mut self) {}
        fn restore(&mut self) {}
        fn write_checkpoint(&self, _: &Path) -> Result<(), SolverError> {
            Ok(())
        }
        fn read_checkpoint(&mut self, _: &Path) -> Result<(), SolverError> {
            Ok(())
        }
        fn write_fields(&mut self, _: &Window) -> Result<(), SolverError> {
            Ok(())
        }
        fn solver_seconds(&self) -> f64 {
            0.0
        }
    };
}

impl Participant for IdleFluid {
    type Incoming = Kinematics;
    type Outgoing = Loads;
    const ROLE: Role = Role::Fluid;

    fn advance(
        &mut self,
        window: &Window,
        exchange: &mut dyn Exchange<Kinematics, Loads>,
    ) -> Result<WindowReport, SolverError> {
        exchange.send(window.header(), &mut |loads| {
            for load in loads {
                load.force[2] = window.step as f64;
            }
        })?;
        let mut sum = 0.0;
        exchange.receive(window, &mut |_, grains| {
            sum = grains.iter().map(|grain| grain.position[2]).sum();
        })?;
        expect(sum, self.0, window)?;
        Ok(REPORT)
    }
    stateless!();
}

impl Participant for IdleDem {
    type Incoming = Loads;
    type Outgoing = Kinematics;
    const ROLE: Role = Role::Dem;

    fn advance(
        &mut self,
        window: &Window,
        exchange: &mut dyn Exchange<Loads, Kinematics>,
    ) -> Result<WindowReport, SolverError> {
        let mut sum = 0.0;
        exchange.receive(window, &mut |_, loads| {
            sum = loads.iter().map(|load| load.force[2]).sum();
        })?;
        expect(sum, self.0, window)?;
        exchange.send(window.header(), &mut |grains| {
            for grain in grains {
                grain.position[2] = window.step as f64;
            }
        })?;
        Ok(REPORT)
    }
    stateless!();
}

fn expect(sum: f64, grains: usize, window: &Window) -> Result<(), ExchangeError> {
    let expected = (grains as u64 * window.step) as f64;
    if sum == expected {
        return Ok(());
    }
    Err(ExchangeError::Order { what: format!("sum {sum} in window {}, expected {expected}", window.step) })
}
