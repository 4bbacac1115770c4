//! What a contact does to the fluid in its own window (docs/equations-immersed.md, section 11).
//!
//! A contact is short: the fluid feels the jump ΔU_c of a grain's velocity as an impulsive pressure, in which
//! viscosity has no part. So the jump's flow δu is potential flow about a hard mask b,
//! ```text
//! δu = P Λ,   Λ = Σ_i q_i (ΔU_i − δu),   q = e^{−2s/w},   P: projection, of homogeneous walls
//! ```
//! or with Λ = b Y and b = q/(1 + q)
//! ```text
//! (1 − b) Y + P b Y = ΔU
//! ```
//! which, times b, is symmetric and positive: conjugate gradients with the metric ∫ b f g dV. The grain gets
//! what the fluid took, once, with the next message.

use crate::field::{clear_own, own_planes};
use crate::grid::Grid;
use crate::immersed::Immersed;
use crate::immersed::body::{Motion, Shape};
use crate::immersed::mask_model::{Mask, MaskModel};
use crate::immersed::places::{Places, Values, fewest};
use crate::methods::grains::Grains;
use crate::step::Stepper;
use crate::threads::share;

use super::wall_impulse::WallImpulse;

/// Residual at which the solve ends, over that at its start: what the fluid takes is within 0.2 % of what it
/// is at a tenth of it, for half as many projections.
const RESIDUAL: f64 = 1e-2;

/// Largest number of projections of a solve; 6 to 10 do.
const MOST: usize = 40;

/// Radius of a mask that holds nothing, over that of the grain.
const NO_MASK: f64 = -1e3;

/// The potential flow of jumps.
pub(super) struct Contact<const D: usize> {
    /// The grains, with a mask where they have a jump or are held.
    immersed: Immersed<D>,
    /// Which grains the fluid moves.
    free: Vec<bool>,
    motions: Vec<Motion>,
    /// ∫ b dV of each grain, m³.
    volumes: Vec<[f64; 3]>,
    places: Places<D>,
    /// At the places: b, and b times the control volume, m³.
    mask: Values<D>,
    weight: Values<D>,
    /// Y, and ΔU less what Y makes of the left side, m/s.
    force: Values<D>,
    residual: Values<D>,
    /// Where to go next, and what that makes of the left side, m/s.
    direction: Values<D>,
    image: Values<D>,
    /// What it does to the walls of the box, where that is asked for.
    pub(super) walls: Option<WallImpulse<D>>,
}

impl<const D: usize> Contact<D> {
    /// For grains of which `free` says whether the fluid moves them; `walls`: forces on the walls of the box
    /// are asked for.
    pub(super) fn new(grid: &Grid<D>, shapes: &[Shape], free: Vec<bool>, walls: bool) -> Self {
        let values = || std::array::from_fn(|_| Vec::new());
        Self {
            immersed: Immersed::new(grid, shapes.to_vec(), false),
            free,
            motions: vec![Motion::default(); shapes.len()],
            volumes: vec![[0.0; 3]; shapes.len()],
            places: Places::default(),
            mask: values(),
            weight: values(),
            force: values(),
            residual: values(),
            direction: values(),
            image: values(),
            walls: walls.then(|| WallImpulse::new(grid)),
        }
    }

