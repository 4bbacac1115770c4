//! Both solvers at once: the loads of a window are those that the fluid formed in the one before.

use super::{FluidExchange, Solver};
use crate::health::Health;
use crate::work::Work;
use protocol::message::Loads;
use protocol::participant::{SolverError, Window};

impl<const D: usize> Solver<D> {
    /// yu-shao-2007, yu-shao-fixed-point: send the loads kept, predict u* while the DEM works, keep the loads
    /// of it, receive the motion, impose it.
    pub(super) fn window_overlapped(
        &mut self,
        window: &Window,
        exchange: &mut FluidExchange<'_>,
    ) -> Result<Health, SolverError> {
        let kept = &self.memory.kept;
        exchange.send(window.header(), &mut |out| out.copy_from_slice(kept))?;
        let work = Work::begin();
        let health = self.predict(window)?;
        self.seconds += work.seconds();
        self.receive(window, exchange)?;
        let work = Work::begin();
        self.keep();
        self.impose_carried();
        self.seconds += work.seconds();
        Ok(health)
    }

    /// Loads for the first window, of a flow that has not been looked at: buoyancy, and what moves the fluid
    /// as a whole.
    pub(super) fn keep_first(&mut self) {
        let drive = self.memory.first_drive(&self.stepper);
        let Self { rule, immersed, memory, .. } = self;
        memory.kept = immersed.shapes().iter().map(|shape| rule.first(shape, drive)).collect();
    }

    /// Loads for the next window. The acceleration in them is that of this one, the A_prev that the DEM will
    /// add.
    fn keep(&mut self) {
        self.measure_virtual_mass();
        let Self { rule, immersed, measured, memory, .. } = self;
        for (grain, m) in measured.iter_mut().enumerate() {
            m.acceleration = memory.acceleration(grain);
            m.drive = [0.0; 3];
        }
        let loads = immersed.shapes().iter().zip(&*measured).map(|(shape, m)| rule.loads(shape, m));
        memory.kept.iter_mut().zip(loads).for_each(|(kept, loads): (&mut Loads, Loads)| *kept = loads);
    }
}
