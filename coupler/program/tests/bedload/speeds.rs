//! Speeds that follow from a scene, in the bounds and notes of its plan.

use bedload_scene::{CheckedScene, SceneSource};
use coupler::bounds::{Bound, Level};
use coupler::config::Coupling;
use coupler::plan::Plan;
use protocol::facts::{DemFacts, FluidFacts, Measure, Side, SolverBound};

use crate::fake_solvers::SPHERE;

/// U of that sphere.
const TERMINAL: f64 = 20.32 * 0.061_237_243_569_579_45;

#[derive(Clone)]
struct Case {
    text: String,
    dt: f64,
    contact_time: f64,
}

impl Case {
    /// A sphere 1.5 D over a floor; Ar = 800, so that Re = 20.3 and U = 1.244 by Schiller & Naumann (1935).
    fn new() -> Self {
        let of_sphere = Self { text: SPHERE.to_owned(), dt: 0.01, contact_time: 0.01 };
        of_sphere
            .with("until = 1.0", "until = 100.0")
            .with("upper = [4.0, 4.0, 4.0]", "upper = [4.0, 4.0, 8.0]")
            .with("cells = [64, 64, 64]", "cells = [32, 32, 64]")
            .with("viscosity = 0.01", "viscosity = 0.06123724356957945")
            .with("position = [2.0, 2.0, 2.0]", "position = [2.0, 2.0, 6.0]")
    }

    fn with(mut self, from: &str, to: &str) -> Self {
        assert!(self.text.contains(from), "{from}");
        self.text = self.text.replace(from, to);
        self
    }

    fn plan(&self) -> Plan {
        let source = SceneSource { file: "s.toml".into(), text: self.text.clone() };
        let scene = CheckedScene::new(source).expect("a good scene");
        // As our fluid: the scene names no speed.
        let cfl = SolverBound::new("cfl", "u dt/Δx", (0.0, Measure::Window), Side::AtMost, 1.2);
        let fluid = FluidFacts {
            cells: 65536,
            dt: self.dt,
            spacing: 0.125,
            step_cost: 0.01,
            bounds: vec![cfl],
            ..FluidFacts::default()
        };
        let dem = DemFacts {
            grains: 1,
            dt: self.contact_time / 50.0,
            contact_time: self.contact_time,
            substep_cost: 1e-6,
            resolved: toml::from_str("lubrication = { roughness = 4e-4 }\ncontact = { restitution = 0.97 }")
                .expect("a table"),
            ..DemFacts::default()
        };
        let coupling = Coupling::read(&scene).expect("good coupling");
        let fluid = scene.scene.medium.is_some().then_some(&fluid);
        Plan::new(&scene, &coupling, fluid, Some(&dem), None).expect("a plan")
    }

    fn bound(&self, name: &str) -> Bound {
        let bound = self.plan().bounds.into_iter().find(|bound| bound.name == name);
        bound.unwrap_or_else(|| panic!("{name} is not checked"))
    }

    fn notes(&self) -> String {
        self.plan().notices.join("\n")
    }
}

#[test]
fn a_sphere_that_will_fall_counts_with_its_terminal_speed() {
    let bound = Case { dt: 0.1, ..Case::new() }.bound("cfl");
    assert!((bound.value - TERMINAL * 0.1 / 0.125).abs() < 0.002, "{}", bound.relation());
    assert!(bound.holds && bound.margin < 2.0);
    // The step of 0.3 with which such a fall ended at −1.15e7 m, at a margin of infinity.
    let bound = Case { dt: 0.3, ..Case::new() }.bound("cfl");
    assert!(bound.refuses(&[]) && bound.why.contains("settling"), "{}", bound.relation());
    // Too short to reach it: (ρ_p − ρ)/(ρ_p + ρ/2) g t = 2/3 · 0.1.
    let short = Case { dt: 0.01, ..Case::new() }.with("until = 100.0", "until = 0.1");
    assert!((short.bound("cfl").value - 0.2 / 3.0 * 0.01 / 0.125).abs() < 1e-12);
}

#[test]
fn a_driven_flow_counts_with_its_laminar_speed() {
    let case = Case::new()
        .with("density = 4.0", "density = 1.0")
        .with("viscosity = 0.06123724356957945", "viscosity = 1.0");
    let case = case.with("[[grains]]", "body_force = [0.25, 0.0, 0.0]\n[[grains]]");
    // What resists the drive is not known well: beyond the limit it only warns, and the run is watched.
    let fast = Case { dt: 1.0, ..case.clone() }.bound("cfl");
    assert!(!fast.holds && fast.level == Level::Warn, "{}", fast.relation());
    // A flow rate that is held balances the drive along its axis.
    let held =
        case.clone().with("[[grains]]", "flow_rate = { axis = \"x\", mean_velocity = 0.0 }\n[[grains]]");
    assert_eq!(held.bound("cfl").value, 0.0);
    // 0.25 · h²/(8 ν), h = 8 less what one sphere fills of 4 × 4 at a solid fraction of 0.6.
    let height = 8.0 - std::f64::consts::PI / 6.0 / 0.6 / 16.0;
    assert!((case.bound("cfl").value - 0.25 * height * height / 8.0 * 0.01 / 0.125).abs() < 1e-12);
}

