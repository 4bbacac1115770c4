//! The first cell that is not finite after a step that failed.
//!
//! The pressure of one cell depends on every other, so one bad cell spoils the whole velocity within a
//! stage. [`Stepper`] therefore stops at the first projection whose solution is not finite, and this
//! file looks at what that projection was given.

use crate::field::for_each_own_unknown;
use crate::grid::Grid;
use crate::immersed::body::laboratory;
use crate::ranks::Ranks;
use crate::step::Stepper;
use std::fmt;

/// A value that is not finite, or the one that grew most where all are spoilt alike.
#[derive(Clone, Debug, PartialEq)]
pub struct FirstNonFinite<const D: usize> {
    /// What it is a value of.
    pub what: &'static str,
    /// Component, by grid axis.
    pub component: usize,
    /// Cell: the value stands on its lower face along the component's axis.
    pub cell: [usize; D],
    /// Its place, m, along the grid's axes.
    pub position: [f64; D],
    /// The value.
    pub value: f64,
    /// Axis letter of the component.
    letter: char,
}

/// Names of what may be wrong, in the order in which they are reported.
const FIELDS: [&str; 5] = [
    "the force of the grains on the fluid",
    "the acceleration by convection",
    "the velocity",
    "of what is finite still the largest velocity",
    "of what is finite still the largest acceleration by convection",
];

impl<const D: usize> fmt::Display for FirstNonFinite<D> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { what, cell, position, value, letter, .. } = self;
        write!(f, "{what} along {letter} is {value:e} in cell {cell:?}, at {position:?} m")
    }
}

impl<const D: usize> FirstNonFinite<D> {
    /// Looks for it after a step that went wrong; `force` is what the caller gave to that step.
    pub fn find(stepper: &Stepper<D>, force: Option<&[Vec<f64>; D]>) -> Self {
        let (grid, state) = (stepper.grid(), stepper.state());
        let bad = |x: f64| !x.is_finite();
        let first = |what, field: &[Vec<f64>; D]| Self::first(grid, what, field, bad);
        let [of_force, of_convection, of_velocity, ..] = FIELDS;
        // In the order in which one is made of the other. Where viscosity is implicit its solution
        // spreads what is bad over everything: then the convection term tells, or nothing does.
        force
            .and_then(|force| first(of_force, force))
            .or_else(|| first(of_convection, &state.history))
            .or_else(|| first(of_velocity, &state.velocity).filter(|_| Self::is_local(grid, &state.velocity)))
            .unwrap_or_else(|| Self::largest(grid, &state.velocity, &state.history))
    }

    /// What the first of `ranks` reports: the first in the order of `FIELDS` of what all ranks found in
    /// their planes.
    pub fn of_all(&self, ranks: &Ranks) -> String {
        let place = FIELDS.iter().position(|what| *what == self.what).unwrap_or(FIELDS.len());
        let mine = (place * ranks.size() + ranks.rank()) as f64;
        let mut first = [mine];
        ranks.combine(&mut first, f64::min);
        let text = if first == [mine] { self.to_string() } else { String::new() };
        let letters: Vec<f64> = text.chars().map(|letter| f64::from(u32::from(letter))).collect();
        let all = ranks.gather(&letters).concat();
        all.iter().filter_map(|letter| char::from_u32(*letter as u32)).collect()
    }

    fn new(grid: &Grid<D>, what: &'static str, component: usize, cell: [usize; D], value: f64) -> Self {
        let position = std::array::from_fn(|a| grid.nodes(component, a)[cell[a]]);
        let letter = ['x', 'y', 'z'][laboratory(grid.geometry, component)];
        Self { what, component, cell, position, value, letter }
    }

    /// The first value of a field, in memory order, for which `is_bad` holds.
    fn first(
        grid: &Grid<D>,
        what: &'static str,
        field: &[Vec<f64>; D],
        is_bad: impl Fn(f64) -> bool,
    ) -> Option<Self> {
        let mut found = None;
        for (d, u) in field.iter().enumerate().filter(|(_, u)| !u.is_empty()) {
            for_each_own_unknown(grid, d, |at, index| {
                if found.is_none() && is_bad(u[index]) {
                    found = Some(Self::new(grid, what, d, at, u[index]));
                }
            });
        }
        found
    }

    /// Whether a component has a finite value left: nothing has been spread over everything.
    fn is_local(grid: &Grid<D>, field: &[Vec<f64>; D]) -> bool {
        Self::first(grid, "", field, f64::is_finite).is_some()
    }

    /// The largest finite value of the velocity, or of the convection where no velocity is finite.
    fn largest(grid: &Grid<D>, velocity: &[Vec<f64>; D], history: &[Vec<f64>; D]) -> Self {
        let of = |what, field: &[Vec<f64>; D]| {
            let mut most: Option<Self> = None;
            for (d, u) in field.iter().enumerate() {
                for_each_own_unknown(grid, d, |at, index| {
                    let value = u[index];
                    if value.is_finite() && most.as_ref().is_none_or(|most| value.abs() > most.value.abs()) {
                        most = Some(Self::new(grid, what, d, at, value));
                    }
                });
            }
            most
        };
        let [.., of_velocity, of_convection] = FIELDS;
        of(of_velocity, velocity)
            .or_else(|| of(of_convection, history))
            .unwrap_or_else(|| Self::new(grid, FIELDS[2], 0, [0; D], f64::NAN))
    }
}
