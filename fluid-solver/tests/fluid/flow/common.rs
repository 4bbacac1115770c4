//! Grids, fields and norms shared by the tests.

use fluid_solver::axis::AxisSpec;
use fluid_solver::boundary::Boundary;
use fluid_solver::engines::HasEngine;
use fluid_solver::field::{State, for_each_unknown};
use fluid_solver::grid::{Geometry, Grid, GridSpec};
use fluid_solver::ranks::Ranks;
use fluid_solver::scheme::{Options, Scheme, Viscous};
use fluid_solver::step::Stepper;

/// The schemes that every order test goes through.
pub(crate) const SCHEMES: [Scheme; 2] = [Scheme::RungeKutta3, Scheme::AdamsBashforth2];

/// Equal cells from 0 to `length`.
pub(crate) fn uniform(length: f64, cells: usize) -> AxisSpec {
    AxisSpec::Uniform { start: 0.0, end: length, cells }
}

/// A plane or space grid.
pub(crate) fn grid<const D: usize>(axes: [AxisSpec; D], boundaries: [[Boundary<D>; 2]; D]) -> Grid<D> {
    let geometry = if D == 2 { Geometry::Plane } else { Geometry::Space };
    let spec = GridSpec { geometry, axes, boundaries };
    Grid::new(&spec).expect("the test's grid is valid")
}

/// A pipe of radius 1 around r = 0, periodic along z, with a wall at rest.
pub(crate) fn pipe(r: AxisSpec, z: AxisSpec) -> Grid<2> {
    let spec = GridSpec {
        geometry: Geometry::Axisymmetric,
        axes: [r, z],
        boundaries: [[Boundary::Axis, Boundary::WALL], [Boundary::Periodic, Boundary::Periodic]],
    };
    Grid::new(&spec).expect("the test's grid is valid")
}

/// A stepper with implicit viscosity, convection and no body force.
pub(crate) fn stepper<const D: usize>(grid: Grid<D>, nu: f64, scheme: Scheme) -> Stepper<D>
where
    Grid<D>: HasEngine<D>,
{
    let options =
        Options { viscosity: nu, scheme, viscous: Viscous::Implicit, convection: true, body_force: [0.0; D] };
    Stepper::new(grid, options)
}

/// N = −∇·(u u) (without `viscosity`, m²/s) or ν ∇²u (with it, Stokes flow) of a velocity, as the stepper
/// computes it: a first step of Adams–Bashforth leaves it in the history.
fn tendency_of<const D: usize>(grid: &Grid<D>, velocity: [Vec<f64>; D], viscosity: f64) -> [Vec<f64>; D]
where
    Grid<D>: HasEngine<D>,
{
    let options = Options {
        viscosity,
        scheme: Scheme::AdamsBashforth2,
        viscous: Viscous::Explicit,
        convection: viscosity == 0.0,
        body_force: [0.0; D],
    };
    let mut stepper = Stepper::new(grid.clone(), options);
    stepper.state_mut().velocity = velocity;
    stepper.advance_without_projection(1.0, None);
    stepper.state().history.clone()
}

/// −∇·(u u) as the stepper computes it.
pub(crate) fn convection_of<const D: usize>(grid: &Grid<D>, velocity: &[Vec<f64>; D]) -> [Vec<f64>; D]
where
    Grid<D>: HasEngine<D>,
{
    tendency_of(grid, velocity.clone(), 0.0)
}

/// ∇²u of component `d` as the stepper computes it.
pub(crate) fn laplacian_of<const D: usize>(grid: &Grid<D>, d: usize, u: &[f64]) -> Vec<f64>
where
    Grid<D>: HasEngine<D>,
{
    let mut velocity = grid.new_vector();
    velocity[d].copy_from_slice(u);
    std::mem::take(&mut tendency_of(grid, velocity, 1.0)[d])
}

/// Volume-weighted root mean square of `u − exact` for component `d`.
pub(crate) fn error<const D: usize>(
    grid: &Grid<D>,
    d: usize,
    u: &[f64],
    exact: impl Fn([f64; D]) -> f64,
) -> f64 {
    let (mut sum, mut volume) = (0.0, 0.0);
    for_each_unknown(grid, d, |at, index| {
        let v = grid.control_volume(d, at);
        let e = u[index] - exact(std::array::from_fn(|a| grid.nodes(d, a)[at[a]]));
        sum += v * e * e;
        volume += v;
    });
    (sum / volume).sqrt()
}

/// Root mean square of the difference of two fields over the unknowns of component `d`.
pub(crate) fn distance<const D: usize>(grid: &Grid<D>, d: usize, a: &[f64], b: &[f64]) -> f64 {
    let (mut sum, mut count) = (0.0_f64, 0.0);
    for_each_unknown(grid, d, |_, index| {
        sum += (a[index] - b[index]).powi(2);
        count += 1.0;
    });
    (sum / count).sqrt()
}

/// Compares every bit of two states, halos and padding included.
pub(crate) fn assert_same<const D: usize>(a: &State<D>, b: &State<D>) {
    let fields = |s: &State<D>| [s.velocity.clone(), s.history.clone()].concat();
    let bits = |f: &[f64]| f.iter().map(|x| x.to_bits()).collect::<Vec<_>>();
    for (name, (x, y)) in fields(a).iter().zip(&fields(b)).enumerate() {
        let differ = bits(x).iter().zip(&bits(y)).filter(|(x, y)| x != y).count();
        assert_eq!(differ, 0, "field {name} of {D} velocities, {D} histories");
        assert!(x.iter().all(|x| x.is_finite()), "field {name} is not finite");
    }
    assert_eq!(bits(&a.pressure), bits(&b.pressure), "pressure");
}