    /// Gives the fluid the jumps of `grains`, whose contacts began at the `parts` of the window of length
    /// `dt`, s; what it took goes to the memory. `field`: all zero before and after, for what is projected.
    pub(super) fn give(
        &mut self,
        fluid: &mut Stepper<D>,
        grains: &mut Grains<D>,
        parts: &[f64],
        dt: f64,
        field: &mut [Vec<f64>; D],
    ) {
        let memory = &mut grains.memory;
        memory.taken.fill([0.0; 3]);
        self.walls.iter_mut().for_each(WallImpulse::clear);
        if memory.jumps.as_flattened().iter().all(|jump| *jump == 0.0) {
            return;
        }
        let model = MaskModel { mask: Mask::Izard2014, dt: 1.0, ..grains.model };
        for (grain, motion) in self.motions.iter_mut().enumerate() {
            let jump = memory.jumps[grain];
            let place = memory.before[grain].predicted(parts.get(grain).unwrap_or(&1.0) * dt);
            *motion = Motion { velocity: jump, spin: [0.0; 3], ..place };
            let holds = jump != [0.0; 3] || !self.free[grain];
            let shape = &mut self.immersed.shapes_mut()[grain];
            shape.mask_radius = shape.radius * if holds { 1.0 } else { NO_MASK };
        }
        self.fit(fluid.grid(), &model, field);
        self.solve(fluid, &model, field);
        let Self { immersed, places, mask, force, residual, direction, image, walls, .. } = self;
        project(fluid, places, field, (mask, force, image), |grid, sign, flow| {
            walls.iter_mut().for_each(|walls| walls.add(grid, sign, flow));
        });
        walls.iter_mut().for_each(|walls| walls.find(fluid.grid()));
        let own = own_planes(fluid.grid());
        for (u, flow) in fluid.state_mut().velocity.iter_mut().zip(&*field) {
            u[own.clone()].iter_mut().zip(&flow[own.clone()]).for_each(|(u, flow)| *u += flow);
        }
        // The part of Λ that is a grain's is b_i (ΔU_i + Λ − δu), less what is left of the residual.
        multiply(mask, force, direction);
        add(image, -1.0, direction);
        add(image, 1.0, residual);
        places.scatter(image, field);
        let forces = immersed.forces((fluid.grid(), &model, &self.motions), field, None);
        let taken = memory.taken.iter_mut().zip(&memory.jumps).zip(forces).zip(grains.immersed.shapes());
        for (((taken, jump), force), shape) in taken.filter(|(((_, jump), _), _)| **jump != [0.0; 3]) {
            *taken = std::array::from_fn(|c| force.force[c] / shape.volume - jump[c]);
        }
        clear_own(fluid.grid(), field);
    }

    /// Gives each mask the volume of its grain: its smooth edge holds more outside than it lacks inside. One
    /// that the box cuts stays as it is.
    fn fit(&mut self, grid: &Grid<D>, model: &MaskModel, field: &[Vec<f64>; D]) {
        let Self { immersed, motions, volumes, .. } = self;
        immersed.contents((grid, model, motions), field);
        immersed.volumes(grid.geometry, volumes);
        // The first rank alone knows them.
        let ranks = grid.division.ranks();
        if !ranks.is_alone() {
            ranks.spread(volumes.as_flattened_mut());
        }
        for (grain, volumes) in volumes.iter().enumerate() {
            let filled = volumes.iter().filter(|volume| **volume > 0.0);
            let (count, sum) = filled.fold((0.0, 0.0), |(count, sum), volume| (count + 1.0, sum + volume));
            if count > 0.0 {
                let shape = &mut immersed.shapes_mut()[grain];
                let ratio = (shape.volume * count / sum).min(1.0);
                let power = 1.0 / f64::from(grid.geometry.grain_dimensions());
                shape.mask_radius = shape.radius * ratio.powf(power);
            }
        }
    }

    /// Finds the places, b and Y.
    fn solve(&mut self, fluid: &mut Stepper<D>, model: &MaskModel, field: &mut [Vec<f64>; D]) {
        let Self { immersed, motions, places, mask, weight, force, residual, direction, image, .. } = self;
        let grid = fluid.grid();
        immersed.impose_direct((grid, model, motions), field);
        places.clear();
        places.add(grid, immersed);
        // b ΔU
        places.gather(field, residual);
        immersed.store_mask((grid, model, motions), field);
        places.gather(field, mask);
        places.volumes(grid, image);
        multiply(mask, image, weight);
        change(residual, [mask], |residual, [b]| *residual = if b > 0.0 { *residual / b } else { 0.0 });
        for ((force, direction), residual) in force.iter_mut().zip(&mut *direction).zip(&*residual) {
            direction.clone_from(residual);
            force.clear();
            force.resize(residual.len(), 0.0);
        }
        let first = product(fluid.grid(), weight, residual, residual);
        let mut size = first;
        let mut rounds = 0;
        while rounds < MOST && size > RESIDUAL * RESIDUAL * first {
            rounds += 1;
            project(fluid, places, field, (mask, direction, image), |_, _, _| {});
            change(image, [direction, mask], |image, [direction, b]| *image += (1.0 - b) * direction);
            let step = size / product(fluid.grid(), weight, direction, image);
            add(force, step, direction);
            add(residual, -step, image);
            let before = size;
            size = product(fluid.grid(), weight, residual, residual);
            let ratio = size / before;
            change(direction, [residual], |direction, [residual]| *direction = residual + ratio * *direction);
        }
    }
}

