//! Sweeps: their runs, and what is refused.

use std::path::Path;

use bedload_scene::{CheckedScene, SceneError, SceneSource};
use study::sweep::Sweep;
use study::vary::{SingleRun, Vary};

const SCENE: &str = r#"
until = 1.0
[domain]
geometry = "axisymmetric"
lower = [0.0, 0.0]
upper = [20.0, 40.0]
cells = [400, 800]
boundary = { r_upper = "free-slip", z = "free-slip" }
[medium]
density = 1.0
viscosity = 1.0
[[grains]]
position = [0.0, 0.0, 20.0]
radius = 0.5
density = 2.0
[fluid.time]
dt = 0.02
"#;

fn sweep(section: &str) -> Result<Sweep, SceneError> {
    #[derive(serde::Deserialize)]
    struct Document {
        chart: Section,
    }
    #[derive(serde::Deserialize)]
    struct Section {
        #[serde(default)]
        set: toml::Table,
        #[serde(default)]
        vary: Vec<Vary>,
        #[serde(default)]
        runs: Vec<SingleRun>,
    }
    let source = SceneSource { file: "s.toml".into(), text: format!("{SCENE}{section}") };
    let scene = CheckedScene::new(source)?;
    let chart = scene.source.section::<Document>()?.chart;
    Sweep::new((&scene, Path::new("s.toml")), &scene.source, "chart", &chart.set, &chart.vary, &chart.runs)
}

/// Line and key of what is refused, and the message.
fn refusal(section: &str) -> (usize, String, String) {
    let error = sweep(section).expect_err(section);
    (error.line - SCENE.lines().count(), error.key.clone(), error.to_string())
}

const GOOD: &str = r#"[[chart.vary]]
key = "resolution"
name = "D/dx"
values = [8, 10.0]
[[chart.vary]]
name = "method"
values = [
  { name = "thin", set = { "fluid.time.cfl" = 0.35, "fluid.time.dt" = 0.01 } },
  { name = "direct", set = { fluid.method = "izard-2014" } },
]
[[chart.runs]]
label = "paper"
set = { "fluid.method" = "izard-2014", "grains[0].density" = 4.0, "resolution" = 16 }
"#;

#[test]
fn combinations_come_with_the_last_key_fastest_then_single_runs() {
    let sweep = sweep(GOOD).unwrap();
    let keys: Vec<&str> = sweep.columns.iter().map(|column| column.key.as_str()).collect();
    assert_eq!(keys, ["resolution", "method", "grains[0].density"]);
    assert_eq!(sweep.columns[0].name, "D/dx");
    let labels: Vec<&str> = sweep.points.iter().map(|point| point.label.as_str()).collect();
    assert_eq!(
        labels,
        [
            "resolution-8_thin",
            "resolution-8_direct",
            "resolution-10.0_thin",
            "resolution-10.0_direct",
            "paper"
        ]
    );
    let first = &sweep.points[0];
    assert_eq!(first.set, ["fluid.time.cfl=0.35", "fluid.time.dt=0.01", "domain.cells=[160, 320]"]);
    assert_eq!(first.values, ["8", "thin", "2.0"]);
    // The single run's values are found where it has them from.
    assert_eq!(sweep.points[4].values, ["16", "direct", "4.0"]);
}

#[test]
fn values_of_any_type_are_set_as_they_are() {
    let text = "[[chart.vary]]\nkey = \"domain.boundary.z\"\nvalues = [\"free-slip\", { type = \"no-slip\" }]\n\
                [[chart.vary]]\nkey = \"threads\"\nvalues = [1, 2]\n";
    let sweep = sweep(text).unwrap();
    assert_eq!(sweep.points[2].set, [r#"domain.boundary.z={ type = "no-slip" }"#]);
    assert_eq!(
        sweep.points.iter().map(|p| p.threads).collect::<Vec<_>>(),
        [Some(1), Some(2), Some(1), Some(2)]
    );
    assert_eq!(sweep.points[3].values, ["{ type = 'no-slip' }", "2"]);
    assert_eq!(sweep.points[3].label, "z-type----no-slip_threads-2");
}

#[test]
fn what_every_run_is_set_to_comes_first() {
    let sweep = sweep(&format!("[chart]\nset = {{ until = 0.5, resolution = 8 }}\n{GOOD}")).unwrap();
    assert_eq!(sweep.points[1].set, ["until=0.5", "fluid.method=\"izard-2014\"", "domain.cells=[160, 320]"]);
    assert_eq!(sweep.points[2].set[3], "domain.cells=[200, 400]", "its own resolution wins");
    let (line, key, _) = refusal("[chart]\nset = { until = -0.5 }\n[[chart.runs]]\nlabel = \"a\"\n");
    assert_eq!((line, key.as_str()), (2, "chart.set"));
}

#[test]
fn wrong_entries_are_refused_at_their_line() {
    let (line, key, message) = refusal(&GOOD.replace("10.0]", "10.01]"));
    assert_eq!((line, key.as_str()), (4, "chart.vary[0].values[1]"));
    assert!(message.contains("whole numbers, such as 10"), "{message}");
    let (line, key, message) =
        refusal(&GOOD.replace("\"resolution\"\n", "\"until\"\n").replace("10.0", "-1.0"));
    assert_eq!((line, key.as_str()), (4, "chart.vary[0].values[1]"));
    assert!(message.contains("until"), "{message}");
    let (line, key, _) = refusal(&GOOD.replace("\"resolution\"\n", "\"unti\"\n"));
    assert_eq!((line, key.as_str()), (4, "chart.vary[0].values[0]"));
    let (line, key, _) = refusal(&GOOD.replace("[8, 10.0]", "[]"));
    assert_eq!((line, key.as_str()), (4, "chart.vary[0].values"));
    let (line, _, message) = refusal(&GOOD.replace("[8, 10.0]", "[8, 8]"));
    assert!(line == 4 && message.contains("second time"), "{message}");
    let (line, _, message) = refusal(&GOOD.replace(", set = { fluid.method", ", sets = 1, set = { x"));
    assert!(line == 9 && message.contains("no bundle"), "{message}");
    let (line, key, _) = refusal(&GOOD.replace("label = \"paper\"", "label = \"../paper\""));
    assert_eq!((line, key.as_str()), (12, "chart.runs[0].label"));
    let (line, key, _) = refusal(&GOOD.replace("grains[0]", "grains[7]"));
    assert_eq!((line, key.as_str()), (13, "chart.runs[0].set"));
    let (_, key, message) = refusal("[chart]\n");
    assert!(key == "chart" && message.contains("names no run"), "{message}");
    let many = "[[chart.vary]]\nkey = \"a\"\nvalues = [1,2,3,4,5,6,7,8,9,10]\n";
    let many: String = ["a", "b", "c", "d"].map(|key| many.replace("\"a\"", &format!("{key:?}"))).concat();
    assert!(refusal(&many).2.contains("more than 5000"));
}
