//! Every bound of the plan with a case below and one above its limit, and the ladder of steps.

use bedload_scene::{CheckedScene, SceneSource};
use coupler::bounds::{Bound, DragChart, DragGrid, NAMES};
use coupler::config::Coupling;
use coupler::plan::{Participants, Plan, substeps};
use protocol::facts::{BoundRow, DemFacts, FluidFacts, Level, Measure, Side, SolverBound};
use protocol::scheme::Scheme;

use crate::fake_solvers::SPHERE;

fn scene(overrides: &[&str]) -> CheckedScene {
    let source = SceneSource { file: "test.toml".into(), text: SPHERE.into() };
    let overrides: Vec<String> = overrides.iter().map(|text| (*text).to_owned()).collect();
    CheckedScene::new(source.with_overrides(&overrides).expect("fits")).expect("a good scene")
}

fn fluid() -> FluidFacts {
    FluidFacts {
        cells: 64 * 64 * 64,
        memory: 1 << 20,
        dt: 0.01,
        spacing: 0.0625,
        cfl: 0.5,
        cfl_limit: 0.8,
        step_cost: 0.02,
        ..FluidFacts::default()
    }
}

fn dem() -> DemFacts {
    DemFacts {
        grains: 1,
        memory: 1 << 10,
        dt: 1e-4,
        contact_time: 2e-3,
        interaction_range: 0.25,
        substep_cost: 1e-6,
        ..DemFacts::default()
    }
}

struct Case {
    scene: Vec<&'static str>,
    fluid: FluidFacts,
    dem: DemFacts,
}

impl Case {
    fn new() -> Self {
        Self { scene: Vec::new(), fluid: fluid(), dem: dem() }
    }

    fn plan(&self) -> Plan {
        let scene = scene(&self.scene);
        let coupling = Coupling::read(&scene).expect("good coupling");
        Plan::new(&scene, &coupling, Some(&self.fluid), Some(&self.dem), Some(1 << 30)).expect("a plan")
    }

    fn bound(&self, name: &str) -> Option<Bound> {
        self.plan().bounds.into_iter().find(|bound| bound.name == name)
    }
}

/// The bound holds as `set(case, good)` and breaks as `set(case, bad)`.
fn below_and_above<T>(name: &str, good: T, bad: T, set: impl Fn(&mut Case, T)) {
    for (value, expected) in [(good, true), (bad, false)] {
        let mut case = Case::new();
        set(&mut case, value);
        let bound = case.bound(name).unwrap_or_else(|| panic!("{name} is not checked"));
        assert_eq!(bound.holds, expected, "{name}: {}", bound.relation());
        assert_eq!(bound.margin >= 1.0 - 1e-9, expected);
        assert!(!bound.why.is_empty() && !bound.source.is_empty() && !bound.remedy.is_empty(), "{name}");
    }
}

#[test]
fn the_plain_case_breaks_nothing_that_stops_it() {
    let plan = Case::new().plan();
    assert_eq!(plan.refusals().count(), 0, "{:?}", plan.refusals().collect::<Vec<_>>());
    assert_eq!((plan.participants, plan.scheme), (Participants::Coupled, Some(Scheme::SemiImplicit)));
    assert_eq!(plan.steps.substeps, 100);
    assert!((plan.steps.dt_dem - 1e-4).abs() < 1e-18);
    assert_eq!(plan.windows, 100);
    // 100 windows of 0.02 s, and of 100 sub-steps of 1 µs.
    assert!((plan.cost - 100.0 * (0.02 + 1e-4)).abs() < 1e-12);
}

/// A bound of the fluid as a table over the window: lighter than 2 is refused in windows of 0.01 s and less,
/// lighter than 8 beyond.
fn table() -> SolverBound {
    let row = |up_to, limit, source: &str| BoundRow { up_to, value: 4.0, limit, source: source.to_owned() };
    SolverBound {
        rows: vec![row(0.01, 2.0, "short"), row(f64::INFINITY, 8.0, "long")],
        ..SolverBound::new("density-ratio", "ρ_p/ρ", (0.0, Measure::Window), Side::AtLeast, 0.0).because(
            "why",
            "elsewhere",
            "remedy",
        )
    }
}

