//! Inflow and outflow: entry flows against exact developed profiles, symmetry, conservation, same
//! bits, and outflow that turns back.

use crate::flow::common::{SCHEMES, assert_same, error, grid, observed_order, put_back, stepper, uniform};
use crate::flow::reference::largest_divergence;
use fluid_solver::axis::AxisSpec;
use fluid_solver::boundary::{Boundary, Profile};
use fluid_solver::engines::HasEngine;
use fluid_solver::field::{State, for_each_unknown, set_component};
use fluid_solver::grid::{Geometry, Grid, GridSpec};
use fluid_solver::open::OpenFaces;
use fluid_solver::scheme::{Options, Scheme, Viscous};
use fluid_solver::step::Stepper;
use std::f64::consts::PI;

/// Inflow with mean velocity `speed` along `axis`.
fn inflow<const D: usize>(axis: usize, speed: f64, profile: Profile) -> Boundary<D> {
    let mut velocity = [0.0; D];
    velocity[axis] = speed;
    Boundary::Inflow { velocity, profile }
}

/// Faces of an axis along which fluid flows with mean `speed`: upwards if positive.
fn through<const D: usize>(axis: usize, speed: f64, profile: Profile) -> [Boundary<D>; 2] {
    let inflow = inflow(axis, speed, profile);
    if speed > 0.0 { [inflow, Boundary::Outflow] } else { [Boundary::Outflow, inflow] }
}

/// Runs `steps` steps of `dt` and checks continuity: round-off over the cell width.
fn settle<const D: usize>(s: &mut Stepper<D>, steps: usize, dt: f64) {
    s.project_velocity();
    (0..steps).for_each(|_| s.step(dt, None));
    let divergence = largest_divergence(s.grid(), &s.state().velocity);
    assert!(divergence < 1e-11, "divergence {divergence:e}");
}

/// Root mean square of component `d` less `exact` where `there`.
fn error_where<const D: usize>(
    s: &Stepper<D>,
    d: usize,
    there: impl Fn([f64; D]) -> bool,
    exact: impl Fn([f64; D]) -> f64,
) -> f64 {
    let (g, u) = (s.grid(), &s.state().velocity[d]);
    let (mut sum, mut count) = (0.0, 0.0);
    for_each_unknown(g, d, |at, index| {
        let x = std::array::from_fn(|a| g.nodes(d, a)[at[a]]);
        if there(x) {
            sum += (u[index] - exact(x)).powi(2);
            count += 1.0;
        }
    });
    (f64::sqrt(sum / count)).max(f64::MIN_POSITIVE)
}

/// A channel of width 1 and length 5 along `axis` of the plane, entered by a uniform stream.
fn plane_channel(n: usize, axis: usize, speed: f64) -> Grid<2> {
    let mut axes = [uniform(1.0, n), uniform(1.0, n)];
    axes[axis] = uniform(5.0, 5 * n);
    let mut boundaries = [[Boundary::WALL; 2]; 2];
    boundaries[axis] = through(axis, speed, Profile::Uniform);
    grid(axes, boundaries)
}

/// Entry of a uniform stream into a plane channel: from 2.5 widths on the parabola 6 U z (1 − z)
/// (what is left of the entry decays like e^{−4.2 x}, 3e-5), second order, along either axis and
/// either way, whatever the scheme; the pressure falls by 12 ν U.
#[test]
fn plane_entry_flow_becomes_the_parabola() {
    for (axis, speed, scheme) in
        [(0, 1.0, SCHEMES[0]), (0, -1.0, SCHEMES[0]), (1, 1.0, SCHEMES[1]), (1, -1.0, SCHEMES[0])]
    {
        let mut slopes = Vec::new();
        let errors = [8, 16, 32].map(|n| {
            let mut s = stepper(plane_channel(n, axis, speed), 0.5, scheme);
            settle(&mut s, 60 * n / 8, 0.4 / n as f64);
            let x = |x: [f64; 2]| if speed > 0.0 { x[axis] } else { 5.0 - x[axis] };
            let exact = |at: [f64; 2]| 6.0 * speed * at[1 - axis] * (1.0 - at[1 - axis]);
            let p = |i: usize| {
                let mut at = [n as isize / 2; 2];
                at[axis] = if speed > 0.0 { i } else { 5 * n - 1 - i } as isize;
                s.state().pressure[s.grid().index(at)]
            };
            slopes.push(((p(4 * n) - p(3 * n)) / (12.0 * 0.5) + 1.0).abs());
            error_where(&s, axis, |at| x(at) > 2.5, exact)
        });
        assert!(observed_order(&format!("entry along {axis} at {speed}"), &errors) > 1.9);
        assert!(observed_order("its pressure", &slopes) > 1.9);
    }
}

