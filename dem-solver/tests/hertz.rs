//! Hertz–Mindlin contact against the exact solutions of Hertz (1882) and of the damped oscillator it
//! maps to (Antypov & Elliott 2011), and the linear law of a given stiffness.
mod common;
use common::{dem, floor};
use dem_solver::laws::hertz_mindlin::{DURATION, HertzMindlin};
use dem_solver::{ContactLaw, LinearSpringDashpot, laws::linear::RestitutionForm};
use dem_solver::{Dem, DemSpec, Grain, Integrator};

const E: f64 = 7e10;
const NU: f64 = 0.25;
const RHO: f64 = 2500.0;
const R: f64 = 1e-3;

fn glass(restitution: f64) -> HertzMindlin {
    HertzMindlin {
        young_modulus: E,
        poisson_ratio: NU,
        restitution,
        impact_speed: 1.0,
        friction: 0.0,
        form: RestitutionForm::Izard2014,
        damping_ratio: 0.0,
        sliding: Default::default(),
        lever_arm: Default::default(),
        rolling: None,
    }
}

/// Two spheres that meet head-on, or one on a wall, with relative speed `v`.
fn approach(law: ContactLaw, v: f64, wall: bool) -> Dem {
    let mut lower = Grain::new([0.0, 0.0, R], R, RHO);
    lower.velocity = [0.0, 0.0, -v];
    let grains = if wall {
        vec![lower]
    } else {
        let mut upper = Grain::new([0.0, 0.0, 3.0 * R], R, RHO);
        (lower.velocity, upper.velocity) = ([0.0, 0.0, 0.5 * v], [0.0, 0.0, -0.5 * v]);
        vec![lower, upper]
    };
    let mut spec = DemSpec::new(grains, law);
    if wall {
        spec.walls.push(floor());
    }
    spec.integrator = Integrator::VelocityVerlet;
    dem(&spec)
}

/// Largest overlap, duration and restitution of a collision, in steps of `dt`.
fn collide(mut dem: Dem, v: f64, dt: f64) -> (f64, f64, f64) {
    let (mut overlap, mut before) = (0.0f64, f64::NEG_INFINITY);
    for step in 1.. {
        let report = dem.advance(dt, 1, &[]).expect("advances");
        overlap = overlap.max(report.largest_overlap);
        let g = &dem.grains;
        let (gap, speed) = if g.len() == 1 {
            (g.position[0].z - R, g.velocity[0].z)
        } else {
            (g.position[1].z - g.position[0].z - 2.0 * R, g.velocity[1].z - g.velocity[0].z)
        };
        if report.contacts == 0 && step > 2 {
            // the gap closes to zero at constant speed once the (undamped) force has gone
            return (overlap, dem.time() - gap / speed, speed / v);
        }
        assert!(gap > before || step < 1_000_000, "it never ends");
        before = gap.min(before);
    }
    unreachable!()
}

#[test]
fn an_elastic_collision_has_hertz_duration_and_overlap() {
    let sphere = 4.0 / 3.0 * std::f64::consts::PI * R.powi(3) * RHO;
    let modulus = E / (2.0 * (1.0 - NU * NU));
    for (wall, mass, radius) in [(false, 0.5 * sphere, 0.5 * R), (true, sphere, R)] {
        for v in [0.01, 1.0] {
            let k = 4.0 / 3.0 * modulus * f64::sqrt(radius);
            let deepest = (1.25 * mass * v * v / k).powf(0.4);
            let lasts = DURATION * deepest / v;
            let law = ContactLaw::HertzMindlin(HertzMindlin { impact_speed: v, ..glass(1.0) });
            let derived = law.contact_time(mass, radius).expect("has one");
            assert!((derived / lasts - 1.0).abs() < 1e-12);
            let (overlap, time, e) = collide(approach(law, v, wall), v, lasts / 2000.0);
            println!(
                "wall {wall} v {v}: {:.2e} {:.2e} {:.2e}",
                overlap / deepest - 1.0,
                time / lasts - 1.0,
                e - 1.0
            );
            // second order in dt: (1/2000)² times a factor of a few
            assert!((overlap / deepest - 1.0).abs() < 5e-6);
            assert!((time / lasts - 1.0).abs() < 1e-4);
            assert!((e - 1.0).abs() < 1e-5);
        }
    }
}