#[test]
fn a_wall_that_speeds_up_is_not_to_pass_a_grain_in_a_window() {
    // A radius of 0.5 m in windows of 0.01 s.
    let slow = "domain.boundary.z={ type = \"no-slip\", velocity = [[0.0, [0.0, 0.0, 0.0]], [0.5, [49.0, 0.0, 0.0]]] }";
    let fast = "domain.boundary.z={ type = \"no-slip\", velocity = [[0.0, [0.0, 0.0, 0.0]], [0.5, [51.0, 0.0, 0.0]]] }";
    below_and_above("wall-speed", slow, fast, |case, face| case.scene = vec![face]);
    let constant = "domain.boundary.z={ type = \"no-slip\", velocity = [51.0, 0.0, 0.0] }";
    assert!(Case { scene: vec![constant], ..Case::new() }.bound("wall-speed").is_none());
    let held = vec![fast, "grains[0].motion=\"fixed\""];
    assert!(Case { scene: held, ..Case::new() }.bound("wall-speed").is_none(), "nothing touches it");
}

#[test]
fn a_table_of_the_fluid_is_looked_up_at_the_length_of_the_window() {
    below_and_above("density-ratio", 0.01, 0.011, |case, dt| {
        case.fluid.dt = dt;
        case.fluid.bounds = vec![table()];
    });
    let mut case = Case::new();
    case.fluid.bounds = vec![table()];
    case.fluid.dt = 0.02;
    let bound = case.bound("density-ratio").expect("a bound");
    assert_eq!((bound.value, bound.limit, bound.source.as_str()), (4.0, 8.0, "long"));
    // Of another order of the exchange than the plan's.
    case.fluid.bounds = vec![SolverBound { scheme: Some(Scheme::Iterated), ..table() }];
    assert!(case.bound("density-ratio").is_none());
}

/// A bound of a solver, `factor` times `measure` at most 1.
fn solver_bound(name: &str, factor: f64, measure: Measure) -> SolverBound {
    SolverBound::new(name, "x", (factor, measure), Side::AtMost, 1.0).because(
        "it breaks",
        "a test",
        "mend it",
    )
}

#[test]
fn bounds_of_the_solvers_are_judged_at_the_steps_of_the_plan() {
    // Windows of 0.01 s, sub-steps of 1e-4 s, t_c = 2e-3 s.
    for (measure, good, bad) in [
        (Measure::One, 1.0, 1.01),
        (Measure::Window, 99.0, 101.0),
        (Measure::Substep, 9.9e3, 1.01e4),
        (Measure::WindowOverContact, 0.19, 0.21),
    ] {
        below_and_above("cfl", good, bad, |case, factor| {
            case.fluid.bounds = vec![solver_bound("cfl", factor, measure)];
        });
        below_and_above("contact-dashpot", good, bad, |case, factor| {
            case.dem.bounds = vec![solver_bound("contact-dashpot", factor, measure)];
        });
    }
    let mut case = Case::new();
    case.fluid.bounds = vec![
        solver_bound("a-foreign-one", 2.0, Measure::One),
        solver_bound("cfl", 2.0, Measure::One).warning(),
    ];
    let plan = case.plan();
    let refused: Vec<&str> = plan.refusals().map(|bound| bound.name.as_str()).collect();
    assert_eq!(refused, ["a-foreign-one"]);
    assert!(plan.warnings().any(|bound| bound.name == "cfl"));
    case.fluid.bounds.remove(0);
    case.fluid.bounds[0].level = Level::Refuse;
    case.scene = vec!["coupling.force=[\"cfl\"]"];
    assert_eq!(case.plan().refusals().count(), 0);
    // Void where the window is long enough: 5 contact times.
    case.scene.clear();
    for (from, checked) in [(5.1, true), (4.9, false)] {
        case.fluid.bounds[0].void_from = Some((Measure::WindowOverContact, from));
        assert_eq!(case.bound("cfl").is_some(), checked);
    }
}