/// A parabola that enters stays what it is: the whole channel within the excess of the discrete
/// parabola, second order.
#[test]
fn parabolic_inflow_stays_a_parabola() {
    let errors = [8, 16, 32].map(|n| {
        let z = through(0, 2.0, Profile::Parabolic);
        let g = grid([uniform(3.0, 3 * n), uniform(1.0, n)], [z, [Boundary::WALL; 2]]);
        let mut s = stepper(g, 0.2, Scheme::AdamsBashforth2);
        settle(&mut s, 20 * n, 0.2 / n as f64);
        error(s.grid(), 0, &s.state().velocity[0], |[_, z]| 12.0 * z * (1.0 - z))
    });
    assert!(observed_order("parabola", &errors) > 1.9);
    assert!(errors[2] < 3e-3, "{errors:?}");
}

/// Uniform stream between free-slip faces: nothing changes, to round-off.
#[test]
fn uniform_stream_passes_unchanged() {
    let slip = [Boundary::FreeSlip; 2];
    for scheme in SCHEMES {
        let x = Boundary::Inflow { velocity: [1.0, 0.0, 0.25], profile: Profile::Uniform };
        let g = grid(
            [uniform(2.0, 16), uniform(1.0, 8), uniform(1.0, 8)],
            [[x, Boundary::Outflow], slip, [Boundary::Periodic; 2]],
        );
        let mut s = stepper(g.clone(), 0.01, scheme);
        for (d, value) in [(0, 1.0), (2, 0.25)] {
            set_component(&g, d, &mut s.state_mut().velocity[d], |_| value);
        }
        settle(&mut s, 40, 0.05);
        for (d, value) in [(0, 1.0), (1, 0.0), (2, 0.25)] {
            assert!(error(&g, d, &s.state().velocity[d], |_| value) < 1e-13, "{scheme:?} {d}");
        }
    }
}

/// A tube of radius 1 and length 6 around r = 0.
fn tube(r: AxisSpec, n: usize, speed: f64, profile: Profile) -> Grid<2> {
    let spec = GridSpec {
        geometry: Geometry::Axisymmetric,
        axes: [r, uniform(6.0, 3 * n)],
        boundaries: [[Boundary::Axis, Boundary::WALL], through(1, speed, profile)],
    };
    Grid::new(&spec).expect("a valid tube")
}

/// Entry into a tube, upwards and downwards: Hagen–Poiseuille, 2 U (1 − r²), second order.
#[test]
fn tube_entry_flow_becomes_hagen_poiseuille() {
    for speed in [1.0, -1.0] {
        let errors = [8, 16, 32].map(|n| {
            let mut s = stepper(tube(uniform(1.0, n), n, speed, Profile::Uniform), 1.0, SCHEMES[1]);
            settle(&mut s, 10 * n, 0.3 / n as f64);
            let far = |[_, z]: [f64; 2]| if speed > 0.0 { z > 3.5 } else { z < 2.5 };
            error_where(&s, 1, far, |[r, _]| 2.0 * speed * (1.0 - r * r))
        });
        assert!(observed_order(&format!("tube at {speed}"), &errors) > 1.9);
    }
}

