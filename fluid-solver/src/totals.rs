//! Sums over the box that `observe.totals` asks for, in the order of
//! [`bedload_output::totals::fluid_values`].

use crate::boundary::Boundary;
use crate::field::for_each_own_row;
use crate::solver::Solver;
use crate::step::Stepper;
use crate::threads::share;
use bedload_scene::{CheckedScene, Total};

/// Number of sums of a component: velocity times volume, volume, and the forces by axis and side.
const SUMS: usize = 2 + 6;

/// All of them, by sum and component.
type Sums = [[f64; 3]; SUMS];

/// What is asked for.
#[derive(Clone, Debug)]
pub(crate) struct Totals {
    /// The mean velocity along every axis but this one.
    across: Option<usize>,
    forces: bool,
    /// Sums over the components after the last window; none where the state was put back since.
    last: Option<Sums>,
}

impl Totals {
    pub(crate) fn of(scene: &CheckedScene) -> Option<Self> {
        let asked = scene.scene.observe.totals.as_ref()?;
        let across = scene.scene.domain.geometry.axes().iter().position(|axis| *axis == asked.axis);
        let forces = asked.has(&Total::ON_WALLS);
        Some(Self { across: across.filter(|_| asked.has(&[Total::FluidFlux])), forces, last: None })
    }

    /// The state is another one than after the last window.
    pub(crate) fn put_back(&mut self) {
        self.last = None;
    }

    /// Before a window. Every rank must call it.
    pub(crate) fn begin<const D: usize>(&mut self, solver: &Solver<D>) {
        if self.forces && self.last.is_none() {
            self.last = Some(self.components(solver));
        }
    }

    /// Sums over the components; one rank adds its planes after the other.
    fn components<const D: usize>(&self, solver: &Solver<D>) -> Sums {
        let mut sums = Sums::default();
        let flat = sums.as_flattened_mut();
        solver.grid().division.ranks().relay(flat, |flat| {
            let sums: &mut Sums = flat.as_chunks_mut().0.try_into().expect("as many as there are");
            // A component is summed from below, by one thread.
            let mut columns: [_; D] = std::array::from_fn(|d| sums.each_ref().map(|sums| sums[d]));
            let fluid = (solver.stepper(), solver.density());
            share(&mut columns[..], 0..D, 1, &|components, columns| {
                components.zip(columns).for_each(|(d, column)| self.add_component(fluid, d, column));
            });
            for (d, column) in columns.iter().enumerate() {
                sums.iter_mut().zip(column).for_each(|(sums, sum)| sums[d] = *sum);
            }
        });
        sums
    }

    /// After a window: what the fluid is now, and the mean forces over the window, friction by those at its
    /// ends. Every rank must call it.
    pub(crate) fn measure<const D: usize>(&mut self, solver: &Solver<D>, out: &mut Vec<f64>) {
        let grid = solver.grid();
        let mut sums = self.components(solver);
        if let Some(before) = self.last.replace(sums) {
            for (now, before) in sums[2..].as_flattened_mut().iter_mut().zip(before[2..].as_flattened()) {
                *now = 0.5 * (before + *now);
            }
        }
        if self.forces {
            grid.division.ranks().relay(sums.as_flattened_mut(), |flat| {
                self.add_pressure(solver, flat.as_chunks_mut().0.try_into().expect("as many as there are"));
            });
        }
        let beyond = if self.forces { solver.beyond_stress() } else { None };
        for (sum, push) in sums[2..].iter_mut().zip(beyond.iter().flatten().flatten()) {
            sum.iter_mut().zip(push).for_each(|(sum, push)| *sum += solver.density() * push);
        }
        if let Some(across) = self.across {
            out.extend((0..D).filter(|d| *d != across).map(|d| sums[0][d] / sums[1][d]));
        }
        for (a, sides) in grid.boundaries.iter().enumerate().filter(|_| self.forces) {
            for side in (0..2).filter(|side| is_wall(&sides[*side])) {
                out.extend_from_slice(&sums[2 + 2 * a + side][..D]);
            }
        }
    }