#[test]
fn bounds_are_printed_in_the_order_of_their_names_and_foreign_ones_last() {
    let mut case = Case::new();
    case.fluid.bounds = vec![
        solver_bound("a-foreign-one", 1.0, Measure::One),
        solver_bound("density-ratio", 1.0, Measure::One),
    ];
    case.dem.bounds = vec![
        solver_bound("tangential-dashpot", 1.0, Measure::One),
        solver_bound("contact-dashpot", 1.0, Measure::One),
    ];
    let names: Vec<String> = case.plan().bounds.into_iter().map(|bound| bound.name).collect();
    let place = |name: &str| names.iter().position(|other| other == name).expect(name);
    let order = [
        "density-ratio",
        "contact-steps",
        "contact-dashpot",
        "window-over-contact",
        "tangential-dashpot",
        "memory",
        "a-foreign-one",
    ];
    assert!(order.map(place).is_sorted(), "{names:?}");
}

#[test]
fn sub_steps_and_windows_of_a_contact() {
    below_and_above(
        "contact-steps",
        "coupling.steps_per_contact=10",
        "coupling.steps_per_contact=9",
        |case, steps| {
            case.dem.dt = 1.0;
            case.scene = vec![steps];
        },
    );
    below_and_above(
        "contact-accuracy",
        "coupling.steps_per_contact=20",
        "coupling.steps_per_contact=19",
        |case, steps| {
            case.dem.dt = 1.0;
            case.scene = vec![steps];
        },
    );
    below_and_above("window-over-contact", 0.2, 0.201, |case, dt| case.fluid.dt = dt);
    let mut case = Case::new();
    case.dem.contact_time = f64::INFINITY;
    assert!(case.bound("contact-steps").is_none(), "nothing can touch");
}

#[test]
fn grid_and_memory() {
    // D/Δx of 5 and 4, of 8 and 7 on the axis with the fewest cells.
    below_and_above("resolution", "domain.cells=[64,64,20]", "domain.cells=[64,64,16]", |case, cells| {
        case.scene = vec![cells];
    });
    below_and_above(
        "resolution-accuracy",
        "domain.cells=[64,64,32]",
        "domain.cells=[64,64,28]",
        |case, cells| {
            case.scene = vec![cells];
        },
    );
    below_and_above("memory", 1 << 29, 1 << 31, |case, bytes| case.fluid.memory = bytes);
}

/// The sphere towed at a Reynolds number over a grid.
fn towed(reynolds: f64, resolution: f64) -> Case {
    let cells = (4.0 * resolution).round();
    let viscosity = if reynolds > 0.0 { 1.0 / reynolds } else { 1.0 };
    let set = [
        "gravity=[0,0,0]".to_owned(),
        "grains=[{position=[2,2,2],radius=0.5,density=1.0,motion=\"prescribed\",velocity=[0,0,1]}]"
            .to_owned(),
        format!("domain.cells=[{cells},{cells},{cells}]"),
        format!("medium.viscosity={viscosity:?}"),
        format!("fluid.time.convection={}", reynolds > 0.0),
    ];
    Case { scene: set.into_iter().map(|text| &*text.leak()).collect(), ..Case::new() }
}

#[test]
fn the_drag_has_the_error_of_the_chart_and_none_beyond_it() {
    let chart = DragChart::parse(DragChart::TEXT).expect("the chart");
    assert!(chart.grids.len() >= 16, "{}", chart.grids.len());
    for grid in chart.grids.iter().filter(|grid| (4.0 * grid.resolution).fract() == 0.0) {
        let plan = towed(grid.reynolds, grid.resolution).plan();
        let error = plan.drag.as_ref().and_then(|drag| drag.error).expect("within the chart");
        assert_eq!(error, grid.error);
        let line = plan.lines().into_iter().find(|line| line.starts_with("drag error ")).expect("a line");
        assert!(line.contains("a sphere alone in r-z, the nearest that is charted"), "{line}");
        let bound = plan.bounds.iter().find(|bound| bound.name == "drag-accuracy").expect("a bound");
        assert_eq!((bound.value, bound.holds, bound.level), (error.mean, error.mean <= 0.05, Level::Warn));
    }
    let [most, finest] = [|grid: &DragGrid| grid.reynolds, |grid: &DragGrid| grid.resolution]
        .map(|of| chart.grids.iter().map(of).fold(0.0, f64::max));
    for beyond in [towed(2.0 * most, 10.0), towed(20.0, 2.0 * finest)] {
        let drag = beyond.plan().drag.expect("a sphere that moves");
        assert!(drag.error.is_none() && drag.said.starts_with("not known at Re = "), "{}", drag.said);
        assert!(beyond.bound("drag-accuracy").is_none());
    }
}

