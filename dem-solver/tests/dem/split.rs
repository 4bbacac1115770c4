//! Forces sub-step by sub-step: they add up to m dv/dt, their means are those of the window, and noting them
//! changes no bit.
use crate::common::{dem, floor, law, spec};
use bedload_scene::{CheckedScene, SceneSource};
use dem_solver::lubrication::settings::LubricationSettings;
use dem_solver::participant::DemParticipant;
use dem_solver::report::GrainLoad;
use dem_solver::{DemSpec, Grain, Integrator, Lubrication, OverTime, Vec3};
use protocol::message::{Header, Kinematics, Loads};
use protocol::participant::{Exchange, ExchangeError, Participant, Window};
use std::f64::consts::PI;

const R: f64 = 0.5;

/// Changes within the windows; a sub-step of RK3 sees it at its stages alone, and no corner.
fn gravity() -> OverTime<[f64; 3]> {
    OverTime::table(vec![(0.0, [0.0, 0.0, -9.81]), (0.01, [1.0, 0.0, -7.0]), (0.02, [0.0, 0.0, -9.0])])
}

/// Two grains above a floor, the upper one on its way to the lower one, under loads with a virtual mass.
fn set_up(integrator: Integrator, film: bool) -> DemSpec {
    let mut upper = Grain::new([0.1, 0.0, 3.0 * R + 0.003], R, 2.0);
    upper.velocity = [0.2, 0.1, -1.0];
    let lower = Grain::new([0.0, 0.0, R + 0.002], R, 2.0);
    let mut set_up = spec(vec![lower, upper], law(0.7, 0.02));
    set_up.walls.push(floor());
    set_up.gravity = gravity();
    set_up.integrator = integrator;
    set_up.split = true;
    set_up.viscosity = 0.05;
    if film {
        set_up.lubrication = Lubrication::AsPrinted(LubricationSettings::new(1e-3));
    }
    set_up
}

fn loads() -> Vec<GrainLoad> {
    let load = |x: f64| GrainLoad { force: Vec3::new(x, 0.0, 3.0), added_mass: 0.3, ..GrainLoad::default() };
    vec![load(0.5), load(-0.2)]
}

#[test]
fn forces_of_every_sub_step_add_up_to_the_acceleration_and_to_the_means() {
    let mass = 2.0 * 4.0 / 3.0 * PI * R.powi(3);
    for integrator in [Integrator::SymplecticEuler, Integrator::VelocityVerlet, Integrator::Rk3] {
        for film in [false, true] {
            if integrator == Integrator::Rk3 && film {
                continue;
            }
            let set_up = set_up(integrator, film);
            let (mut solver, mut silent) = (dem(&set_up), dem(&DemSpec { split: false, ..set_up.clone() }));
            let (mut bore, mut filmed) = (false, false);
            for n_sub in [25, 25, 1, 25] {
                let before = solver.grains.acceleration.clone();
                solver.split(&[1, 0]);
                solver.advance(0.005, n_sub, &loads()).expect("advances");
                silent.advance(0.005, n_sub, &loads()).expect("advances");
                assert!(solver.save() == silent.save(), "{integrator:?}, {film:?}: noting changes the run");
                let seen = solver.observations();
                let rows = seen.split.rows();
                assert_eq!(rows.len(), 2 * n_sub as usize);
                let mut means = [Vec3::zeros(); 4];
                for row in rows {
                    let load = loads()[row.grain];
                    let virtual_mass = (before[row.grain] - row.acceleration) * load.added_mass;
                    let weight = Vec3::from(gravity().mean(row.time - row.dt, row.time)) * mass;
                    let sum = row.contact + row.lubrication + load.force + virtual_mass + weight;
                    let off = (sum - row.acceleration * mass).norm() / (sum.norm() + weight.norm());
                    assert!(off < 1e-11, "{integrator:?}, {film:?}: {off:e} in {row:?}");
                    means[row.grain] += row.contact / f64::from(n_sub);
                    means[2 + row.grain] += row.lubrication / f64::from(n_sub);
                    bore |= row.contact.norm() > 0.0;
                    filmed |= row.lubrication.norm() > 0.0;
                }
                for grain in 0..2 {
                    for (ours, mean) in [
                        (means[grain], seen.mean_contact[grain]),
                        (means[2 + grain], seen.mean_lubrication[grain]),
                    ] {
                        assert!(
                            (ours - mean).norm() <= 1e-12 * mean.norm(),
                            "{integrator:?}, {film:?}: {ours} for {mean}"
                        );
                    }
                }
                let last = rows.last().expect("a row");
                assert_eq!((last.grain, last.substep), (0, n_sub - 1));
                assert_eq!(last.position, solver.grains.position[0]);
                assert_eq!(last.velocity, solver.grains.velocity[0]);
                assert!((last.time - solver.time()).abs() < 1e-15);
            }
            assert!(bore && filmed == film, "{integrator:?}, {film:?}: the case has its forces");
        }
    }
}

/// Gives every grain the same loads.
struct Steady(Vec<Kinematics>);