    /// Momentum, and friction on walls: μ (u − U)/(½ Δ) over the face, with the value next to it.
    fn add_component<const D: usize>(
        &self,
        (stepper, density): (&Stepper<D>, f64),
        d: usize,
        sums: &mut [f64; SUMS],
    ) {
        let (grid, u) = (stepper.grid(), &stepper.state().velocity[d]);
        let friction = 2.0 * density * stepper.options().viscosity;
        let [mut momentum, mut whole] = [sums[0], sums[1]];
        for_each_own_row(grid, d, |mut at, places| {
            // What is beside a wall along other axes, the whole row is.
            let walls = |a: usize, cell: usize| {
                let sides = [0, grid.cells[a] - 1].into_iter().enumerate();
                let wall = move |side: usize| matches!(grid.boundaries[a][side], Boundary::NoSlip { .. });
                sides.filter(move |(side, face)| self.forces && a != d && cell == *face && wall(*side))
            };
            let beside = (1..D).any(|a| walls(a, at[a]).next().is_some());
            let ends = [at[0], at[0] + places.len() - 1];
            // Momentum where it is asked for, else walls alone.
            if self.across.is_none() && !beside && ends.iter().all(|end| walls(0, *end).next().is_none()) {
                return;
            }
            let rest: [f64; D] = std::array::from_fn(|a| grid.volumes(d, a)[at[a]]);
            for (index, first) in places.zip(&grid.volumes(d, 0)[at[0]..]) {
                // As `control_volume` has it.
                let volume = rest[1..].iter().fold(grid.turn() * first, |volume, next| volume * next);
                momentum += u[index] * volume;
                whole += volume;
                if beside || ends.contains(&at[0]) {
                    for a in 0..D {
                        for (side, face) in walls(a, at[a]) {
                            let width = grid.axes[a].widths[face];
                            let (area, slip) =
                                (volume / width, u[index] - grid.boundaries[a][side].velocity(d));
                            sums[2 + 2 * a + side] += friction * slip / width * area;
                        }
                    }
                }
                at[0] += 1;
            }
        });
        [sums[0], sums[1]] = [momentum, whole];
    }

    /// Pressure on walls, whose slope across them is zero.
    fn add_pressure<const D: usize>(&self, solver: &Solver<D>, sums: &mut Sums) {
        let (grid, p) = (solver.grid(), solver.pressure());
        for row in grid.own_rows() {
            let rest = [0, row % grid.cells[1], row / grid.cells[1]];
            let face = |a: usize, side: usize| if side == 0 { 0 } else { grid.cells[a] - 1 };
            let wall = |a: usize, side: usize| is_wall(&grid.boundaries[a][side]);
            let beside =
                |a: usize, cell: usize| (0..2).filter(move |side| cell == face(a, *side) && wall(a, *side));
            let rows = (1..D).any(|a| beside(a, rest[a]).next().is_some());
            let cells = if rows { 0..grid.cells[0] } else { 0..1 };
            let last = (!rows && grid.cells[0] > 1).then(|| grid.cells[0] - 1);
            for i in cells.chain(last) {
                let at: [usize; D] = std::array::from_fn(|a| if a == 0 { i } else { rest[a] });
                for (a, side) in (0..D).flat_map(|a| beside(a, at[a]).map(move |side| (a, side))) {
                    let area = grid.cell_volume(at) / grid.axes[a].widths[at[a]];
                    let outward = if side == 0 { -1.0 } else { 1.0 };
                    sums[2 + 2 * a + side][a] += outward * solver.density() * p[grid.row(row) + i] * area;
                }
            }
        }
    }
}

fn is_wall<const D: usize>(boundary: &Boundary<D>) -> bool {
    matches!(boundary, Boundary::NoSlip { .. } | Boundary::FreeSlip)
}