#[test]
fn nothing_is_said_of_the_drag_of_other_methods_other_solvers_and_grains_that_only_drift() {
    let said = |change: fn(&mut Case)| {
        let mut case = towed(20.0, 10.0);
        change(&mut case);
        case.plan().drag
    };
    assert!(said(|_| {}).is_some());
    assert!(said(|case| case.scene.push("fluid.method=\"izard-2014\"")).is_none());
    assert!(said(|case| case.fluid.foreign = true).is_none());
    assert!(
        said(|case| case.scene.extend(["grains[0].velocity=[0,0,0]", "grains[0].motion=\"free\""])).is_none()
    );
}

/// Bounds that our solvers own: the tests of these crates put them below and above their limits
/// (`fluid-solver/tests/fluid/immersed/bounds.rs` and `src/methods/limits.rs`,
/// `dem-solver/tests/dem/bounds.rs`).
const OF_SOLVERS: [&str; 9] = [
    "density-range",
    "resting-weight",
    "dense-bed-forcing",
    "cfl",
    "direct-forcing",
    "direct-forcing-accuracy",
    "explicit-viscosity",
    "contact-dashpot",
    "tangential-dashpot",
];

#[test]
fn every_name_is_judged_by_some_test_or_at_run_time() {
    // `unstable` is checked window by window, not in the plan; `overlap` has its test in `speeds.rs`.
    let text = include_str!("plan.rs");
    for name in
        NAMES.iter().filter(|name| !["overlap", "unstable"].contains(name) && !OF_SOLVERS.contains(name))
    {
        assert!(
            text.contains(&format!("(\"{name}\"")) || text.contains(&format!("        \"{name}\",\n")),
            "no test of {name}"
        );
    }
}

#[test]
fn an_adaptive_window_is_held_below_the_contact_bound_and_a_fixed_one_is_refused() {
    let mut case = Case::new();
    case.fluid.dt = 0.5;
    case.fluid.adaptive = true;
    let plan = case.plan();
    assert!((plan.steps.dt_fluid - 0.2).abs() < 1e-15, "100 t_c");
    assert_eq!(plan.refusals().count(), 0);
    case.fluid.adaptive = false;
    let plan = case.plan();
    assert_eq!(plan.refusals().map(|bound| bound.name.as_str()).collect::<Vec<_>>(), ["window-over-contact"]);
}

#[test]
fn adaptive_windows_begin_with_the_first_and_keep_the_bounds_that_the_plan_keeps() {
    let plan = |bounds: Vec<SolverBound>| {
        let fluid = FluidFacts { adaptive: true, first_dt: 0.002, bounds, ..fluid() };
        Case { fluid, ..Case::new() }.plan()
    };
    let free = plan(Vec::new());
    assert_eq!((free.steps.dt_fluid, free.dt_first, free.windows), (0.01, 0.002, 100));
    assert!((free.dt_max - 0.2).abs() < 1e-15, "100 t_c");
    // A table that breaks beyond 0.01 s, a factor that does beyond 0.05 s; of another order: nothing.
    assert_eq!(plan(vec![table()]).dt_max, 0.01);
    assert!((plan(vec![solver_bound("cfl", 20.0, Measure::Window)]).dt_max - 0.05).abs() < 1e-15);
    let other = SolverBound { scheme: Some(Scheme::Iterated), ..table() };
    assert_eq!(plan(vec![other]).dt_max, free.dt_max);
    // One that is broken already, and forced, holds nothing back.
    assert_eq!(plan(vec![solver_bound("cfl", 200.0, Measure::Window)]).dt_max, free.dt_max);
    // A fluid that names no first step begins with its own.
    assert_eq!(Case::new().plan().dt_first, 0.01);
}