impl Exchange<Loads, Kinematics> for Steady {
    fn receive(
        &mut self,
        window: &Window,
        read: &mut dyn FnMut(&Header, &[Loads]),
    ) -> Result<(), ExchangeError> {
        let load = Loads { force: [0.0, 0.0, 0.1], added_mass: 0.01, ..Loads::default() };
        read(&window.header(), &vec![load; self.0.len()]);
        Ok(())
    }

    fn send(&mut self, _: Header, write: &mut dyn FnMut(&mut [Kinematics])) -> Result<(), ExchangeError> {
        write(&mut self.0);
        Ok(())
    }
}

const SCENE: &str = "until = 1.0\ngravity = [0.0, 0.0, -9.81]\n\
    [domain]\ngeometry = \"plane\"\nlower = [0.0, 0.0]\nupper = [1.0, 1.0]\n\
    boundary = { x = \"no-slip\", z = \"no-slip\" }\n\
    [dem.contact]\nlaw = \"linear-spring-dashpot\"\nrestitution = 0.5\ncontact_time = 0.01\nfriction = 0.5\n\
    [[grains]]\nposition = [0.5, 0.0, 0.101]\nradius = 0.1\ndensity = 2.0\nvelocity = [0.1, 0.0, -0.2]\n\
    [[grains]]\nposition = [0.2, 0.0, 0.5]\nradius = 0.1\ndensity = 2.0\n";

#[test]
fn the_windows_asked_for_are_written_and_no_others() {
    let text = format!("{SCENE}[observe]\nsubsteps = {{ grains = [0], from = 0.015, to = 0.035 }}\n");
    let scene = CheckedScene::new(SceneSource { file: "s.toml".into(), text }).expect("reads");
    let out = std::env::temp_dir().join(format!("bedload-substeps-{}", std::process::id()));
    let mut solver = DemParticipant::new(&scene, &out).expect("builds");
    let mut exchange = Steady(vec![Kinematics::default(); 2]);
    for step in 0..6u64 {
        let window =
            Window { step, attempt: 0, time: 0.01 * step as f64, dt: 0.01, substeps: 20, output: false };
        solver.advance(&window, &mut exchange).expect("advances");
    }
    let mut names: Vec<String> = std::fs::read_dir(out.join("fields"))
        .expect("a folder")
        .map(|entry| entry.expect("an entry").file_name().into_string().expect("text"))
        .collect();
    names.sort();
    assert_eq!(names, [1, 2, 3].map(|step| format!("substeps_{step:08}.csv")));
    let table = std::fs::read_to_string(out.join("fields").join(&names[0])).expect("reads");
    let mut lines = table.lines();
    let header: Vec<&str> = lines.next().expect("a header").split(',').collect();
    assert_eq!(header[..5], ["substep", "t", "grain", "position_x", "position_z"]);
    let column = |name: &str| header.iter().position(|known| *known == name).expect("the column");
    let (mut touched, mut rows) = (false, 0);
    for line in lines {
        let row: Vec<f64> = line.split(',').map(|cell| cell.parse().expect("a number")).collect();
        let sum: f64 =
            ["contact_force_z", "lubrication_force_z", "fluid_force_z", "virtual_mass_force_z", "weight_z"]
                .iter()
                .map(|name| row[column(name)])
                .sum();
        let mass = -row[column("weight_z")] / 9.81;
        let off = sum - mass * row[column("acceleration_z")];
        assert!(
            off.abs() < 1e-12 * mass * 9.81_f64.max(row[column("acceleration_z")].abs()),
            "{off:e} in {line}"
        );
        assert!(row[column("fluid_force_z")] == 0.1 && row[column("grain")] == 0.0);
        touched |= row[column("contact_force_z")] > 0.0;
        rows += 1;
    }
    assert!(touched && rows == 20, "{rows} rows");
    std::fs::remove_dir_all(&out).expect("removed");
}

#[test]
fn what_cannot_be_noted_is_refused_by_key() {
    let refused = |observe: &str| {
        let text = format!("{SCENE}[observe]\nsubsteps = {{ {observe} }}\n");
        let source = SceneSource { file: "s.toml".into(), text };
        let read = CheckedScene::new(source)
            .and_then(|scene| DemParticipant::new(&scene, "none".as_ref()).map(drop));
        read.expect_err("refused").to_string()
    };
    for (observe, words) in [
        ("grains = [2]", ["observe.substeps.grains", "holds 2"]),
        ("grains = []", ["observe.substeps.grains", "is empty"]),
        ("grains = [1, 1]", ["observe.substeps.grains", "twice"]),
        ("grains = [1], from = 2.0, to = 1.0", ["observe.substeps.to", "is 1, from 2"]),
        ("grains = [1], from = -1.0", ["observe.substeps.from", "-1"]),
        ("grains = [1], windows = [1, 2]", ["windows", "from"]),
    ] {
        let said = refused(observe);
        assert!(words.iter().all(|word| said.contains(word)), "{observe}: {said}");
    }
}
