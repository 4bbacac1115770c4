//! `summary.json`: the result of a run for scripts. SI units.
//!
//! JSON has no infinity: what is unknown or infinite is `null`.

use std::collections::BTreeMap;
use std::path::Path;

use serde::{Deserialize, Serialize};

use crate::error::OutputError;
use crate::file::atomic_write;
use bedload_scene::{CheckedScene, Geometry, Metric};
use protocol::participant::Window;

/// How a run ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum RunStatus {
    /// Reached its end.
    Completed,
    /// Stopped by an error.
    Failed,
    /// Stopped because the exchange alternated or grew from window to window.
    Unstable,
    /// Stopped by a signal, with a usable checkpoint.
    Interrupted,
}

/// The whole file.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
pub struct Summary {
    /// How it ended.
    pub status: RunStatus,
    /// Why, if it failed.
    pub error: Option<String>,
    /// Version of the program that wrote it.
    pub version: String,
    /// Identity of the scene as read, overrides included.
    pub scene_sha256: String,
    /// Time and steps.
    pub time: Time,
    /// Size of the problem.
    pub size: Size,
    /// What it cost.
    pub cost: Cost,
    /// Numbers that the scene asked for, by name.
    pub metrics: BTreeMap<String, MetricValue>,
    /// How exact they are, where coarser grids were run to see.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub verification: Option<Verification>,
}

/// How exact a run is, by coarser grids of its scene.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
pub struct Verification {
    /// Relative error asked for.
    pub target: f64,
    /// Estimated largest relative error over the metrics; `null` where there is no estimate.
    pub error: Option<f64>,
    /// The metric that has it.
    pub metric: String,
    /// The grids, coarsest first; the last is that of this run.
    pub grids: Vec<VerifiedGrid>,
    /// Of each metric.
    pub metrics: BTreeMap<String, VerifiedMetric>,
}

/// A grid that was run to see how exact the finest is.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
pub struct VerifiedGrid {
    /// Cells along each axis.
    pub cells: Vec<u64>,
    /// D/Δx; `null` without grains.
    pub resolution: Option<f64>,
    /// CPU time of the solvers, s.
    pub cpu_s: f64,
}

/// A metric on these grids.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, Serialize)]
pub struct VerifiedMetric {
    /// Its value on each grid, `null` where there is none.
    pub values: Vec<Option<f64>>,
    /// Observed order of the three finest; `null` where they do not go one way, ever slower.
    pub order: Option<f64>,
    /// Estimated relative error of the finest value; `null` where there is no estimate.
    pub error: Option<f64>,
}

/// Time and steps.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, Serialize)]
pub struct Time {
    /// Simulated time, s.
    pub simulated: f64,
    /// Steps of the fluid.
    pub fluid_steps: u64,
    /// Sub-steps of the DEM.
    pub dem_substeps: u64,
    /// Mean step of the fluid, s.
    pub dt_fluid: Option<f64>,
    /// Smallest sub-step of the DEM, s: the one that resolves contacts. Away from contact a window
    /// may take few, long ones, so that the mean says nothing.
    pub dt_dem: Option<f64>,
    /// Shortest contact duration, s.
    pub contact_time: Option<f64>,
    /// DEM sub-steps in a window.
    pub substeps_per_window: SubstepRange,
}

/// Least, mean and most sub-steps in a window.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize, Serialize)]
pub struct SubstepRange {
    /// Least.
    pub min: u64,
    /// Mean.
    pub mean: f64,
    /// Most.
    pub max: u64,
}

/// Size of the problem.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
pub struct Size {
    /// Cells of the fluid, 0 in a dry run.
    pub cells: u64,
    /// Grains, all motions included.
    pub grains: u64,
    /// Geometry.
    pub geometry: Geometry,
}