#[test]
fn the_smaller_of_two_sub_steps_wins() {
    let mut case = Case::new();
    case.dem.dt = 5e-5;
    assert_eq!(case.plan().steps.substeps, 200, "the DEM's own");
    case.dem.dt = 1.0;
    assert_eq!(case.plan().steps.substeps, 100, "t_c/20");
    assert_eq!(substeps(0.3, 0.1), 3, "0.3/0.1 is 2.9999999999999996");
    assert_eq!(substeps(0.1 + 0.2, 0.1), 3, "0.30000000000000004/0.1");
    assert_eq!(substeps(0.31, 0.1), 4);
    assert_eq!(substeps(0.01, 0.1), 1);
}

#[test]
fn the_fluid_must_be_able_to_follow_the_scheme() {
    let plan = |schemes: &[Scheme], name: &str| {
        let scene = scene(&[&format!("coupling.scheme=\"{name}\"")]);
        let facts = FluidFacts { schemes: schemes.to_vec(), ..fluid() };
        Plan::new(&scene, &Coupling::read(&scene).unwrap(), Some(&facts), Some(&dem()), None)
    };
    use Scheme::{Explicit, Iterated, SemiImplicit};
    let all = [(Explicit, "explicit"), (SemiImplicit, "semi-implicit"), (Iterated, "iterated")];
    for schemes in [&[Explicit][..], &[SemiImplicit], &[SemiImplicit, Iterated]] {
        assert_eq!(plan(schemes, "auto").unwrap().scheme, Some(schemes[0]));
        for (scheme, name) in all {
            match plan(schemes, name) {
                Ok(plan) => assert!(schemes.contains(&scheme) && plan.scheme == Some(scheme)),
                Err(error) => {
                    assert!(!schemes.contains(&scheme), "{schemes:?} {name}");
                    assert_eq!(error.key, "coupling.scheme");
                    assert!(error.message.contains(&schemes[0].to_string()), "{}", error.message);
                }
            }
        }
    }
    // A fluid that does not say.
    assert_eq!(plan(&[], "auto").unwrap().scheme, Some(SemiImplicit));
    assert!(plan(&[], "iterated").is_ok() && plan(&[], "explicit").is_err());
}

#[test]
fn windows_are_repeated_where_a_bound_of_the_fluid_asks_for_it_and_nowhere_else() {
    let facts = |dt: f64, schemes: &[Scheme]| {
        let mut repeated = SolverBound { scheme: Some(Scheme::Iterated), ..table() };
        repeated.rows.iter_mut().for_each(|row| row.limit = 0.01);
        let once =
            SolverBound { scheme: Some(Scheme::SemiImplicit), wider_in: Some(Scheme::Iterated), ..table() };
        FluidFacts { dt, schemes: schemes.to_vec(), bounds: vec![once, repeated], ..fluid() }
    };
    let plan = |overrides: &[&str], facts: &FluidFacts| {
        let scene = scene(overrides);
        Plan::new(&scene, &Coupling::read(&scene).unwrap(), Some(facts), Some(&dem()), None).unwrap()
    };
    let (short, long) = (facts(0.01, &[]), facts(0.02, &[]));
    assert_eq!(plan(&[], &short).scheme, Some(Scheme::SemiImplicit));
    let repeats = plan(&[], &long);
    assert_eq!(repeats.scheme, Some(Scheme::Iterated));
    let notices = repeats.notices.join(" ");
    assert!(notices.contains("iterated") && notices.contains("density-ratio"), "{notices}");
    assert!(repeats.bounds.iter().all(|bound| bound.name != "density-ratio" || bound.holds));
    // Who names a scheme, or forces the bound, gets what was asked for.
    let scheme = |overrides: &[&str]| plan(overrides, &long).scheme;
    assert_eq!(scheme(&["coupling.scheme=\"semi-implicit\""]), Some(Scheme::SemiImplicit));
    assert_eq!(scheme(&["coupling.force=[\"density-ratio\"]"]), Some(Scheme::SemiImplicit));
    // Windows are half as many, and each costs six attempts.
    assert!(repeats.cost > 2.0 * plan(&[], &short).cost, "{}", repeats.cost);
    // A fluid that cannot repeat a window: the bound is broken.
    let plan = plan(&[], &facts(0.02, &[Scheme::SemiImplicit]));
    assert_eq!(plan.scheme, Some(Scheme::SemiImplicit));
    assert!(plan.bounds.iter().any(|bound| bound.name == "density-ratio" && !bound.holds));
}

