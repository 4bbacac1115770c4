//! The cells that hold force, as a list: what the attempts at a window are compared and mixed over.

use super::Immersed;
use super::layer_sums::{first, words};
use crate::grid::Grid;
use crate::threads::share;

/// Values at the [`Places`], by component.
pub type Values<const D: usize> = [Vec<f64>; D];

/// Values from which on components are worked on side by side.
const MANY: usize = 32_768;

/// Fewest components for a thread: all where there are few values.
pub fn fewest<const D: usize>(values: &Values<D>) -> usize {
    if values.iter().map(Vec::len).sum::<usize>() < MANY { D } else { 1 }
}

/// Groups of eight cells that hold force, or held some since [`Places::clear`]. It only grows, at its end:
/// values taken earlier are the beginning of those taken later, and are zero at what has come since.
#[derive(Clone, Debug)]
pub struct Places<const D: usize> {
    /// A bit for each lanes_at, as in [`super::component::Component`].
    marks: [Vec<u64>; D],
    /// Where each eight begins in its field.
    begins: [Vec<usize>; D],
}

impl<const D: usize> Default for Places<D> {
    fn default() -> Self {
        Self { marks: std::array::from_fn(|_| Vec::new()), begins: std::array::from_fn(|_| Vec::new()) }
    }
}

impl<const D: usize> Places<D> {
    /// Forgets all.
    pub fn clear(&mut self) {
        self.marks.iter_mut().for_each(|marks| marks.fill(0));
        self.begins.iter_mut().for_each(Vec::clear);
    }

    /// Number of cells, over all components.
    pub fn cells(&self) -> usize {
        8 * self.begins.iter().map(Vec::len).sum::<usize>()
    }

    /// Adds what holds force now.
    pub fn add(&mut self, grid: &Grid<D>, immersed: &Immersed<D>) {
        let (words, stride, size) = (words(grid), grid.stride(1), grid.stride(D - 1));
        let layers = grid.cells[D - 1];
        for ((marks, begins), component) in
            self.marks.iter_mut().zip(&mut self.begins).zip(&immersed.components)
        {
            marks.resize(component.forced.len(), 0);
            let of_a_layer = (marks.len() / layers).max(1);
            for (index, (mark, forced)) in marks.iter_mut().zip(&component.forced).enumerate() {
                let (k, word) = (index / of_a_layer, index % of_a_layer);
                let place = first(grid, 0) + k * size + word / words * stride + word % words * 512;
                let mut new = forced & !*mark;
                *mark |= forced;
                while new != 0 {
                    begins.push(place + 8 * new.trailing_zeros() as usize);
                    new &= new - 1;
                }
            }
        }
    }

    /// Declares all of them to hold force, so that the next time force is imposed it is taken from those
    /// where no grain is any more.
    pub fn hold(&self, immersed: &mut Immersed<D>) {
        for (component, marks) in immersed.components.iter_mut().zip(&self.marks) {
            component.forced.iter_mut().zip(marks).for_each(|(forced, mark)| *forced |= mark);
        }
    }

    /// `out` ← the control volumes here, in the unit of [`Grid::control_volume`]; zero where there is no
    /// unknown.
    pub fn volumes(&self, grid: &Grid<D>, out: &mut Values<D>) {
        for (d, (begins, out)) in self.begins.iter().zip(out).enumerate() {
            let unknowns = grid.unknowns(d);
            out.clear();
            for begin in begins {
                let mut rest = begin - first(grid, 0);
                let mut at = [0; D];
                for a in (0..D).rev() {
                    (at[a], rest) = (rest / grid.stride(a), rest % grid.stride(a));
                }
                out.extend((0..8).map(|lane| {
                    let at = std::array::from_fn(|a| if a == 0 { at[0] + lane } else { at[a] });
                    let known = unknowns.iter().zip(at).all(|(range, at)| range.contains(&at));
                    if known { grid.control_volume(d, at) } else { 0.0 }
                }));
            }
        }
    }

    /// `out` ← the fields' values here.
    pub fn gather(&self, fields: &[Vec<f64>; D], out: &mut Values<D>) {
        let most = fewest(out);
        share(&mut out[..], 0..D, most, &|components, out| {
            for (d, out) in components.zip(out) {
                out.clear();
                self.begins[d].iter().for_each(|begin| out.extend_from_slice(&fields[d][*begin..*begin + 8]));
            }
        });
    }

    /// Writes values into the fields; those that are missing at the end are zero.
    pub fn scatter(&self, values: &Values<D>, fields: &mut [Vec<f64>; D]) {
        share(&mut fields[..], 0..D, fewest(values), &|components, fields| {
            for (d, field) in components.zip(fields) {
                let (mut groups, zero) = (values[d].chunks_exact(8), [0.0; 8]);
                for begin in &self.begins[d] {
                    field[*begin..*begin + 8].copy_from_slice(groups.next().unwrap_or(&zero[..]));
                }
            }
        });
    }
}