/// `field` and, at the places, `out` ← P b Y; `seen` gets b Y with 1, then P b Y with −1.
fn project<const D: usize>(
    fluid: &mut Stepper<D>,
    places: &Places<D>,
    field: &mut [Vec<f64>; D],
    (mask, force, out): (&Values<D>, &Values<D>, &mut Values<D>),
    mut seen: impl FnMut(&Grid<D>, f64, &[Vec<f64>; D]),
) {
    clear_own(fluid.grid(), field);
    multiply(mask, force, out);
    places.scatter(out, field);
    seen(fluid.grid(), 1.0, field);
    fluid.project_other(field);
    seen(fluid.grid(), -1.0, field);
    places.gather(field, out);
}

/// Calls `with` for every value of `to` and those of `from` at its place, components side by side where there
/// are many values.
fn change<const D: usize, const N: usize>(
    to: &mut Values<D>,
    from: [&Values<D>; N],
    with: impl Fn(&mut f64, [f64; N]) + Sync,
) {
    let most = fewest(to);
    share(&mut to[..], 0..D, most, &|components, to| {
        for (d, to) in components.zip(to) {
            let from = from.map(|values| &values[d][..to.len()]);
            for (k, to) in to.iter_mut().enumerate() {
                with(to, from.map(|values| values[k]));
            }
        }
    });
}

/// `out` ← a b.
fn multiply<const D: usize>(a: &Values<D>, b: &Values<D>, out: &mut Values<D>) {
    out.iter_mut().zip(a).for_each(|(out, a)| out.resize(a.len(), 0.0));
    change(out, [a, b], |out, [a, b]| *out = a * b);
}

/// `to` += factor `from`.
fn add<const D: usize>(to: &mut Values<D>, factor: f64, from: &Values<D>) {
    change(to, [from], |to, [from]| *to += factor * from);
}

