//! Set-ups shared by the tests of this folder.

use bedload_scene::Outline;
use dem_solver::{ContactLaw, Dem, DemSpec, Freedom, Grain, Shape, State, Vec3, Wall};
use dem_solver::{LinearSpringDashpot, laws::linear::RestitutionForm};
use std::f64::consts::PI;

/// A frictionless law as printed (Izard et al. 2014, eqs 17 and 18) with restitution `e` and contact time
/// `t_c`.
pub(crate) fn law(e: f64, t_c: f64) -> LinearSpringDashpot {
    LinearSpringDashpot { form: RestitutionForm::Izard2014, ..LinearSpringDashpot::new(e, t_c, 0.0) }
}

pub(crate) fn exact(mut law: LinearSpringDashpot) -> LinearSpringDashpot {
    law.form = RestitutionForm::ExactRestitution;
    law
}

pub(crate) fn spec(grains: Vec<Grain>, law: LinearSpringDashpot) -> DemSpec {
    DemSpec::new(grains, ContactLaw::LinearSpringDashpot(law))
}

pub(crate) fn dem(spec: &DemSpec) -> Dem {
    Dem::new(spec).expect("valid spec")
}

/// Restitution and duration, s, of an isolated collision under the clipped law: of the damped oscillation
/// only the time in which the force pushes. The duration is over t_c where the stiffness is given.
pub(crate) fn effective(law: &LinearSpringDashpot) -> (f64, f64) {
    let pair = law.pair();
    let decay = 0.5 * pair.damping;
    let omega = (pair.stiffness - decay * decay).sqrt();
    let rest = PI - 2.0 * (decay / omega).atan();
    ((-decay / omega * rest).exp(), rest / omega)
}

/// Momentum, kg m/s; dry masses.
pub(crate) fn momentum(solver: &Dem) -> Vec3 {
    let g = &solver.grains;
    (0..g.len()).map(|i| g.velocity[i] * g.mass[i]).sum()
}

/// Angular momentum about the origin, kg m²/s; dry masses, positions within the period.
pub(crate) fn angular_momentum(solver: &Dem) -> Vec3 {
    let g = &solver.grains;
    (0..g.len()).map(|i| g.position[i].cross(&g.velocity[i]) * g.mass[i] + g.spin[i] * g.inertia[i]).sum()
}

/// Adds a free body of the plane that is not round, at rest, and returns it.
pub(crate) fn add_body(
    set_up: &mut DemSpec,
    outline: Outline,
    position: [f64; 3],
    density: f64,
) -> &mut Grain {
    set_up.shape = Shape::Disc;
    let place = set_up.outlines.len() as u32;
    let grain = Grain::new(position, outline.reach(), density);
    set_up.outlines.push(outline);
    set_up.grains.push(Grain { outline: Some(place), free: Freedom::PLANE, ..grain });
    let last = set_up.grains.len() - 1;
    &mut set_up.grains[last]
}

/// Contacts that bear a force, of grains and with walls.
pub(crate) fn contacts(solver: &Dem) -> usize {
    let state = solver.save();
    let of_bodies = state.body_contacts.len() + state.body_wall_contacts.len();
    state.contacts.len() + state.wall_contacts.len() + of_bodies
}

/// Contacts after a window without a fluid.
pub(crate) fn contacts_after(solver: &mut Dem, dt_window: f64, n_sub: u32) -> usize {
    solver.advance(dt_window, n_sub, &[]).expect("advances");
    contacts(solver)
}

/// From where it stands, 20 windows of `solver`, once more in it after a restore, and in a fresh one of
/// `set_up` from the saved bytes: all in the same bits. Returns the state that they started from.
pub(crate) fn repeats<R: PartialEq + std::fmt::Debug>(
    what: &str,
    set_up: &DemSpec,
    solver: &mut Dem,
    advance: impl Fn(&mut Dem) -> R,
) -> State {
    let saved = solver.save();
    let bytes = bincode::serde::encode_to_vec(&saved, bincode::config::standard()).expect("serialises");
    let mut first = Vec::new();
    for _ in 0..20 {
        first.push((advance(solver), solver.observations().clone()));
    }
    let end = solver.save();
    let read: State =
        bincode::serde::decode_from_slice(&bytes, bincode::config::standard()).expect("reads").0;
    for (solver, state) in [(solver, saved.clone()), (&mut dem(set_up), read)] {
        solver.restore(&state).expect("restores");
        assert!(solver.save() == saved, "{what}: what is restored is what was saved");
        for (report, seen) in &first {
            assert_eq!(&advance(solver), report, "{what}");
            assert!(solver.observations() == seen, "{what}");
        }
        assert!(solver.save() == end, "{what}: the repeated run ends in other bits");
    }
    saved
}

/// Text of a file of the repository; `path` from its root.
pub(crate) fn repository_file(path: &str) -> String {
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("..").join(path);
    std::fs::read_to_string(&path)
        .unwrap_or_else(|error| panic!("{}: {error}; run in a checkout", path.display()))
}

/// Floor z = 0.
pub(crate) fn floor() -> Wall {
    Wall::new([0.0; 3], [0.0, 0.0, 1.0])
}

/// A deterministic stream of numbers in [0, 1) (SplitMix64).
pub(crate) struct Random(pub(crate) u64);

impl Random {
    pub(crate) fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
    }

    pub(crate) fn vector(&mut self, low: f64, high: f64) -> [f64; 3] {
        std::array::from_fn(|_| low + (high - low) * self.next())
    }
}

/// `n` grains of radius about 0.5 on a jittered cubic lattice, some in slight overlap, in random motion.
pub(crate) fn cloud(n: usize, seed: u64) -> Vec<Grain> {
    let mut random = Random(seed);
    let side = (1..).find(|side: &usize| side.pow(3) >= n).expect("a cube");
    (0..n)
        .map(|k| {
            let site = [k % side, k / side % side, k / (side * side)];
            let jitter = random.vector(-0.05, 0.05);
            let position = std::array::from_fn(|axis| 0.55 + 1.1 * site[axis] as f64 + jitter[axis]);
            let mut grain = Grain::new(position, 0.45 + 0.1 * random.next(), 1.0);
            grain.velocity = random.vector(-1.0, 1.0);
            grain.spin = random.vector(-1.0, 1.0);
            grain
        })
        .collect()
}