#[test]
fn coupling_section_names_what_is_wrong() {
    for (text, key) in [
        ("coupling.deadline=0", "coupling.deadline"),
        ("coupling.checkpoint_every=-1", "coupling.checkpoint_every"),
        ("coupling.steps_per_contact=nan", "coupling.steps_per_contact"),
        ("coupling.deadlin=3", "coupling.deadlin"),
        ("coupling.scheme=\"sometimes\"", "coupling.scheme"),
        ("coupling.iterations.tolerance=0", "coupling.iterations.tolerance"),
        ("coupling.iterations.tolerance=nan", "coupling.iterations.tolerance"),
        ("coupling.iterations.max_iterations=1", "coupling.iterations.max_iterations"),
        ("coupling.iterations.most=5", "coupling.iterations.most"),
        ("coupling.iterations.depth=0", "coupling.iterations.depth"),
        ("coupling.iterations.relaxation=\"aitken\"", "coupling.iterations.relaxation"),
        ("coupling.scheme=\"overlapped\"", "coupling.scheme"),
        ("coupling.iterations.mots=3", "coupling.iterations.mots"),
    ] {
        let error = Coupling::read(&scene(&[text])).expect_err(text);
        assert_eq!(error.key, key, "{error}");
        assert!(error.line > 0 && !error.remedy.is_empty());
    }
}

#[test]
fn bounds_of_a_solver_of_the_run_can_be_forced_by_name_too() {
    let own = || SolverBound::new("lift", "dt_dem", (1.0, Measure::Substep), Side::AtMost, 1e-9);
    let mut case = Case::new();
    case.scene = vec!["coupling.force=[\"lift\"]"];
    let scene = scene(&case.scene);
    let coupling = Coupling::read(&scene).expect("its names are checked with the plan");
    let error = Plan::new(&scene, &coupling, Some(&case.fluid), Some(&case.dem), None).expect_err("no such");
    assert_eq!(error.key, "coupling.force", "{error}");
    assert!(error.message.contains("`lift`") && error.message.contains("contact-steps"), "{error}");
    assert!(error.line > 0 && !error.remedy.is_empty());
    case.dem.bounds = vec![own()];
    assert!(case.plan().refusals().all(|bound| bound.name != "lift"));
    case.scene = vec!["coupling.force=[\"lift\", \"speed-limit\"]"];
    let scene = self::scene(&case.scene);
    let coupling = Coupling::read(&scene).unwrap();
    let error = Plan::new(&scene, &coupling, Some(&case.fluid), Some(&case.dem), None).expect_err("no such");
    assert!(error.message.contains("`speed-limit`") && error.message.ends_with(", lift"), "{error}");
    case.scene.clear();
    assert!(case.plan().refusals().any(|bound| bound.name == "lift"));
}

