//! `bedload chart`: a small chart from end to end, what is never repeated, and sections that are wrong.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::time::SystemTime;

use bedload_output::Claim;
use bedload_scene::{CheckedScene, SceneSource};
use study::kind::Kind;
use study::study::Study;
use tests::harness::{Folder, bedload, browse, said};

/// A grain that flies against a wall; its speed afterwards is that of the law, eqs 17 and 18 clipped:
/// exp(−r (π − atan2(2r, 1 − r²))), r = −ln e/π.
const SCENE: &str = r#"
title = "A grain against a wall"
until = 0.03
[domain]
geometry = "space"
lower = [0.0, 0.0, 0.0]
upper = [1.0, 1.0, 1.0]
boundary = { x = "free-slip", y = "free-slip", z_lower = "no-slip", z_upper = "free-slip" }
[[grains]]
position = [0.5, 0.5, 0.1005]
velocity = [0.0, 0.0, -0.1]
radius = 0.1
density = 2.0
[dem.contact]
law = "linear-spring-dashpot"
restitution = 0.87
contact_time = 0.01
[observe]
every = 0.01
[[metrics]]
name = "speed"
kind = "final"
column = "velocity_z[0]"
"#;

const CHART: &str = r#"
[chart]
title = "Restitution <&>"
about = "A test."
metric = "speed"
reference = 0.0873421
source = "solution of the law"
repeat = 2
baseline = "paper"
published = [{ name = "nobody", cost = 1.0, error = 0.5, source = "no source: a test" }]
[[chart.vary]]
key = "dem.integrator"
name = "integrator"
values = ["symplectic-euler", "velocity-verlet"]
[[chart.vary]]
key = "dem.steps_per_contact"
name = "t_c/Δt"
values = [12, 25, 50]
[[chart.runs]]
label = "paper"
set = { "dem.steps_per_contact" = 100 }
[[chart.runs]]
label = "refused"
set = { "dem.steps_per_contact" = 4 }
"#;