/// Developed flow of mean 1 in a square duct of width 1 (White 1974, eq. 3-48): sum of the modes
/// cosh/cos, normalised by its own mean.
fn duct(y: f64, z: f64) -> f64 {
    let (mut u, mut mean) = (0.0, 0.0);
    for k in (1..80).step_by(2) {
        let k = PI * f64::from(k);
        // e^{-…} forms do not overflow.
        let ratio = |y: f64| ((k * (y - 1.0)).exp() + (-k * y).exp()) / (1.0 + (-k).exp());
        u += (k * z).sin() / k.powi(3) * (1.0 - ratio(y));
        mean += 2.0 / k.powi(4) * (1.0 - 2.0 / k * (0.5 * k).tanh());
    }
    u / mean
}

/// Entry into a square duct in space along each axis: the developed series, second order.
#[test]
fn duct_entry_flow_becomes_the_series() {
    for (axis, speed, scheme) in [(0, 1.0, SCHEMES[1]), (1, -1.0, SCHEMES[0]), (2, 1.0, SCHEMES[0])] {
        let errors = [12, 24].map(|n| {
            let mut axes = [uniform(1.0, n), uniform(1.0, n), uniform(1.0, n)];
            axes[axis] = uniform(4.0, 4 * n);
            let mut boundaries = [[Boundary::WALL; 2]; 3];
            boundaries[axis] = through(axis, speed, Profile::Uniform);
            let mut s = stepper(grid(axes, boundaries), 1.0, scheme);
            settle(&mut s, 10 * n, 0.3 / n as f64);
            let (a, b) = ((axis + 1) % 3, (axis + 2) % 3);
            let far = |x: [f64; 3]| if speed > 0.0 { x[axis] > 2.5 } else { x[axis] < 1.5 };
            error_where(&s, axis, far, |x| speed * duct(x[a], x[b]))
        });
        assert!(observed_order(&format!("duct along {axis} at {speed}"), &errors) > 1.9);
    }
}

/// A disturbed stream past walls: every kind of open face has something to do.
fn disturbed<const D: usize>(g: &Grid<D>, scheme: Scheme, viscous: Viscous) -> Stepper<D>
where
    Grid<D>: HasEngine<D>,
{
    let options = Options { viscosity: 0.02, scheme, viscous, convection: true, body_force: [0.0; D] };
    let mut s = Stepper::new(g.clone(), options);
    for d in 0..D {
        set_component(g, d, &mut s.state_mut().velocity[d], |x| {
            let phase: f64 = (0..D).map(|a| (1.0 + (a + d) as f64) * x[a]).sum();
            if d == 1 { 0.0 } else { f64::from(d == 0) + 0.7 * (2.0 * phase).sin() }
        });
    }
    s.project_velocity();
    s
}

/// A plane flow in space, periodic across, is the plane flow: open along x, then along z.
#[test]
fn plane_flow_in_space_is_the_plane_flow() {
    let (p, w) = ([Boundary::Periodic; 2], [Boundary::WALL; 2]);
    for scheme in SCHEMES {
        for viscous in [Viscous::Implicit, Viscous::Explicit] {
            for (axis, speed) in [(0, 1.0), (0, -1.0), (1, 1.0), (1, -1.0)] {
                let [x, z] = [uniform(2.0, 16), uniform(1.0, 12)];
                let mut flat = [[Boundary::WALL; 2]; 2];
                flat[axis] = through(axis, speed, Profile::Parabolic);
                let mut space = [w, p, w];
                space[2 * axis] = through(2 * axis, speed, Profile::Parabolic);
                let g2: Grid<2> = grid([x.clone(), z.clone()], flat);
                let g3: Grid<3> = grid([x, uniform(1.0, 8), z], space);
                let mut s2 = disturbed_plane(&g2, scheme, viscous);
                let mut s3 = disturbed_plane(&g3, scheme, viscous);
                for _ in 0..10 {
                    s2.step(0.01, None);
                    s3.step(0.01, None);
                }
                for (d, c) in [(0, 0), (1, 2)] {
                    let u = &s2.state().velocity[d];
                    let there = |at: [usize; 3]| u[g2.index([at[0] as isize, at[2] as isize])];
                    let mut worst = 0.0_f64;
                    for_each_unknown(&g3, c, |at, index| {
                        worst = worst.max((s3.state().velocity[c][index] - there(at)).abs());
                    });
                    assert!(worst < 1e-11, "{scheme:?} {viscous:?} axis {axis} {speed}: {worst:e}");
                }
            }
        }
    }
}

