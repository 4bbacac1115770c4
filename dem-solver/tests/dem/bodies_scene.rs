//! Bodies that are not round, from the scene's text through the participant.
use bedload_program::alone::StandIn;
use bedload_scene::{CheckedScene, SceneSource};
use dem_solver::config::Config;
use dem_solver::participant::DemParticipant;
use dem_solver::{Lubrication, State};
use protocol::checkpoint;
use protocol::participant::{Participant, Window};

const BODIES: &str = "until = 1.0\ngravity = [0.0, 0.0, -9.81]\n\
    [domain]\ngeometry = \"plane\"\nlower = [0.0, 0.0]\nupper = [0.4, 0.6]\nboundary = { x = \"no-slip\", z \
    = \"no-slip\" }\n\
    [[grains]]\nshape = \"rectangle\"\nsides = [0.2, 0.05]\nposition = [0.15, 0.0, 0.1]\ndensity = 2500.0\n\
    orientation = [0.9659258262890683, 0.0, 0.25881904510252074, 0.0]\n\
    [[grains]]\nshape = \"ellipse\"\nsemi_axes = [0.08, 0.03]\nposition = [0.2, 0.0, 0.22]\ndensity = 2500.0\n\
    [[grains]]\nshape = \"polygon\"\nvertices = [[0.0, 0.0], [0.1, 0.0], [0.12, 0.05], [0.03, 0.09]]\n\
    position = [0.25, 0.0, 0.34]\ndensity = 2500.0\n\
    [[grains]]\nshape = \"disc\"\nradius = 0.04\nposition = [0.12, 0.0, 0.42]\ndensity = 2500.0\n";
const CONTACT: &str = "[dem.contact]\nlaw = \"linear-spring-dashpot\"\nrestitution = 0.5\ncontact_time = \
    0.002\nfriction = 0.4\n";

fn read(text: &str) -> CheckedScene {
    CheckedScene::new(SceneSource { file: "s.toml".into(), text: text.into() }).expect("a scene")
}

#[test]
fn a_heap_of_a_scene_runs_writes_its_outlines_and_goes_on_from_a_checkpoint() {
    let folder = std::env::temp_dir().join(format!("bedload-bodies-{}", std::process::id()));
    let scene = read(&format!("{BODIES}{CONTACT}"));
    let mut solver = DemParticipant::new(&scene, &folder).expect("builds");
    let mass = 2500.0 * 0.2 * 0.05;
    assert!((solver.dem().grains.mass[0] - mass).abs() < 1e-9);
    assert!((solver.dem().grains.inertia[0] - mass * (0.2f64.powi(2) + 0.05f64.powi(2)) / 12.0).abs() < 1e-9);
    let mut exchange = StandIn::new(solver.grains(), bedload_program::alone::buoyancy(&scene));
    let window = |step: u64| Window {
        step,
        attempt: 0,
        time: 0.004 * step as f64,
        dt: 0.004,
        substeps: 100,
        output: true,
    };
    let mut go = |solver: &mut DemParticipant, steps: std::ops::Range<u64>| {
        for step in steps {
            solver.advance(&window(step), &mut exchange).expect("advances");
            solver.write_fields(&window(step)).expect("writes");
        }
    };
    let busy = |state: &State| !state.body_contacts.is_empty() && !state.body_wall_contacts.is_empty();
    let mut done = 0;
    while !busy(&solver.dem().save()) && done < 300 {
        go(&mut solver, done..done + 1);
        done += 1;
    }
    solver.write_checkpoint(&folder).expect("writes");
    let (_, state): (_, State) = checkpoint::read_any(&folder, "dem").expect("reads");
    assert!(
        !state.body_contacts.is_empty() && !state.body_wall_contacts.is_empty(),
        "in the middle of contacts"
    );
    go(&mut solver, done..400);
    solver.write_fields(&window(400)).expect("writes");
    let bytes = std::fs::read(folder.join("fields/bodies_00000400.vtp")).expect("is there");
    let text = String::from_utf8_lossy(&bytes);
    assert!(text.contains("NumberOfPoints=\"72\"") && text.contains("NumberOfPolys=\"3\""));
    let mut other = DemParticipant::new(&scene, &folder).expect("builds");
    other.read_checkpoint(&folder).expect("reads");
    go(&mut other, done..400);
    assert!(other.dem().save() == solver.dem().save(), "the same bits");
    std::fs::remove_dir_all(&folder).expect("goes");
}

#[test]
fn what_a_scene_with_bodies_may_not_ask_for_is_told_at_its_key() {
    let whole = format!("{BODIES}{CONTACT}");
    Config::new(&read(&whole)).expect("as it is");
    let refused = |key: &str, text: &str| {
        let fault = Config::new(&read(text)).expect_err("refused").to_string();
        assert!(fault.contains(&format!("{key}: ")), "{key}: {fault}");
    };
    refused("dem.contact.rolling", &format!("{whole}rolling = {{ friction = 0.1 }}\n"));
    refused("dem.integrator", &format!("{BODIES}[dem]\nintegrator = \"rk3\"\n{CONTACT}"));
    refused("observe.energy", &format!("{whole}[observe]\nenergy = true\n"));
    let law = "[dem]\ndt = 1e-4\n[dem.contact]\nlaw = \"wan-turek\"\nsoftness = 1e-5\nwall_softness = 1e-5\n\
        range = 0.002\n";
    refused("dem.contact.law", &format!("{BODIES}{law}"));
    let profile =
        "[observe.profile]\naxis = \"z\"\nlower = [0.0, 0.0, 0.0]\nupper = [0.4, 1.0, 0.6]\nslabs = 4\n";
    refused("observe.profile", &format!("{whole}{profile}"));
    let wet = whole.replace("boundary", "cells = [80, 120]\nboundary")
        + "[medium]\ndensity = 1000.0\nviscosity = 1e-1\n";
    let spec = Config::new(&read(&wet)).expect("reads").spec;
    assert_eq!(spec.lubrication, Lubrication::None, "films between them are not modelled");
    refused(
        "dem.lubrication.form",
        &format!("{wet}[dem.lubrication]\nform = \"as-printed\"\nroughness = 1e-3\n"),
    );
}
