//! The flow on its grid: what a step works on.

use crate::field::State;
use crate::ghosts::{Ghosts, Side};
use crate::grid::Grid;
use crate::halo::{fill_velocity_across, fill_velocity_and_open};
use crate::near_convection::NearConvection;
use crate::scheme::Options;

/// Grid, choices and state of a flow.
pub struct Flow<const D: usize> {
    pub(crate) grid: Grid<D>,
    pub(crate) options: Options<D>,
    pub(crate) state: State<D>,
    /// Terms of convection near grains, where there are any.
    pub(crate) near: Option<Box<NearConvection<D>>>,
}

impl<const D: usize> Flow<D> {
    /// Refreshes halo, wall faces and open faces of the velocity.
    pub(crate) fn fill_halos(&mut self) {
        let State { velocity, open, .. } = &mut self.state;
        if !self.grid.division.ranks().is_alone() {
            return fill_divided(&self.grid, velocity);
        }
        for (d, u) in velocity.iter_mut().enumerate() {
            fill_velocity_and_open(&self.grid, open, d, u);
        }
    }

    /// Computes the terms of convection near grains from the present velocity.
    pub(crate) fn refresh_near(&mut self) {
        let Some(near) = &mut self.near else { return };
        if !self.grid.division.ranks().is_alone() {
            let mut fields: Vec<_> =
                self.state.velocity.iter_mut().map(|u| (&mut u[..], Side::Both)).collect();
            Ghosts::new(&self.grid).fetch(2, &mut fields);
        }
        near.evaluate(&self.grid, &self.state.velocity);
    }

    /// Whether fluid passes through a face of the box.
    pub(crate) fn is_open(&self) -> bool {
        !self.state.open.is_empty()
    }

    /// Moves the velocity on outflow faces on by `dt` (s), and fills the halos with it.
    pub(crate) fn convect_outflow(&mut self, dt: f64) {
        if self.is_open() {
            self.state.open.convect(&self.grid, &self.state.velocity, dt);
            self.fill_halos();
        }
    }
}

/// Halos and wall faces of the planes of a rank and of those beside it, which it fetches.
fn fill_divided<const D: usize>(grid: &Grid<D>, velocity: &mut [Vec<f64>; D]) {
    for (d, u) in velocity.iter_mut().enumerate() {
        (0..D - 1).for_each(|axis| fill_velocity_across(grid, d, axis, u));
    }
    let mut fields: Vec<_> = velocity.iter_mut().map(|u| (&mut u[..], Side::Both)).collect();
    Ghosts::new(grid).fetch(1, &mut fields);
    for (d, u) in velocity.iter_mut().enumerate() {
        fill_velocity_across(grid, d, D - 1, u);
    }
}
