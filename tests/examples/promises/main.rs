//! Counts the promises of `--accuracy … --verify` on scenes drawn at random: `cargo run --release -p tests
//! --example promises -- FIRST LAST OUT.csv`, with the programs built (`cargo build --release`). What each
//! seed's scene is served with is compared with the limit of the grids that it ran and of finer ones, 1.5
//! times as fine each (Richardson 1911), or the finest value where these do not go one way. Its price is
//! that of all grids over that of the coarsest which would have done.

mod drawn;

use std::fmt::Write as _;
use std::process::ExitCode;

use coupler::limit::richardson;
use coupler::resolution::{fast, set};
use serde_json::Value;
use tests::harness::{Folder, bedload, metric, said, summary};

use drawn::{Drawn, scene};

/// Most CPU time of a finer grid, s; the second is run where it is estimated to take no longer.
const LONGEST: f64 = 60.0;

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [first, last, out] = arguments.as_slice() else {
        eprintln!("promises FIRST LAST OUT.csv");
        return ExitCode::from(2);
    };
    let (Ok(first), Ok(last)) = (first.parse::<u64>(), last.parse::<u64>()) else {
        eprintln!("promises: FIRST and LAST are seeds");
        return ExitCode::from(2);
    };
    let mut table = String::from("seed,kind,numbers,asked,verdict,error,estimate,dearer,cpu_s,grids,why\n");
    let mut counts = [0; 4];
    for seed in first..=last {
        let drawn = scene(seed);
        let (place, verdict, cells) = match outcome(seed, &drawn) {
            Outcome::Served(served) => {
                let kept = served.error <= drawn.target;
                let dearer = served.dearer.map_or(String::new(), |dearer| format!("{dearer:.1}"));
                let cells = format!(
                    "{:.5},{:.5},{dearer},{:.1},{},",
                    served.error, served.estimate, served.cpu, served.grids
                );
                (usize::from(!kept), if kept { "kept" } else { "broken" }, cells)
            }
            Outcome::Failed(why) => (2, "failed", format!(",,,,,{}", cell(&why))),
            Outcome::Refused(why) => (3, "refused", format!(",,,,,{}", cell(&why))),
        };
        counts[place] += 1;
        let numbers = cell(&drawn.numbers);
        let line = format!("{seed},{},{numbers},{},{verdict},{cells}", drawn.kind, drawn.target);
        println!("{line}");
        let _ = writeln!(table, "{line}");
        std::fs::write(out, &table).expect("the table is written");
    }
    let [kept, broken, failed, refused] = counts;
    println!("kept {kept}, broken {broken}, failed {failed}, refused {refused}");
    ExitCode::from(u8::from(broken + failed > 0))
}

/// Text as a cell of a table.
fn cell(text: &str) -> String {
    text.replace([',', '\n'], ";")
}

/// What a scene was served with.
struct Served {
    /// Largest relative error of its metrics.
    error: f64,
    /// The same as the program estimated it.
    estimate: f64,
    /// CPU time of all its grids over that of the coarsest which would have done, if one would.
    dearer: Option<f64>,
    /// CPU time of all its grids, s.
    cpu: f64,
    /// D/Δx of its grids.
    grids: String,
}

enum Outcome {
    Served(Served),
    Failed(String),
    Refused(String),
}

