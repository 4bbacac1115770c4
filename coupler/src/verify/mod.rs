//! `bedload run --accuracy 5% --verify`: a run whose error is measured, by coarser grids of its own scene.
//!
//! The grids of a scene (`ladder`) are run from the coarsest on. What the scene is measured by (`measured`)
//! is compared from grid to grid: once the error that [`limit::band`] estimates of the finest is within what
//! is asked for, that grid's run is the result. A run on the next grid costs several times as much, so that
//! all that were coarser cost less than the last. Where a chart serves the scene its setting is the coarsest
//! that is taken.

mod ladder;
mod measured;

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use bedload_output::{Summary, Verification, VerifiedGrid, VerifiedMetric};
use bedload_program::{Interrupts, RunOptions, VERSION, summarise};
use bedload_scene::{CheckedScene, SceneSource};

use crate::failure::Failure;
use crate::limit;
use crate::number::Short;
use crate::plan::Plan;
use crate::prepare::Prepared;
use crate::run::{self, Report};
use crate::{accuracy, resolution};
use ladder::{Ladder, Rung};

/// Most that a run may cost over the two coarsest.
const DEAREST: f64 = 50.0;

/// What may be run whatever those cost, s on one core.
const CHEAP: f64 = 60.0;

/// What is said where the next grid is run on their account.
const STEPS: &str = "its steps are not as much shorter as its cells, so that their error is not seen; \
                     fluid.time.dt, where it is given, follows the cells";

/// A grid of the scene, planned.
struct Planned {
    rung: Rung,
    options: RunOptions,
    prepared: Prepared,
}

/// What the runs came to, coarsest first.
#[derive(Default)]
struct Found {
    /// Widths of the cells over the scene's.
    widths: Vec<f64>,
    summaries: Vec<Summary>,
    /// Does the scene name its metrics? Each must then have a value.
    named: bool,
}

/// Runs a scene on finer and finer grids until its error, by those before, is at most what `accuracy` says.
///
/// # Errors
/// [`Failure`]: bad input, a run that failed, or [`Failure::Run`] where the finest grid that may be run is
/// not exact enough: its run is the result all the same, and `summary.json` says how far it is.
pub fn run(options: &RunOptions, report: Report) -> Result<(), Failure> {
    run::begin()?;
    let source = SceneSource::read(&options.scene, &options.all_overrides())?;
    let Some((target, text)) = accuracy::asked(&source)? else {
        return Err(Failure::Input(
            "--verify measures whether a run is as exact as asked, and nothing is asked: add --accuracy 5%, \
             or accuracy = \"5%\" in the scene"
                .into(),
        ));
    };
    if options.resume {
        return Err(Failure::Input(
            "--verify begins anew: it cannot --resume; without --verify, and with the --set that it printed, \
             the last run goes on"
                .into(),
        ));
    }
    let scene = CheckedScene::new(source)?;
    if scene.scene.medium.is_none() {
        let message = "--verify refines the grid of the fluid, and the scene has none";
        let remedy = "leave --verify out, and refine dem.steps_per_contact";
        return Err(scene.source.error("accuracy", message, remedy).into());
    }
    let (mut base, charted) = match accuracy::choose(&scene, target, &text) {
        Ok(expected) => {
            let (base, expected) = expected.before(options)?;
            protocol::tell!("bedload: {expected}");
            (base, !expected.set.is_empty())
        }
        Err(refused) => {
            protocol::tell!("bedload: accuracy {}; its own grids are measured", refused.message);
            (options.clone(), false)
        }
    };
    let named = !scene.scene.metrics.is_empty();
    base.overrides.extend(measured::metrics(&scene));
    let scene = base.read_scene()?;
    let names = measured::names(&scene, named);
    if names.is_empty() {
        let message = if named {
            "are differences from something else alone, of which --verify compares none"
        } else {
            "are none, and --verify has nothing to compare: the scene moves no grain and drives no flow"
        };
        return Err(scene.source.error("metrics", message, "name [[metrics]] that are to be exact").into());
    }
    let ladder = Ladder::of(&scene, charted);
    let planned = planned(&ladder, &base)?;
    planned[0].prepared.tell();
    price(&planned, ladder.needed);
    let folder = options.folder(&scene)?;
    let interrupts = run::listen()?;
    let mut found = Found { named, ..Found::default() };
    let outcome = climb(&planned, &ladder, &names, target, &interrupts, &mut found);
    let (Some(last), Some(rung)) = (found.summaries.last(), found.widths.len().checked_sub(1)) else {
        return summarise(&folder, &mut Summary::new(&scene, VERSION), outcome);
    };
    let mut summary = last.clone();
    // A run that broke off leaves the one before it as the finest.
    take_in(&planned[rung].options.out_path(), folder.root()).map_err(|error| {
        let root = folder.root().display();
        Failure::Run(format!("cannot move the last run into {root}: {error}"))
    })?;
    summary.verification = Some(found.verification(&planned, &names, target));
    let outcome = summarise(&folder, &mut summary, outcome);
    crate::coupled::draw(folder.root(), report);
    outcome?;
    bedload_program::done("bedload", folder.root(), &format!("; to go on:{}", planned[rung].settings()));
    Ok(())
}