/// What a run cost. CPU times count solver work only: no start-up, output or log.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, Serialize)]
pub struct Cost {
    /// Wall time of the run, s.
    pub wall_s: f64,
    /// CPU time of the fluid, s.
    pub fluid_cpu_s: f64,
    /// CPU time of the DEM, s.
    pub dem_cpu_s: f64,
    /// CPU time of the coupler, s.
    pub coupler_cpu_s: f64,
    /// Wall time of sending and receiving, without waiting for the peer, s.
    pub exchange_s: f64,
    /// Wall time of recording, s.
    pub record_s: f64,
    /// Fluid CPU time over cells and steps, ns.
    pub ns_per_cell_step: Option<f64>,
    /// DEM CPU time over free grains and sub-steps, ns.
    pub ns_per_grain_substep: Option<f64>,
    /// Peak resident memory.
    pub peak_rss_bytes: PeakRss,
}

/// Peak resident memory of each process, bytes; `null` where there was no such process.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize)]
pub struct PeakRss {
    /// Fluid solver.
    pub fluid: Option<u64>,
    /// DEM solver.
    pub dem: Option<u64>,
    /// Coupler.
    pub coupler: Option<u64>,
}

/// One metric.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, Serialize)]
pub struct MetricValue {
    /// Measured value, `null` if it could not be measured.
    pub value: Option<f64>,
    /// Its standard error, of means that have one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub standard_error: Option<f64>,
    /// Unit, `-` if it has none.
    pub unit: String,
    /// Published or exact value.
    pub reference: Option<f64>,
    /// |value − reference| / |reference|; `null` without a reference, or where that is 0.
    pub relative_error: Option<f64>,
    /// Where the reference comes from.
    pub source: Option<String>,
    /// Why there is no value, or what to know about it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub note: Option<String>,
    /// A value that is no reference, of which no error is made.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub compared_with: Option<f64>,
    /// What the scene says of the number.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub remark: Option<String>,
}

impl MetricValue {
    /// A measured value; one that is not finite counts as not measured.
    pub fn measured(value: f64, unit: &str, reference: Option<f64>, source: Option<String>) -> Self {
        if !value.is_finite() {
            return Self::missing(format!("the value is {value}"), unit, reference, source);
        }
        let relative_error =
            reference.filter(|reference| *reference != 0.0).map(|r| (value - r).abs() / r.abs());
        Self {
            value: Some(value),
            unit: unit.to_owned(),
            reference,
            relative_error,
            source,
            ..Self::default()
        }
    }

    /// What a metric came to: its value, perhaps with a note, or why there is none.
    pub fn of(metric: &Metric, unit: &str, outcome: Result<(f64, Option<String>), String>) -> Self {
        let (reference, source) = (metric.reference, metric.source.clone());
        match outcome {
            Ok((value, note)) => {
                let measured = Self::measured(value, unit, reference, source);
                Self { note: measured.note.clone().or(note), ..measured }
            }
            Err(why) => Self::missing(why, unit, reference, source),
        }
    }

    /// A metric that could not be measured, and why.
    pub fn missing(
        note: impl Into<String>,
        unit: &str,
        reference: Option<f64>,
        source: Option<String>,
    ) -> Self {
        Self { unit: unit.to_owned(), reference, source, note: Some(note.into()), ..Self::default() }
    }
}

impl Summary {
    /// A summary of `scene` in which nothing has been done yet.
    pub fn new(scene: &CheckedScene, version: &str) -> Self {
        let domain = &scene.scene.domain;
        let cells = domain.cells.iter().map(|count| *count as u64).product();
        Self {
            status: RunStatus::Completed,
            error: None,
            version: version.to_owned(),
            scene_sha256: scene.sha256(),
            time: Time::default(),
            size: Size {
                cells: if scene.scene.medium.is_some() { cells } else { 0 },
                grains: scene.grains.len() as u64,
                geometry: domain.geometry,
            },
            cost: Cost::default(),
            metrics: BTreeMap::new(),
            verification: None,
        }
    }

    /// Adds what the scene says beside the numbers of its metrics.
    pub fn remark(&mut self, metrics: &[Metric]) {
        for metric in metrics {
            if let Some(value) = self.metrics.get_mut(&metric.name) {
                value.compared_with = metric.compared_with;
                value.remark.clone_from(&metric.remark);
            }
        }
    }