/// Observed order of a sequence of errors with factors of two between them; prints it.
pub(crate) fn observed_order(what: &str, errors: &[f64]) -> f64 {
    let order = |w: &[f64]| (w[0] / w[1]).log2();
    let orders: Vec<f64> = errors.windows(2).map(order).collect();
    let errors: Vec<String> = errors.iter().map(|e| format!("{e:.3e}")).collect();
    println!("{what}: errors {errors:?}, orders {orders:.3?}");
    orders[orders.len() - 1]
}

/// Repeatable numbers in −1..1 (linear congruential generator of Knuth, MMIX constants).
pub(crate) struct Random(pub u64);

impl Random {
    pub(crate) fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    }

    /// Fills the unknowns of component `d`.
    pub(crate) fn fill<const D: usize>(&mut self, grid: &Grid<D>, d: usize, u: &mut [f64]) {
        for_each_unknown(grid, d, |_, index| u[index] = self.next());
    }
}

/// Every grid of the combination tests, small, in plane, axisymmetric and annular geometry.
pub(crate) fn plane_grids() -> Vec<Grid<2>> {
    let mut grids = Vec::new();
    let stretched = AxisSpec::Growing { start: 0.0, core_end: 0.4, width: 0.1, end: 2.0, cells: 11 };
    for z in pairs() {
        for x in pairs() {
            grids.push(grid([uniform(1.0, 12), uniform(1.5, 10)], [x, z]));
            grids.push(grid([uniform(1.0, 9), uniform(1.5, 16)], [x, z]));
            if !x[0].is_periodic() {
                grids.push(grid([stretched.clone(), uniform(1.5, 10)], [x, z]));
            }
            if !z[0].is_periodic() {
                grids.push(grid([uniform(1.0, 12), stretched.clone()], [x, z]));
            }
        }
        for outer in [Boundary::WALL, Boundary::FreeSlip] {
            for r in [uniform(1.0, 10), stretched.clone()] {
                let spec = GridSpec {
                    geometry: Geometry::Axisymmetric,
                    axes: [r, uniform(1.5, 20)],
                    boundaries: [[Boundary::Axis, outer], z],
                };
                grids.push(Grid::new(&spec).expect("a valid pipe"));
            }
            let spec = GridSpec {
                geometry: Geometry::Axisymmetric,
                axes: [AxisSpec::Uniform { start: 0.5, end: 1.5, cells: 10 }, uniform(1.5, 8)],
                boundaries: [[outer, Boundary::WALL], z],
            };
            grids.push(Grid::new(&spec).expect("a valid annulus"));
        }
    }
    grids
}

/// Every grid of the combination tests in space.
pub(crate) fn space_grids() -> Vec<Grid<3>> {
    let mut grids = Vec::new();
    for x in pairs() {
        for y in pairs() {
            for z in pairs() {
                grids.push(grid([uniform(1.0, 10), uniform(1.2, 9), uniform(0.8, 8)], [x, y, z]));
            }
        }
    }
    let stretched = AxisSpec::Faces(vec![0.0, 0.1, 0.22, 0.36, 0.5, 0.68, 0.9]);
    let [p, w] = [Boundary::Periodic, Boundary::WALL];
    grids.push(grid(
        [uniform(1.0, 12), uniform(1.2, 16), stretched],
        [[p, p], [w, w], [w, Boundary::FreeSlip]],
    ));
    // Blocks along z, of equal and of different numbers of planes.
    for z in pairs() {
        for cells in [8_u8, 33] {
            let axes = [uniform(1.0, 10), uniform(1.2, 9), uniform(0.1 * f64::from(cells), cells.into())];
            let grid = grid(axes, [[p, p], [w, w], z]);
            grids.push(grid.divided(Ranks::alone()).expect("enough planes"));
        }
    }
    grids
}

/// Every pair of conditions that the two faces of an axis can have.
fn pairs<const D: usize>() -> [[Boundary<D>; 2]; 5] {
    let [p, w, s] = [Boundary::Periodic, Boundary::WALL, Boundary::FreeSlip];
    [[p, p], [w, w], [s, s], [w, s], [s, w]]
}

/// Puts a saved state back, on the same grid.
pub(crate) fn put_back<const D: usize>(stepper: &mut Stepper<D>, saved: &State<D>) {
    *stepper.state_mut() = saved.clone();
    stepper.restart(saved.time, saved.previous_dt, saved.steps);
}

/// ½ ∫ u² dV over the unknowns, m⁵/s² per unit density (plane: per metre of depth).
pub(crate) fn kinetic_energy<const D: usize>(grid: &Grid<D>, velocity: &[Vec<f64>; D]) -> f64 {
    let mut energy = 0.0;
    for (d, u) in velocity.iter().enumerate() {
        for_each_unknown(grid, d, |at, index| {
            energy += 0.5 * u[index] * u[index] * grid.control_volume(d, at);
        });
    }
    energy
}