/// Its grids, up to the dearest that may be run.
fn planned(ladder: &Ladder<'_>, base: &RunOptions) -> Result<Vec<Planned>, Failure> {
    let mut all: Vec<Planned> = Vec::new();
    loop {
        let place = all.len();
        let rung = ladder.rung(place);
        let overrides = [&base.overrides[..], &rung.set].concat();
        let out = Some(base.out_path().join(format!("verify-{}", place + 1)));
        let options = RunOptions { overrides, out, overwrite: true, ..base.clone() };
        let checked = Prepared::new(&options).and_then(|made| made.refuse_broken().map(|()| made));
        let needed = place <= ladder.needed;
        let prepared = match checked {
            Ok(prepared) => prepared,
            Err(failure) if needed => return Err(failure),
            Err(_) => return Ok(all),
        };
        if prepared.plan.cells != rung.cells.iter().product::<u64>() {
            return Err(Failure::Input(
                "--verify refines domain.cells, which the fluid solver of this scene does not take: it plans \
                 the same cells whatever they are"
                    .into(),
            ));
        }
        if !needed && is_too_dear(&prepared.plan, &all) {
            return Ok(all);
        }
        all.push(Planned { rung, options, prepared });
    }
}

/// Price of a run: seconds on one core, or cells times windows where a solver does not say.
fn dear(plan: &Plan) -> f64 {
    if plan.cost > 0.0 { plan.cost } else { (plan.cells * plan.windows) as f64 }
}

/// Is a run beside the two coarsest, and by itself, too dear to be made unasked?
fn is_too_dear(plan: &Plan, before: &[Planned]) -> bool {
    let two: f64 = before.iter().take(2).map(|grid| dear(&grid.prepared.plan)).sum();
    dear(plan) > DEAREST * two && (plan.cost == 0.0 || plan.cost > CHEAP)
}

/// Says what the grids cost, those up to `needed` and those that may follow.
fn price(planned: &[Planned], needed: usize) {
    for (place, grid) in planned.iter().enumerate() {
        let when = if place <= needed { "is run" } else { "where the ones before do not suffice" };
        protocol::tell!("bedload: grid {}: {}: {when}", place + 1, grid.line());
    }
}

impl Planned {
    /// Cells, windows and cost.
    fn line(&self) -> String {
        let plan = &self.prepared.plan;
        let cost = if plan.cost > 0.0 {
            format!("about {} s on one core", Short(plan.cost))
        } else {
            "cost unknown".to_owned()
        };
        let resolution = resolution::of(&self.prepared.scene);
        let resolution = resolution.map_or(String::new(), |cells| format!("D/Δx = {:.3}, ", Short(cells)));
        format!("{resolution}{:?} cells, {} windows, {cost}", self.rung.cells, plan.windows)
    }

    /// Its `--set`, with which its run goes on.
    fn settings(&self) -> String {
        self.options.overrides.iter().map(|set| format!(" --set '{set}'")).collect()
    }
}

/// Runs grid after grid until one is exact enough.
fn climb(
    planned: &[Planned],
    ladder: &Ladder<'_>,
    names: &[String],
    target: f64,
    interrupts: &Interrupts,
    found: &mut Found,
) -> Result<(), Failure> {
    for (place, grid) in planned.iter().enumerate() {
        protocol::tell!("bedload: grid {} of at most {}: {}", place + 1, planned.len(), grid.line());
        let ran = run::carry_out(&grid.options, &grid.prepared, interrupts, |folder| Ok(folder.to_owned()));
        if ran.is_err() && interrupts.count() > 0 {
            protocol::say!("bedload: grid {} goes on without --verify, with{}", place + 1, grid.settings());
        }
        ran?;
        if interrupts.count() > 0 {
            return Err(Failure::Interrupted(format!("after grid {}", place + 1)));
        }
        found.summaries.push(Summary::read(&grid.options.out_path().join("summary.json"))?);
        found.widths.push(grid.rung.width);
        if place == 0 {
            continue;
        }
        let metrics = found.metrics(names);
        if metrics.is_empty() {
            return Err(Failure::Run(format!("none of {} could be measured", names.join(", "))));
        }
        let (name, error) = worst(&metrics);
        protocol::tell!(
            "bedload: grid {}: error {} % by estimate, {} % asked for; {}",
            place + 1,
            Short(100.0 * error),
            Short(100.0 * target),
            lines(&metrics).join("; ")
        );
        let follows = found.steps_follow();
        if error <= target && place >= ladder.least && follows {
            return Ok(());
        }
        if !follows {
            protocol::tell!("bedload: grid {}: {STEPS}", place + 1);
        }
        if place + 1 == planned.len() {
            let found = if error.is_finite() {
                format!("is within {} % by estimate", Short(100.0 * error))
            } else {
                "has no estimate, as it has no value on one of the last three grids".to_owned()
            };
            let (joint, steps) = if follows { ("", "") } else { ("; ", STEPS) };
            return Err(Failure::Run(format!(
                "not as exact as asked: {name} {found}, {} % was asked for; the next grid costs more than \
                 {DEAREST} times the first two and {CHEAP} s, or breaks a bound: ask for less{joint}{steps}",
                Short(100.0 * target)
            )));
        }
    }
    Ok(())
}