    /// Marks the run as failed.
    pub fn fail(&mut self, error: &dyn std::fmt::Display) {
        self.end(RunStatus::Failed, error);
    }

    /// Says how the run ended, and why.
    pub fn end(&mut self, status: RunStatus, error: &dyn std::fmt::Display) {
        self.status = status;
        self.error = Some(error.to_string());
    }

    /// Fills in the two unit costs from the CPU times, the size and the steps. `free_grains` is
    /// the number of grains that the DEM moves.
    pub fn set_unit_costs(&mut self, free_grains: u64) {
        let nanoseconds = |seconds: f64, count: u64| (count > 0).then(|| seconds * 1e9 / count as f64);
        let cell_steps = self.size.cells * self.time.fluid_steps;
        let grain_substeps = free_grains * self.time.dem_substeps;
        self.cost.ns_per_cell_step = nanoseconds(self.cost.fluid_cpu_s, cell_steps);
        self.cost.ns_per_grain_substep = nanoseconds(self.cost.dem_cpu_s, grain_substeps);
    }

    /// Writes the file, whole or not at all.
    ///
    /// # Errors
    /// [`OutputError`].
    pub fn write(&self, path: &Path) -> Result<(), OutputError> {
        let mut text = serde_json::to_string_pretty(self)
            .map_err(|error| OutputError::Content { path: path.to_owned(), what: error.to_string() })?;
        text.push('\n');
        atomic_write(path, text.as_bytes())
    }

    /// Reads the file.
    ///
    /// # Errors
    /// [`OutputError`] if it is missing, [`OutputError::NotEnded`] beside a scene, or not a summary.
    pub fn read(path: &Path) -> Result<Self, OutputError> {
        let begun = path.parent().filter(|folder| folder.join("scene.toml").exists() && !path.exists());
        if let Some(folder) = begun {
            return Err(OutputError::NotEnded(folder.to_owned()));
        }
        let text = protocol::input_file::read_text(path).map_err(OutputError::file("read", path))?;
        serde_json::from_str(&text).map_err(|error| OutputError::Content {
            path: path.to_owned(),
            what: format!("not a summary of this version: {error}; run the scene again"),
        })
    }
}

/// Counts of windows and sub-steps as the run goes; part of the coupler's checkpoint.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize, Serialize)]
pub struct Tally {
    /// Windows accepted.
    pub windows: u64,
    /// Simulated time, s.
    pub simulated: f64,
    /// DEM sub-steps in all accepted windows.
    pub substeps: u64,
    /// Least in a window.
    pub least: u64,
    /// Most in a window.
    pub most: u64,
    /// Smallest sub-step, s; none before the first.
    pub finest: Option<f64>,
}

impl Tally {
    /// Adds an accepted window in which the DEM did `substeps`.
    pub fn record(&mut self, window: &Window, substeps: u64) {
        self.least = if self.windows == 0 { substeps } else { self.least.min(substeps) };
        self.most = self.most.max(substeps);
        if substeps > 0 {
            let dt = window.dt / substeps as f64;
            self.finest = Some(self.finest.map_or(dt, |finest| finest.min(dt)));
        }
        self.windows += 1;
        self.substeps += substeps;
        self.simulated = window.time + window.dt;
    }

    /// The `time` part of the summary; `contact_time` in s, infinite where nothing can touch.
    pub fn time(&self, has_fluid: bool, contact_time: f64) -> Time {
        let mean = |count: u64| (count > 0).then(|| self.simulated / count as f64);
        Time {
            simulated: self.simulated,
            fluid_steps: if has_fluid { self.windows } else { 0 },
            dem_substeps: self.substeps,
            dt_fluid: mean(if has_fluid { self.windows } else { 0 }),
            dt_dem: self.finest,
            contact_time: contact_time.is_finite().then_some(contact_time),
            substeps_per_window: SubstepRange {
                min: self.least,
                mean: if self.windows > 0 { self.substeps as f64 / self.windows as f64 } else { 0.0 },
                max: self.most,
            },
        }
    }
}