/// Σ weight a b over the places of all ranks, in the order of the planes whatever the number of ranks.
fn product<const D: usize>(grid: &Grid<D>, weight: &Values<D>, a: &Values<D>, b: &Values<D>) -> f64 {
    let mut sums = [0.0; D];
    grid.division.ranks().relay(&mut sums, |sums| {
        share(sums, 0..D, fewest(weight), &|components, sums| {
            for (d, sum) in components.zip(sums) {
                let values = weight[d].iter().zip(&a[d]).zip(&b[d]);
                values.for_each(|((weight, a), b)| *sum += weight * a * b);
            }
        });
    });
    sums.iter().sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::axis::AxisSpec;
    use crate::boundary::{Boundary, Profile};
    use crate::engines::HasEngine;
    use crate::grid::{Geometry, GridSpec};
    use crate::measure::momentum;
    use crate::methods::virtual_mass::images::at_a_wall;
    use crate::scheme::{Options, Scheme, Viscous};

    const DT: f64 = 0.1;

    fn fluid<const D: usize>(
        geometry: Geometry,
        lengths: [f64; D],
        n: usize,
        boundaries: [[Boundary<D>; 2]; D],
    ) -> Stepper<D>
    where
        Grid<D>: HasEngine<D>,
    {
        let axes = lengths.map(|end| AxisSpec::Uniform { start: 0.0, end, cells: (end * n as f64) as usize });
        let grid = Grid::new(&GridSpec { geometry, axes, boundaries }).expect("a grid");
        let options = Options {
            viscosity: 0.01,
            scheme: Scheme::AdamsBashforth2,
            viscous: Viscous::Explicit,
            convection: true,
            body_force: [0.0; D],
        };
        Stepper::new(grid, options)
    }

    /// Spheres of D = 1 at rest at these places get these jumps; what the fluid took of each.
    fn given<const D: usize>(
        fluid: &mut Stepper<D>,
        centres: &[[f64; 3]],
        jumps: &[[f64; 3]],
        free: &[bool],
    ) -> Vec<[f64; 3]> {
        let volume = std::f64::consts::PI / 6.0;
        let shape = Shape::round(0.5, 2.0, volume, 0.1);
        let shapes = vec![shape; centres.len()];
        let model = MaskModel { mask: Mask::ParameterFree, width: 0.5, wave: 1.0, viscosity: 0.01, dt: DT };
        let motions = centres.iter().map(|centre| Motion { centre: *centre, ..Motion::default() }).collect();
        let grid = fluid.grid();
        let mut grains = Grains::new(Immersed::new(grid, shapes.clone(), false), model, motions, None);
        let mut contact = Contact::new(grid, &shapes, free.to_vec(), false);
        grains.memory.jumps = jumps.to_vec();
        let mut field = grid.new_vector();
        contact.give(fluid, &mut grains, &vec![1.0; jumps.len()], DT, &mut field);
        assert!(field.iter().flatten().all(|value| *value == 0.0));
        grains.memory.taken
    }

    const TUBE: [[Boundary<2>; 2]; 2] =
        [[Boundary::Axis, Boundary::FreeSlip], [Boundary::WALL, Boundary::FreeSlip]];

    /// The fluid takes the added mass of an ideal fluid: far from walls, near one and touching it.
    #[test]
    fn the_fluid_takes_the_added_mass() {
        for (n, limit) in [(10, 0.02), (16, 0.015), (32, 0.012)] {
            for gap in [2.5, 0.5, 0.1, 0.0] {
                let mut fluid = fluid(Geometry::Axisymmetric, [3.0, 6.0], n, TUBE);
                let taken = given(&mut fluid, &[[0.0, 0.0, 0.5 + gap]], &[[0.0, 0.0, 1.0]], &[true])[0][2];
                let exact = at_a_wall(3, 0.5, gap);
                println!("D/dx {n} gap {gap} D: C {taken:.4}, exact {exact:.4}");
                assert!((taken / exact - 1.0).abs() < limit, "D/dx {n} gap {gap}: {taken} {exact}");
                let grid = fluid.grid();
                let centre = grid.index([0, ((0.5 + gap) * n as f64) as isize]);
                let inside = fluid.state().velocity[1][centre];
                assert!((inside - 1.0).abs() < 0.01, "{inside}");
            }
        }
    }

    /// What the fluid takes of two spheres that touch, and jump aside, is what it has then: to rounding. A
    /// third one that has no jump is not felt, unless it is held.
    #[test]
    fn the_fluid_has_what_it_took() {
        let periodic = [[Boundary::Periodic; 2]; 3];
        let centres = [[0.6, 1.1, 0.9], [1.4, 1.7, 0.9], [0.7, 0.4, 1.6]];
        let jumps = [[1.0, -0.3, 0.2], [-0.7, 0.1, 0.0], [0.0; 3]];
        let mut two = Vec::new();
        for count in [2, 3] {
            let mut fluid = fluid(Geometry::Space, [2.0; 3], 10, periodic);
            let taken = given(&mut fluid, &centres[..count], &jumps[..count], &[true; 3][..count]);
            for c in 0..3 {
                let sum: f64 = taken.iter().zip(&jumps).map(|(taken, jump)| taken[c] + jump[c]).sum();
                let found = momentum(fluid.grid(), c, &fluid.state().velocity[c]);
                assert!((found - sum * std::f64::consts::PI / 6.0).abs() < 1e-13, "{c}: {found} {sum}");
            }
            if count == 3 {
                assert_eq!(two, taken[..2]);
                let mut fluid = self::fluid(Geometry::Space, [2.0; 3], 10, periodic);
                assert_ne!(two, given(&mut fluid, &centres, &jumps, &[true, true, false])[..2]);
            }
            two = taken;
        }
    }

    /// An impulsive pressure moves no fluid through a face, whatever flows there, nor feels a wall that
    /// moves.
    #[test]
    fn faces_of_the_box_are_closed_to_a_jump() {
        let inflow = Boundary::Inflow { velocity: [0.0, 2.0], profile: Profile::Uniform };
        let moving = Boundary::NoSlip { velocity: [0.0, 3.0] };
        let mut found = Vec::new();
        for faces in [TUBE, [[Boundary::Axis, moving], [inflow, Boundary::Outflow]]] {
            let mut fluid = fluid(Geometry::Axisymmetric, [1.5, 3.0], 10, faces);
            let open = fluid.state().open.clone();
            found.push(given(&mut fluid, &[[0.0, 0.0, 0.7]], &[[0.0, 0.0, 1.0]], &[true]));
            assert_eq!(open, fluid.state().open);
        }
        assert_eq!(found[0], found[1]);
    }
}