fn text(path: &Path) -> String {
    std::fs::read_to_string(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

/// When each run's result was written.
fn written(out: &Path) -> BTreeMap<PathBuf, SystemTime> {
    let mut found = BTreeMap::new();
    for runs in ["runs", "runs-2"] {
        for entry in std::fs::read_dir(out.join(runs)).expect("runs").flatten() {
            let path = entry.path().join("summary.json");
            if let Ok(data) = std::fs::metadata(&path) {
                found.insert(path, data.modified().expect("a time"));
            }
        }
    }
    found
}

/// Rows of `chart.csv` by label, each by column.
fn rows(out: &Path) -> BTreeMap<String, BTreeMap<String, String>> {
    let table = text(&out.join("chart.csv"));
    let mut lines = table.lines().map(|line| line.split(',').map(str::to_owned).collect::<Vec<_>>());
    let header = lines.next().expect("a header");
    let row = |cells: Vec<String>| header.iter().cloned().zip(cells).collect::<BTreeMap<_, _>>();
    lines.map(row).map(|row| (row["label"].clone(), row)).collect()
}

#[test]
fn a_chart_is_run_once_and_its_page_made_again() {
    let folder = Folder::new("chart");
    let scene = folder.write("wall.toml", &format!("{SCENE}{CHART}"));
    let out = folder.join("out");
    let chart = || bedload(&["chart".as_ref(), scene.as_os_str(), "--out".as_ref(), out.as_os_str()]);
    let first = chart();
    assert_eq!(first.status.code(), Some(0), "{}", said(&first));
    let (csv, svg, html) = (out.join("chart.csv"), out.join("chart.svg"), out.join("chart.html"));
    let header = "dem.integrator,dem.steps_per_contact,cpu_s,wall_s,error,pareto,label,value,";
    assert!(text(&csv).starts_with(header), "{}", text(&csv));
    let rows = rows(&out);
    assert_eq!(rows.len(), 8, "{rows:?}");
    let error = |label: &str| -> f64 { rows[label]["error"].parse().expect(label) };
    let verlet = [12, 25, 50].map(|n| error(&format!("integrator-velocity-verlet_steps_per_contact-{n}")));
    assert!(verlet[2] < verlet[0] && verlet[2] < 0.02, "{verlet:?}");
    assert_eq!(rows["paper"]["dem.steps_per_contact"], "100");
    assert_eq!(rows["paper"]["dem.integrator"], "", "it is left to its default");
    let refused = &rows["refused"];
    assert_eq!((refused["error"].as_str(), refused["pareto"].as_str()), ("", "0"));
    assert!(refused["note"].contains("contact"), "{refused:?}");
    let front: Vec<_> = rows.values().filter(|row| row["pareto"] == "1").collect();
    assert!(!front.is_empty() && front.iter().all(|row| row["repeats"] == "2" && row["beside"] == "0"));
    // Which runs are named is a question of time.
    assert!(text(&svg).contains("t_c/Δt ") && text(&svg).contains("<title>published: nobody"));
    let page = text(&html);
    for part in [
        "Restitution &lt;&amp;&gt;",
        "solution of the law",
        "integrator = velocity-verlet",
        "no source: a test",
    ] {
        assert!(page.contains(part), "no {part}");
    }
    assert!(said(&first).contains("cheapest within"), "{}", said(&first));

    // Nothing is repeated, and nothing changes.
    let before = (text(&csv), text(&svg), text(&html), written(&out));
    assert_eq!(before.3.len(), 14);
    let second = chart();
    assert_eq!(second.status.code(), Some(0), "{}", said(&second));
    assert_eq!(said(&second).matches("finished before").count(), 14, "{}", said(&second));
    assert_eq!(before, (text(&csv), text(&svg), text(&html), written(&out)));

    // The page comes from the table and the scene.
    std::fs::remove_file(&html).expect("removed");
    std::fs::remove_file(&svg).expect("removed");
    let report = bedload(&["report".as_ref(), out.as_os_str()]);
    assert_eq!(report.status.code(), Some(0), "{}", said(&report));
    assert_eq!((&before.1, &before.2), (&text(&svg), &text(&html)));
    in_a_browser(&html);

    // Another value of another key: the runs there are stay.
    let more =
        CHART.replace("values = [12, 25, 50]", "values = [12, 25, 50, 80]").replace("A test.", "More.");
    std::fs::write(&scene, format!("{SCENE}{more}")).expect("written");
    let third = chart();
    assert_eq!(said(&third).matches("finished before").count(), 14, "{}", said(&third));
    assert_eq!(written(&out).len(), 18);

    // A run that was interrupted goes on from its checkpoint.
    let summary = out.join("runs/paper/summary.json");
    let completed = text(&summary);
    assert!(completed.contains("\"completed\""), "{completed}");
    std::fs::write(&summary, completed.replace("\"completed\"", "\"interrupted\"")).expect("written");
    let fourth = chart();
    assert_eq!(said(&fourth).matches("paper: goes on").count(), 1, "{}", said(&fourth));
    assert_eq!(said(&fourth).matches("finished before").count(), 17, "{}", said(&fourth));
    assert!(text(&summary).contains("\"completed\""), "{}", text(&summary));
}

#[test]
fn a_run_is_finished_only_with_the_states_and_tables_that_it_began_with() {
    let folder = Folder::new("chart-inputs");
    let bed = folder.write("bed.toml", SCENE);
    let on = SCENE.replace("[dem.contact]", "[dem]\ninitial_state = \"bed\"\n[dem.contact]");
    let metric = "[[metrics]]\nname = \"apart\"\nkind = \"series-difference\"\ncolumn = \"velocity_z[0]\"\n\
                  file = \"table.csv\"\n";
    let chart = "[chart]\nmetric = \"speed\"\nreference = 0.09\n[[chart.runs]]\nlabel = \"a\"\n\
                 set = { \"dem.steps_per_contact\" = 50 }\n";
    let scene = folder.write("on.toml", &format!("{on}{metric}{chart}"));
    let out = folder.join("out");
    let charted = |expected: &str| {
        let output = bedload(&["chart".as_ref(), scene.as_os_str(), "--out".as_ref(), out.as_os_str()]);
        assert_eq!(output.status.code(), Some(0), "{}", said(&output));
        assert!(said(&output).contains(&format!("a: {expected}")), "{expected}: {}", said(&output));
    };
    let state = |until: &str| {
        let to = folder.join("bed");
        let [bed, to] = [&bed, &to].map(|path| path.to_str().expect("UTF-8"));
        let output = bedload(&["run", bed, "--out", to, "--overwrite", "--until", until]);
        assert_eq!(output.status.code(), Some(0), "{}", said(&output));
    };
    state("0.03");
    folder.write("table.csv", "t,value\n0.01,0.1\n0.03,0.1\n");
    charted("runs");
    charted("finished before");
    folder.write("table.csv", "t,value\n0.01,0.1\n0.03,0.2\n");
    charted("runs");
    state("0.02");
    charted("runs");
    // The same again is the same.
    state("0.02");
    charted("finished before");
    std::fs::remove_dir_all(folder.join("bed")).expect("removed");
    charted("finished before; a state or table that it read is gone");
}

/// The page in headless Chromium: it is drawn, and its console stays empty. Without the browser only
/// a remark is left.
fn in_a_browser(page: &Path) {
    let folder = Folder::new("chart-browser");
    let picture = folder.join("page.png");
    let Some(said) = browse(page, (1300, 2400), &[&format!("--screenshot={}", picture.display())]) else {
        return;
    };
    assert!(!said.contains("CONSOLE"), "{said}");
    let bytes = std::fs::metadata(&picture).map_or(0, |data| data.len());
    assert!(bytes > 20_000, "a picture of {bytes} bytes: {said}");
}

#[test]
fn a_chart_without_any_error_fails_and_a_wrong_folder_is_refused() {
    let folder = Folder::new("chart-fails");
    let chart = "[chart]\nmetric = \"speed\"\nreference = 1.0\n[[chart.runs]]\nlabel = \"refused\"\n\
                 set = { \"dem.steps_per_contact\" = 4 }\n";
    let scene = folder.write("wall.toml", &format!("{SCENE}{chart}"));
    let out = folder.join("out");
    let output = bedload(&["chart".as_ref(), scene.as_os_str(), "--out".as_ref(), out.as_os_str()]);
    assert_eq!(output.status.code(), Some(1), "{}", said(&output));
    assert!(said(&output).contains("no run gave an error"), "{}", said(&output));
    assert_eq!(rows(&out)["refused"]["error"], "");
    assert!(out.join("chart.html").exists(), "the page says what failed");
    std::fs::write(out.join("summary.json"), "{}").expect("written");
    let output = bedload(&["chart".as_ref(), scene.as_os_str(), "--out".as_ref(), out.as_os_str()]);
    assert_eq!(output.status.code(), Some(2), "{}", said(&output));
}

/// Each of two charts has a folder of its own; neither replaces the other, nor what a third has made.
#[test]
fn two_charts_do_not_share_a_folder() {
    let folder = Folder::new("two-charts");
    let chart = "[chart]\nmetric = \"speed\"\nreference = 0.0873421\n[[chart.runs]]\nlabel = \"a\"\n\
                 set = { \"dem.steps_per_contact\" = 50 }\n";
    let [one, two] = ["one", "two"].map(|name| {
        let out = folder.join("out");
        let scene = folder.write(&format!("{name}.toml"), &format!("{SCENE}{chart}"));
        (scene, out.join(name))
    });
    let out = folder.join("out");
    let words = ["study".as_ref(), one.0.as_os_str(), two.0.as_os_str(), "--out".as_ref(), out.as_os_str()];
    let output = bedload(&words);
    assert_eq!(output.status.code(), Some(0), "{}", said(&output));
    assert!(one.1.join("chart.csv").exists() && two.1.join("chart.csv").exists());
    let output = bedload(&["chart".as_ref(), two.0.as_os_str(), "--out".as_ref(), one.1.as_os_str()]);
    assert_eq!(output.status.code(), Some(2), "{}", said(&output));
    assert!(said(&output).contains("another study"), "{}", said(&output));
}

#[test]
fn a_folder_in_use_is_left_alone() {
    let folder = Folder::new("chart-in-use");
    let scene = folder.write("wall.toml", &format!("{SCENE}{CHART}"));
    let out = folder.join("out");
    std::fs::create_dir_all(&out).expect("made");
    let claim = Claim::of(&out).expect("free");
    let case = Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenes/validation/haff.toml");
    let command = |name: &str, what: &Path| {
        let output = bedload(&[name.as_ref(), what.as_os_str(), "--out".as_ref(), out.as_os_str()]);
        (output.status.code(), said(&output))
    };
    let sweep = Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenes/stability/resting.toml");
    for (name, what) in [("run", &scene), ("chart", &scene), ("validate", &case), ("stability", &sweep)] {
        let (code, said) = command(name, what);
        assert_eq!(code, Some(7), "{name}: {said}");
        assert!(said.contains("in use by another process"), "{name}: {said}");
    }
    drop(claim);
    let (code, said) = command("run", &scene);
    assert_eq!(code, Some(0), "{said}");
}

#[test]
fn every_chart_of_the_scenes_is_planned() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let mut charted = 0;
    for folder in ["scenes", "scenes/drag"] {
        for entry in std::fs::read_dir(root.join(folder)).expect("scenes").flatten() {
            let path = entry.path();
            if path.extension().is_none_or(|end| end != "toml") || !text(&path).contains("\n[chart]\n") {
                continue;
            }
            let planned = SceneSource::read(&path, &[])
                .and_then(CheckedScene::new)
                .and_then(|scene| Study::of_scene(&scene, &path, Kind::Chart));
            let runs = planned.unwrap_or_else(|error| panic!("{error}")).points.len();
            assert!((3..=120).contains(&runs), "{}: {runs} runs", path.display());
            charted += 1;
        }
    }
    assert!(charted >= 8, "{charted} charts");
}

/// Marks the line at which an error must stand.
const MARK: char = '§';

#[test]
fn wrong_sections_are_refused_at_file_line_and_key() {
    let good = CHART;
    let read = |text: &str| {
        let source = SceneSource { file: "wall.toml".into(), text: format!("{SCENE}{text}") };
        let scene = CheckedScene::new(source).expect("the scene itself is right");
        Study::of_scene(&scene, Path::new("wall.toml"), Kind::Chart).map(|study| study.points.len())
    };
    assert_eq!(read(good).expect("the section is right"), 8);
    let cases = [
        ("metric = \"speed\"", "metric§ = \"sped\"", "chart.metric", "metrics are speed"),
        ("metric = \"speed\"", "metric = \"speed\"\nx§ = \"size\"", "chart.x", "which is not varied"),
        ("metric = \"speed\"", "", "chart", "no `metric`"),
        ("metric = \"speed\"", "metrik§ = \"speed\"", "chart.metrik", "unknown field"),
        ("reference = 0.0873421", "", "chart.metric", "no reference"),
        ("reference = 0.0873421", "reference§ = \"exact\"", "chart.reference", "expected a number"),
        (
            "reference = 0.0873421",
            "reference§ = { richardson = \"until\" }",
            "chart.reference.richardson",
            "not varied",
        ),
        (
            "reference = 0.0873421",
            "reference§ = { richardson = \"dem.steps_per_contact\", with = { \"dem.integrator\" = \"rk3\" } }",
            "chart.reference.with",
            "its values are symplectic-euler, velocity-verlet",
        ),
        (
            "reference = 0.0873421",
            "reference§ = { richardson = \"dem.integrator\" }",
            "chart.reference.richardson",
            "a limit needs 3",
        ),
        (
            "reference = 0.0873421",
            "reference§ = { richardson = \"dem.steps_per_contact\", with = { \"dem.steps_per_contact\" = 12 } }",
            "chart.reference.with",
            "is refined",
        ),
        ("metric = \"speed\"", "metric = \"speed\"\nx§ = \"dem.integrator\"", "chart.x", "symplectic-euler"),
        ("metric = \"speed\"", "metric§ = \"superficial_velocity_x\"", "chart.metric", "metrics are speed"),
        ("label = \"paper\"", "label = \"paper\"\nat§ = 1.0", "chart.runs[0].at", "runs of a case"),
        (
            "[[chart.runs]]\nlabel = \"paper\"",
            "[[chart.vary]]\nname = \"error\"\nvalues = [{ name = \"3\", set = { until = 1.0 } }]\n\
             [[chart.runs]]\nlabel = \"paper\"",
            "chart.vary[2]",
            "column of the table",
        ),
        (
            "[[chart.runs]]\nlabel = \"paper\"",
            "[[chart.vary]]\nname = \"b\"\n\
             values§ = [{ name = \"x\", set = { \"dem.steps_per_contact\" = 30 } }]\n\
             [[chart.runs]]\nlabel = \"paper\"",
            "chart.vary[2].values[0]",
            "vary already",
        ),
        ("baseline =", "seed§ =", "chart.seed", "its name is now chart.baseline"),
        ("repeat = 2", "repeat§ = 0", "chart.repeat", "1 to 1000"),
        ("repeat = 2", "repeat§ = 1.5", "chart.repeat", "invalid type"),
        ("cost = 1.0, error", "cost = -1.0, error", "chart.published[0].cost", "positive"),
        ("values = [12, 25, 50]", "values§ = []", "chart.vary[1].values", "is empty"),
        ("values = [12, 25, 50]", "", "chart.vary[1].values", "missing field"),
        ("key = \"dem.steps_per_contact\"\n", "key = \"untill\"\n", "chart.vary[1].values[0]", "untill"),
        ("label = \"paper\"", "label§ = \"a/b\"", "chart.runs[0].label", "becomes a folder"),
        ("label = \"refused\"", "label§ = \"paper\"", "chart.runs[1].label", "already"),
    ];
    for (from, to, key, words) in cases {
        assert_eq!(good.matches(from).count(), 1, "{from}");
        let text = good.replacen(from, to, 1);
        let line = text.lines().position(|line| line.contains(MARK));
        let error = read(&text.replace(MARK, "")).expect_err(to);
        assert_eq!((error.file.as_str(), error.key.as_str()), ("wall.toml", key), "{error}");
        assert!(error.message.contains(words) && !error.remedy.is_empty(), "{error}");
        if let Some(line) = line {
            assert_eq!(error.line, SCENE.lines().count() + line + 1, "{error}");
        }
    }
    let folder = Folder::new("chart-wrong");
    let scene =
        folder.write("wall.toml", &format!("{SCENE}{}", good.replace("\"paper\"\np", "\"papers\"\np")));
    let output = bedload(&["chart".as_ref(), scene.as_os_str()]);
    assert_eq!(output.status.code(), Some(2), "{}", said(&output));
    assert!(said(&output).contains("chart.baseline"), "{}", said(&output));
    let none = folder.write("none.toml", SCENE);
    let output = bedload(&["chart".as_ref(), none.as_os_str()]);
    assert_eq!(output.status.code(), Some(2), "{}", said(&output));
}
