//! Forces on the grains in a window, kept for the stresses that they transmit.

use protocol::message::{Kinematics, Loads};

/// Forces on the grains in the last window, N.
#[derive(Clone, Debug, Default)]
pub(crate) struct GrainForces {
    /// Of the fluid, without buoyancy; of contacts; of lubrication.
    pub(crate) of: [Vec<[f64; 3]>; 3],
}

impl GrainForces {
    pub(crate) fn new(grains: usize) -> Self {
        Self { of: std::array::from_fn(|_| vec![[0.0; 3]; grains]) }
    }

    /// Keeps what the fluid sends of grains that displace `masses` of it, kg, under `gravity`, m/s².
    pub(crate) fn keep_loads(
        &mut self,
        gravity: [f64; 3],
        masses: impl Iterator<Item = f64>,
        loads: &[Loads],
    ) {
        for ((kept, mass), sent) in self.of[0].iter_mut().zip(masses).zip(loads) {
            *kept = std::array::from_fn(|c| sent.force[c] + mass * gravity[c]);
        }
    }

    /// Keeps what comes back.
    pub(crate) fn keep_kinematics(&mut self, records: &[Kinematics]) {
        let [_, contact, lubrication] = &mut self.of;
        for ((contact, lubrication), record) in contact.iter_mut().zip(lubrication).zip(records) {
            (*contact, *lubrication) = (record.contact_force, record.lubrication_force);
        }
    }
}