/// Like [`disturbed`], independent of y.
fn disturbed_plane<const D: usize>(g: &Grid<D>, scheme: Scheme, viscous: Viscous) -> Stepper<D>
where
    Grid<D>: HasEngine<D>,
{
    let options = Options { viscosity: 0.02, scheme, viscous, convection: true, body_force: [0.0; D] };
    let mut s = Stepper::new(g.clone(), options);
    for d in [0, D - 1] {
        let state = s.state_mut();
        set_component(g, d, &mut state.velocity[d], |x| {
            (3.0 * x[0] + 2.0 * x[D - 1] + f64::from(d > 0)).sin()
        });
    }
    s.project_velocity();
    s
}

/// What leaves is what enters, every step, to round-off, on several faces at once.
#[test]
fn as_much_leaves_as_enters() {
    let g = grid(
        [uniform(1.0, 12), uniform(1.2, 10), uniform(0.8, 8)],
        [
            [inflow(0, 1.0, Profile::Parabolic), Boundary::Outflow],
            [Boundary::WALL, Boundary::FreeSlip],
            [inflow(2, 0.5, Profile::Uniform), Boundary::Outflow],
        ],
    );
    for scheme in SCHEMES {
        let mut s = disturbed(&g, scheme, Viscous::Explicit);
        let entering = s.state().open.flow(&g, false);
        assert!((entering - (1.2 * 0.8 + 0.5 * 1.2)).abs() < 1e-14, "{entering}");
        for _ in 0..20 {
            s.step(5e-3, None);
            assert!(largest_divergence(&g, &s.state().velocity) < 1e-11);
        }
    }
}

/// Vortices much faster than the stream leave: the outflow turns back for a while. The flow stays
/// finite, never becomes faster than at the start, and is the uniform stream in the end.
#[test]
fn outflow_that_turns_back_does_no_harm() {
    for scheme in SCHEMES {
        let x = [inflow(0, 1.0, Profile::Uniform), Boundary::Outflow];
        let g = grid([uniform(4.0, 64), uniform(2.0, 32)], [x, [Boundary::FreeSlip; 2]]);
        let mut s = stepper(g.clone(), 2e-3, scheme);
        let vortex = |x: f64, z: f64| 8.0 * (-((x - 2.8).powi(2) + (z - 1.0).powi(2)) / 0.1).exp();
        let state = s.state_mut();
        set_component(&g, 0, &mut state.velocity[0], |[x, z]| 1.0 - (z - 1.0) / 0.2 * vortex(x, z));
        set_component(&g, 1, &mut state.velocity[1], |[x, z]| (x - 2.8) / 0.2 * vortex(x, z));
        s.project_velocity();
        let fastest = |s: &Stepper<2>| {
            s.state()
                .velocity
                .iter()
                .flatten()
                .fold(0.0_f64, |m, u| if u.is_finite() { m.max(u.abs()) } else { f64::INFINITY })
        };
        let (start, mut back) = (fastest(&s), false);
        for _ in 0..2400 {
            s.step(5e-3, None);
            back |= s.state().open.faces()[1].values[0].iter().any(|u| *u < -0.5);
            assert!(fastest(&s) < 1.05 * start, "{scheme:?}: {} of {start}", fastest(&s));
        }
        assert!(back, "the outflow never turned back: the test is void");
        let left = error(&g, 0, &s.state().velocity[0], |_| 1.0);
        assert!(left < 0.05, "{scheme:?}: {left}");
    }
}

/// Nothing enters any more: what is left of the parabola on the outflow does not drive a flow, and viscosity
/// takes all of it, as e^{−π² ν t}.
#[test]
fn a_channel_whose_inflow_stops_comes_to_rest() {
    for scheme in SCHEMES {
        let mut s = stepper(plane_channel(8, 0, 1.0), 0.5, scheme);
        settle(&mut s, 100, 0.02);
        s.state_mut().open.fields_mut().take(2).for_each(|values| values.fill(0.0));
        settle(&mut s, 300, 0.02);
        let left = s.state().velocity.iter().flatten().fold(0.0_f64, |most, u| most.max(u.abs()));
        assert!(left < 1e-6, "{scheme:?}: {left}");
    }
}

