//! Lubrication in all gaps of a sub-step at once.
//!
//! The implicit equations of all gaps together are the condition of least
//! ½ Σ_i M_i |v_i − v*_i|² + (1/dt) Σ_gaps ∫Φ: a convex function, so visiting one gap after the
//! other, each with its impulse re-solved against the present velocities, converges to the one
//! solution (Gauss–Seidel; "sequential impulses" in rigid-body dynamics). One gap, or gaps that
//! share no grain that can move, are exact after one sweep. Each visit changes both partners by
//! opposite impulses, so momentum is kept to round-off whatever the number of sweeps.
//!
//! Within a window a sub-step begins with the impulses extrapolated from the two before: they change
//! little, so that few sweeps do what many would from zero. A window begins from zero, so nothing of this
//! is state.
//!
//! The order is fixed: gaps that act, grain pairs (i, j) ascending, then walls by grain, in classes without a
//! common grain that can move ([`crate::lubrication::packs`]); eight of a class are visited at once. M_i
//! holds the virtual mass, locked directions have zero inverse mass.

use crate::grains::{Grains, Response};
use crate::lubrication::film_list::{FilmList, Geometry};
use crate::lubrication::law::LubricationModel;
use crate::lubrication::packs::Packs;
use crate::lubrication::rows::Rows;
use crate::lubrication::visit::Pass;
use crate::motion::Vec3;
use crate::search::contact_list::ContactList;
use crate::surroundings::Surroundings;
use crate::vector::kernel::dispatch;

/// The implicit pass; its memory is kept between sub-steps.
#[derive(Clone, Debug, Default)]
pub(crate) struct LubricationSolver {
    list: FilmList,
    packs: Packs,
    rows: Rows,
    /// Mean force of the films on each wall over the last sub-step, N.
    pub(crate) on_walls: Vec<Vec3>,
    /// Leave the widest vectors unused (tests).
    plain: bool,
}

impl LubricationSolver {
    /// Without films; `plain` leaves the widest vectors unused.
    pub(crate) fn new(plain: bool) -> Self {
        Self { plain, ..Self::default() }
    }

    /// Takes new neighbour lists.
    pub(crate) fn take(
        &mut self,
        around: &Surroundings,
        model: &LubricationModel,
        grains: &Grains,
        lists: (&ContactList, &ContactList),
    ) {
        self.packs.keep(&self.list);
        self.list.build(model, grains, around.walls.len(), lists);
        self.on_walls.resize(around.walls.len(), Vec3::zeros());
        self.packs.reserve(self.list.first.len(), grains.len() + around.walls.len() + 1);
    }

    /// A window begins: the next sub-step starts from nothing.
    pub(crate) fn forget(&mut self) {
        self.packs.forget();
    }

    /// Applies the impulses of all gaps over `dt` to the velocities, in place, and writes the mean
    /// force of the gaps on each grain into `force`. Positions stay at the start of the sub-step.
    pub(crate) fn apply(
        &mut self,
        around: &Surroundings,
        (model, sweeps): (&LubricationModel, u32),
        grains: &mut Grains,
        response: &Response,
        (t, dt): (f64, f64),
        force: &mut [Vec3],
    ) {
        let Self { list, packs, rows, on_walls, plain } = self;
        rows.load(grains, response, (&around.walls, t), model.tangential);
        dispatch(Geometry { list, rows, length: around.periods.length, dt }, *plain);
        list.meet_walls(rows, &around.walls, (t, dt));
        packs.update(list, rows);
        if packs.films > 0 {
            let sweeps = if packs.films == 1 { 1 } else { sweeps };
            let pass = Pass { model, list, packs: &mut packs.packs, rows, sweeps, dt };
            dispatch(pass, *plain);
        }
        rows.store(grains, force, on_walls);
    }
}
