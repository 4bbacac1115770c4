//! A window again and again from the same start, until the motion that it leads to is the one it began with.

use super::{FluidExchange, Solver};
use crate::attempts::numbers;
use crate::health::Health;
use crate::immersed::Wrench;
use crate::work::Work;
use protocol::participant::{SolverError, Window};

/// Added to C_v for each ν dt/D²: in long windows the drag of the first attempts, taken with a force that
/// knows nothing of the motion yet, would throw a light grain out of the box. From 1 to 18 all converge at
/// ν dt/D² = 0.8; 0 does not below ρ_r = 0.5. Without influence on what they converge to.
const DRAG: f64 = 2.0;

impl<const D: usize> Solver<D> {
    /// yu-shao-fixed-point: as [`Solver::window_semi_implicit`], with the force that the attempt before would
    /// leave behind in place of the one carried from the last window, from the second attempt on. The state
    /// is that of the start of the window already: whoever orders an attempt restores it.
    pub(super) fn window_iterated(
        &mut self,
        window: &Window,
        exchange: &mut FluidExchange<'_>,
    ) -> Result<Health, SolverError> {
        let work = Work::begin();
        self.guess(window);
        let health = self.predict(window)?;
        self.virtual_mass_ahead(window.dt);
        self.seconds += work.seconds();
        self.exchange(window, exchange)?;
        let work = Work::begin();
        self.impose_carried();
        let Self { attempts, stepper, immersed, lambda, memory, .. } = self;
        if let Some(attempts) = attempts {
            attempts.note(window.dt, stepper.grid(), immersed, lambda, &memory.motions);
        }
        self.seconds += work.seconds();
        Ok(health)
    }

    /// The force and the motion at the end of the window with which this attempt begins: in the first the
    /// force carried and the acceleration of the last window, so that it is the semi-implicit one.
    fn guess(&mut self, window: &Window) {
        let Self { attempts, stepper, immersed, lambda, memory, .. } = self;
        let Some(attempts) = attempts else { return };
        if window.attempt > 0 && attempts.has_begun() {
            attempts.go_on(immersed, lambda);
            return;
        }
        let drive = memory.first_drive(stepper);
        let motion = memory.motions.iter().enumerate().map(|(grain, motion)| {
            let (u, mut a) = (numbers(motion), numbers_of(&memory.acceleration(grain)));
            (0..3).for_each(|c| a[c] += drive[c]);
            std::array::from_fn(|c| u[c] + window.dt * a[c])
        });
        attempts.begin(stepper.grid(), immersed, lambda, motion);
    }

    /// The DEM adds m_a A_prev with the acceleration of the last window; the message adds what the attempt
    /// before knows better.
    fn virtual_mass_ahead(&mut self, dt: f64) {
        let Self { attempts, measured, memory, immersed, model, .. } = self;
        let Some(attempts) = attempts else { return };
        for (grain, (m, shape)) in measured.iter_mut().zip(immersed.shapes()).enumerate() {
            m.more = DRAG * model.viscosity * dt / (2.0 * shape.radius).powi(2);
            let (guess, now) = (attempts.motion(grain), numbers(&memory.motions[grain]));
            let before = numbers_of(&m.acceleration);
            let ahead = |c: usize| (guess[c] - now[c]) / dt - before[c];
            // It is in the first guess already.
            m.drive = [0.0; 3];
            m.ahead =
                Wrench { force: std::array::from_fn(ahead), torque: std::array::from_fn(|c| ahead(c + 3)) };
        }
    }
}

/// A vector and its moment.
fn numbers_of(wrench: &Wrench) -> [f64; 6] {
    let [f, t] = [wrench.force, wrench.torque];
    [f[0], f[1], f[2], t[0], t[1], t[2]]
}