#[test]
fn restitution_is_the_asked_one_at_any_speed() {
    for v in [0.01, 1.0, 10.0] {
        for (form, e, expected) in [
            (RestitutionForm::ExactRestitution, 0.6, 0.6),
            (RestitutionForm::ExactRestitution, 0.9, 0.9),
            // the clipped oscillator, as for the linear law
            (RestitutionForm::Izard2014, 0.5, 0.5503),
            (RestitutionForm::Izard2014, 0.87, 0.8734),
        ] {
            let law = HertzMindlin { form, impact_speed: v, ..glass(e) };
            let lasts = law.contact_time_of(2e-6, 0.5 * R);
            let got = collide(approach(ContactLaw::HertzMindlin(law), v, false), v, lasts / 2000.0).2;
            println!("{form:?} {e} at {v}: {got:.5}");
            assert!((got - expected).abs() < 3e-4, "{form:?} e = {e} at {v} m/s: {got}");
        }
    }
}

#[test]
fn an_oblique_collision_without_slip_creates_no_energy() {
    for psi in [0.2, 1.0, 3.0] {
        let v = 0.1;
        let law = HertzMindlin { impact_speed: v, friction: 1e6, ..glass(1.0) };
        let lasts = law.contact_time_of(2e-6, 0.5 * R);
        let mut dem = approach(ContactLaw::HertzMindlin(law), v, false);
        dem.grains.velocity[0].x = 0.5 * psi * v;
        dem.grains.velocity[1].x = -0.5 * psi * v;
        let (start, turning) = (dem.kinetic_energy(), dem.angular_momentum());
        for _ in 0..4000 {
            dem.advance(lasts / 2000.0, 1, &[]).expect("advances");
            assert!(dem.kinetic_energy() + dem.elastic_energy() <= start * (1.0 + 1e-6));
        }
        let kept = dem.kinetic_energy() / start;
        println!("psi {psi}: {kept:.6} of the energy after the collision");
        assert!(kept > 0.5 && kept <= 1.0 + 1e-6);
        assert!((dem.angular_momentum() - turning).norm() <= 1e-12 * turning.norm());
        assert!(dem.grains.spin[0].norm() > 0.0);
    }
}

#[test]
fn a_given_stiffness_sets_duration_by_mass_and_keeps_restitution() {
    let k = 1e4;
    for radius in [R, 2.0 * R] {
        let mut law = LinearSpringDashpot::new(0.5, 1.0, 0.0);
        (law.contact_time, law.stiffness) = (None, Some(k));
        let mass = 0.5 * 4.0 / 3.0 * std::f64::consts::PI * radius.powi(3) * RHO;
        let t_c = law.contact_time_of(mass);
        // eq. 18: k_n = m*(π² + ln² e)/t_c²
        let expected = (mass * (std::f64::consts::PI.powi(2) + 0.5f64.ln().powi(2)) / k).sqrt();
        assert!((t_c / expected - 1.0).abs() < 1e-12);
        let mut twin = LinearSpringDashpot::new(0.5, t_c, 0.0);
        twin.form = law.form;
        let run = |law| {
            let mut low = Grain::new([0.0; 3], radius, RHO);
            let high = Grain::new([0.0, 0.0, 2.0 * radius], radius, RHO);
            low.velocity = [0.0, 0.0, 0.1];
            let mut dem = dem(&DemSpec::new(vec![low, high], ContactLaw::LinearSpringDashpot(law)));
            dem.advance(2.0 * t_c, 400, &[]).expect("advances");
            dem.grains.velocity[1].z - dem.grains.velocity[0].z
        };
        let (derived, given) = (run(law), run(twin));
        assert!((derived / given - 1.0).abs() < 1e-9, "{derived} {given}");
        assert!((derived / 0.1 - 0.5503).abs() < 2e-3, "{derived}");
    }
}

#[test]
fn bad_parameters_are_refused_by_name() {
    let refused = |law: HertzMindlin, name: &str| {
        let error = law.validate().expect_err(name).to_string();
        assert!(error.contains(name), "{error}");
    };
    refused(HertzMindlin { young_modulus: 0.0, ..glass(0.9) }, "young_modulus");
    refused(HertzMindlin { poisson_ratio: 0.6, ..glass(0.9) }, "poisson_ratio");
    refused(HertzMindlin { impact_speed: f64::NAN, ..glass(0.9) }, "impact_speed");
    refused(glass(1.5), "restitution");
    let mut both = LinearSpringDashpot::new(0.5, 1.0, 0.0);
    both.stiffness = Some(1.0);
    assert!(both.validate().expect_err("both").to_string().contains("left out where stiffness"));
    (both.contact_time, both.stiffness) = (None, None);
    assert!(both.validate().expect_err("none").to_string().contains("contact_time is missing"));
    let mut flat = DemSpec::new(vec![Grain::new([0.0; 3], R, RHO)], ContactLaw::HertzMindlin(glass(0.9)));
    flat.shape = dem_solver::Shape::Disc;
    assert!(flat.validate().expect_err("discs").to_string().contains("spheres"));
}
