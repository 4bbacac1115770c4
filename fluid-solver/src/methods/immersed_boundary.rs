//! What a method of the immersed boundary does in a window, in this order (docs/equations-immersed.md,
//! section 3):
//!
//! ```text
//! place     the grains where they are expected at the end of the window, and the force with them
//! step      the fluid, with that force
//! measure   what the fluid does to each grain
//!           (the loads are sent, the motion of the grains comes back)
//! impose    that motion on the fluid
//! ```

use super::grains::Grains;
use crate::grid::Grid;
use crate::step::Stepper;
use protocol::message::Loads;
use protocol::participant::Window;

/// Vectors by axis and side of the walls of the box.
pub type OnWalls<const D: usize> = [[[f64; D]; 2]; D];

/// A method of the immersed boundary on `D` axes.
pub trait ImmersedBoundary<const D: usize>: Send {
    /// Puts grains and force where they are expected at the end of the window.
    fn place(&mut self, fluid: &Stepper<D>, grains: &mut Grains<D>, window: &Window);

    /// One step of the fluid of length `dt`, s.
    fn step(&mut self, fluid: &mut Stepper<D>, grains: &mut Grains<D>, dt: f64);

    /// Finds what the fluid does to each grain in the step.
    fn measure(&mut self, fluid: &mut Stepper<D>, grains: &mut Grains<D>, dt: f64);

    /// The message about each grain.
    fn loads(&self, grains: &Grains<D>, out: &mut [Loads]);

    /// Imposes the motion that came back, [`Memory::motions`](super::grains::Memory::motions).
    fn impose(&mut self, fluid: &mut Stepper<D>, grains: &mut Grains<D>, dt: f64);

    /// Finds again what follows from fields and grains, after these were set.
    fn resume(&mut self, fluid: &Stepper<D>, grains: &mut Grains<D>);

    /// How fast the fluid still goes through the grain through which it goes fastest, m/s, and which one that
    /// is, as far as grains at rest are meant: a force that is carried from window to window grows by what is
    /// left of the flow through its grain, over dt. None where no force is carried.
    fn leak(&self, _: &Grains<D>) -> Option<(f64, usize)> {
        None
    }

    /// Part of the step `allowed`, s, that a touch leaves of it, one that was in this window or one that is
    /// near; `spacing`: smallest cell, m.
    fn part_of_step(&mut self, _: &Grains<D>, _allowed: f64, _spacing: f64) -> f64 {
        1.0
    }

    /// Mean force over the density of the fluid on the walls of the box in the last window, of length `dt`,
    /// s, by axis, side and component, m⁴/s² (plane: m³/s²), that pressure and friction do not have.
    fn force_on_walls(&self, _: &Grid<D>, _dt: f64) -> Option<OnWalls<D>> {
        None
    }

    /// Mean of p/ρ over the last window, m²/s², where that of its end is none of it.
    fn mean_pressure(&self) -> Option<&[f64]> {
        None
    }

    /// Values at points of the bodies that decide the next window, by component: the method's part of a
    /// checkpoint beside fields and grains.
    fn points(&self) -> Option<&[Vec<f64>; D]> {
        None
    }

    /// The same, to be set before [`ImmersedBoundary::resume`].
    fn points_mut(&mut self) -> Option<&mut [Vec<f64>; D]> {
        None
    }
}