impl Found {
    /// Are the steps of the finest grid as much shorter than those of the one before as its cells, or at
    /// least half as much, in the logarithm? Else what two grids share hides the error of the steps.
    fn steps_follow(&self) -> bool {
        let ([.., before, last], [.., wide, narrow]) = (&self.summaries[..], &self.widths[..]) else {
            return false;
        };
        let steps = |summary: &Summary| summary.time.fluid_steps as f64;
        steps(last) / steps(before) >= (wide / narrow).sqrt()
    }

    /// Each metric that the scene names, or that has a value on any grid, with the estimated error of the
    /// finest.
    fn metrics(&self, names: &[String]) -> BTreeMap<String, VerifiedMetric> {
        let of = |name: &String| {
            let value = |summary: &Summary| summary.metrics.get(name).and_then(|metric| metric.value);
            let values: Vec<Option<f64>> = self.summaries.iter().map(value).collect();
            (self.named || values.iter().any(Option::is_some))
                .then(|| (name.clone(), verified(&self.widths, values)))
        };
        names.iter().filter_map(of).collect()
    }

    fn verification(&self, planned: &[Planned], names: &[String], target: f64) -> Verification {
        let metrics = self.metrics(names);
        let (metric, error) = worst(&metrics);
        let grid = |(grid, summary): (&Planned, &Summary)| VerifiedGrid {
            cells: grid.rung.cells.clone(),
            resolution: resolution::of(&grid.prepared.scene),
            cpu_s: summary.cost.fluid_cpu_s + summary.cost.dem_cpu_s,
        };
        Verification {
            target,
            error: Some(error).filter(|error| error.is_finite()),
            metric,
            grids: planned.iter().zip(&self.summaries).map(grid).collect(),
            metrics,
        }
    }
}

/// A metric from its values on grids of these widths, coarsest first: its error is that of the finest, by the
/// three finest.
fn verified(widths: &[f64], values: Vec<Option<f64>>) -> VerifiedMetric {
    let pairs = widths.iter().zip(&values).rev().take(3);
    let points: Option<Vec<(f64, f64)>> = pairs.map(|(width, value)| Some((*width, (*value)?))).collect();
    let Some(points) = points else { return VerifiedMetric { values, order: None, error: None } };
    let finest = points[0].1.abs();
    let error = limit::band(&points).map(|band| if band > 0.0 { band / finest } else { 0.0 });
    let order = limit::richardson(&points).and_then(|limit| limit.order);
    VerifiedMetric { values, order, error: error.filter(|error| error.is_finite()) }
}

/// The metric with the largest error; without an estimate it is infinite.
fn worst(metrics: &BTreeMap<String, VerifiedMetric>) -> (String, f64) {
    let errors = metrics.iter().map(|(name, of)| (name.clone(), of.error.unwrap_or(f64::INFINITY)));
    errors.max_by(|a, b| a.1.total_cmp(&b.1)).unwrap_or((String::new(), f64::INFINITY))
}

/// Each metric in words.
fn lines(metrics: &BTreeMap<String, VerifiedMetric>) -> Vec<String> {
    let line = |(name, of): (&String, &VerifiedMetric)| {
        let text = |value: &Option<f64>| value.map_or("none".into(), |value| Short(value).to_string());
        let values: Vec<String> = of.values.iter().map(text).collect();
        let order = of.order.map_or(String::new(), |order| format!(", order {order:.1}"));
        let error = of.error.map_or("no estimate".into(), |error| format!("{} %", Short(100.0 * error)));
        format!("{name} {} ({error}{order})", values.join(", "))
    };
    metrics.iter().map(line).collect()
}

/// Moves everything in a folder into another.
fn take_in(from: &Path, into: &Path) -> std::io::Result<()> {
    for entry in fs::read_dir(from)? {
        let entry = entry?;
        let (path, place) = (entry.path(), into.join(entry.file_name()));
        if path.is_dir() {
            fs::create_dir_all(&place)?;
            take_in(&path, &place)?;
        } else {
            fs::rename(&path, &place)?;
        }
    }
    fs::remove_dir(from)
}
