//! The drag that changes within a window (docs/equations-immersed.md, section 12).
//!
//! A fluid sends one force a window, that of the motion with which the window begins. Contacts make the
//! grains of a bed vibrate, and where windows are not short against a period that force feeds the vibration.
//! What the fluid would add within the window is, for a sphere of velocity v and spin ω,
//!
//! ```text
//! −2c (v − vⁿ),     2c  = m_f (18 n + 10.2 n^½)/dt,   n = ν dt/D²
//! −2c' (ω − ωⁿ),    2c' = I_f (60 n + 5.6 n^½)/dt
//! ```
//!
//! steady drag and sudden motion together, divided by the window. Half of it suffices: with
//!
//! ```text
//! −c (v − vⁿ) + ½ c dt A_prev
//! ```
//!
//! no window is too long (**test** `tests/dem/window_drag.rs`). The second term gives back what the first
//! took in the window before, so that a steady change of velocity feels neither.

use crate::grain::Shape;
use crate::grains::{Grains, Response};
use crate::motion::Vec3;
use crate::search::lists::Neighbours;
use crate::spec::{DemSpec, Integrator};
use std::f64::consts::PI;

/// Steady drag and sudden motion of a sphere, over m_f and I_f.
const MOVING: [f64; 2] = [18.0, 10.2];
const TURNING: [f64; 2] = [60.0, 5.6];
/// Where it acts (docs/stability.md, Contacts and windows): not at all up to the first number, whole from the
/// second on. Of dt/t_c …
const LONG: [f64; 2] = [0.1, 0.25];
/// … of the fluid's answer to a spin in a window over what it turns, (60 n + 5.6 n^½)/(ρ_p/ρ + ½) …
const VISCOUS: [f64; 2] = [0.2, 0.4];
/// … and, the other way round, of −ln(e_n) dt/t_c, what a contact's own dashpot takes in a window.
const DAMPED: [f64; 2] = [0.2, 0.3];
/// Contacts from which on a grain is one of a bed, as in the fluid's virtual mass.
const OF_A_BED: u8 = 2;

#[derive(Clone, Debug)]
pub(crate) struct WindowDrag {
    /// ρ, kg/m³, and ν, m²/s.
    density: f64,
    viscosity: f64,
    contact_time: f64,
    /// −ln e_n.
    damping: f64,
    /// Length of the present window, s; 0 without loads.
    pub(super) window: f64,
    contacts: Vec<u8>,
}

/// 0 up to the first of `ends`, 1 from the second on.
fn ramp(value: f64, [from, to]: [f64; 2]) -> f64 {
    ((value - from) / (to - from)).clamp(0.0, 1.0)
}

impl WindowDrag {
    /// Of a run; none without a fluid, springs, or spheres that kicks move.
    pub(crate) fn of(spec: &DemSpec) -> Option<Self> {
        let law = spec.contact.linear()?;
        let masses = spec.grains.iter().map(|grain| spec.shape.mass(grain.radius, grain.density));
        let lightest = masses.fold(f64::INFINITY, f64::min);
        let acts = spec.fluid_density > 0.0
            && spec.viscosity > 0.0
            && spec.shape == Shape::Sphere
            && spec.integrator != Integrator::Rk3;
        acts.then(|| Self {
            density: spec.fluid_density,
            viscosity: spec.viscosity / spec.fluid_density,
            contact_time: law.contact_time_of(0.5 * lightest),
            damping: -law.restitution.ln(),
            window: 0.0,
            contacts: Vec::with_capacity(spec.grains.len()),
        })
    }

    /// Acts over the sub-step `dt` on the grains of `lists` with two contacts or more, which had `start` as
    /// velocities and spins when the window began.
    pub(crate) fn act(
        &mut self,
        dt: f64,
        grains: &mut Grains,
        response: &Response,
        lists: &Neighbours,
        start: (&[Vec3], &[Vec3]),
    ) {
        let windows = self.window / self.contact_time;
        let part = ramp(windows, LONG) * (1.0 - ramp(self.damping * windows, DAMPED));
        if part == 0.0 {
            return;
        }
        self.count(grains.len(), lists);
        let back = 0.5 * self.window;
        for i in (0..grains.len()).filter(|i| self.contacts[*i] >= OF_A_BED) {
            let radius = grains.radius[i];
            let mass = self.density * 4.0 / 3.0 * PI * radius.powi(3);
            let number = self.viscosity * self.window / (4.0 * radius * radius);
            let drag = |[steady, sudden]: [f64; 2]| steady * number + sudden * number.sqrt();
            let viscous = ramp(drag(TURNING) / (grains.mass[i] / mass + 0.5), VISCOUS);
            let share = 0.5 * part * viscous * dt / self.window * mass;
            hold(
                &mut grains.velocity[i],
                &(start.0[i] + grains.acceleration[i] * back),
                &(response.inverse_mass[i] * (share * drag(MOVING))),
            );
            hold(
                &mut grains.spin[i],
                &(start.1[i] + grains.spin_acceleration[i] * back),
                &(response.inverse_inertia[i] * (share * drag(TURNING) * 0.4 * radius * radius)),
            );
        }
    }

    /// Counts the contacts that bear a force.
    fn count(&mut self, grains: usize, lists: &Neighbours) {
        let contacts = &mut self.contacts;
        contacts.clear();
        contacts.resize(grains, 0);
        let mut note = |grain: u32| {
            let count = &mut contacts[grain as usize];
            *count = count.saturating_add(1);
        };
        let Neighbours { pairs, walls, .. } = lists;
        for k in (0..pairs.len()).filter(|k| pairs.touching[*k]) {
            note(pairs.first[k]);
            note(pairs.other[k]);
        }
        (0..walls.len()).filter(|k| walls.touching[*k]).for_each(|k| note(walls.first[k]));
    }
}

/// v ← v − c (v − to), at the new v.
fn hold(v: &mut Vec3, to: &Vec3, c: &Vec3) {
    for axis in 0..3 {
        v[axis] = (v[axis] + c[axis] * to[axis]) / (1.0 + c[axis]);
    }
}