/// Open grids for the tests of same bits, large enough for four threads.
fn space_grid() -> Grid<3> {
    grid(
        [uniform(1.0, 40), uniform(1.2, 42), uniform(0.8, 44)],
        [
            through(0, 1.0, Profile::Parabolic),
            [Boundary::WALL; 2],
            [Boundary::Outflow, inflow(2, -0.5, Profile::Uniform)],
        ],
    )
}

/// Three steps of a disturbed stream on a pool of threads.
fn run<const D: usize>(g: &Grid<D>, scheme: Scheme, viscous: Viscous, threads: usize) -> State<D>
where
    Grid<D>: HasEngine<D>,
{
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
    pool.expect("a pool of threads").install(|| {
        let mut s = disturbed(g, scheme, viscous);
        (0..3).for_each(|_| s.step(1e-3, None));
        s.state().clone()
    })
}

/// The number of threads changes no bit, on two axes and in space.
#[test]
fn threads_do_not_change_a_bit_of_open_flow() {
    let flat = grid(
        [uniform(1.0, 300), uniform(1.0, 250)],
        [through(0, 1.0, Profile::Parabolic), [Boundary::WALL, Boundary::FreeSlip]],
    );
    let space = space_grid();
    for scheme in SCHEMES {
        for viscous in [Viscous::Implicit, Viscous::Explicit] {
            let (one, first) = (run(&flat, scheme, viscous, 1), run(&space, scheme, viscous, 1));
            for threads in [2, 3, 4] {
                let (other, next) =
                    (run(&flat, scheme, viscous, threads), run(&space, scheme, viscous, threads));
                assert_same(&other, &one);
                assert_same(&next, &first);
                assert!(other.open == one.open && next.open == first.open, "open faces");
            }
        }
    }
}

/// A stepper that has never seen the state goes on with the same bits: the outflow is in it. Halos
/// refreshed in between (for output) change nothing.
#[test]
fn restored_open_flow_repeats_its_future() {
    fn repeat<const D: usize>(g: &Grid<D>)
    where
        Grid<D>: HasEngine<D>,
    {
        for scheme in SCHEMES {
            for viscous in [Viscous::Implicit, Viscous::Explicit] {
                let mut s = disturbed(g, scheme, viscous);
                (0..3).for_each(|_| s.step(1e-3, None));
                let mut other = Stepper::new(g.clone(), s.options().clone());
                put_back(&mut other, s.state());
                other.fill_halos();
                for stepper in [&mut s, &mut other] {
                    (0..3).for_each(|_| stepper.step(2e-3, None));
                }
                assert_same(s.state(), other.state());
                assert_eq!(s.state().open, other.state().open);
            }
        }
    }
    repeat(&tube(uniform(1.0, 12), 10, 1.0, Profile::Parabolic));
    repeat(&grid(
        [uniform(1.0, 12), uniform(1.2, 10), uniform(0.8, 8)],
        [through(0, -1.0, Profile::Parabolic), [Boundary::WALL; 2], [Boundary::Periodic; 2]],
    ));
}

