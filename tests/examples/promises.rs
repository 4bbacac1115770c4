//! Counts the promises of `--accuracy` on scenes drawn at random:
//! `cargo run --release -p tests --example promises -- FIRST LAST OUT.csv`, with the programs built
//! (`cargo build --release`). Each seed's scene is run as `--accuracy` has it and on two finer grids with
//! steps as much shorter; what it is compared with is their limit (Richardson 1911, order 1 to 2), or the
//! finest value where the three do not go one way.

use std::fmt::Write as _;
use std::process::ExitCode;

use tests::drawn::{Drawn, scene};
use tests::harness::{Folder, bedload, metric, said, summary};

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
    let mut table = String::from("seed,kind,numbers,asked,verdict,error,resolution,why\n");
    let mut counts = [0; 4];
    for seed in first..=last {
        let drawn = scene(seed);
        let outcome = outcome(seed, &drawn);
        let (place, verdict, error, cells, why) = match outcome {
            Outcome::Kept(error, cells) => (0, "kept", Some(error), cells, String::new()),
            Outcome::Broken(error, cells) => (1, "broken", Some(error), cells, String::new()),
            Outcome::Failed(why) => (2, "failed", None, String::new(), why),
            Outcome::Refused(why) => (3, "refused", None, String::new(), why),
        };
        counts[place] += 1;
        let error = error.map_or(String::new(), |error| format!("{error:.5}"));
        let line = format!(
            "{seed},{},{},{},{verdict},{error},{cells},{}",
            drawn.kind,
            drawn.numbers.replace(',', ";"),
            drawn.target,
            why.replace([',', '\n'], ";")
        );
        println!("{line}");
        let _ = writeln!(table, "{line}");
        std::fs::write(out, &table).expect("the table is written");
    }
    let [kept, broken, failed, refused] = counts;
    println!("kept {kept}, broken {broken}, failed {failed}, refused {refused}");
    ExitCode::from(u8::from(broken + failed > 0))
}

enum Outcome {
    /// Largest error, grid.
    Kept(f64, String),
    Broken(f64, String),
    Failed(String),
    Refused(String),
}

fn outcome(seed: u64, drawn: &Drawn) -> Outcome {
    let folder = Folder::new(&format!("promises-{seed}"));
    let path = folder.write("scene.toml", &drawn.text);
    let path = path.to_str().expect("UTF-8");
    let target = format!("{}%", 100.0 * drawn.target);
    let run = |name: &str, more: &[String]| -> Result<Vec<f64>, String> {
        let out = folder.join(name);
        let out_text = out.to_str().expect("UTF-8");
        let mut arguments: Vec<String> =
            ["run", path, "--out", out_text, "--no-record", "--threads", "1"].map(str::to_owned).into();
        arguments.extend_from_slice(more);
        let output = bedload(&arguments);
        if output.status.success() {
            Ok(drawn.metrics.iter().map(|name| metric(&out, name)).collect())
        } else {
            Err(format!("{:?}: {}", output.status.code(), said(&output)))
        }
    };
    let asked = ["--accuracy".to_owned(), target];
    let values = match run("asked", &asked) {
        Ok(values) => values,
        Err(words) if words.starts_with("Some(2)") && words.contains("accuracy") => {
            return Outcome::Refused(reason(&words));
        }
        Err(words) => return Outcome::Failed(words),
    };
    let chosen = summary(&folder.join("asked"));
    let cells = chosen_cells(&folder);
    let dt = chosen["time"]["dt_fluid"].as_f64();
    let mut ladder = vec![(1.0, values)];
    for finer in &drawn.finer {
        let grid: Vec<u64> = cells.iter().map(|count| even(finer * *count as f64)).collect();
        let mut more = vec!["--set".to_owned(), format!("domain.cells={grid:?}")];
        match dt.filter(|_| drawn.kind != "bounces in r-z") {
            Some(dt) => more.extend(["--set".to_owned(), format!("fluid.time.dt={:?}", dt / finer)]),
            None => more.extend(["--set".to_owned(), format!("fluid.time.cfl={:?}", 0.5)]),
        }
        match run(&format!("finer-{finer}"), &more) {
            Ok(values) => ladder.push((1.0 / finer, values)),
            Err(words) => return Outcome::Failed(format!("finer grid {words}")),
        }
    }
    let error = (0..drawn.metrics.len())
        .map(|place| {
            let points: Vec<(f64, f64)> = ladder.iter().map(|(h, values)| (*h, values[place])).collect();
            (points[0].1 / limit(&points) - 1.0).abs()
        })
        .fold(0.0, f64::max);
    let grid = format!("{cells:?}").replace(',', "");
    if error <= drawn.target { Outcome::Kept(error, grid) } else { Outcome::Broken(error, grid) }
}

/// What the program said was wrong, without its remedy.
fn reason(words: &str) -> String {
    let joined = words.replace('│', " ");
    let said = joined.split_once("accuracy:").map_or(joined.as_str(), |(_, rest)| rest);
    let said = said.split_once('╭').map_or(said, |(message, _)| message);
    said.split_whitespace().collect::<Vec<_>>().join(" ").replace("/ ", "/")
}

/// The grid that was chosen.
fn chosen_cells(folder: &Folder) -> Vec<u64> {
    let text = std::fs::read_to_string(folder.join("asked").join("scene.toml")).expect("scene.toml");
    let scene: toml::Table = toml::from_str(&text).expect("TOML");
    let cells = scene["domain"]["cells"].as_array().expect("cells");
    cells.iter().filter_map(toml::Value::as_integer).map(|count| count.unsigned_abs()).collect()
}

/// The nearest even number from `count` on.
fn even(count: f64) -> u64 {
    2 * (0.5 * count - 1e-9).ceil() as u64
}

/// Limit of three values (h, f), coarsest first.
fn limit(points: &[(f64, f64)]) -> f64 {
    let [(h3, f3), (h2, f2), (h1, f1)] = *points else { return points[points.len() - 1].1 };
    let asked = (f3 - f2) / (f2 - f1);
    let ratio = |p: f64| (h3.powf(p) - h2.powf(p)) / (h2.powf(p) - h1.powf(p));
    if !(asked.is_finite() && asked > 0.0) {
        return f1;
    }
    let order = if asked < ratio(1.0) {
        1.0
    } else if asked > ratio(2.0) {
        2.0
    } else {
        let (mut low, mut high) = (1.0, 2.0);
        for _ in 0..40 {
            let middle: f64 = 0.5 * (low + high);
            if ratio(middle) < asked { low = middle } else { high = middle }
        }
        0.5 * (low + high)
    };
    f1 + (f1 - f2) / ((h2 / h1).powf(order) - 1.0)
}
