//! What the coupling itself costs: three processes, idle solvers, µs per window: percentiles of the wall time
//! from one window's end to the next, which with one window ahead is the time of an exchange, and the CPU
//! time of all three.
//!
//! ```text
//! cargo run --release -p bedload-protocol --example exchange_cost -- [--windows N] [--grains N,N,…] [--ahead N,N]
//! ```
//!
//! One window is `Advance` → loads → kinematics → `Done` of both solvers, each record written and
//! read once in every process. The program starts itself again in the two roles. The last line says
//! how soon the coupler notices that a solver was killed.

use std::error::Error;
use std::path::{Path, PathBuf};
use std::process::{Child, Command as Process, Stdio};
use std::time::{Duration, Instant};

use protocol::channel::{CONNECT_VARIABLE, CouplerLink, Event, Rendezvous, Waiting};
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
    let aheads: Vec<usize> = value("--ahead", "1,4").split(',').map(str::parse).collect::<Result<_, _>>()?;
    let cores = std::thread::available_parallelism()?;
    println!("{cores} cores, 3 processes, {windows} windows, idle solvers");
    println!(
        "| grains | waiting | ahead | mean | p50 | p99 | p99.9 | CPU: coupler, fluid, DEM | sending and \
         receiving: fluid, DEM |"
    );
    println!("|---:|---|---|---:|---:|---:|---:|---|---|");
    for grains in grains {
        for (name, waiting, spin_us) in
            [("event", Waiting::Event, 0), ("yield+event", Waiting::Event, 50), ("spin", Waiting::Spin, 50)]
        {
            for ahead in aheads.iter().copied() {
                let mut rendezvous = Rendezvous::new(grains)?;
                rendezvous.waiting = waiting;
                rendezvous.spin_us = spin_us;
                rendezvous.ahead = ahead;
                let cost = measure(&rendezvous, windows)?;
                println!("| {grains} | {name} | {ahead} | {cost} |");
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
    let mut link = CouplerLink::create(&rendezvous)?;
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

/// What a window costs, µs.
struct Cost {
    /// Wall time of each window, sorted.
    windows: Vec<f64>,
    /// CPU time of coupler, fluid and DEM.
    cpu: [f64; 3],
    /// Each solver's own sending and receiving.
    exchange: [f64; 2],
}

impl std::fmt::Display for Cost {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let share = |part: f64| {
            self.windows[((part * self.windows.len() as f64) as usize).min(self.windows.len() - 1)]
        };
        let mean = self.windows.iter().sum::<f64>() / self.windows.len() as f64;
        let ([coupler, fluid, dem], [sent, got]) = (self.cpu, self.exchange);
        write!(f, "{mean:.1} | {:.1} | {:.1} | {:.1} | ", share(0.5), share(0.99), share(0.999))?;
        write!(f, "{coupler:.1}, {fluid:.1}, {dem:.1} | {sent:.1}, {got:.1}")
    }
}

/// CPU time of all threads of a process so far, µs.
fn cpu_time(pid: u32) -> Outcome<f64> {
    let mut sum = 0.0;
    for thread in std::fs::read_dir(format!("/proc/{pid}/task"))? {
        let text = std::fs::read_to_string(thread?.path().join("schedstat"))?;
        sum += text.split_whitespace().next().unwrap_or("0").parse::<f64>()? * 1e-3;
    }
    Ok(sum)
}

/// Runs `windows` windows.
fn measure(rendezvous: &Rendezvous, windows: u64) -> Outcome<Cost> {
    let mut link = CouplerLink::create(rendezvous)?;
    let mut children = Vec::new();
    for role in &rendezvous.roles {
        children.push(start(rendezvous, *role)?);
    }
    link.wait_ready(&mut || Ok(()))?;
    let pids = [std::process::id(), children[0].id(), children[1].id()];
    let before = pids.map(|pid| cpu_time(pid).unwrap_or(f64::NAN));
    let mut count = Count::default();
    let mut times = Vec::with_capacity(windows as usize);
    let mut last = Instant::now();
    let mut given = 0;
    while (times.len() as u64) < windows {
        while given < windows && link.unanswered() < rendezvous.ahead as u64 {
            link.order(command(Order::Advance, given))?;
            given += 1;
        }
        count.hear(&mut link)?;
        if count.done[0].min(count.done[1]) > times.len() as u64 {
            times.push(last.elapsed().as_secs_f64() * 1e6);
            last = Instant::now();
        }
    }
    let per_window = 1.0 / windows as f64;
    let after = pids.map(|pid| cpu_time(pid).unwrap_or(f64::NAN));
    let cpu = std::array::from_fn(|of| (after[of] - before[of]) * per_window);
    link.order(command(Order::Stop, windows))?;
    for mut child in children {
        if !child.wait()?.success() {
            return Err("a solver failed".into());
        }
    }
    let expected = 2 * windows;
    if count.seen != expected || !count.sum.is_finite() {
        return Err(format!("observed {} of {expected} messages, sum {}", count.seen, count.sum).into());
    }
    times.sort_by(f64::total_cmp);
    Ok(Cost { windows: times, cpu, exchange: count.exchange.map(|seconds| seconds * 1e6 * per_window) })
}

/// What the coupler has heard.
#[derive(Default)]
struct Count {
    done: [u64; 2],
    seen: u64,
    sum: f64,
    exchange: [f64; 2],
}

impl Count {
    /// Takes the next message.
    fn hear(&mut self, link: &mut CouplerLink) -> Outcome<()> {
        match link.next(Duration::from_secs(10), &mut || Ok(()))? {
            Event::Loads(lent) => {
                self.seen += 1;
                self.sum += lent.records().iter().map(|load| load.force[2]).sum::<f64>();
            }
            Event::Kinematics(lent) => {
                self.seen += 1;
                self.sum += lent.records().iter().map(|grain| grain.position[2]).sum::<f64>();
            }
            Event::Status(role, status) if status.state == State::Done as u64 => {
                let solver = usize::from(role == Role::Dem);
                self.done[solver] += 1;
                self.exchange[solver] = status.exchange_s;
            }
            Event::Status(role, status) => return Err(format!("{role}: {}", status.text()).into()),
        }
        Ok(())
    }
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
    Err(ExchangeError::Order(format!("sum {sum} in window {}, expected {expected}", window.step)))
}