/// The laminar shapes: mean 1, and the peaks of the parabola (1.5), film (1.5 at the free side), tube
/// (2) and square duct (2.25, product of two parabolas), to the mean over a cell.
#[test]
fn laminar_profiles_have_their_mean_and_their_peak() {
    let n = 64;
    let peak =
        |open: &OpenFaces<2>, axis: usize| open.faces()[0].values[axis].iter().copied().fold(0.0, f64::max);
    let x = through(0, 1.0, Profile::Parabolic);
    let plates = grid([uniform(1.0, 8), uniform(1.0, n)], [x, [Boundary::WALL; 2]]);
    let film = grid([uniform(1.0, 8), uniform(1.0, n)], [x, [Boundary::WALL, Boundary::FreeSlip]]);
    let pipe = tube(uniform(1.0, n), n, 1.0, Profile::Parabolic);
    for (g, axis, top) in [(&plates, 0, 1.5), (&film, 0, 1.5), (&pipe, 1, 2.0)] {
        let open = OpenFaces::new(g);
        let flow = if axis == 1 { PI } else { 1.0 };
        assert!((open.flow(g, false) - flow).abs() < 1e-12, "{}", open.flow(g, false));
        assert!((peak(&open, axis) / top - 1.0).abs() < 1e-3, "{}", peak(&open, axis));
    }
    let w = [Boundary::WALL; 2];
    let duct = grid(
        [uniform(1.0, 8), uniform(1.0, n), uniform(1.0, n)],
        [through(0, 1.0, Profile::Parabolic), w, w],
    );
    let open = OpenFaces::new(&duct);
    let peak = open.faces()[0].values[0].iter().copied().fold(0.0, f64::max);
    assert!((open.flow(&duct, false) - 1.0).abs() < 1e-12 && (peak / 2.25 - 1.0).abs() < 1e-3, "{peak}");
}

/// Ethier & Steinman (1994): component `d` at `x` and time `t`; a = π/4, d = π/2.
fn ethier_steinman(d: usize, x: [f64; 3], nu_t: f64) -> f64 {
    let (a, b) = (0.25 * PI, 0.5 * PI);
    let [x, y, z] = [x[d], x[(d + 1) % 3], x[(d + 2) % 3]];
    let wave = (a * x).exp() * (a * y + b * z).sin() + (a * z).exp() * (a * x + b * y).cos();
    -a * wave * (-b * b * nu_t).exp()
}

/// Sets the velocity on all six faces from a function of component and position.
fn set_faces(s: &mut Stepper<3>, value: impl Fn(usize, [f64; 3]) -> f64) {
    let (grid, state) = s.parts_mut();
    for (number, values) in state.open.fields_mut().enumerate() {
        let (axis, side, d) = (number / 6, number / 3 % 2, number % 3);
        let [first, second] = [[1, 2], [0, 2], [0, 1]][axis];
        for (entry, u) in values.iter_mut().enumerate() {
            let mut x = [grid.axes[axis].faces[side * grid.cells[axis]]; 3];
            x[first] = grid.nodes(d, first)[entry % grid.cells[first]];
            x[second] = grid.nodes(d, second)[entry / grid.cells[first]];
            *u = value(d, x);
        }
    }
}

/// A flow in space with all terms alive and every component given on all six faces, where it enters
/// and leaves: second order, which begins late (1.7 from 8 to 16 cells). The faces hold the values of the
/// end of a step: dt ∝ Δx².
#[test]
fn ethier_steinman_flow_converges() {
    let nu = 0.2;
    for (scheme, viscous) in [(SCHEMES[1], Viscous::Implicit), (SCHEMES[1], Viscous::Explicit)] {
        let errors = [12, 24, 48].map(|n| {
            let axis = AxisSpec::Uniform { start: -1.0, end: 1.0, cells: n };
            let given = |a| [inflow(a, 1.0, Profile::Uniform), inflow(a, 1.0, Profile::Uniform)];
            let g = grid([axis.clone(), axis.clone(), axis], [given(0), given(1), given(2)]);
            let options = Options { viscosity: nu, scheme, viscous, convection: true, body_force: [0.0; 3] };
            let mut s = Stepper::new(g.clone(), options);
            for d in 0..3 {
                set_component(&g, d, &mut s.state_mut().velocity[d], |x| ethier_steinman(d, x, 0.0));
            }
            let steps = n * n / 8;
            let dt = 0.1 / steps as f64;
            for k in 1..=steps {
                set_faces(&mut s, |d, x| ethier_steinman(d, x, nu * k as f64 * dt));
                s.step(dt, None);
            }
            (0..3).map(|d| error(&g, d, &s.state().velocity[d], |x| ethier_steinman(d, x, nu * 0.1))).sum()
        });
        assert!(observed_order(&format!("Ethier–Steinman, {scheme:?} {viscous:?}"), &errors) > 1.9);
    }
}
