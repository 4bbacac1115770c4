//! The plain loop: a solver that runs alone, with a stand-in for its absent peer.
//!
//! A fluid alone is given the motion that the scene prescribes; a DEM alone is given no load but, where
//! the scene has a fluid, the buoyancy.

use bedload_scene::{CheckedScene, Grain, Motion, Oscillation};
use protocol::message::{Header, Kinematics, Loads, Record};
use protocol::participant::{Exchange, ExchangeError, Participant, SolverError, Window, WindowReport};

/// What the absent peer would say in a window.
pub type Answer<R> = Box<dyn Fn(&Window, &mut [R]) + Send>;

/// The exchange of a solver alone.
pub struct StandIn<In: Record, Out: Record> {
    answer: Answer<In>,
    incoming: Vec<In>,
    outgoing: Vec<Out>,
    header: Header,
}

impl<In: Record, Out: Record> StandIn<In, Out> {
    /// For `grains` grains, with `answer` in place of the peer.
    #[must_use]
    pub fn new(grains: usize, answer: Answer<In>) -> Self {
        Self {
            answer,
            incoming: vec![In::default(); grains],
            outgoing: vec![Out::default(); grains],
            header: Header::default(),
        }
    }

    /// What the solver was given in the last window.
    #[must_use]
    pub fn incoming(&self) -> &[In] {
        &self.incoming
    }

    /// What the solver sent in the last window.
    #[must_use]
    pub fn outgoing(&self) -> (&Header, &[Out]) {
        (&self.header, &self.outgoing)
    }
}

impl<In: Record, Out: Record> Exchange<In, Out> for StandIn<In, Out> {
    fn send(&mut self, header: Header, fill: &mut dyn FnMut(&mut [Out])) -> Result<(), ExchangeError> {
        self.header = header;
        fill(&mut self.outgoing);
        Ok(())
    }

    fn receive(
        &mut self,
        window: &Window,
        read: &mut dyn FnMut(&Header, &[In]),
    ) -> Result<(), ExchangeError> {
        (self.answer)(window, &mut self.incoming);
        read(&window.header(), &self.incoming);
        Ok(())
    }
}

/// The motion that the scene prescribes, at the end of each window.
#[must_use]
pub fn prescribed_motion(scene: &CheckedScene) -> Answer<Kinematics> {
    let grains = scene.grains.clone();
    Box::new(move |window, out| {
        let t = window.time + window.dt;
        for (grain, motion) in grains.iter().zip(out) {
            *motion = motion_at(grain, t);
        }
    })
}

/// State of a grain that forces do not move, at time `t`.
#[must_use]
pub fn motion_at(grain: &Grain, t: f64) -> Kinematics {
    let (displacement, velocity, spin) = match (grain.motion, grain.oscillation) {
        (Motion::Prescribed, Some(swing)) => swung(&swing, t),
        (Motion::Prescribed, None) => (grain.velocity.map(|v| v * t), grain.velocity, grain.spin),
        (Motion::Free, _) => ([0.0; 3], grain.velocity, grain.spin),
        (Motion::Fixed, _) => ([0.0; 3], [0.0; 3], [0.0; 3]),
    };
    let [w, x, y, z] = grain.orientation;
    let start = nalgebra::UnitQuaternion::from_quaternion(nalgebra::Quaternion::new(w, x, y, z));
    let turned = nalgebra::UnitQuaternion::from_scaled_axis(nalgebra::Vector3::from(spin) * t) * start;
    Kinematics {
        position: std::array::from_fn(|axis| grain.position[axis] + displacement[axis]),
        orientation: [turned.w, turned.i, turned.j, turned.k],
        velocity,
        spin,
        ..Kinematics::default()
    }
}

/// Displacement since t = 0, velocity and spin of a swinging grain.
fn swung(swing: &Oscillation, t: f64) -> ([f64; 3], [f64; 3], [f64; 3]) {
    let rate = 2.0 * std::f64::consts::PI * swing.frequency;
    let angle = rate * t + swing.phase;
    let displacement = swing.amplitude.map(|speed| speed / rate * (swing.phase.cos() - angle.cos()));
    (displacement, swing.amplitude.map(|speed| speed * angle.sin()), [0.0; 3])
}

/// Buoyancy alone: −m_f g on every grain, where the scene has a fluid.
#[must_use]
pub fn buoyancy(scene: &CheckedScene) -> Answer<Loads> {
    let gravity = scene.scene.gravity;
    let density = scene.scene.medium.as_ref().map_or(0.0, |medium| medium.density);
    let displaced: Vec<f64> = scene.grains.iter().map(|grain| density * grain.volume()).collect();
    Box::new(move |_, out| {
        for (mass, loads) in displaced.iter().zip(out) {
            *loads = Loads { force: gravity.map(|g| -mass * g), ..Loads::default() };
        }
    })
}

/// Steps of a solver alone.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Clock {
    /// Largest window, s.
    pub window: f64,
    /// DEM sub-step, s (infinite for a fluid).
    pub substep: f64,
    /// May a window be shortened by the solver's own limit?
    pub adaptive: bool,
}

impl Clock {
    /// The next window from `time`, ending at `until` at the latest; the last two share what is left, so that
    /// none is a sliver, over which the mean of a force means nothing.
    #[must_use]
    pub fn next(&self, step: u64, time: f64, until: f64, limit: f64, output: bool) -> Window {
        let wished = if self.adaptive { self.window.min(limit) } else { self.window };
        // A remainder of a few parts in 1e9 is rounding, not a window.
        let dt = match until - time {
            left if left <= wished * (1.0 + 1e-9) => left,
            left if left < wished * (2.0 - 1e-9) => 0.5 * left,
            _ => wished,
        };
        let substeps =
            if self.substep.is_finite() { (dt / self.substep * (1.0 - 1e-12)).ceil().max(1.0) } else { 1.0 };
        Window { step, attempt: 0, time, dt, substeps: substeps as u64, output }
    }
}

/// One window of a solver alone.
///
/// # Errors
/// As [`Participant::advance`].
pub fn advance<P: Participant>(
    solver: &mut P,
    window: &Window,
    exchange: &mut StandIn<P::Incoming, P::Outgoing>,
) -> Result<WindowReport, SolverError> {
    let report = solver.advance(window, exchange)?;
    if window.output {
        solver.write_fields(window)?;
    }
    Ok(report)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_last_window_lands_on_the_end() {
        let clock = Clock { window: 0.1, substep: 0.03, adaptive: false };
        let (mut time, mut step) = (0.0, 0);
        while time < 1.05 {
            let window = clock.next(step, time, 1.05, f64::INFINITY, false);
            assert_eq!(window.substeps, if window.dt > 0.09 { 4 } else { 3 });
            assert!(window.dt > 0.07, "no window is a sliver: {}", window.dt);
            time = window.time + window.dt;
            step += 1;
        }
        assert_eq!((time, step), (1.05, 11));
    }

    #[test]
    fn a_swing_is_the_integral_of_its_velocity() {
        let swing = Oscillation { amplitude: [0.0, 0.0, 2.0], frequency: 0.5, phase: 0.3 };
        let h = 1e-5;
        let (before, after) = (swung(&swing, 0.7 - h).0[2], swung(&swing, 0.7 + h).0[2]);
        let velocity = swung(&swing, 0.7).1[2];
        assert!(((after - before) / (2.0 * h) - velocity).abs() < 1e-8);
        assert_eq!(swung(&swing, 0.0).0, [0.0; 3]);
    }
}