fn outcome(seed: u64, drawn: &Drawn) -> Outcome {
    let folder = Folder::new(&format!("promises-{seed}"));
    let path = folder.write("scene.toml", &drawn.text);
    let path = path.to_str().expect("UTF-8");
    let run = |name: &str, more: &[String]| {
        let out = folder.join(name);
        let out = out.to_str().expect("UTF-8");
        let mut arguments: Vec<String> =
            ["run", path, "--out", out, "--no-record", "--threads", "1"].map(str::to_owned).into();
        arguments.extend_from_slice(more);
        let output = bedload(&arguments);
        (output.status.code(), said(&output))
    };
    let asked = ["--accuracy".to_owned(), format!("{}%", 100.0 * drawn.target), "--verify".to_owned()];
    match run("asked", &asked) {
        (Some(0), _) => {}
        (Some(1), words) if words.contains("not as exact as asked") => {
            return Outcome::Refused(reason(&words));
        }
        (Some(2), words) => return Outcome::Refused(reason(&words)),
        (code, words) => return Outcome::Failed(format!("{code:?}: {}", reason(&words))),
    }
    let verification = summary(&folder.join("asked"))["verification"].take();
    let grids = verification["grids"].as_array().expect("grids");
    let cells = |grid: &Value| -> Vec<f64> {
        grid["cells"].as_array().expect("cells").iter().filter_map(Value::as_f64).collect()
    };
    let costs: Vec<f64> = grids.iter().filter_map(|grid| grid["cpu_s"].as_f64()).collect();
    let finest = cells(&grids[grids.len() - 1]);
    let width = |cells: &[f64]| cells.iter().product::<f64>().powf(-1.0 / cells.len() as f64);
    let mut widths: Vec<f64> = grids.iter().map(|grid| width(&cells(grid))).collect();
    let mut values: Vec<Vec<f64>> = drawn.metrics.iter().map(|name| on_grids(&verification, name)).collect();
    let (served, mut last) = (grids.len(), costs[costs.len() - 1]);
    for step in 1..=2 {
        if step == 2 && last * 1.5_f64.powi(finest.len() as i32 + 1) > LONGEST {
            break;
        }
        let times = 1.5_f64.powi(step);
        let finer: Vec<u64> = finest.iter().map(|count| fast((count * times - 1e-6).ceil() as u64)).collect();
        let (name, grid) = (format!("finer-{step}"), set(&finer, None));
        let (Some(0), _) = run(&name, &["--set".to_owned(), grid.concat()]) else {
            return Outcome::Failed(format!("a grid {}", name));
        };
        let out = folder.join(&name);
        for (values, name) in values.iter_mut().zip(&drawn.metrics) {
            values.push(metric(&out, name));
        }
        let cost = &summary(&out)["cost"];
        last = cost["fluid_cpu_s"].as_f64().unwrap_or(0.0) + cost["dem_cpu_s"].as_f64().unwrap_or(0.0);
        widths.push(width(&finer.iter().map(|count| *count as f64).collect::<Vec<_>>()));
    }
    let limits: Vec<f64> = values.iter().map(|values| limit(&widths, values)).collect();
    // Of the grids that were run, the coarsest from which on all are exact enough.
    let error = |grid: usize| {
        let of = values.iter().zip(&limits).map(|(values, limit)| (values[grid] / limit - 1.0).abs());
        of.fold(0.0, f64::max)
    };
    let enough = (0..served).rev().take_while(|grid| error(*grid) <= drawn.target).last();
    let cpu: f64 = costs.iter().sum();
    let resolutions = grids.iter().filter_map(|grid| grid["resolution"].as_f64());
    Outcome::Served(Served {
        error: error(served - 1),
        estimate: verification["error"].as_f64().unwrap_or(f64::NAN),
        dearer: enough.map(|grid| cpu / costs[grid]),
        cpu,
        grids: resolutions.map(|cells| format!("{cells:.1}")).collect::<Vec<_>>().join(" "),
    })
}

/// Values of a metric on the grids of a run.
fn on_grids(verification: &Value, name: &str) -> Vec<f64> {
    let values = verification["metrics"][name]["values"].as_array().expect(name);
    values.iter().map(|value| value.as_f64().unwrap_or(f64::NAN)).collect()
}

/// What the program said was wrong, without its remedy.
fn reason(words: &str) -> String {
    let joined = words.replace('│', " ");
    let marks = ["not as exact as asked: ", "accuracy:", "bedload: "];
    let said =
        marks.iter().find_map(|mark| joined.rsplit_once(mark)).map_or(joined.as_str(), |(_, rest)| rest);
    let said = said.split_once('╭').map_or(said, |(message, _)| message);
    said.split_whitespace().collect::<Vec<_>>().join(" ").replace("/ ", "/")
}

/// Limit of the values on these grids, coarsest first.
fn limit(widths: &[f64], values: &[f64]) -> f64 {
    let points: Vec<(f64, f64)> = widths.iter().copied().zip(values.iter().copied()).collect();
    richardson(&points).map_or(values[values.len() - 1], |limit| limit.value)
}