#[test]
fn who_takes_part() {
    assert_eq!(Participants::of(&scene(&[r#"grains[0].motion="fixed""#])), Participants::Fluid);
    let dry = SPHERE.replace("[medium]\ndensity = 1.0\nviscosity = 0.01\n", "");
    let dry = CheckedScene::new(SceneSource { file: "dry.toml".into(), text: dry }).unwrap();
    let coupling = Coupling::read(&dry).unwrap();
    let plan = Plan::new(&dry, &coupling, None, Some(&dem()), None).unwrap();
    assert_eq!((plan.participants, plan.scheme), (Participants::Dem, None));
    assert_eq!((plan.steps.dt_fluid, plan.steps.substeps), (1e-4, 1));
    assert!(plan.bounds.iter().any(|bound| bound.name == "contact-steps"));
    assert!(!plan.bounds.iter().any(|bound| bound.name == "window-over-contact"));
}

#[test]
fn a_sub_step_that_is_not_taken_as_the_scene_asks_is_told() {
    let said = |dt: f64| {
        let case = Case { dem: DemFacts { dt, ..dem() }, ..Case::new() };
        let plan = case.plan();
        let told = plan.notices.iter().find(|notice| notice.starts_with("dem.dt")).cloned();
        (plan.dt_dem_target, told)
    };
    assert_eq!(said(1e-4), (1e-4, None), "a twentieth of the contact time");
    let (taken, told) = said(4e-4);
    assert_eq!(taken, 1e-4);
    let told = told.expect("a notice");
    assert!(
        told.contains("4.000e-4 s (5 in a contact time)") && told.contains("at most 1.000e-4 s"),
        "{told}"
    );
}

#[test]
fn few_windows_in_a_period_and_long_ones_after_a_release_are_told() {
    let told = |overrides: &[&'static str], dt: f64, word: &str| {
        let case = Case { scene: overrides.to_vec(), fluid: FluidFacts { dt, ..fluid() }, ..Case::new() };
        case.plan().notices.into_iter().find(|notice| notice.starts_with(word))
    };
    let swing: &[&str] = &[
        "grains[0].motion=prescribed",
        "grains[0].velocity={ amplitude = [0.0, 0.0, 0.1], frequency = 10.0 }",
    ];
    let few = told(swing, 0.01, "oscillation").expect("a notice");
    assert!(few.contains("10 windows in a period") && few.contains("fluid.time.dt = 0.002 s"), "{few}");
    assert_eq!(told(swing, 0.001, "oscillation"), None);
    assert!(told(&[], 1e9, "release").is_some());
    assert_eq!(told(&[], 1e-9, "release"), None);
    // Adaptive windows resolve both.
    let adaptive = |overrides: &[&'static str], dt: f64| {
        let fluid = FluidFacts { dt, adaptive: true, ..fluid() };
        Case { scene: overrides.to_vec(), fluid, ..Case::new() }.plan().notices
    };
    let words = ["oscillation", "release"];
    let found = [adaptive(swing, 0.01), adaptive(&[], 1e9)].concat();
    assert!(found.iter().all(|notice| words.iter().all(|word| !notice.starts_with(word))), "{found:?}");
}

#[test]
fn keys_beside_others_that_make_them_idle_are_told() {
    let told = |overrides: &[&'static str], fluid: FluidFacts| {
        let notices = Case { scene: overrides.to_vec(), fluid, ..Case::new() }.plan().notices;
        notices.into_iter().find(|notice| notice.contains("no effect"))
    };
    let repeats = ["coupling.iterations.max_iterations=5"];
    let idle = told(&repeats, fluid()).expect("a notice");
    assert!(idle.starts_with("coupling.iterations") && idle.contains("semi-implicit"), "{idle}");
    let fixed = |adaptive: bool| FluidFacts { cfl: 0.3, adaptive, ..fluid() };
    let idle = told(&[], fixed(false)).expect("a notice");
    assert!(idle.contains("fluid.time.cfl = 0.3") && idle.contains("fluid.time.dt"), "{idle}");
    assert_eq!(told(&[], fixed(true)), None);
    assert_eq!(told(&[], fluid()), None);
}

#[test]
fn fields_and_a_log_beyond_the_end_are_told() {
    let told = |overrides: &[&'static str], word: &str| {
        let case = Case { scene: overrides.to_vec(), ..Case::new() };
        case.plan().notices.into_iter().find(|notice| notice.starts_with(word))
    };
    let late = told(&["until=0.3", "observe.fields_at=[0.1, 5.0]"], "observe.fields_at").expect("a notice");
    assert!(late.contains("5 s is after the end of the run, until = 0.3 s"), "{late}");
    assert_eq!(told(&["until=0.3", "observe.fields_at=[0.1, 0.3]"], "observe.fields_at"), None);
    for key in ["observe.every", "observe.fields_every"] {
        let overrides = |every: &str| format!("{key}={every}").leak() as &str;
        let late = told(&["until=0.3", overrides("5.0")], key).expect("a notice");
        assert!(late.contains("5 s is after the end of the run"), "{late}");
        assert_eq!(told(&["until=0.3", overrides("0.3")], key), None);
    }
    let planes = |from: &str| format!("observe.planes={{ every = 0.03, from = {from} }}").leak() as &str;
    let late = told(&["until=0.05", planes("0.04")], "observe.planes").expect("a notice");
    assert!(late.contains("0.06 s is after the end of the run, until = 0.05 s"), "{late}");
    assert_eq!(told(&["until=0.05", planes("0.03")], "observe.planes"), None);
    let clock = told(&["until=4e11"], "until").expect("a notice");
    assert!(clock.contains("1.845e10 s") && clock.contains("larger unit of time"), "{clock}");
    assert_eq!(told(&["until=1e10"], "until"), None);
}

#[test]
fn a_wall_that_moves_in_a_fluid_and_a_face_that_lets_grains_out_are_told() {
    let told = |overrides: &[&'static str], word: &str| {
        let case = Case { scene: overrides.to_vec(), ..Case::new() };
        case.plan().notices.into_iter().find(|notice| notice.starts_with(word))
    };
    let wall = "walls=[{ point = [0, 0, 0.5], normal = [0, 0, 1], velocity = [0, 0, 0.2] }]";
    let moving = told(&[wall], "walls[0]").expect("a notice");
    assert!(moving.contains("moves at 0.2 m/s") && moving.contains("does not see it"), "{moving}");
    assert_eq!(told(&["walls=[{ point = [0, 0, 0.5], normal = [0, 0, 1] }]"], "walls"), None);
    let lid = "domain.boundary={ x = \"periodic\", y = \"periodic\", z_lower = \"no-slip\", \
               z_upper = \"free-slip\" }";
    let light = "grains[0].density=0.5";
    let out = told(&[lid, light], "buoyancy").expect("a notice");
    assert!(out.contains("upper face of z") && out.contains("z_upper = { type = \"free-slip\""), "{out}");
    assert_eq!(told(&[lid], "weight"), None, "the floor stops it");
    assert_eq!(told(&[light], "buoyancy"), None, "the lid stops it");
    let above = "walls=[{ point = [0, 0, 3.5], normal = [0, 0, -1] }]";
    assert_eq!(told(&[lid, light, above], "buoyancy"), None, "a wall stops it");
}

/// Films act on free grains: a held or driven one beside what moves otherwise is told, whichever of the two
/// moves, across a periodic face too.
#[test]
fn a_held_grain_beside_what_moves_otherwise_is_told() {
    let told = |overrides: &[&'static str]| {
        let case = Case { scene: overrides.to_vec(), ..Case::new() };
        case.plan().notices.into_iter().find(|notice| notice.contains("lacks the film"))
    };
    let lid = "domain.boundary={ x = \"periodic\", y = \"periodic\", z_lower = \"no-slip\", z_upper = { type = \
               \"no-slip\", velocity = [0.1, 0.0, 0.0] } }";
    let grain = |place: &str, more: &str| {
        format!("{{ position = {place}, radius = 0.5, density = 2.0, motion = \"fixed\"{more} }}")
    };
    let grains = |all: &[String]| format!("grains=[{}]", all.join(", ")).leak() as &'static str;
    let held = grain("[2.0, 2.0, 3.48]", "");
    assert!(
        told(&[lid, grains(std::slice::from_ref(&held))])
            .expect("a notice")
            .starts_with("grain 0, held or driven")
    );
    assert_eq!(told(&[grains(std::slice::from_ref(&held))]), None, "the lid is at rest");
    let driven = grain("[0.49, 2.0, 2.0]", ", velocity = [0.0, 0.0, 1e-3]").replace("fixed", "prescribed");
    let beyond = grain("[3.47, 2.0, 2.0]", "");
    assert!(told(&[grains(&[beyond.clone(), driven.clone()])]).expect("a notice").starts_with("grain 1"));
    assert_eq!(told(&[grains(&[beyond.replace("3.47", "2.6"), driven])]), None);
}