#[test]
fn an_overlap_beyond_a_tenth_is_refused_where_the_scene_names_the_speed_and_warned_of_where_it_follows() {
    // U t_c/(π R): 0.0999 and 0.1001.
    let at = |part: f64| Case { contact_time: part * 0.5 * std::f64::consts::PI / TERMINAL, ..Case::new() };
    let good = at(0.0995).bound("overlap");
    assert!(good.holds && (good.value - 0.0995).abs() < 2e-4, "{}", good.relation());
    let bad = at(0.1005).bound("overlap");
    assert!(!bad.holds && bad.level == Level::Warn, "{}", bad.relation());
    let thrown =
        at(0.1005).with("density = 4.0", "density = 4.0\nvelocity = [0.0, 0.0, -10.0]").bound("overlap");
    assert!(thrown.refuses(&[]) && !thrown.refuses(&["overlap".to_owned()]), "{}", thrown.relation());
    assert!(thrown.remedy.contains("contact_time"));
    // A DEM alone does not end there: it is told. 5.5 m of free fall.
    let dry = Case { contact_time: 0.1, ..Case::new() }
        .with("[medium]\ndensity = 1.0\nviscosity = 0.06123724356957945\n", "");
    let bound = dry.bound("overlap");
    assert!((bound.value - 11.0_f64.sqrt() * 0.1 / (std::f64::consts::PI * 0.5)).abs() < 1e-12);
    assert!(!bound.holds && bound.level == Level::Warn);
}

#[test]
fn a_contact_time_that_costs_without_need_is_said_with_one_that_would_do() {
    let notes = Case { contact_time: 2e-9, ..Case::new() }.notes();
    assert!(notes.contains("contact_time: t_c = 2.000e-9 s asks for"), "{notes}");
    // One per cent of R: 0.01 π R/U = 0.01262 s.
    assert!(notes.contains("t_c = 0.01262 s lets them overlap by 1 %"), "{notes}");
    assert!(!Case::new().notes().contains("contact_time"));
}

#[test]
fn gravity_along_a_periodic_axis_is_said_unless_something_resists() {
    let open = || Case::new().with("z = \"no-slip\"", "z = \"periodic\"");
    let notes = open().notes();
    assert!(notes.contains("gravity acts along z") && notes.contains("for ever"), "{notes}");
    // What it proposes is enough: −g with the weight of the sphere, 1 + 3 π/6/128.
    let balance = 1.0 + 3.0 * std::f64::consts::PI / 6.0 / 128.0;
    assert!(notes.contains("medium.body_force = 1.01"), "{notes}");
    let held = format!("body_force = [0.0, 0.0, {balance:?}]\n[[grains]]");
    assert!(!open().with("[[grains]]", &held).notes().contains("gravity acts"));
    let rate = "flow_rate = { axis = \"z\", mean_velocity = 0.0 }\n[[grains]]";
    assert!(!open().with("[[grains]]", rate).notes().contains("gravity acts"));
    let walled = open().with("x = \"periodic\"", "x = \"no-slip\"");
    assert!(!walled.notes().contains("gravity acts"));
    assert!(!Case::new().notes().contains("gravity acts"));
}

#[test]
fn cells_that_are_no_cubes_are_said() {
    assert!(!Case::new().notes().contains("no cubes"));
    let notes = Case::new().with("cells = [32, 32, 64]", "cells = [32, 32, 48]").notes();
    assert!(notes.contains("no cubes, 0.125 to 0.1667 m"), "{notes}");
}

/// A bounce hangs on the roughness of its grains: by how much is said where there is a bounce.
#[test]
fn the_roughness_that_a_bounce_hangs_on_is_said() {
    let notes = |density: &str| Case::new().with("density = 4.0", density).notes();
    // (ρ_p + ½ρ) U D/(9 μ): 5.2 and 35, where (1 + e) ln 10/St = 0.1295; measured from 28 on.
    assert!(!notes("density = 2.0").contains("roughness:"));
    let rough = notes("density = 8.0");
    assert!(rough.contains("about 0.1295") && rough.contains("is the default"), "{rough}");
    assert!(!rough.contains("not measured at this St"));
    assert!(notes("density = 5.0").contains("not measured at this St"));
    // Nothing bounces where nothing falls.
    assert!(!Case::new().with("-1.0]", "0.0]").notes().contains("roughness:"));
}
